"""Pictures of a workspace: slices, volumes, and the arcs of a device's circle.

What is kept is blue, what is lost orange: where help is needed.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.methods.workspace import Slice, Workspace
from selfmotion.report.theme import BASELINE, INK, NULL, TASK, legend_below, new_figure, themed
from selfmotion.studies.deboon import DeviceResult

KEPT, LOST = TASK, NULL
COLUMNS = 4
# Joints drawn along a device's circle, those of [DeBoon] figs 11 and 13.
DEVICE_JOINTS = ("elbow_flexion", "wrist_deviation", "wrist_flexion", "wrist_pronation")


@themed
def slices_figure(space: Workspace) -> Figure:
    """Draw the points of each slice that are reached, and those that limits take away."""
    n_rows = -(-len(space.slices) // COLUMNS)
    figure, axes = new_figure(
        n_rows, COLUMNS, size=(7.2, 1.95 * n_rows + 0.4), share_x=True, share_y=True
    )
    flat = axes.ravel()
    for ax, part in zip(flat, space.slices, strict=False):
        _slice(ax, part)
    for ax in flat[len(space.slices) :]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("y, forward (m)")
    for ax in axes[-1]:
        ax.set_xlabel("x, right (m)")
    legend_below(figure, flat[0], columns=3)
    return figure


@themed
def hulls_figure(space: Workspace) -> Figure:
    """Draw the outlines of the convex hulls, free and limited, from three sides ([DeBoon] fig. 6).

    The arm's ground has x to the right, y forward and z up.
    """
    from scipy.spatial import ConvexHull

    figure, axes = new_figure(1, 3, size=(7.2, 3.0))
    views = (("from above", 0, 1), ("from the right", 1, 2), ("from the front", 0, 2))
    names = ("x, right (m)", "y, forward (m)", "z, up (m)")
    kinds = [("free", LOST, "all ranges"), ("limited", KEPT, "limited")]
    for ax, (title, i, j) in zip(axes[0], views, strict=True):
        for name, colour, label in kinds:
            if name not in space.regions or not len(space.hull(name)):
                continue
            flat = space.hull(name)[:, [i, j]]
            outline = flat[ConvexHull(flat).vertices]
            ax.fill(*outline.T, facecolor=colour, alpha=0.18, linewidth=0)
            closed = np.concatenate([outline, outline[:1]])
            ax.plot(*closed.T, color=colour, linewidth=1.4, label=label)
        ax.plot(0, 0, "+", color=INK, ms=6, label="sternoclavicular joint")
        if title == "from the front":
            ax.invert_xaxis()  # who faces a person has that person's right on the left
        ax.set(title=title, xlabel=names[i], ylabel=names[j], aspect="equal")
        ax.grid(True, axis="both")
    legend_below(figure, axes[0, 0], columns=3)
    return figure


def _slice(ax: Axes, part: Slice) -> None:
    """Draw one slice, seen from above."""
    kept = part.regions.get("limited", part.regions["free"])
    sets = [(kept, KEPT, "reached")]
    if "lost" in part.regions:
        sets.append((part.regions["lost"], LOST, "reached without the limits only"))
    for region, colour, label in sets:
        x = region.points[region.inside]
        ax.plot(x[:, 0], x[:, 1], ".", ms=2.2, color=colour, label=label, rasterized=True)
    ax.plot(0, 0, "+", color=INK, ms=6, label="sternoclavicular joint")
    ax.set_title(f"z = {1e3 * part.height:+.0f} mm")
    ax.set_aspect("equal")
    ax.grid(True, axis="both")


@themed
def arcs_figure(result: DeviceResult) -> Figure:
    """Draw feasible arcs of the device's circles, and the elbow's angle along them."""
    elbows = list(dict.fromkeys(elbow for elbow, _ in result.arcs))
    figure, axes = new_figure(2, len(elbows), size=(7.2, 6.0), share_x="row", share_y="row")
    along = "y, forward (m)" if result.scenario.plane == "yz" else "x, right (m)"
    for column, elbow in enumerate(elbows):
        radii = [radius for name, radius in result.arcs if name == elbow]
        for shade, radius in zip((0.45, 0.7, 1.0), radii, strict=False):
            turn = np.linspace(0, 2 * np.pi, 200)
            axes[0, column].plot(*_circle(result, radius, turn), ":", color=BASELINE, lw=0.8)
            for i, arc in enumerate(result.arcs[elbow, radius]):
                angles = np.linspace(arc.first, arc.last, 200)
                label = f"r = {1e3 * radius:.0f} mm" if i == 0 else None
                style = {"color": KEPT, "alpha": shade, "lw": 1.0 + 1.6 * shade}
                axes[0, column].plot(*_circle(result, radius, angles), label=label, **style)
                q = arc.path.q[:, arc.path.task.arm.chain.index("elbow_flexion")]
                axes[1, column].plot(np.rad2deg(arc.path.time), np.rad2deg(q), **style)
        axes[0, column].set_aspect("equal")
        axes[0, column].set_title(f"elbow {elbow}")
        axes[0, column].set_xlabel(along)
        axes[1, column].set_xlabel("angle on the circle (degrees)")
    axes[0, 0].set_ylabel("z, up (m)")
    axes[1, 0].set_ylabel("elbow flexion (degrees)")
    legend_below(figure, axes[0, 0], columns=3)
    return figure


@themed
def arc_joints_figure(result: DeviceResult) -> Figure:
    """Draw elbow and wrist along the arcs ([DeBoon] figs 11 and 13, the computed curves)."""
    elbows = list(dict.fromkeys(elbow for elbow, _ in result.arcs))
    figure, axes = new_figure(
        len(DEVICE_JOINTS), len(elbows), size=(7.2, 8.4), share_x=True, share_y="row"
    )
    for column, elbow in enumerate(elbows):
        arcs = [(radius, a) for (name, radius), a in result.arcs.items() if name == elbow]
        for row, joint in enumerate(DEVICE_JOINTS):
            ax = axes[row, column]
            for shade, (radius, parts) in zip((0.45, 0.7, 1.0), arcs, strict=False):
                for i, arc in enumerate(parts):
                    q = arc.path.q[:, arc.path.task.arm.chain.index(joint)]
                    label = f"r = {1e3 * radius:.0f} mm" if i == 0 else None
                    style = {"color": KEPT, "alpha": shade, "lw": 1.0 + 1.6 * shade}
                    ax.plot(np.rad2deg(arc.path.time), np.rad2deg(q), label=label, **style)
            if column == 0:
                ax.set_ylabel(f"{joint.replace('_', ' ')}\n(degrees)")
        axes[0, column].set_title(f"elbow {elbow}")
        axes[-1, column].set_xlabel("angle on the circle (degrees)")
    legend_below(figure, axes[0, 0], columns=3)
    return figure


def _circle(
    result: DeviceResult, radius: float, angles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Give horizontal and vertical coordinates (m) of points on a circle."""
    across = result.scenario.centre[1 if result.scenario.plane == "yz" else 0]
    up = result.scenario.centre[2]
    return across + radius * np.cos(angles), up + radius * np.sin(angles)
