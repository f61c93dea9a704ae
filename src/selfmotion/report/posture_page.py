"""The report of `selfmotion posture`: natural postures, with effort along each self-motion."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from jaxtyping import Float
from numpy import ndarray

from selfmotion.errors import Status
from selfmotion.methods.effort.curve import DRAWN_GAP
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.posture_figures import coordinates_figure, effort_figure, muscles_figure

# Poses drawn; the table holds all of them.
MOST_DRAWN = 8


def write_posture_report(
    path: str | Path,
    finder: PostureFinder,
    poses: Sequence[tuple[str, Float[ndarray, "4 4"]]],
    table: pd.DataFrame,
    provenance: Provenance,
) -> Path:
    """Write the report on natural postures; give its path.

    Args:
        path: the HTML file.
        finder: the model and how its least effort was searched for.
        poses: name and hand pose of those that have a posture; the first are drawn.
        table: one row a pose, with its status.
        provenance: where the postures come from.
    """
    convention = finder.model.convention
    words = (
        f"Least muscle effort of {finder.model.arm.name}, convention {convention}, over all "
        "postures that hold the hand where it is. Where effort is flat, or two valleys are as "
        "deep, effort does not say how a person would hold the arm: the status tells.",
    )
    sections = [
        Section(
            "Postures",
            words=words,
            tables=(
                Table(table, "Swivel angle and coordinates in degrees; effort Σa² has no unit."),
            ),
        )
    ]
    sections += [pose_section(finder, name, T) for name, T in poses[:MOST_DRAWN]]
    if len(poses) > MOST_DRAWN:
        sections[0] = Section(
            "Postures",
            words=(*words, f"The first {MOST_DRAWN} of {len(poses)} are drawn."),
            tables=sections[0].tables,
        )
    summary = f"A natural posture was found for {len(poses)} of {len(table)} hand poses."
    footer = Footer((provenance,), ("Li2022",))
    return write_report(path, "Natural postures", sections, summary=summary, footer=footer)


def sentence_of(status: Status) -> str:
    """Write a status as a sentence."""
    return f"{status.sentence[:1].upper()}{status.sentence[1:]}."


def pose_section(finder: PostureFinder, name: str, T_hand: Float[ndarray, "4 4"]) -> Section:
    """Draw one pose: effort and coordinates over swivel angle, and the arm."""
    found = finder.find(T_hand)
    manifold = finder.manifolds.find(T_hand, clearance=finder.clearance)
    curves = finder.curves(manifold, gap=DRAWN_GAP)
    return Section(
        f"Pose {name}",
        words=(sentence_of(found.status),),
        pictures=(
            Picture(
                effort_figure(curves, found),
                "Muscle effort over the swivel angle, with the feasible intervals.",
                f"Muscle effort over swivel angle for pose {name}",
            ),
            Picture(
                coordinates_figure(curves, found),
                "Coordinates over the swivel angle; the posture of least effort is marked.",
                f"Coordinates over swivel angle for pose {name}",
            ),
            Picture(
                muscles_figure(finder.model, found.q, found.activations),
                "The arm at least effort; muscles are coloured by activation.",
                f"The arm with its muscles for pose {name}",
            ),
        ),
    )
