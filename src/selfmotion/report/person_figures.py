"""Figures of one person: natural postures, plans beside recordings, what a splint changes."""

import numpy as np
import pandas as pd
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.report.theme import (
    BASELINE,
    INK,
    JOINT_COLOURS,
    TASK,
    legend_below,
    new_figure,
    themed,
    words,
)
from selfmotion.studies.people_means import rows_of
from selfmotion.studies.splint_change import SplintChange

BEFORE, AFTER = TASK, JOINT_COLOURS[2]
# More names than these would run into each other.
FEW_TASKS = 3
MODEL_COLOURS = (TASK, JOINT_COLOURS[1], BASELINE)


@themed
def weights_of_person_figure(estimate: WeightEstimate) -> Figure:
    """Draw the weights that are identified, with their 95 % intervals."""
    known = np.flatnonzero(np.isfinite(estimate.weights))
    figure, axes = new_figure(1, 1, size=(6.4, 1.2 + 0.32 * len(known)))
    ax, y, w = axes[0, 0], np.arange(len(known)), estimate.weights[known]
    low, high = estimate.interval()[known].T
    ax.hlines(y, low, high, color=TASK, linewidth=1.6)
    ax.plot(w, y, "o", color=TASK, markersize=6)
    ax.set_xscale("log")
    plain_ticks(ax.xaxis)
    ax.set_yticks(y, [words(estimate.joints[i]) for i in known])
    ax.invert_yaxis()
    ax.grid(axis="x")
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("weight (the larger, the more the joint is spared)")
    return figure


@themed
def natural_posture_figure(postures: pd.DataFrame) -> Figure:
    """Draw natural and predicted swivel angles by task and moment.

    Args:
        postures: table of `one_person.OnePerson.postures`.
    """
    kinds = list(dict.fromkeys(zip(postures["task"], postures["moment"], strict=True)))
    figure, axes = new_figure(1, 1, size=(6.4, 1.6 + 0.5 * len(kinds)))
    ax = axes[0, 0]
    marks = (
        ("natural_deg", "recorded", INK, "o"),
        ("effort_deg", "least effort", TASK, "s"),
        ("bounded_deg", "least effort in the ranges used otherwise", JOINT_COLOURS[1], "D"),
    )
    for row, (task, moment) in enumerate(kinds):
        part = rows_of(postures, {"task": task, "moment": moment})
        for j, (column, name, colour, marker) in enumerate(marks):
            y = np.full(len(part), row + 0.22 * (j - 1))
            label = name if row == 0 else None
            ax.plot(part[column], y, marker, color=colour, alpha=0.75, label=label, markersize=5)
    ax.set_yticks(range(len(kinds)), [f"{words(t)}, {words(m)}" for t, m in kinds])
    ax.set_ylim(len(kinds) - 0.5, -0.5)
    ax.grid(axis="x")
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("swivel angle (°)")
    legend_below(figure, ax, columns=3)
    return figure


@themed
def plans_figure(plans: pd.DataFrame) -> Figure:
    """Draw how far planned movements are from recorded ones, by task and model."""
    tasks, models = (list(dict.fromkeys(plans[c])) for c in ("task", "model"))
    columns = (
        ("apart_mm", "path, rms distance (mm)"),
        ("posture_error_deg", "posture at the end,\nrms over joints (°)"),
        ("swivel_error_deg", "swivel angle at the end,\nerror (°)"),
    )
    figure, axes = new_figure(1, 3, size=(7.4, 3.0))
    for ax, (column, label) in zip(axes[0], columns, strict=True):
        for i, model in enumerate(models):
            for j, task in enumerate(tasks):
                part = rows_of(plans, {"task": task, "model": model})[column].to_numpy(float)
                part = part[np.isfinite(part)]
                x = j + 0.24 * (i - 1)
                colour = MODEL_COLOURS[i % 3]
                ax.plot(np.full(len(part), x), part, "o", color=colour, alpha=0.45, markersize=3.5)
                if len(part):
                    ax.plot([x - 0.1, x + 0.1], [part.mean()] * 2, color=colour, linewidth=2.2)
            ax.plot([], [], color=MODEL_COLOURS[i % 3], linewidth=2.2, label=model)
        ax.set_xticks(range(len(tasks)), [words(t).replace(" ", "\n") for t in tasks])
        if len(tasks) > FEW_TASKS:
            ax.tick_params(axis="x", labelrotation=45)
        ax.set_ylabel(label)
        ax.set_ylim(bottom=0.0)
    legend_below(figure, axes[0, 0], columns=3)
    return figure


@themed
def compensation_figure(change: SplintChange) -> Figure:
    """Draw how far each joint moves in a movement, without and with the splint."""
    moved = np.degrees(np.maximum(change.excursion_before, change.excursion_after)) > 0.1
    joints = [j for j, m in zip(change.joints, moved, strict=True) if m]
    figure, axes = new_figure(1, 1, size=(6.4, 1.5 + 0.42 * len(joints)))
    ax = axes[0, 0]
    y = np.arange(len(joints))
    for shift, values, colour, label in (
        (-0.19, change.excursion_before, BEFORE, "all ranges"),
        (0.19, change.excursion_after, AFTER, "with the splint"),
    ):
        ax.barh(y + shift, np.degrees(values[moved]), height=0.36, color=colour, label=label)
    ax.set_yticks(y, [words(joint) for joint in joints])
    ax.invert_yaxis()
    ax.grid(axis="x")
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("range in a movement, mean over movements (°)")
    legend_below(figure, ax, columns=2)
    return figure


@themed
def weights_change_figure(change: SplintChange) -> Figure:
    """Draw the weights that would be identified without and with the splint."""
    figure, axes = new_figure(1, 1, size=(6.4, 3.0))
    ax = axes[0, 0]
    shown = [
        (estimate, colour, marker, label, shift)
        for estimate, colour, marker, label, shift in (
            (change.before, BEFORE, "o", "all ranges", -0.1),
            (change.after, AFTER, "s", "with the splint", 0.1),
        )
        if estimate is not None
    ]
    known = np.zeros(len(change.joints), dtype=bool)
    for estimate, *_ in shown:
        known |= np.isfinite(estimate.weights)
    joints = np.flatnonzero(known)
    for estimate, colour, marker, label, shift in shown:
        w = estimate.weights[joints]
        ax.plot(np.arange(len(joints)) + shift, w, marker, color=colour, label=label, markersize=6)
    ax.set_yscale("log")
    plain_ticks(ax.yaxis)
    ax.set_xticks(range(len(joints)), [words(change.joints[i]).replace(" ", "\n") for i in joints])
    ax.set_ylabel("weight (largest is 1)")
    legend_below(figure, ax, columns=2)
    return figure


def plain_ticks(axis: Axis) -> None:
    """Write the ticks of a logarithmic axis as numbers, not as powers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
