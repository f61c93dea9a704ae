"""One look for all pictures: colours keep their meaning, every axis is drawn alike.

Task velocity is blue, null-space velocity orange, the unweighted baseline (W = I) grey. Joints
take the colours of Okabe and Ito (2008), which people with a colour vision deficiency can tell
apart, in their published order; the two colours spoken for are left out. Conditions differ by
line style and marker, so that a picture also reads in black and white.
"""

import functools
from collections.abc import Callable
from typing import Any, Literal, ParamSpec

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

TASK = "#0072B2"
NULL = "#E69F00"
BASELINE = "#8A8A8A"
INK = "#24292F"  # text and axes; the HTML report replaces it by the colour of its own text
GRID = "#D8DEE4"

# Okabe-Ito without orange (null space) and blue (task). Black comes late because it is also the
# colour of the axes, yellow last and darkened because it is faint on paper.
JOINT_COLOURS = ("#56B4E9", "#009E73", "#D55E00", "#CC79A7", INK, "#B8A900")
JOINT_DASHES = ("-", "--", ":")
CONDITION_LINES = ("-", "--", ":", "-.")
CONDITION_MARKERS = ("o", "s", "^", "D", "v", "P")

# Opacity of a band of one standard deviation.
BAND = 0.22

STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "text.color": INK,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "figure.dpi": 100,
    "svg.fonttype": "none",
    "svg.hashsalt": "selfmotion",
}

_P = ParamSpec("_P")
Share = bool | Literal["row", "col"]


def themed(draw: Callable[_P, Figure]) -> Callable[_P, Figure]:
    """Run a drawing function under the style; what it sets is undone afterwards."""

    @functools.wraps(draw)
    def styled(*args: _P.args, **kwargs: _P.kwargs) -> Figure:
        with matplotlib.rc_context(STYLE):
            figure = draw(*args, **kwargs)
            FigureCanvasAgg(figure)
            return figure

    return styled


def new_figure(
    n_rows: int = 1,
    n_columns: int = 1,
    *,
    size: tuple[float, float] = (6.4, 3.6),
    share_x: Share = False,
    share_y: Share = False,
) -> tuple[Figure, np.ndarray]:
    """Make a figure and its axes, always as an array (rows, columns).

    Args:
        n_rows: rows of panels.
        n_columns: columns of panels.
        size: width and height (inches).
        share_x: as in `Figure.subplots`: False, True, "row" or "col".
        share_y: the same for the vertical axis.
    """
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(n_rows, n_columns, squeeze=False, sharex=share_x, sharey=share_y)  # pyright: ignore[reportCallIssue, reportArgumentType]
    return figure, axes


def joint_colour(index: int) -> str:
    """Give the colour of the joint at a place in its arm."""
    return JOINT_COLOURS[index % len(JOINT_COLOURS)]


def joint_dash(index: int) -> str:
    """Give the line style of a joint; it changes where the colours start again."""
    return JOINT_DASHES[index // len(JOINT_COLOURS) % len(JOINT_DASHES)]


def condition_line(index: int) -> str:
    """Give the line style of the condition at a place in its study."""
    return CONDITION_LINES[index % len(CONDITION_LINES)]


def condition_marker(index: int) -> str:
    """Give the marker of the condition at a place in its study."""
    return CONDITION_MARKERS[index % len(CONDITION_MARKERS)]


def words(name: str) -> str:
    """Turn an identifier into words: ``shoulder_flexion`` to ``shoulder flexion``."""
    return name.replace("_", " ")


def zero_line(axes: Axes) -> None:
    """Draw the line y = 0 behind the data."""
    axes.axhline(0.0, color=BASELINE, linewidth=0.7, zorder=0.5)


def legend_below(figure: Figure, source: Axes, *, columns: int = 5) -> None:
    """Put the legend of an axes below all panels, where it covers no data."""
    handles, labels = source.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=min(columns, len(handles)))
