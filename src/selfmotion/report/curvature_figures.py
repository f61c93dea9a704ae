"""Pictures of curved paths: the paths beside their lines, net areas by direction, loops by target.

The hand's path has the colour of the task; the way back is lighter, what stands apart is grey.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.report.planner_figures import BACK
from selfmotion.report.theme import BASELINE, INK, TASK, legend_below, new_figure, themed, zero_line

Path = Sequence[Sequence[float]]
COLUMNS = 3
# Panels of people; the tables hold the others.
MOST_PANELS = 9
# So many letters fit below one panel.
LETTERS = 60


@themed
def curved_paths_figure(paths: Sequence[Path], movements: pd.DataFrame) -> Figure:
    """Draw every path as it is, with its straight line, one panel a person and side.

    Paths in space are seen along the axis in which they extend least.

    Args:
        paths: (samples, 2 or 3) of each movement, m; empty where it could not be measured.
        movements: subject, side, condition and stands_apart of each.
    """
    groups = _people(movements)
    figure, axes = _panels(len(groups), height=3.1)
    conditions = list(dict.fromkeys(movements["condition"].fillna("")))
    for ax, (title, rows) in zip(axes, groups.items(), strict=False):
        drawn = {i: np.array(paths[i]) for i in rows if len(paths[i])}
        ax.set_title(title)
        if not drawn:
            continue
        plane = _plane(drawn.values())
        for i, path in drawn.items():
            x, y = path[:, plane].T
            apart = bool(movements["stands_apart"].iloc[i])
            condition = movements["condition"].fillna("").iloc[i]
            colour = BASELINE if apart else colour_of(condition, conditions)
            ax.plot(x[[0, -1]], y[[0, -1]], color=BASELINE, linewidth=0.6, linestyle=":")
            ax.plot(x, y, color=colour, linewidth=0.9, alpha=0.8)
        ax.set_aspect("equal", adjustable="datalim")
        names = [("x", "y", "z")[axis] for axis in plane]
        ax.set_xlabel(f"{names[0]} (m)")
        ax.set_ylabel(f"{names[1]} (m)")
    first = axes[0]
    for condition in conditions:
        label = condition or "path"
        first.plot([], [], color=colour_of(condition, conditions), label=label)
    first.plot([], [], color=BASELINE, linestyle=":", label="straight line")
    if any(movements["stands_apart"].tolist()):
        first.plot([], [], color=BASELINE, label="stands apart")
    legend_below(figure, first)
    return figure


@themed
def net_areas_figure(movements: pd.DataFrame, tests: pd.DataFrame) -> Figure:
    """Draw A_net of each movement by direction, with its mean; a star where it differs from zero.

    Args:
        movements: subject, side, condition, target, a_net, stands_apart of each.
        tests: the tests of a_net.
    """
    usable = movements.loc[~movements["stands_apart"] & movements["a_net"].notna()]
    known = tests.loc[tests["measure"] == "a_net"]
    return _by_direction(
        usable.assign(way=_ways(usable)), known.assign(way=_ways(known)), "a_net", "A_net"
    )


@themed
def hysteresis_figure(loops: pd.DataFrame, tests: pd.DataFrame) -> Figure:
    """Draw the hysteresis of each loop by target, with its mean; a star where it is not zero."""
    known = tests.loc[tests["measure"] == "hysteresis"]
    return _by_direction(
        loops.assign(way=_ways(loops.assign(condition=None))),
        known.assign(way=_ways(known)),
        "hysteresis",
        "A_net out + back",
    )


def colour_of(condition: str, conditions: Sequence[str]) -> str:
    """Give the colour of a condition: the first and others of a study dark, the second light."""
    return BACK if len(conditions) > 1 and condition == conditions[1] else TASK


def _by_direction(rows: pd.DataFrame, tests: pd.DataFrame, value: str, label: str) -> Figure:
    groups = _people(rows)
    figure, axes = _panels(len(groups), height=2.9)
    for ax, (title, members) in zip(axes, groups.items(), strict=False):
        own = rows.iloc[members]
        ways = list(dict.fromkeys(own["way"]))
        tested = tests.iloc[_people(tests)[title]].set_index("way")
        zero_line(ax)
        for at, way in enumerate(ways):
            values = own.loc[own["way"] == way, value].to_numpy(dtype=float)
            # Side by side and not on top of each other.
            beside = np.linspace(-0.18, 0.18, len(values)) if len(values) > 1 else np.zeros(1)
            ax.plot(at + beside, values, "o", color=TASK, markersize=3.5, alpha=0.6)
            ax.plot([at - 0.3, at + 0.3], [values.mean()] * 2, color=INK, linewidth=1.4)
            if way in tested.index and bool(tested.loc[way, "differs"]):
                ax.annotate(
                    "*", (at, values.max()), (0, 3), textcoords="offset points", ha="center"
                )
        ax.margins(y=0.18)
        ax.set_xlim(-0.6, len(ways) - 0.4)
        turned = sum(map(len, ways)) > LETTERS / min(COLUMNS, len(groups))
        slant: dict[str, Any] = {"rotation": 60, "ha": "right", "rotation_mode": "anchor"}
        ax.set_xticks(range(len(ways)), ways, fontsize=8, **(slant if turned else {}))
        ax.set_title(title)
        ax.set_ylabel(label)
    first = axes[0]
    first.plot([], [], "o", color=TASK, markersize=3.5, label="one movement")
    first.plot([], [], color=INK, label="mean (*: differs from 0)")
    legend_below(figure, first)
    return figure


def _ways(rows: pd.DataFrame) -> list[str]:
    """Name each row by its condition and target."""
    both = rows.loc[:, ["condition", "target"]].to_dict("records")
    return [" ".join(str(v) for v in row.values() if v) or "all" for row in both]


def _people(rows: pd.DataFrame) -> dict[str, list[int]]:
    """Give row numbers by person and side, in order of appearance."""
    groups: dict[str, list[int]] = {}
    for i, row in enumerate(rows.loc[:, ["subject", "side"]].to_dict("records")):
        name = " ".join(str(value) for value in row.values() if value)
        groups.setdefault(name or "all movements", []).append(i)
    return groups


def _panels(count: int, *, height: float) -> tuple[Figure, list[Axes]]:
    shown = min(count, MOST_PANELS)
    columns = min(COLUMNS, shown)
    rows = -(-shown // columns)
    figure, axes = new_figure(rows, columns, size=(max(6.4, 3.2 * columns), height * rows + 0.4))
    for ax in axes.flat[shown:]:
        ax.set_visible(False)
    return figure, list(axes.flat[:shown])


def _plane(paths: Iterable[np.ndarray]) -> list[int]:
    """Give the two axes in which paths extend most, in order."""
    spread = np.sum([np.ptp(path, axis=0) for path in paths], axis=0)
    return sorted(np.argsort(spread)[-2:].tolist())
