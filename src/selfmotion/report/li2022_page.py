"""The report of `selfmotion reproduce li2022`: its table and figures, what they mean."""

from collections.abc import Sequence

import pandas as pd

from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Page, Picture, Section, Table
from selfmotion.report.posture_figures import coordinates_figure, effort_figure, muscles_figure
from selfmotion.studies.li2022 import Reproduction

# Rows of Figs 3 and 4 shown: every so many.
EVERY_ELEVATION, EVERY_SWIVEL = 20, 10


def li2022_page(
    model: MusculoskeletalArm,
    made: Reproduction,
    numbers: pd.DataFrame,
    provenance: Provenance,
    *,
    more: Sequence[Section] = (),
) -> Page:
    """Give the report on a reproduction.

    Args:
        model: the arm with muscles that it was made with.
        made: the paper's synthetic analysis, computed again.
        numbers: each published number beside ours.
        provenance: how it was made.
        more: further sections, as those on recorded people.
    """
    sections = [
        Section(
            "Published numbers beside ours",
            words=(f"The arm is {model.arm.name}, convention {model.convention}.",),
            tables=(
                Table(numbers, "`kind` says what may be compared."),
                Table(made.table_iv, "As the paper's Table IV: other studies, on their people."),
            ),
        ),
        shoulder_section(made),
        example_section(model, made),
        postures_section(made),
        *more,
    ]
    summary = f"{len(numbers)} published numbers beside ours; {len(made.postures)} hand poses."
    footer = Footer((provenance,), ("Li2022",))
    return Page("Li et al. 2022, computed again", tuple(sections), summary, footer)


def shoulder_section(made: Reproduction) -> Section:
    """Show where the shoulder centre goes, and what that does to the swivel angle."""
    return Section(
        "The shoulder centre moves",
        tables=(
            Table(
                made.shoulder.iloc[::EVERY_ELEVATION],
                "As Fig 3: displacement (m) by elevation.",
            ),
            Table(
                made.swivel.iloc[::EVERY_SWIVEL],
                "As Fig 4: swivel angle (deg) with the centre fixed and moving; displacement of "
                "the elbow (m).",
            ),
        ),
    )


def example_section(model: MusculoskeletalArm, made: Reproduction) -> Section:
    """Draw effort along the self-motion of the example pose."""
    found = made.example
    return Section(
        "The example pose",
        words=(f"{found.status.sentence}.",),
        pictures=(
            Picture(
                effort_figure(made.curves, found),
                "As Fig 6: muscle effort over the swivel angle, with the feasible intervals.",
                "Muscle effort over the swivel angle of the example pose",
            ),
            Picture(
                coordinates_figure(made.curves, found),
                "Coordinates over the swivel angle; the posture of least effort is marked.",
                "Coordinates over the swivel angle of the example pose",
            ),
            Picture(
                muscles_figure(model, found.q, found.activations),
                "The arm at least effort; muscles are coloured by activation.",
                "The arm with its muscles, from the front and from the right",
            ),
        ),
    )


def postures_section(made: Reproduction) -> Section:
    """Show the natural posture of each pose, and how well its inverse kinematics began."""
    return Section(
        "Natural postures of vertical-cup poses",
        tables=(
            Table(made.postures, "Place (m), range and swivel angle (deg), effort, time."),
            Table(made.hybrid, "As Fig 5: error of starts (m, rad), swivel uncertainty (deg)."),
        ),
    )
