"""Pictures of a study's people: swivel angle over the movement, shares of velocity, synergy."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.errors import RangeError
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.uncertainty import interval_factor
from selfmotion.report.theme import (
    BAND,
    BASELINE,
    INK,
    TASK,
    joint_colour,
    joint_dash,
    legend_below,
    new_figure,
    themed,
    words,
    zero_line,
)
from selfmotion.studies.study_statistics import Key
from selfmotion.studies.study_summary import weights_on_one_scale, weights_over_people

MOMENT = "percent_"
# Column of the shares, its name in the legend, its marker and the colours of edge and face.
SHARES = (
    ("task_share_identity", "all weights alike", "o", BASELINE, BASELINE),
    ("task_share", "weights of these movements", "s", TASK, TASK),
    ("task_share_others", "weights of the other conditions", "D", TASK, "white"),
)
COLUMNS = 4


@themed
def swivel_bands_figure(curves: pd.DataFrame, trials: pd.DataFrame) -> Figure:
    """Draw the swivel angle over 0 to 100 % of the movement, a line a person.

    Line and band are mean and standard deviation over a person's repeats. Dotted lines stand where
    the moments of the movement are on average.

    Args:
        curves: of a study run: subject, side, condition, file, percent, swivel_deg.
        trials: of the same, with ``percent_MOMENT``.
    """
    people = list(dict.fromkeys(curves["subject"]))
    panels = list(dict.fromkeys(zip(curves["side"], curves["condition"], strict=True)))
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    size = (1.2 + 2.1 * columns, 1.1 + 2.3 * rows)
    figure, axes = new_figure(rows, columns, size=size, share_x=True, share_y=True)
    for ax, (side, condition) in zip(axes.flat, panels, strict=False):
        part = _rows(curves, side, condition)
        for subject, own in part.groupby("subject", sort=False):
            place = people.index(subject)
            wide = own.pivot(index="percent", columns="file", values="swivel_deg")
            percent, angle = wide.index.to_numpy(float), wide.to_numpy(float)
            mean, spread = _middle(angle)
            colour, dash = joint_colour(place), joint_dash(place)
            ax.fill_between(
                percent, mean - spread, mean + spread, color=colour, alpha=BAND, linewidth=0
            )
            ax.plot(percent, mean, color=colour, linestyle=dash, linewidth=1.2)
        _mark_moments(ax, _rows(trials, side, condition))
        name = condition if isinstance(condition, str) else "all movements"
        ax.set_title(f"{name}, {side}" if isinstance(side, str) else name, fontsize=8.5)
        ax.set_xlim(0.0, 100.0)
    for ax in axes.flat[len(panels) :]:
        ax.set_visible(False)
    for place, subject in enumerate(people):  # one legend for all panels, whoever is in them
        axes.flat[0].plot(
            [], [], color=joint_colour(place), linestyle=joint_dash(place), label=str(subject)
        )
    label_bottom(axes, len(panels), "movement (%)")
    for ax in axes[:, 0]:
        ax.set_ylabel("swivel angle (deg)")
    legend_below(figure, axes.flat[0], columns=4)
    return figure


@themed
def people_weights_figure(estimates: Mapping[Key, WeightEstimate]) -> Figure:
    """Draw weights with a line a person: a row of panels for each side, a column a condition.

    Each person's level is fitted, since only ratios mean anything; black: mean over people and its
    95 % interval. Joints and panels in which nothing was identified are left out.

    Raises:
        RangeError: that is all of them.
    """
    panels = list(dict.fromkeys(key[1:] for key in estimates))
    tables = {panel: weights_on_one_scale(_of_panel(estimates, panel)) for panel in panels}
    panels = [panel for panel in panels if len(tables[panel])]
    if not panels:
        raise RangeError("weights of people: none was identified, nothing to draw")
    subjects = list(dict.fromkeys(key[0] for key in estimates))
    order = next(iter(estimates.values())).joints
    joints = [j for j in order if any(bool(np.any(t["joint"] == j)) for t in tables.values())]
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    size = (1.3 + max(1.9, 0.42 * len(joints)) * columns, 1.6 + 2.3 * rows)
    figure, axes = new_figure(rows, columns, size=size, share_x=True, share_y=True)
    for ax, panel in zip(axes.flat, panels, strict=False):
        part = _of_panel(estimates, panel)
        _weights_panel(
            ax,
            (subjects, joints),
            tables[panel],
            weights_over_people({(k, *panel): e for k, e in part.items()}),
        )
        side, condition = panel
        name = condition or "all movements"
        ax.set_title(f"{name}, {side}" if side else name, fontsize=8.5)
        known = tables[panel]["subject"].nunique()
        ax.text(0.03, 0.02, f"{known} of {len(part)} people", transform=ax.transAxes, fontsize=6.5)
    for ax in axes.flat[len(panels) :]:
        ax.set_visible(False)
    label_bottom(axes, len(panels), "")
    for ax in axes[:, 0]:
        ax.set_ylabel("IK weight (largest mean = 1)")
    for place, subject in enumerate(subjects):
        axes.flat[0].plot(
            [], [], color=joint_colour(place), linestyle=joint_dash(place), label=subject or "all"
        )
    legend_below(figure, axes.flat[0], columns=4)
    return figure


def _weights_panel(
    ax: Axes, order: tuple[list[str], list[str]], people: pd.DataFrame, mean: pd.DataFrame
) -> None:
    subjects, joints = order
    for subject, own in people.groupby("subject", sort=False):
        place = subjects.index(str(subject))
        weight = own.set_index("joint")["weight"].reindex(joints).to_numpy(float)
        sideways = 0.3 * (place + 0.5) / len(subjects) - 0.3
        ax.plot(
            np.arange(len(joints)) + sideways,
            weight,
            color=joint_colour(place),
            linestyle=joint_dash(place),
            marker="o",
            markersize=2.5,
            linewidth=0.8,
            alpha=0.8,
        )
    at = np.array([joints.index(j) for j in mean["joint"]]) + 0.15
    centre, low, high = (np.asarray(mean[k], dtype=float) for k in ("weight", "lower", "upper"))
    bars = np.nan_to_num(np.stack([centre - low, high - centre]))
    ax.errorbar(at, centre, bars, color=INK, marker="s", ms=3.5, capsize=2, ls="", linewidth=1.1)
    ax.set_yscale("log")
    ax.set_xticks(range(len(joints)), [words(j) for j in joints], rotation=60, ha="right")
    ax.tick_params(axis="x", labelsize=7)
    ax.set_xlim(-0.5, len(joints) - 0.5)


def _of_panel(
    estimates: Mapping[Key, WeightEstimate], panel: tuple[str, str]
) -> dict[str, WeightEstimate]:
    return {key[0]: e for key, e in estimates.items() if key[1:] == panel}


@themed
def shares_figure(groups: pd.DataFrame) -> Figure:
    """Draw task shares and synergy by condition: a point a person, mean and 95 % interval.

    Args:
        groups: of a study run: one row a person, side and condition.
    """
    sides = list(dict.fromkeys(groups["side"]))
    conditions = list(dict.fromkeys(groups["condition"]))
    width = 1.4 + 1.25 * len(conditions)
    figure, axes = new_figure(
        2, len(sides), size=(width * len(sides), 5.4), share_x=True, share_y="row"
    )
    for s, side in enumerate(sides):
        own = groups.loc[groups["side"] == side]
        top, bottom = axes[0, s], axes[1, s]
        for c, condition in enumerate(conditions):
            part = own.loc[own["condition"] == condition]
            for i, (column, label, marker, edge, face) in enumerate(SHARES):
                values = part[column].to_numpy(float)
                at = c + 0.26 * (i - 1)
                _people(top, at, values, (marker, edge, face), label if c == 0 else "")
            _people(bottom, c, part["synergy"].to_numpy(float), ("o", INK, INK), "")
        top.set_title(f"{side} arm" if side else "")
        top.set_ylim(0.0, 1.0)
        zero_line(bottom)
        bottom.set_xticks(range(len(conditions)), [words(c).replace(" ", "\n") for c in conditions])
        bottom.set_xlim(-0.5, len(conditions) - 0.5)
    axes[0, 0].set_ylabel("task share of squared\njoint velocity")
    axes[1, 0].set_ylabel("synergy index ΔV\n(above 0: the task is kept)")
    legend_below(figure, axes[0, 0], columns=3)
    return figure


def label_bottom(axes: np.ndarray, panels: int, text: str) -> None:
    """Label the horizontal axis of the lowest panel of each column, and show its ticks."""
    rows, columns = axes.shape
    for column in range(columns):
        shown = [row for row in range(rows) if row * columns + column < panels]
        if shown:
            axes[shown[-1], column].set_xlabel(text)
            axes[shown[-1], column].tick_params(labelbottom=True)


def _middle(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give mean and deviation (deg) over repeats; NaN where more than half of them are missing."""
    known = np.isfinite(angle)
    count = np.maximum(known.sum(axis=1), 1)
    mean = np.where(known, angle, 0.0).sum(axis=1) / count
    square = np.where(known, (angle - mean[:, None]) ** 2, 0.0).sum(axis=1) / count
    few = 2 * known.sum(axis=1) < angle.shape[1]
    return np.where(few, np.nan, mean), np.where(few, np.nan, np.sqrt(square))


def _people(
    ax: Axes, at: float, values: np.ndarray, look: tuple[str, str, str], label: str
) -> None:
    """Draw people as points, and their mean with its t-interval beside them."""
    marker, edge, face = look
    known = values[np.isfinite(values)]
    if not known.size:
        return
    sideways = 0.06 * (np.arange(len(known)) * 0.618 % 1.0 - 0.5)
    ax.plot(at - 0.05 + sideways, known, marker, color=edge, alpha=0.4, ms=2.8, mew=0, ls="")
    half = 0.0
    if len(known) > 1:
        half = interval_factor(0.95, len(known)) * known.std(ddof=1) / np.sqrt(len(known))
    ax.errorbar(
        [at + 0.06],
        [known.mean()],
        [half],
        color=edge,
        marker=marker,
        markerfacecolor=face,
        markersize=5,
        linewidth=1.1,
        capsize=2,
        ls="",
        label=label,
    )


def _mark_moments(ax: Axes, trials: pd.DataFrame) -> None:
    for column in [c for c in trials if c.startswith(MOMENT)]:
        percent = np.asarray(trials[column], dtype=float)
        if column.removeprefix(MOMENT) in ("start", "end") or np.isnan(percent).all():
            continue
        at = float(np.nanmean(percent))
        ax.axvline(at, color=INK, linestyle=":", linewidth=0.9, zorder=0.6)
        ax.annotate(
            words(column.removeprefix(MOMENT)),
            (at, 0.98),
            xycoords=("data", "axes fraction"),
            xytext=(-2, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=6.5,
        )


def _rows(table: pd.DataFrame, side: object, condition: object) -> pd.DataFrame:
    kept: Sequence[bool] = [
        _same(a, side) and _same(b, condition)
        for a, b in zip(table["side"], table["condition"], strict=True)
    ]
    return table.loc[np.asarray(kept, dtype=bool)]


def _same(a: object, b: object) -> bool:
    """Compare labels; a missing one equals a missing one."""
    return a == b or not (isinstance(a, str) or isinstance(b, str))
