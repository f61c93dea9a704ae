"""Pictures of variance over repetitions: along and across the uncontrolled manifold."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from selfmotion.errors import ShapeError
from selfmotion.methods.uncontrolled_manifold import ManifoldVariance
from selfmotion.report.theme import NULL, TASK, legend_below, new_figure, themed, zero_line

UNITS = {"q": "rad²", "qd": "(rad/s)²"}


@themed
def manifold_figure(variances: Mapping[tuple[str | None, ...], ManifoldVariance]) -> Figure:
    """Draw variance per dimension, along (null space) and across (task), and the synergy index.

    Args:
        variances: by labels; the lines are the mean over them, the bands their spread.

    Raises:
        ShapeError: the variances are of different variables or phases.
    """
    all_of_them = list(variances.values())
    first = all_of_them[0]
    same = all(
        v.variable == first.variable and len(v.phase) == len(first.phase) for v in all_of_them
    )
    if not same:
        raise ShapeError("manifold variances are of different variables or phases")
    figure, axes = new_figure(1, 2, size=(6.8, 3.0), share_x=True)
    percent = 100.0 * first.phase
    left, right = axes[0]
    for name, colour, label in (
        ("along", NULL, "along the manifold (null space)"),
        ("across", TASK, "across it (task)"),
    ):
        stack = np.array([getattr(v, name) for v in all_of_them])
        left.plot(percent, np.median(stack, axis=0), color=colour, label=label)
        if len(stack) > 1:
            low, high = np.quantile(stack, (0.25, 0.75), axis=0)
            left.fill_between(percent, low, high, color=colour, alpha=0.22, linewidth=0)
    left.set_ylabel(f"variance per dimension ({UNITS[first.variable]})")
    left.set_ylim(bottom=0.0)
    stack = np.array([v.synergy for v in all_of_them])
    right.plot(percent, np.median(stack, axis=0), color="#24292F")
    if len(stack) > 1:
        low, high = np.quantile(stack, (0.25, 0.75), axis=0)
        right.fill_between(percent, low, high, color="#24292F", alpha=0.18, linewidth=0)
    zero_line(right)
    right.set_ylabel("synergy index ΔV (no unit)")
    for ax in (left, right):
        ax.set_xlabel("progress of the movement (%)")
        ax.set_xlim(0, 100)
    legend_below(figure, left)
    return figure
