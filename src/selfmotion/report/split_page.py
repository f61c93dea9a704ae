"""The report of `selfmotion split`: task and null-space velocity, and variance over repetitions."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.methods.uncontrolled_manifold import ManifoldVariance
from selfmotion.methods.velocity_split import VelocitySplit
from selfmotion.motion.recording import Study
from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.manifold_figures import manifold_figure
from selfmotion.report.velocity_figures import split_figure
from selfmotion.studies.velocity_profiles import split_bands

Key = tuple[str | None, ...]


def write_split_report(
    path: str | Path,
    study: Study,
    weights: Float[np.ndarray, " joints"],
    parts: Sequence[VelocitySplit],
    variances: Mapping[Key, ManifoldVariance],
) -> Path:
    """Write the report on a split study; give its path.

    Args:
        path: the HTML file.
        study: what was analysed, without gaps.
        weights: the diagonal of W.
        parts: the split of each recording, in the study's order.
        variances: of each group of repetitions.
    """
    sections = [shares_section(study, weights, parts)]
    if variances:
        sections.append(manifold_section(variances))
    task = float(np.nanmean([part.task_share for part in parts]))
    summary = f"On average {100 * task:.0f} % of the squared joint velocity serves the hand."
    footer = Footer((Provenance("split"),), ("Khoramshahi2022",))
    return write_report(
        path, "Task and null-space velocity", sections, summary=summary, footer=footer
    )


def shares_section(
    study: Study, weights: Float[np.ndarray, " joints"], parts: Sequence[VelocitySplit]
) -> Section:
    """Show velocities and shares."""
    rows = [
        {
            "recording": part.name,
            "task share": part.task_share,
            "null-space share": part.null_share,
        }
        for part in parts
    ]
    values = ", ".join(f"{j} {w:.3g}" for j, w in zip(study.joints, weights, strict=True))
    return Section(
        "Velocity",
        words=(f"Weights: {values}.",),
        pictures=(
            Picture(
                split_figure(split_bands(study, weights)),
                "Mean and standard deviation over movements, by progress of the movement.",
                "Task and null-space velocity of each joint over the movement",
            ),
        ),
        tables=(Table(pd.DataFrame(rows), "Shares of the squared joint velocity."),),
    )


def manifold_section(variances: Mapping[Key, ManifoldVariance]) -> Section:
    """Show the variance along and across the uncontrolled manifold."""
    return Section(
        "Variance over repetitions",
        words=(
            "Variance along the uncontrolled manifold leaves the hand where it is; variance "
            "across it moves the hand. More along than across (ΔV above 0) is called a synergy "
            "that stabilises the hand.",
            "Recordings of one person, side, condition and target are taken for repetitions, also "
            "where the files name none of these.",
        ),
        pictures=(
            Picture(
                manifold_figure(variances),
                "Variance per dimension along and across the manifold.",
                "Variance along and across the uncontrolled manifold over the movement",
            ),
        ),
    )
