"""The report of `selfmotion reproduce li2022`: its table and figures, what they mean."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Page, Picture, Section, Table, format_number
from selfmotion.report.li2022_figures import (
    hybrid_figure,
    poses_figure,
    shoulder_figure,
    swivel_figure,
)
from selfmotion.report.posture_figures import coordinates_figure, effort_figure, muscles_figure
from selfmotion.report.posture_page import sentence_of
from selfmotion.studies.li2022 import NUMBERS, Reproduction

PRINTED = {number.key: number.values for number in NUMBERS}
# Poses shown in the table of natural postures, evenly among all.
MOST_ROWS = 12


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
        more: sections on recorded people; left out: the paper's Table IV stands alone.
    """
    sections = [
        Section(
            "Published numbers beside ours",
            words=(f"The arm is {model.arm.name}, convention {model.convention}.",),
            tables=(Table(numbers, "The column kind says what may be compared."),),
        ),
        shoulder_section(made),
        hybrid_section(made),
        example_section(model, made),
        postures_section(made),
        *(more or [table_iv_section(made)]),
    ]
    summary = f"{len(numbers)} published numbers beside ours; {len(made.postures)} hand poses."
    footer = Footer((provenance,), ("Li2022",))
    return Page("Li et al. 2022, computed again", tuple(sections), summary, footer)


def shoulder_section(made: Reproduction) -> Section:
    """Show where the shoulder centre goes, and what that does to the swivel angle."""
    columns = ["elevation_deg", "forward", "up", "right"]
    highest, *last = made.shoulder[columns].to_numpy(dtype=float)[-1]
    ours = ", ".join(f"{100.0 * value:.1f}" for value in last)
    off = np.abs(made.swivel["difference_deg"].to_numpy(dtype=float))
    mean, spread = PRINTED["fig4"]
    return Section(
        "The shoulder centre moves",
        pictures=(
            Picture(
                shoulder_figure(made.shoulder, PRINTED["fig3"]),
                "As Fig 3: displacement of the shoulder centre as the arm is raised; dashed in A: "
                "its projections onto the plane of the back and the floor. At "
                f"{highest:.0f}° the paper prints -6.8, 5.7, 5.7 cm forward, up and "
                f"right, here it is {ours} cm. The arm is another one; a right shoulder's centre "
                "moves inwards, so that the paper's last number lacks its minus.",
                "Path of the shoulder centre in space, and by direction over elevation",
            ),
            Picture(
                swivel_figure(made.swivel, (mean, spread)),
                "As Fig 4: swivel angle along one self-motion, with the shoulder centre fixed at "
                f"home and where it is. The paper: {mean:g} ± {spread:g}° apart; here "
                f"{off.mean():.2f} ± {off.std():.2f}°, on another arm and pose.",
                "Two swivel angles over shoulder elevation, and their difference",
            ),
        ),
    )


def hybrid_section(made: Reproduction) -> Section:
    """Show how well the hybrid inverse kinematics does, and how long things take."""
    off = made.hybrid["uncertainty_deg"].to_numpy(dtype=float)
    refined = 1e3 * float(made.hybrid["refined_m"].to_numpy(dtype=float).max())
    return Section(
        "Hybrid inverse kinematics, and times",
        pictures=(
            Picture(
                hybrid_figure(made.hybrid),
                f"As Fig 5, over {len(made.hybrid)} vertical-cup poses: A how far swivel angles "
                f"are from those asked for (here {off.mean():.2f} ± {off.std():.2f}°); B and C "
                "errors of the closed form (mean of a pose) and after refinement (greatest of a "
                "pose): box quartiles, whiskers extremes. The paper shows this as a figure and "
                f"prints no number; here refinement ends at {format_number(refined, 1)} mm. The "
                "tail of A: far poses with the elbow nearly straight, where the shoulder centre, "
                "which moves, turns the swivel angle far.",
                "Swivel uncertainty, and errors of hand position and orientation",
            ),
        ),
        tables=(
            Table(
                made.timing,
                "Times of section IV-B beside ours. The machines differ, and so do the ways to "
                "effort: the paper asks OpenSim for each posture.",
            ),
        ),
    )


def example_section(model: MusculoskeletalArm, made: Reproduction) -> Section:
    """Draw effort along the self-motion of the example pose."""
    found = made.example
    several = int((made.postures["minima"].to_numpy(dtype=int) > 1).sum())
    return Section(
        "The example pose",
        words=(sentence_of(found.status),),
        pictures=(
            Picture(
                effort_figure(made.curves, found),
                "As Fig 6: muscle effort over the swivel angle, with the feasible intervals. The "
                "paper shows several local minima on its pose and prints no number; here this "
                f"pose has {len(found.minima)}, and {several} of {len(made.postures)} poses have "
                "more than one.",
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
    """Show the natural posture of each pose."""
    step = max(1, -(-len(made.postures) // MOST_ROWS))
    table = made.postures.iloc[::step].drop(columns=["milliseconds"])
    table = table.assign(**{k: (100.0 * table[k]).round().astype(int) for k in "xyz"})
    names = {"x": "right (cm)", "y": "forward (cm)", "z": "up (cm)"}
    names |= {"range_deg": "range (deg)", "swivel_deg": "swivel (deg)", "effort": "effort Σa²"}
    return Section(
        "Natural postures of vertical-cup poses",
        pictures=(
            Picture(
                poses_figure(made.postures),
                f"Swivel angle of least effort at the {len(made.postures)} places of the cup, from "
                "the shoulder. Places behind one another lie on one spot.",
                "Swivel angle of least effort by place of the hand, from above and from the right",
            ),
        ),
        tables=(
            Table(
                table.rename(columns=names),
                f"{len(table)} of {len(made.postures)} poses: place of the hand from the shoulder, "
                "range of self-motion, swivel angle and effort of the natural posture.",
            ),
        ),
    )


def table_iv_section(made: Reproduction) -> Section:
    """Show the paper's Table IV where no people are at hand."""
    return Section(
        "Other laws",
        tables=(Table(made.table_iv, "As the paper's Table IV: other studies, on their people."),),
    )
