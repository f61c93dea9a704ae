"""The report of `selfmotion reproduce khoramshahi2022`: its figures, its table, what they mean."""

import numpy as np
import pandas as pd

from selfmotion.report.convergence_figures import (
    convergence_figure,
    gamma_figure,
    noise_figure,
    two_joint_figure,
)
from selfmotion.report.html import Footer, Page, Picture, Section, Table
from selfmotion.report.velocity_figures import (
    null_share_figure,
    null_velocity_figure,
    velocity_figure,
)
from selfmotion.report.weights_figures import contribution_figure, weights_figure
from selfmotion.studies.khoramshahi2022 import Reproduction
from selfmotion.studies.reaching_study import ReachingResult
from selfmotion.studies.screen_study import ScreenResult

WHAT_WEIGHTS_ARE = (
    "A weight says how costly it is for this person to move a joint in order to move the hand. "
    "Only ratios mean something: doubling all weights changes nothing that can be observed."
)
WHAT_GROUPS_ARE = (
    "Two joints can be compared only if they can stand in for each other: if some movement of "
    "both leaves the hand where it is. Joints that can be compared, directly or through others, "
    "form a group; the largest weight of each group is set to 1, and weights of different groups "
    "have nothing to do with each other."
)
WHAT_NOT_IDENTIFIED_IS = (
    "A joint is given no weight where the data cannot tell it: because no other joint could do "
    "its work, because it did not move, because the movements made did not call on the choice, "
    "or because the uncertainty is larger than the factor e (2.7). Such a joint is shown in words "
    "and not as a number."
)
GENERATED = (
    "The published recordings are not at hand. These people are generated, with weights drawn "
    "around the published ones: agreement with the paper is built in and proves nothing. What "
    "can be learnt here is whether the method finds the weights that the people have."
)
GENERATED_AT_THE_SCREEN = (
    "The published recordings are not at hand. These people are generated: how they move is our "
    "own design, and only their preference for the elbow in Natural is taken from Table 1. What "
    "the other conditions give follows from that design and need not agree with the paper."
)

ESTIMATORS = {
    "ml": "maximum likelihood",
    "paper": "Algorithm 1",
    "feedback": "with posture feedback",
}


def khoramshahi2022_page(made: Reproduction) -> Page:
    """Give the report on a reproduction."""
    summary = (
        f"{len(made.table)} published numbers beside ours; {made.table['comparable'].sum()} of "
        "them can be compared."
    )
    sections = [comparison_section(made), *example_sections(made)]
    sections += [*reaching_sections(made.reaching), screen_section(made.screen)]
    footer = Footer((made.provenance,), ("Khoramshahi2022",))
    title = "Khoramshahi et al. 2022, computed again"
    return Page(title, tuple(sections), summary, footer)


def comparison_section(made: Reproduction) -> Section:
    """Show the published numbers beside ours, and our weights beside the authors'."""
    numbers = made.table.drop(columns=["unit", "comparable"])
    tables = [Table(numbers, "Published numbers beside ours; “kind” says what may be compared.")]
    if made.authors is not None:
        tables.append(Table(made.authors, "Weights of the authors beside ours (largest = 1)."))
    return Section(
        "Published numbers beside ours",
        words=(WHAT_WEIGHTS_ARE, WHAT_GROUPS_ARE, WHAT_NOT_IDENTIFIED_IS),
        tables=tuple(tables),
    )


def example_sections(made: Reproduction) -> list[Section]:
    """Show both numerical examples and the error against noise."""
    repeats = len(made.fig1.weights)
    return [
        Section(
            "Example 1: random chains",
            pictures=(
                Picture(
                    convergence_figure(made.fig1),
                    f"As the paper's Fig 1. Mean and standard deviation of {repeats} data sets; "
                    f"the mean norm of the final error is {made.fig1.final_error:.3f}.",
                    "Five weights against iterations; each settles a little above its true value",
                ),
                Picture(
                    gamma_figure(made.fig2),
                    "As Fig 2. The larger γ, the slower; all end alike, and γ = 1 never moves.",
                    "Error of the weights against iterations, one falling line for each γ",
                ),
                Picture(
                    noise_figure(made.noise),
                    "As S1 File: error against null-space noise (mean and standard deviation). "
                    "Algorithm 1 is biased by it; maximum likelihood much less as long as the "
                    "noise leaves the hand alone.",
                    "Error against noise: the paper's algorithm rises faster than the other",
                ),
            ),
        ),
        Section(
            "Example 2: two joints with a busy null space",
            pictures=(
                Picture(
                    two_joint_figure(made.fig3),
                    "As Fig 3. With γ = 0 the weights end the wrong way round; with 0.2 and 0.4 "
                    "they do not settle; from 0.5 on they do, closer to the truth the larger γ "
                    "is. With the printed schedule they freeze on the way.",
                    "Two weights against iterations, one panel for each γ",
                ),
            ),
        ),
    ]


def reaching_sections(result: ReachingResult) -> list[Section]:
    """Show experiment 1."""
    table, conditions = result.weights, result.conditions
    ml = table.loc[table["method"] == "ml"]
    test = "" if result.test is None else f" Log-ratios of the two conditions: {result.test}."
    weights = Section(
        "Experiment 1: reaching in a viscous field",
        warning=GENERATED if result.generated else "",
        pictures=(
            Picture(
                velocity_figure(result.velocities, conditions),
                f"As Fig 5. Mean and standard deviation over trials of person {result.shown}.",
                "Joint velocities of one person by target and condition",
            ),
            Picture(
                weights_figure(ml, truth=_centre(result)),
                "As Fig 6, by maximum likelihood. Points are people; geometric mean with 95 % "
                f"interval.{test}",
                "Weights of each joint by condition, people as points",
            ),
            Picture(
                null_velocity_figure(result.null, conditions),
                "As Fig 7, first target. Mean over all movements of all people, with standard "
                "deviation.",
                "Joint velocity and null-space velocity with identified weights and with W = I",
            ),
            Picture(
                null_share_figure(result.null, conditions),
                "The same in numbers: each line is a person. With W = I, preference is mistaken "
                "for self-motion.",
                "Null-space speed of each person, smaller with identified weights",
            ),
        ),
    )
    return [weights, *_recovery(result.recovery and result.recovery.table)]


def _centre(result: ReachingResult) -> dict[str, tuple[float, ...]] | None:
    """Give the geometric mean of the true weights by condition; None for recorded people."""
    if not result.truth:
        return None
    means = {}
    for condition in result.conditions:
        logs = [np.log(w) for (_, c), w in result.truth.items() if c == condition]
        means[condition] = tuple(np.exp(np.mean(logs, axis=0)).tolist())
    return means


def _recovery(table: pd.DataFrame | None) -> list[Section]:
    if table is None:
        return []
    lowest = float(np.nanmin(table.loc[table["method"] == "ml", "coverage"]))
    return [
        Section(
            "Are the true weights found?",
            words=(
                "Generated people have known weights. Bias is the mean error of a log-ratio (0.1 "
                "is ten per cent), coverage the share of people whose 95 % interval holds the "
                f"truth. For maximum likelihood it is at least {100 * lowest:.0f} %: "
                "null-space motion that posture drives is not independent of the task. The paper's "
                "Algorithm 1 was stopped early, as it must be: it creeps.",
            ),
            tables=(Table(in_words(table), "Identified against true log-ratios, by estimator."),),
        )
    ]


def in_words(recovery: pd.DataFrame) -> pd.DataFrame:
    """Name estimators and joints as a person reads them."""
    return recovery.assign(
        method=[ESTIMATORS[name] for name in recovery["method"]],
        ratio=recovery["ratio"].str.replace("_", " "),
    )


def screen_section(result: ScreenResult) -> Section:
    """Show experiment 2."""
    table = result.weights
    ml, paper = (table.loc[table["method"] == m] for m in ("ml", "paper"))
    tables = ()
    if result.recovery is not None:
        caption = "Identified against true log-ratios where the person chooses all three joints."
        tables = (Table(in_words(result.recovery.table), caption),)
    return Section(
        "Experiment 2: an elbow that is not one's own",
        warning=GENERATED_AT_THE_SCREEN if result.generated else "",
        words=(
            "With a locked elbow two joints are left for a plane: there is no redundancy, and no "
            "data can tell which of them is preferred. Algorithm 1 gives numbers all the same; "
            "they describe the movement, not the person.",
        ),
        pictures=(
            Picture(
                weights_figure(ml),
                "As Fig 9, by maximum likelihood: where nothing can be told, nothing is shown.",
                "Weights of hip, shoulder and elbow in four conditions",
            ),
            Picture(
                weights_figure(paper.assign(weight=paper["full_weight"], identified=True)),
                "As Fig 9, by Algorithm 1: all numbers that it gives.",
                "Weights of hip, shoulder and elbow in four conditions, by Algorithm 1",
            ),
            Picture(
                contribution_figure(paper),
                "As Table 1: contribution coefficients by Algorithm 1, mean of people.",
                "Stacked bars of the contributions of hip, shoulder and elbow",
            ),
        ),
        tables=tables,
    )
