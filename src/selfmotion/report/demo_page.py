"""The report of `selfmotion demo`: what the library makes of a laboratory's recordings."""

from pathlib import Path

import numpy as np

from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.manifold_figures import manifold_figure
from selfmotion.report.theme import words
from selfmotion.report.velocity_figures import (
    null_share_figure,
    null_velocity_figure,
    velocity_figure,
)
from selfmotion.report.weights_figures import contribution_figure, weights_figure
from selfmotion.studies.demonstration import Demonstration


def write_demo_report(path: str | Path, shown: Demonstration, provenance: Provenance) -> Path:
    """Write the report; give its path."""
    sections = [
        people_section(shown),
        weights_section(shown),
        test_section(shown),
        velocity_section(shown),
        manifold_section(shown),
        next_section(),
    ]
    footer = Footer((provenance,), ("Khoramshahi2022",))
    summary = (
        f"{len(shown.made.people)} generated people reach to three targets, freely and in a field "
        "that brakes shoulder flexion. From their joint angles alone the weights show who moves "
        "what, and that the field makes them use rotation in place of flexion."
    )
    return write_report(
        path,
        "What people do with the freedom of their arm",
        sections,
        summary=summary,
        footer=footer,
    )


def people_section(shown: Demonstration) -> Section:
    """Show what was recorded."""
    study = shown.study
    reaching = shown.reaching
    return Section(
        "The recordings",
        words=(
            f"{len(study)} movements, {study.n_samples} samples. The people are generated, with "
            "weights drawn around those of Khoramshahi et al. (2022), so that what is found can "
            "be held against the truth.",
        ),
        pictures=(
            Picture(
                velocity_figure(reaching.velocities, reaching.conditions),
                f"Joint velocities of {reaching.shown}, mean and standard deviation over trials.",
                "Joint velocities by target and condition",
            ),
        ),
    )


def weights_section(shown: Demonstration) -> Section:
    """Show weights and contributions."""
    reaching = shown.reaching
    centre = {
        c: tuple(np.exp(np.mean([np.log(p.weights[c]) for p in shown.made.people], axis=0)))
        for c in reaching.conditions
    }
    unknown = reaching.weights[reaching.weights["reason"] != ""]
    counts = unknown.groupby(["joint", "reason"], sort=False).size()
    everyone = len(shown.made.people) * len(reaching.conditions)
    return Section(
        "How costly each joint is",
        words=(
            "A weight is what it costs to move a joint for the hand; only ratios mean anything, "
            "and the dearest joint has weight 1.",
        ),
        points=tuple(
            f"{words(str(joint))}: not identified in {count} of {everyone} cases ({reason})."
            for (joint, reason), count in counts.items()  # pyright: ignore[reportGeneralTypeIssues]
        ),
        pictures=(
            Picture(
                weights_figure(reaching.weights, truth=centre),
                "Each point is a person; short bars are the true centre of the people.",
                "Weights of each joint in both conditions",
            ),
            Picture(
                contribution_figure(reaching.weights),
                "Contribution coefficients (eq. 26), mean over people; a joint whose weight has no "
                "effect (elbow flexion here) counts as 1.",
                "Contribution of each joint in both conditions",
            ),
        ),
    )


def test_section(shown: Demonstration) -> Section:
    """Say whether the conditions differ, and how true the weights are."""
    test = shown.reaching.test
    if test is None:
        sentence = "Too few people for a test of the conditions."
    else:
        sentence = (
            f"The conditions differ: Hotelling T² = {test.t2:.0f}, F({test.df[0]}, {test.df[1]}) "
            f"= {test.f:.1f}, p = {test.p_value:.2g} (by sign flips {test.p_permutation:.2g}), "
            f"on log-ratios of weights of {test.n_people} people."
        )
    tables = ()
    if shown.reaching.recovery is not None:
        table = shown.reaching.recovery.table.copy()
        table["ratio"] = [words(str(ratio)) for ratio in table["ratio"]]
        tables = (Table(table, "Identified against true log-ratios of weights."),)
    return Section("Do the conditions differ?", words=(sentence,), tables=tables)


def velocity_section(shown: Demonstration) -> Section:
    """Show task and null-space velocity."""
    reaching = shown.reaching
    return Section(
        "Task and null-space velocity",
        words=(
            "With all weights alike (W = I), what people prefer looks like self-motion; with "
            "their own weights little is left of it.",
        ),
        pictures=(
            Picture(
                null_velocity_figure(reaching.null, reaching.conditions),
                "Mean and standard deviation over people, reaches to the first target.",
                "Velocity and null-space velocity of each joint",
            ),
            Picture(
                null_share_figure(reaching.null, reaching.conditions),
                "Each line is a person.",
                "Null-space speed with identified weights and with W = I",
            ),
        ),
    )


def manifold_section(shown: Demonstration) -> Section:
    """Show variance over repetitions."""
    return Section(
        "Variance over repetitions",
        words=(
            "Variance along the uncontrolled manifold leaves the hand where it is, variance "
            "across it moves the hand. ΔV above 0 is called a synergy that stabilises the "
            "hand; here it is below 0, since the generated people aim anew in every trial.",
        ),
        pictures=(
            Picture(
                manifold_figure(shown.manifold),
                "Median and quartiles over people, conditions and targets.",
                "Variance along and across the uncontrolled manifold",
            ),
        ),
    )


def next_section() -> Section:
    """Say what to type next."""
    return Section(
        "With your own recordings",
        words=("The files beside this report are those of one person. Try:",),
        points=(
            "selfmotion weights reach.csv --arm exoskeleton --report weights.html",
            "selfmotion split reach.csv --arm exoskeleton --report split.html",
            "selfmotion arms, for the arms that are there; a model file (.xml, .urdf) does too",
            "selfmotion reproduce khoramshahi2022 --report paper.html",
        ),
    )
