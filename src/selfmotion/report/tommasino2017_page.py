"""The report of `selfmotion reproduce tommasino2017`: its table and figures, what they mean."""

import pandas as pd

from selfmotion.report.html import Footer, Page, Picture, Section, Table
from selfmotion.report.planner_figures import (
    joint_trajectories_figure,
    net_area_figure,
    paths_figure,
    planned_movements_figure,
    speed_figure,
)
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
            tables=(Table(numbers, "`kind` says what may be compared."),),
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
        ),
    )


def people_section(made: Reproduction) -> Section:
    """Show what simulated people do, beside what the law fitted to them predicts."""
    found = [person.comparison for person in made.people]
    titles = [f"Person {i + 1}" for i in range(len(found))]
    shown = "Person 1. Full lines: mean with one standard deviation; dashed: the model."
    tests = pd.concat(
        [one.to_frame().assign(person=i + 1) for i, one in enumerate(found)], ignore_index=True
    )
    # Person and test first: the table is long, and wide ones are cut on the right.
    first = ["person", "test"]
    dropped = [*first, "t", "df", "note", "against"]
    order = first + [name for name in tests.columns if name not in dropped]
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
                net_area_figure(found[0]),
                "As Fig 6, person 1. Star: the model differs (corrected).",
                "A_net of sixteen movements, measured and predicted",
            ),
            Picture(
                joint_trajectories_figure(found[0], made.figure_3.joints),
                f"As Fig 7. {shown}",
                "Joint angles to and from the east and the west",
            ),
            Picture(
                speed_figure(found[0]),
                f"As Fig 8. {shown}",
                "Speed over the movement, one panel a target",
            ),
        ),
        tables=(
            Table(
                tests.loc[:, order],
                "Tests of the means; A_sum cannot be negative, so that its test says nothing.",
            ),
        ),
    )
