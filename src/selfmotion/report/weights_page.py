"""The report of `selfmotion weights`: what was found, how sure it is, and what it means."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion.methods.coordination import (
    principal_components,
    relative_phase,
    velocity_correlation,
)
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.series import estimate_each
from selfmotion.motion.recording import Study
from selfmotion.report.convergence_figures import fit_history_figure
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.theme import words
from selfmotion.report.velocity_figures import split_figure
from selfmotion.report.weights_figures import (
    contribution_figure,
    ratio_error_figure,
    weights_figure,
)
from selfmotion.studies.velocity_profiles import split_bands
from selfmotion.studies.weight_tables import weight_table

Identify = Callable[[Study], WeightEstimate]
PEOPLE = "Each point is a person; large marks are the geometric mean with its 95 % interval."
ONE_PERSON = "The estimate with its 95 % interval (from the scatter between trials)."


def write_weights_report(
    path: str | Path, study: Study, pooled: WeightEstimate, identify: Identify
) -> Path:
    """Write the report on the weights of a study; give its path.

    Args:
        path: the HTML file.
        study: what was analysed, without gaps.
        pooled: the estimate from all of it.
        identify: how one part of it is estimated, for people and conditions.
    """
    people = estimates_of_people(study, identify)
    sections = [
        weights_section(pooled, people),
        identifiability_section(pooled),
        velocity_section(study, pooled),
        method_section(study, pooled),
        comparison_section(study),
    ]
    footer = Footer((pooled.provenance,), ("Khoramshahi2022",))
    title = "Joint preferences from recorded motion"
    return write_report(path, title, sections, summary=summary(pooled), footer=footer)


def estimates_of_people(study: Study, identify: Identify) -> dict[tuple[str, str], WeightEstimate]:
    """Estimate each person in each condition alone, as far as the labels tell them apart."""
    groups = study.group("subject", "condition")
    keys = {"\n".join(str(v) for v in key): key for key in groups}
    parts = {name: groups[key] for name, key in keys.items()}
    found = estimate_each(parts, identify)
    return {
        (keys[name][0] or "all people", keys[name][1] or "all movements"): estimate
        for name, estimate in found.items()
    }


def summary(pooled: WeightEstimate) -> str:
    """Say in two sentences what the reader should take home."""
    if not pooled.groups:
        return f"No ratio of weights could be identified: {pooled.status.sentence}."
    group = pooled.groups[0]
    order = sorted(group, key=lambda joint: pooled.weights[pooled.joints.index(joint)])
    share, alike = (
        f"{100.0 * (1.0 - left):.1f} %"
        for left in (pooled.unexplained, pooled.unexplained_identity)
    )
    return (
        f"For the hand, {words(order[0])} is the joint that is moved most readily, and "
        f"{words(order[-1])} the one that is spared. With these weights {share} of the "
        f"squared joint velocity serves the task; with all weights alike it would be {alike}."
    )


def weights_section(
    pooled: WeightEstimate, people: Mapping[tuple[str, str], WeightEstimate]
) -> Section:
    """Show weights and contributions, with people as points."""
    table = weight_table(people)
    shown = pooled.to_frame().drop(columns=["group", "reason"])
    shown["joint"] = [words(joint) for joint in shown["joint"]]
    return Section(
        "Weights",
        words=(
            "A weight is what it costs to move a joint for the hand: the joint velocities are "
            "those of least weighted square that move the hand as recorded. Only ratios mean "
            "anything; the dearest joint of a group has weight 1. The contribution β is the "
            "inverse, scaled to add up to 1.",
        ),
        pictures=(
            Picture(
                weights_figure(table),
                PEOPLE if len({s for s, _ in people}) > 1 else ONE_PERSON,
                "Inverse-kinematics weights of each joint, by person and condition",
            ),
            Picture(
                contribution_figure(table),
                "Contribution coefficients (eq. 26); joints whose weight has no effect count as 1.",
                "Stacked bars of the contribution of each joint, by condition",
            ),
        ),
        tables=(
            Table(
                shown,
                "All movements pooled. lower, upper: 95 % limits of the weight; stderr_log: "
                "standard error of the logarithm of its ratio to the largest.",
            ),
        ),
    )


def identifiability_section(pooled: WeightEstimate) -> Section:
    """Say in words what the data can and cannot tell."""
    points = [
        f"{', '.join(words(j) for j in group)}: their ratios are identified."
        for group in pooled.groups
    ]
    points += [f"{words(joint)}: {reason}." for joint, reason in pooled.unidentifiable.items()]
    errors = ratio_errors(pooled)
    pictures = ()
    if len(pooled.joints) > 1:
        pictures = (
            Picture(
                ratio_error_figure(errors, pooled.joints),
                "How well each pair of joints can be compared. A dash: not at all.",
                "Standard error of the log-ratio of weights for each pair of joints",
            ),
        )
    return Section(
        "What the data can tell",
        words=(f"Standard errors: {pooled.stderr_kind}.",),
        points=tuple(points),
        pictures=pictures,
        warning="" if pooled.status.ok else pooled.status.sentence,
    )


def ratio_errors(estimate: WeightEstimate) -> np.ndarray:
    """Give the standard error of each log-ratio (n, n), infinite where it is not identified."""
    n = len(estimate.joints)
    errors = np.full((n, n), np.inf)
    for i in range(n):
        for j in range(n):
            found = estimate.log_ratio(estimate.joints[i], estimate.joints[j])[1]
            errors[i, j] = found if np.isfinite(found) else np.inf
    return errors


def velocity_section(study: Study, pooled: WeightEstimate) -> Section:
    """Show which part of each joint's velocity serves the hand."""
    bands = split_bands(study, pooled.full_weights)
    return Section(
        "Task and null-space velocity",
        words=(
            "Joint velocity is the sum of a part that moves the hand and a part that does not "
            "(self-motion). How it is shared depends on the weights: with all weights alike, "
            "what a person prefers looks like self-motion.",
        ),
        pictures=(
            Picture(
                split_figure(bands),
                "Mean and standard deviation over movements, by progress of the movement.",
                "Task and null-space velocity of each joint over the movement",
            ),
        ),
    )


def method_section(study: Study, pooled: WeightEstimate) -> Section:
    """Say how the numbers came about."""
    pictures = ()
    if len(pooled.history) > 1:
        pictures = (
            Picture(
                fit_history_figure(pooled.history, pooled.joints, method=pooled.method),
                f"Convergence: {pooled.status.sentence}.",
                "Weights from iteration to iteration",
            ),
        )
    index = study.index
    words_ = (
        f"{pooled.n_samples} samples of {pooled.n_trials} movements from "
        f"{index['source'].nunique()} file(s). {pooled.n_rank_deficient} samples in which the "
        "arm was singular were left out.",
    )
    return Section("Data and convergence", words=words_, pictures=pictures)


def comparison_section(study: Study) -> Section:
    """Show the measures that are usually taken, which know nothing of the task."""
    names = [words(joint) for joint in study.joints]
    correlation = pd.DataFrame(velocity_correlation(study), columns=names)
    correlation.insert(0, "joint", names)
    shares = principal_components(study).share
    share_row = pd.DataFrame([shares], columns=[f"component {i + 1}" for i in range(len(shares))])
    tables = [
        Table(correlation, "Correlation of joint velocities."),
        Table(share_row, "Share of the variance of joint velocity by principal component."),
    ]
    if all(r.q is not None and r.n_samples > 1 for r in study):
        phase = np.degrees(relative_phase(study).mean_absolute)
        table = pd.DataFrame(phase, columns=names)
        table.insert(0, "joint", names)
        caption = "Mean absolute continuous relative phase (degrees; 0: in phase, 180: opposite)."
        tables.append(Table(table, caption))
    return Section(
        "For comparison: measures that do not know the task",
        words=(
            "Correlations and principal components describe which joints move together, not "
            "what for: they change when the targets change, even if the person does not.",
        ),
        tables=tuple(tables),
    )
