"""Pictures of [Li2022] computed again: Figs 3 to 5, and effort over the vertical-cup poses."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from selfmotion.report.theme import (
    BASELINE,
    INK,
    NULL,
    TASK,
    joint_colour,
    joint_dash,
    legend_below,
    new_figure,
    themed,
)

# Directions of the shoulder centre's displacement, as columns of `Reproduction.shoulder`.
DIRECTIONS = ("forward", "up", "right")
# Errors of the inverse kinematics are drawn no smaller than this (m, rad): below is rounding.
_FLOOR = 1e-16
CM = 100.0


@themed
def shoulder_figure(shoulder: pd.DataFrame, published: Sequence[float]) -> Figure:
    """Draw where the shoulder centre goes as the arm is raised (Fig 3).

    Args:
        shoulder: elevation_deg and displacement forward, up, right (m).
        published: displacement at the greatest elevation: forward, up, right (cm).
    """
    figure = Figure(figsize=(7.2, 3.5), layout="constrained")
    space: Any = figure.add_subplot(1, 2, 1, projection="3d")
    plain = figure.add_subplot(1, 2, 2)
    _path_in_space(space, CM * shoulder[list(DIRECTIONS)].to_numpy(dtype=float))
    elevation = shoulder["elevation_deg"].to_numpy(dtype=float)
    for i, (name, printed) in enumerate(zip(DIRECTIONS, published, strict=True)):
        plain.plot(
            elevation,
            CM * shoulder[name].to_numpy(dtype=float),
            color=joint_colour(i),
            linestyle=joint_dash(i),
            label=name,
        )
        plain.plot(
            elevation[-1],
            printed,
            marker="D",
            markerfacecolor="none",
            color=joint_colour(i),
            linestyle="none",
            clip_on=False,
            zorder=3 + i,
        )
    plain.plot([], [], "D", color=INK, markerfacecolor="none", label="published, at the end")
    plain.axhline(0.0, color=BASELINE, linewidth=0.7, zorder=0.5)
    plain.set_xlabel("shoulder elevation (deg)")
    plain.set_ylabel("displacement (cm)")
    plain.set_title("B  by direction")
    legend_below(figure, plain)
    return figure


def _path_in_space(ax: Any, moved: np.ndarray) -> None:
    """Draw the path, and its projections onto the plane of the back and onto the floor."""
    forward, up, right = moved.T
    back, floor = forward.min() - 1.5, up.min() - 1.5
    shadow = {"linestyle": "--", "linewidth": 1.0}
    ax.plot(right, np.full_like(right, back), up, color=joint_colour(1), **shadow)
    ax.plot(right, forward, np.full_like(right, floor), color=joint_colour(2), **shadow)
    ax.plot(right, forward, up, color=TASK)
    ax.plot(*moved[-1, [2, 0, 1]], marker=">", color=TASK, linestyle="none")
    ax.plot(0.0, 0.0, 0.0, "o", color=INK)
    ax.text(0.0, 0.0, 0.5, "0°", fontsize=8)
    ax.text(*(moved[-1, [2, 0, 1]] + [0.0, 0.0, 0.5]), "raised", fontsize=8)
    ax.set_xlabel("right (cm)", labelpad=-6)
    ax.set_ylabel("forward (cm)", labelpad=-6)
    ax.set_zlabel("up (cm)", labelpad=-8)
    ax.tick_params(pad=-3, labelsize=7.5)
    ax.view_init(elev=22.0, azim=-60.0)
    ax.set_box_aspect(None, zoom=0.85)
    ax.set_title("A  path of the shoulder centre")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MultipleLocator(2.0))
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))


@themed
def swivel_figure(swivel: pd.DataFrame, published: Sequence[float]) -> Figure:
    """Draw swivel angles with the shoulder centre fixed and moving, over elevation (Fig 4).

    Args:
        swivel: elevation_deg, fixed_deg, moving_deg, difference_deg along one self-motion.
        published: mean and standard deviation of the difference's size (deg).
    """
    figure, axes = new_figure(1, 2, size=(7.2, 3.2))
    left, right = axes[0]
    elevation = swivel["elevation_deg"].to_numpy(dtype=float)
    left.plot(elevation, swivel["fixed_deg"], color=TASK, label="centre fixed at home")
    left.plot(
        elevation,
        swivel["moving_deg"],
        color=NULL,
        linestyle="--",
        label="centre where it is",
    )
    left.set_ylabel("swivel angle (deg)")
    left.set_title("A  two definitions")
    size = np.abs(swivel["difference_deg"].to_numpy(dtype=float))
    mean, spread = published
    right.axhspan(mean - spread, mean + spread, color=BASELINE, alpha=0.22, linewidth=0)
    right.axhline(mean, color=BASELINE, linestyle=":", label="published, mean ± SD")
    right.plot(elevation, size, color=INK, label="size of the difference")
    right.set_ylim(bottom=0.0)
    right.set_ylabel("difference (deg)")
    right.set_title("B  their difference")
    for ax in (left, right):
        ax.set_xlabel("shoulder elevation (deg)")
    _legend_of_both(figure, left, right)
    return figure


def _legend_of_both(figure: Figure, left: Axes, right: Axes) -> None:
    handles, labels = left.get_legend_handles_labels()
    more, words = right.get_legend_handles_labels()
    figure.legend([*handles, *more], [*labels, *words], loc="outside lower center", ncols=2)


@themed
def hybrid_figure(hybrid: pd.DataFrame) -> Figure:
    """Draw how far the hybrid inverse kinematics strays, before and after refinement (Fig 5).

    Args:
        hybrid: one row a pose, as `li2022_poses.hybrid_errors` gives it.
    """
    figure, axes = new_figure(1, 3, size=(7.2, 3.0))
    swivel, position, rotation = axes[0]
    off = hybrid["uncertainty_deg"].to_numpy(dtype=float)
    swivel.hist(off, bins=25, color=TASK)
    swivel.axvline(0.0, color=BASELINE, linewidth=0.9)
    swivel.set_xlabel("asked − reached (deg)")
    swivel.set_ylabel("poses")
    swivel.set_title("A  posture")
    for ax, unit, factor, name in (
        (position, "m", 1e3, "position error (mm)"),
        (rotation, "rad", np.rad2deg(1.0), "orientation error (deg)"),
    ):
        drawn = [
            factor * np.maximum(hybrid[f"{stage}_{unit}"].to_numpy(dtype=float), _FLOOR)
            for stage in ("start", "refined")
        ]
        boxes = ax.boxplot(drawn, widths=0.5, patch_artist=True, whis=(0.0, 100.0))
        for box, colour in zip(boxes["boxes"], (NULL, TASK), strict=True):
            box.set(facecolor=colour, alpha=0.6)
        for line in boxes["medians"]:
            line.set(color=INK)
        ax.set_xticks([1, 2], ["closed form", "refined"])
        ax.set_yscale("log")
        ax.set_ylabel(name)
    position.set_title("B  position")
    rotation.set_title("C  orientation")
    return figure


@themed
def poses_figure(postures: pd.DataFrame) -> Figure:
    """Draw the swivel angle of least effort at the places of the hand, from above and the side.

    Args:
        postures: one row a pose, as `li2022_poses.natural_postures` gives it.
    """
    figure, axes = new_figure(1, 2, size=(7.2, 3.5))
    found = postures.loc[np.isfinite(postures["swivel_deg"].to_numpy(dtype=float))]
    # Poses on one spot of a view are drawn by their height (or depth): the last one is seen.
    x, y, z = (CM * found[k].to_numpy(dtype=float) for k in "xyz")
    swivel = found["swivel_deg"].to_numpy(dtype=float)
    # A few poses far off must not fade all others.
    limit = float(np.percentile(np.abs(swivel), 95.0)) if len(swivel) else 1.0
    drawn = None
    for ax, (across, up), names, title in (
        (axes[0, 0], (x, y), ("to the right", "forward"), "from above"),
        (axes[0, 1], (y, z), ("forward", "up"), "from the right"),
    ):
        drawn = ax.scatter(across, up, c=swivel, cmap="PuOr", vmin=-limit, vmax=limit, s=22)
        drawn.set(edgecolor=BASELINE, linewidth=0.4)
        ax.plot(0.0, 0.0, "+", color=INK, markersize=9)
        ax.annotate("shoulder", (0.0, 0.0), (4, 4), textcoords="offset points", fontsize=8)
        ax.set_xlabel(f"{names[0]} (cm)")
        ax.set_ylabel(f"{names[1]} (cm)")
        ax.set_title(title)
        ax.set_aspect("equal", adjustable="datalim")
    if drawn is not None:
        figure.colorbar(
            drawn, ax=list(axes.flat), label="swivel angle (deg)", shrink=0.9, extend="both"
        )
    return figure
