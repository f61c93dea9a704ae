"""Pictures of Donders surfaces, predicted postures and planned reaches of recorded people.

Each dot is a person; bars are means over people with 95 % intervals. What was recorded is drawn in
ink, plans have the colour of the task, baselines are grey.
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.report.theme import (
    BASELINE,
    INK,
    NULL,
    TASK,
    joint_colour,
    legend_below,
    new_figure,
    themed,
    zero_line,
)
from selfmotion.studies.donders_paths import MODELS, PASSIVE, PLAIN_JERK
from selfmotion.studies.donders_people import DondersPeople, Shown, rms_by_person
from selfmotion.studies.donders_postures import SEGMENTS
from selfmotion.studies.donders_predictions import (
    EFFORT,
    LAW,
    MEAN,
    PREDICTORS,
    REPEAT,
    REPEATS,
    SURFACE,
)
from selfmotion.studies.donders_predictions import (
    TASK as WHOLE_TASK,
)
from selfmotion.studies.donders_surfaces import ALL_TASKS
from selfmotion.studies.people_means import grouped, interval, rows_of

COLOURS = {LAW: TASK, SURFACE: NULL, MEAN: BASELINE, REPEATS: INK, EFFORT: "#CC79A7"}
PATH_LINES = {PASSIVE: (TASK, "-"), PLAIN_JERK: (BASELINE, "--")}


@themed
def surface_figure(shown: Shown) -> Figure:
    """Draw a person's upper-arm surface: torsion over the two directions, with the postures."""
    postures, surface = shown.postures, shown.surface
    figure, axes = new_figure(1, 2, size=(8.6, 3.8))
    some = postures.on_path
    torsion, a, b = np.degrees(surface.components(postures.rotations["shoulder"][some])).T
    residual = np.degrees(surface.residual(postures.rotations["shoulder"][some]))
    map_of, beside = axes[0]
    grid = np.meshgrid(np.linspace(a.min(), a.max(), 60), np.linspace(b.min(), b.max(), 60))
    height = np.degrees(surface.surface.torsion(*(np.radians(g) for g in grid)))
    lines = map_of.contour(*grid, height, levels=10, colors=BASELINE, linewidths=0.8)
    map_of.clabel(lines, fmt="%.0f°", fontsize=7)
    names = list(dict.fromkeys(postures.condition.tolist()))
    for i, name in enumerate(names):
        own = postures.condition[some] == name
        dots = {"color": joint_colour(i), "markersize": 3.0, "linestyle": "none"}
        map_of.plot(a[own], b[own], marker="o", label=name, **dots)
        beside.plot(torsion[own], residual[own], marker="o", **dots)
    map_of.set(xlabel="direction a of the upper arm (°)", ylabel="direction b (°)")
    map_of.set_title("Postures, and torsion of the surface")
    zero_line(beside)
    beside.set(xlabel="torsion (°)", ylabel="torsion beside the surface (°)")
    beside.set_title("What remains")
    legend_below(figure, map_of)
    return figure


@themed
def thickness_figure(run: DondersPeople) -> Figure:
    """Draw the held-out thickness by task, one panel a segment, beside torsion without surface."""
    tasks = list(dict.fromkeys(run.surfaces["task"]))
    figure, axes = new_figure(1, len(SEGMENTS), size=(9.2, 3.6), share_y=True)
    for ax, segment in zip(axes[0], SEGMENTS, strict=True):
        part = rows_of(run.surfaces, {"segment": segment})
        _bars(ax, part, tasks, "torsion_deg", (-0.2, BASELINE, "torsion, no surface"))
        _bars(ax, part, tasks, "held_out_deg", (0.2, TASK, "beside the surface, repeats held out"))
        ax.set_xticks(np.arange(len(tasks)), tasks, rotation=30, ha="right")
        ax.set_title(segment)
    axes[0, 0].set_ylim(bottom=0.0)
    axes[0, 0].set_ylabel("standard deviation (°)")
    if ALL_TASKS in tasks:
        for ax in axes[0]:
            ax.axvline(tasks.index(ALL_TASKS) - 0.5, color=BASELINE, linewidth=0.7)
    legend_below(figure, axes[0, 0])
    return figure


@themed
def prediction_figure(run: DondersPeople) -> Figure:
    """Draw the error of each predictor: a repeat left out, a task left out, on path and moments."""
    rms = rms_by_person(run.predictions)
    effort = rows_of(rms, {"predictor": EFFORT})
    titles = {REPEAT: "a repeat of each task left out", WHOLE_TASK: "a whole task left out"}
    figure, axes = new_figure(1, 2, size=(8.6, 3.8), share_y=True)
    for ax, (kind, title) in zip(axes[0], titles.items(), strict=True):
        at, labels, start = [], [], 0.0
        for place in ("path", "moments"):
            some = rows_of(rms, {"left_out": kind, "place": place})
            groups = [(p, rows_of(some, {"predictor": p})) for p in PREDICTORS]
            groups += [(EFFORT, effort)] if place == "moments" else []
            groups = [(name, rows) for name, rows in groups if len(rows)]
            for i, (name, rows) in enumerate(groups):
                _one(
                    ax, start + i, np.array(rows["rms_deg"], dtype=np.float64), COLOURS[name], name
                )
            if groups:
                at.append(start + 0.5 * (len(groups) - 1))
                labels.append("along the path" if place == "path" else "at the moments")
            start += len(groups) + 1.0
        ax.set_xticks(at, labels)
        ax.set_title(title)
    axes[0, 0].set_ylim(bottom=0.0)
    axes[0, 0].set_ylabel("error of the swivel angle, rms (°)")
    _legend_once(figure, axes[0])
    return figure


@themed
def reaches_figure(run: DondersPeople) -> Figure:
    """Draw each person's reaches from above, recorded and planned, one row a task."""
    tasks = list(dict.fromkeys(reach.task for one in run.shown for reach in one.reaches))
    figure, axes = new_figure(
        max(len(tasks), 1),
        len(run.shown),
        size=(1.5 * len(run.shown) + 1.2, 2.3 * len(tasks) + 0.6),
    )
    for column, one in enumerate(run.shown):
        arm = one.postures.arm
        right = np.cross(arm.forward, arm.up)
        for row, task in enumerate(tasks):
            ax = axes[row, column]
            for i, reach in enumerate(r for r in one.reaches if r.task == task):
                _from_above(ax, reach.recorded, (right, arm.forward), (INK, "-"), i, "recorded")
                for model, line in PATH_LINES.items():
                    _from_above(ax, reach.planned[model], (right, arm.forward), line, i, model)
            ax.set_aspect("equal", adjustable="datalim")
            ax.grid(visible=False)
            if row == 0:
                ax.set_title(one.postures.subject)
            if column == 0:
                ax.set_ylabel(f"{task}\nforward (cm)")
            if row == len(tasks) - 1:
                ax.set_xlabel("right (cm)")
    if tasks:
        legend_below(figure, axes[0, 0])
    return figure


@themed
def plans_figure(run: DondersPeople) -> Figure:
    """Draw how far each model's reaches are from the recorded ones: path and end posture."""
    figure, axes = new_figure(1, 2, size=(8.6, 3.6))
    table = run.reaches.assign(swivel=run.reaches["swivel_error_deg"].abs())
    tasks = list(dict.fromkeys(table["task"]))
    measures = (("apart_mm", "distance of the paths, rms (mm)"), ("swivel", "end swivel error (°)"))
    colours = (TASK, NULL, "#56B4E9", BASELINE)
    for ax, (measure, label) in zip(axes[0], measures, strict=True):
        for i, (model, colour) in enumerate(zip(MODELS, colours, strict=True)):
            part = rows_of(table, {"model": model})
            _bars(ax, part, tasks, measure, ((i - 1.5) * 0.2, colour, model))
        ax.set_xticks(np.arange(len(tasks)), tasks)
        ax.set_ylabel(label)
        ax.set_ylim(bottom=0.0)
    legend_below(figure, axes[0, 0], columns=4)
    return figure


def _bars(
    ax: Axes,
    part: pd.DataFrame,
    tasks: list[str],
    measure: str,
    look: tuple[float, str, str],
) -> None:
    """Draw a person's means as dots beside mean and interval, for each task."""
    shift, colour, label = look
    for i, task in enumerate(tasks):
        own = grouped(rows_of(part, {"task": task}), measure, ["subject", "side"])
        each = [float(np.mean(values)) for values in own.values()]
        _one(ax, i + shift, np.array(each), colour, label if i == 0 else "")


def _one(ax: Axes, at: float, values: np.ndarray, colour: str, label: str) -> None:
    """Draw people as dots, with their mean and its 95 % interval."""
    known = values[np.isfinite(values)]
    if not len(known):
        return
    mean, half = interval(known)
    ax.plot(np.full(len(known), at), known, "o", color=colour, alpha=0.35, markersize=3.0)
    spread = 0.0 if np.isnan(half) else half
    ax.errorbar([at], [mean], yerr=spread, fmt="s", color=colour, capsize=3, label=label or None)


def _from_above(
    ax: Axes,
    path: np.ndarray,
    axes: tuple[np.ndarray, np.ndarray],
    line: tuple[str, str],
    index: int,
    label: str,
) -> None:
    from_start = 100.0 * (path - path[0])
    x, y = (from_start @ axis for axis in axes)
    colour, style = line
    said = label if index == 0 else None
    ax.plot(x, y, style, color=colour, linewidth=1.0, alpha=0.8, label=said)


def _legend_once(figure: Figure, axes: np.ndarray) -> None:
    """Put one entry a name below all panels."""
    entries = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=5)
