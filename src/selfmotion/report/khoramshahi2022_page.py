"""The report of `selfmotion reproduce khoramshahi2022`: each number and figure beside ours."""

from pathlib import Path

import pandas as pd

from selfmotion.report.convergence_figures import (
    convergence_figure,
    gamma_figure,
    noise_figure,
    two_joint_figure,
)
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.velocity_figures import (
    null_share_figure,
    null_velocity_figure,
    velocity_figure,
)
from selfmotion.report.weights_figures import contribution_figure, weights_figure
from selfmotion.studies.khoramshahi2022 import Reproduction
from selfmotion.studies.reaching_study import ReachingResult
from selfmotion.studies.screen_study import ScreenResult

NUMBERS = ("where", "quantity", "published", "ours", "kind", "note")


def write_khoramshahi2022_report(path: str | Path, found: Reproduction) -> Path:
    """Write the report; give its path."""
    sections = [
        numbers_section(found.table),
        examples_section(found),
        reaching_section(found.reaching),
        screen_section(found.screen),
    ]
    if found.authors is not None:
        table = Table(found.authors, "Our weights beside the authors', person by person.")
        sections.append(Section("The authors' weights", tables=(table,)))
    footer = Footer((found.provenance,), ("Khoramshahi2022",))
    title = "Khoramshahi et al. 2022, computed again"
    same = int(found.table["comparable"].sum())
    summary = (
        f"{same} of {len(found.table)} published numbers are comparable with ours; the rest come "
        "from generated people and are of the same kind only."
    )
    return write_report(path, title, sections, summary=summary, footer=footer)


def numbers_section(table: pd.DataFrame) -> Section:
    """Show every published number beside ours."""
    return Section(
        "Published numbers beside ours",
        words=(
            "The published recordings are not part of this package. Where a number rests on "
            "them, ours comes from generated people and is of the same kind, not the same.",
        ),
        tables=(Table(table[list(NUMBERS)], "One row a number; units in the text."),),
    )


def examples_section(found: Reproduction) -> Section:
    """Show Figs 1 to 3, and the error against null-space noise."""
    return Section(
        "Numerical examples",
        pictures=(
            Picture(
                convergence_figure(found.fig1),
                "Fig 1. Five weights converge; mean and standard deviation over data sets.",
                "Weights of five joints against iterations of Algorithm 1",
            ),
            Picture(
                gamma_figure(found.fig2),
                "Fig 2. The null-space ratio γ sets the speed on independent data; γ = 1 rests.",
                "Convergence of Algorithm 1 for several null-space ratios",
            ),
            Picture(
                two_joint_figure(found.fig3),
                "Fig 3. Two joints, null-space motion driven by posture: γ decides the outcome.",
                "Weights of two joints against iterations for several null-space ratios",
            ),
            Picture(
                noise_figure(found.noise),
                "Error of the estimators against null-space noise, projected and not.",
                "Error of the identified weights against the null-space noise",
            ),
        ),
    )


def reaching_section(result: ReachingResult) -> Section:
    """Show experiment 1: Figs 5, 6 and 7, and how true the estimators are."""
    ml = result.weights[result.weights["method"] == "ml"]
    truth = _mean_truth(result)
    tables = ()
    if result.recovery is not None:
        tables = (
            Table(
                result.recovery.table,
                "Identified against true log-ratios of the generated people.",
            ),
        )
    who = "generated people" if result.generated else "recorded people"
    return Section(
        "Experiment 1: reaching in a viscous field",
        words=(f"Weights and null-space velocities of {who}.",),
        pictures=(
            Picture(
                velocity_figure(result.velocities, result.conditions),
                f"Fig 5. Joint velocities of {result.shown}, mean and standard deviation.",
                "Joint velocities by target and condition",
            ),
            Picture(
                weights_figure(ml, truth=truth),
                "Fig 6. Weights (maximum likelihood); each point is a person.",
                "Weights of each joint in both conditions",
            ),
            Picture(
                null_velocity_figure(result.null, result.conditions),
                "Fig 7. Null-space velocity with identified weights and with W = I.",
                "Velocity and null-space velocity of each joint",
            ),
            Picture(
                null_share_figure(result.null, result.conditions),
                "Each line is a person: with identified weights less is left to the null space.",
                "Null-space speed of each person with identified weights and with W = I",
            ),
        ),
        tables=tables,
    )


def screen_section(result: ScreenResult) -> Section:
    """Show experiment 2: Fig 9 and Table 1."""
    paper = result.weights[result.weights["method"] == "paper"]
    shown = paper.assign(weight=paper["full_weight"], identified=True)
    return Section(
        "Experiment 2: a virtual elbow",
        pictures=(
            Picture(
                weights_figure(shown),
                "Fig 9. Weights by Algorithm 1, as the paper computes them; each point a person.",
                "Weights of hip, shoulder and elbow in four conditions",
            ),
            Picture(
                contribution_figure(paper),
                "Table 1 as a picture: contribution coefficients by Algorithm 1.",
                "Stacked bars of contributions in four conditions",
            ),
        ),
    )


def _mean_truth(result: ReachingResult) -> dict[str, tuple[float, ...]] | None:
    """Give the geometric mean of the true weights by condition, or None for recorded people."""
    if not result.truth:
        return None
    import numpy as np

    means = {}
    for condition in result.conditions:
        logs = [np.log(w) for (_, c), w in result.truth.items() if c == condition]
        means[condition] = tuple(np.exp(np.mean(logs, axis=0)).tolist())
    return means
