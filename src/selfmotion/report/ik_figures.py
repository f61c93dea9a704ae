"""Pictures of inverse kinematics: joints inside their limits, and what is missing to targets."""

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from selfmotion.kinematics.arm import Arm
from selfmotion.methods.reaching.saturation import saturated_posture
from selfmotion.report.theme import (
    BASELINE,
    TASK,
    joint_colour,
    joint_dash,
    legend_below,
    new_figure,
    themed,
    words,
)

# Errors up to this (mm) are drawn at it: they say where the solver stopped, nothing of the arm.
LEAST_MM = 1e-3
COLUMNS = 3
# How far the unbounded variable is drawn; the arctangent has then gone 94 % of its way.
SATURATED = 10.0


@themed
def limits_figure(
    q: Float[np.ndarray, "samples coords"],
    limits: Float[np.ndarray, "2 coords"],
    joints: tuple[str, ...],
) -> Figure:
    """Draw each posture as a tick on the range of each joint.

    Args:
        q: postures (degrees).
        limits: lower and upper limits (degrees).
        joints: their names.
    """
    n = len(joints)
    figure, axes = new_figure(size=(6.4, 0.34 * n + 0.9))
    ax = axes[0, 0]
    for j in range(n):
        low, high = _ends(limits[:, j], q[:, j])
        ax.fill_between((low, high), j - 0.31, j + 0.31, color=BASELINE, alpha=0.25, linewidth=0)
        ax.plot(q[:, j], np.full(len(q), j), "|", color=joint_colour(j), markersize=11, zorder=3)
    ax.set_yticks(range(n), [words(joint) for joint in joints])
    ax.set_ylim(n - 0.4, -0.6)
    ax.margins(x=0.03)
    ax.set_xlabel("joint angle (degrees); grey: the range allowed")
    ax.grid(visible=True, axis="x")
    ax.grid(visible=False, axis="y")
    return figure


@themed
def trajectories_figure(
    time: Float[np.ndarray, " samples"],
    q: Float[np.ndarray, "samples coords"],
    limits: Float[np.ndarray, "2 coords"],
    joints: tuple[str, ...],
) -> Figure:
    """Draw each joint over time, with its limits as dashed lines where they are near.

    Args:
        time: s.
        q: postures (degrees).
        limits: lower and upper limits (degrees).
        joints: their names.
    """
    n_rows = -(-len(joints) // COLUMNS)
    size = (7.2, 1.65 * n_rows + 0.5)
    figure, axes = new_figure(n_rows, COLUMNS, size=size, share_x=True)
    for j, ax in enumerate(axes.flat):
        if j >= len(joints):
            ax.set_visible(False)
            continue
        ax.plot(time, q[:, j], color=joint_colour(j))
        span = max(float(np.ptp(q[:, j])), 10.0)
        middle = 0.5 * (float(q[:, j].min()) + float(q[:, j].max()))
        ax.set_ylim(middle - 0.8 * span, middle + 0.8 * span)
        low, high = ax.get_ylim()
        for limit in limits[:, j]:
            if low <= limit <= high:
                ax.axhline(limit, color=BASELINE, linestyle="--", linewidth=1.0)
        ax.set_title(words(joints[j]))
        if j % COLUMNS == 0:
            ax.set_ylabel("degrees")
        if j + COLUMNS >= len(joints):
            ax.set_xlabel("time (s)")
            ax.tick_params(labelbottom=True)
    return figure


@themed
def error_figure(
    error_mm: Float[np.ndarray, " samples"],
    solved: np.ndarray,
    time: Float[np.ndarray, " samples"] | None,
) -> Figure:
    """Draw what is missing to each target, in order of the file or over time, on a log scale."""
    figure, axes = new_figure(size=(6.4, 2.6))
    ax = axes[0, 0]
    x = np.arange(1, len(error_mm) + 1) if time is None else time
    y = np.maximum(error_mm, LEAST_MM)
    ax.semilogy(x[solved], y[solved], "o", color=TASK, label="reached")
    if not solved.all():
        ax.semilogy(x[~solved], y[~solved], "x", color="#D55E00", markersize=6, label="not reached")
        ax.legend(loc="best")
    if time is None and len(x) <= 20:
        ax.set_xticks(x)
    ax.set_xlabel("target (in the order of the file)" if time is None else "time (s)")
    ax.set_ylabel("distance to the target (mm)")
    ax.set_ylim(0.4 * LEAST_MM, max(1.0, 3.0 * float(y.max())))
    return figure


@themed
def saturation_figure(arm: Arm) -> Figure:
    """Draw each joint over the unbounded variable, and how far a step moves it ([DeBoon] fig. 2).

    Args:
        arm: with finite limits.
    """
    figure, axes = new_figure(1, 2, size=(7.2, 4.6), share_y=True)
    left, right = axes[0]
    v = np.linspace(-SATURATED, SATURATED, 401)
    angles, slopes = (np.rad2deg(values) for values in saturated_posture(arm, v))
    for j, joint in enumerate(arm.joints):
        style = {"color": joint_colour(j), "linestyle": joint_dash(j), "label": words(joint)}
        left.plot(v, angles[:, j], **style)
        right.plot(slopes[:, j], angles[:, j], **style)
    left.set_title("angle")
    left.set_xlabel("unbounded variable v")
    left.set_ylabel("joint angle θ (degrees)")
    right.set_title("how far a step of v moves it")
    right.set_xlabel("dθ/dv (degrees)")
    right.set_xlim(left=0.0)
    legend_below(figure, left, columns=3)
    return figure


def _ends(limits: np.ndarray, q: np.ndarray) -> tuple[float, float]:
    """Give a joint's limits, or, where it has none, how far it goes here."""
    low = float(limits[0]) if np.isfinite(limits[0]) else float(q.min())
    high = float(limits[1]) if np.isfinite(limits[1]) else float(q.max())
    return low, high
