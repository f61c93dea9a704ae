"""The report of `selfmotion reproduce tommasino2017`: its table and figures, what they mean."""

from collections.abc import Sequence

import pandas as pd

from selfmotion.methods.curvature import LEVEL, MeanTests
from selfmotion.report.html import Footer, Page, Picture, Section, Table
from selfmotion.report.planner_figures import (
    areas_figure,
    joint_trajectories_figure,
    net_areas_of_people_figure,
    paths_figure,
    planned_movements_figure,
    speed_figure,
)
from selfmotion.studies.tommasino2017 import Comparison
from selfmotion.studies.tommasino2017_numbers import Reproduction

GENERATED = (
    "The recordings of the paper are not at hand. These people are simulated by the same model "
    "that is then fitted to them: that it captures their movements is built in. What can be learnt "
    "here is how often noise alone makes the comparison fail."
)


def tommasino2017_page(made: Reproduction, numbers: pd.DataFrame) -> Page:
    """Give the report on a reproduction.

    Args:
        made: the paper, computed again.
        numbers: each published number beside ours.
    """
    sections = [
        Section(
            "Published numbers beside ours",
            tables=(Table(numbers, "“Kind” says what may be compared."),),
        ),
        planned_section(made),
        people_section(made),
    ]
    summary = (
        f"{len(numbers)} published numbers beside ours, with {len(made.people)} simulated people."
    )
    footer = Footer((made.provenance,), ("Tommasino2017",))
    title = "Tommasino and Campolo 2017, computed again"
    return Page(title, tuple(sections), summary, footer)


def planned_section(made: Reproduction) -> Section:
    """Show the movements that the model plans."""
    return Section(
        "Planned movements",
        pictures=(
            Picture(
                planned_movements_figure(made.figure_3),
                "As the paper's Fig 3: on the diagonals the ways out and back differ.",
                "Paths, joint angles and speed of sixteen planned movements",
            ),
            Picture(
                areas_figure(made.figure_3),
                "As Fig 4, for one of them: A_net = A_R − A_L, as a share of the squared way to "
                "the target. Out and back veer to the same side, which is hysteresis.",
                "Areas beside the straight line on the way out and on the way back",
            ),
        ),
    )


def people_section(made: Reproduction) -> Section:
    """Show what simulated people do, beside what the law fitted to them predicts."""
    found = [person.comparison for person in made.people]
    titles = [f"Person {i + 1}" for i in range(len(found))]
    lines = "Full lines: mean with one standard deviation; dashed: the model."
    return Section(
        "Simulated people",
        warning=GENERATED,
        pictures=(
            Picture(
                paths_figure(found, titles),
                "As Fig 5. Thick: A_net differs from zero; star: hysteresis (corrected after "
                "Holm). Dashed: the model.",
                "Mean paths out and back of each person, with predicted ones",
            ),
            Picture(
                net_areas_of_people_figure(found, titles),
                "As Fig 6. A_net as a share of the squared way to the target; star: the model "
                "differs (corrected).",
                "A_net of sixteen movements of each person, measured and predicted",
            ),
            Picture(
                joint_trajectories_figure(found, titles, made.figure_3.joints),
                f"As Fig 7. {lines}",
                "Joint angles to and from the east and the west, of each person",
            ),
            Picture(
                speed_figure(found[0]),
                f"As Fig 8, person 1. {lines}",
                "Speed over the movement, one panel a target",
            ),
        ),
        tables=(
            Table(
                tests_by_person(found),
                "How many movements or targets differ, by person: before correction, as in the "
                "paper, and in brackets after correction for all of a kind (Holm).",
            ),
        ),
    )


def tests_by_person(found: Sequence[Comparison]) -> pd.DataFrame:
    """Count the tests of each person that find a difference, before and after correction."""

    def count(tests: MeanTests) -> str:
        return f"{int((tests.p < LEVEL).sum())} ({int(tests.differs.sum())})"

    return pd.DataFrame(
        {
            "person": [i + 1 for i in range(len(found))],
            "curved (Asum ≠ 0), of 16": [count(one.sum_tests) for one in found],
            "veers (Anet ≠ 0), of 16": [count(one.net_tests) for one in found],
            "hysteresis, of 8": [count(one.hysteresis_tests) for one in found],
            "model differs, of 16": [count(one.model_tests) for one in found],
        }
    )
