"""Pictures of natural postures: effort and coordinates over swivel angle, the arm's muscles."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from selfmotion.kinematics.forward import tip_positions
from selfmotion.methods.effort.curve import EffortCurve
from selfmotion.methods.effort.posture_result import NaturalPosture
from selfmotion.muscles.geometry import MusculoskeletalArm
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
    words,
)

# Muscles at rest are pale, at full activation dark red; grey levels rise the same way.
ACTIVATION = LinearSegmentedColormap.from_list("activation", ("#E8DCD3", "#D55E00", "#5A0A0A"))
# Effort of postures that nothing holds is raised by the search: not drawn above this many times
# the greatest effort of those that are held.
_HEADROOM = 1.1
# Inches of the picture of the arm that its views leave to labels and scales, and its height.
_BESIDE, _ABOVE_AND_BELOW = 2.8, 0.9
_HEIGHTS = (2.4, 6.0)


@themed
def effort_figure(curves: Sequence[EffortCurve], found: NaturalPosture) -> Figure:
    """Draw effort over swivel angle: feasible intervals, every minimum, jumps.

    Args:
        curves: effort along every feasible interval (`PostureFinder.curves`).
        found: the posture found for the same hand pose.
    """
    figure, axes = new_figure(1, 1, size=(6.4, 3.4))
    ax = axes[0, 0]
    top = max((float(c.effort[c.held].max()) for c in curves if c.held.any()), default=1.0)
    for i, curve in enumerate(curves):
        swivel = np.rad2deg(curve.interval.swivel_near(curve.arc))
        label = "feasible interval" if i == 0 else None
        ax.axvspan(swivel.min(), swivel.max(), color=NULL, alpha=0.10, linewidth=0, label=label)
        held = np.where(curve.held, curve.effort, np.nan)
        ax.plot(swivel, held, color=NULL, label="muscle effort" if i == 0 else None)
        lost = ~curve.held
        if lost.any():
            place = np.full(int(lost.sum()), 0.02)
            ax.plot(swivel[lost], place, "x", color=BASELINE, markersize=4.0, linestyle="none",
                    transform=ax.get_xaxis_transform(), label="no activation holds it")  # fmt: skip
    for jump in found.jumps:
        ax.axvline(np.rad2deg(jump.swivel), color=BASELINE, linestyle=":", linewidth=1.0)
    others = found.minima[1:]
    if others:
        ax.plot(
            np.rad2deg([m.swivel for m in others]),
            [m.effort for m in others],
            "o",
            color=NULL,
            markerfacecolor="white",
            label="other local minimum",
        )
    if found.minima:
        ax.plot(np.rad2deg(found.swivel), found.effort, "o", color=INK, label="least effort")
    ax.set_ylim(0.0, _HEADROOM * top)
    ax.set_xlabel("swivel angle (deg)")
    ax.set_ylabel("muscle effort Σa² (no unit)")
    legend_below(figure, ax, columns=4)
    return figure


@themed
def coordinates_figure(curves: Sequence[EffortCurve], found: NaturalPosture) -> Figure:
    """Draw the coordinates over swivel angle; the posture of least effort is marked.

    Args:
        curves: samples along every feasible interval.
        found: the posture found for the same hand pose.
    """
    figure, axes = new_figure(1, 1, size=(6.4, 3.8))
    ax = axes[0, 0]
    for i, curve in enumerate(curves):
        swivel = np.rad2deg(curve.interval.swivel_near(curve.arc))
        for j, name in enumerate(found.coordinates):
            ax.plot(
                swivel,
                np.rad2deg(curve.q[:, j]),
                color=joint_colour(j),
                linestyle=joint_dash(j),
                label=words(name) if i == 0 else None,
            )
    if found.minima:
        ax.axvline(np.rad2deg(found.swivel), color=INK, linewidth=1.0)
        for j in range(len(found.q)):
            ax.plot(np.rad2deg(found.swivel), np.rad2deg(found.q[j]), "o", color=joint_colour(j))
    ax.set_xlabel("swivel angle (deg)")
    ax.set_ylabel("coordinate (deg)")
    legend_below(figure, ax, columns=4)
    return figure


@themed
def muscles_figure(model: MusculoskeletalArm, q: np.ndarray, activations: np.ndarray) -> Figure:
    """Draw the arm with its muscles coloured by activation, from the front and from the right.

    Args:
        model: arm with muscles.
        q: (7,) posture (rad).
        activations: (M,) by muscle.
    """
    figure, axes = new_figure(1, 2, size=(6.8, 3.6))
    arm = model.arm
    right = np.cross(arm.forward, arm.up)
    paths = model.geometry.paths(q)
    names = ("shoulder", "elbow", "wrist", "hand")
    bones = tip_positions(arm.chain, q, [arm.tip(name) for name in names])[0]
    # A viewer in front sees the person's right on the left.
    views = (("from the front", -right, arm.forward), ("from the right", arm.forward, right))
    norm = Normalize(0.0, max(float(np.max(activations)), 0.05))
    for ax, (title, across, towards) in zip(axes[0], views, strict=True):
        _view(ax, (across, arm.up, towards), bones, paths, activations, norm)
        ax.set_title(title)
    _same_scale(figure, list(axes[0]))
    bar = figure.colorbar(ScalarMappable(norm, ACTIVATION), ax=list(axes[0]), shrink=0.7)
    bar.set_label("activation (no unit)")
    return figure


def _same_scale(figure: Figure, views: list[Axes]) -> None:
    """Let a metre be as long in both views: as wide as what they show, and equally high."""
    widths = [ax.get_xlim()[1] - ax.get_xlim()[0] for ax in views]
    low = min(ax.get_ylim()[0] for ax in views)
    high = max(ax.get_ylim()[1] for ax in views)
    for ax in views:
        ax.set_ylim(low, high)
    grid = views[0].get_gridspec()
    assert grid is not None
    grid.set_width_ratios(widths)
    room = figure.get_size_inches()[0] - _BESIDE
    height = room * (high - low) / sum(widths) + _ABOVE_AND_BELOW
    figure.set_size_inches(room + _BESIDE, float(np.clip(height, *_HEIGHTS)))


def _view(
    ax: Axes,
    directions: tuple[np.ndarray, np.ndarray, np.ndarray],
    bones: np.ndarray,
    paths: list[np.ndarray],
    activations: np.ndarray,
    norm: Normalize,
) -> None:
    """Draw one view: across, up, and towards the viewer are the directions."""
    across, up, _ = directions
    screen = np.column_stack([across, up])
    ax.plot(*(bones @ screen).T, color=BASELINE, linewidth=6.0, alpha=0.6, solid_capstyle="round")
    joints = bones[:3] @ screen
    ax.plot(*joints.T, "o", color=TASK, markersize=5.0, zorder=4)
    for name, place in zip(("shoulder", "elbow", "wrist"), joints, strict=True):
        ax.annotate(name, place, (6, -11), textcoords="offset points", fontsize=7.5, color=TASK)
    order = np.argsort(activations)  # the most active are drawn last
    lines = LineCollection(
        [paths[m] @ screen for m in order],
        colors=[ACTIVATION(norm(float(activations[m]))) for m in order],
        linewidths=0.8 + 1.8 * np.asarray(norm(activations[order])),
    )
    ax.add_collection(lines)
    ax.autoscale()
    ax.set_aspect("equal")
    ax.set_xlabel("across the view (m)")
    ax.set_ylabel("up (m)")
