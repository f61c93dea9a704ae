"""Pictures of a workspace: slices, volumes, and the arcs of a device's circle.

What is kept is blue, what is lost orange: where help is needed.
"""

from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from scipy.spatial import ConvexHull

from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.kinematics.solid_shapes import Capsule, Shape
from selfmotion.methods.workspace import Slice, Workspace
from selfmotion.report.theme import (
    BASELINE,
    INK,
    JOINT_COLOURS,
    NULL,
    TASK,
    legend_below,
    new_figure,
    themed,
)
from selfmotion.studies.deboon import DeviceResult
from selfmotion.studies.deboon_body import Island

KEPT, LOST = TASK, NULL
COLUMNS = 4
# How far from the origin the body's outline is looked for, and its cells (m).
OUTLINE, OUTLINE_CELL = 0.6, 0.005
# Directions in which a hull is drawn by its outermost corner.
DIRECTIONS = 300
# Joints drawn along a device's circle, those of [DeBoon] figs 11 and 13.
DEVICE_JOINTS = ("elbow_flexion", "wrist_deviation", "wrist_flexion", "wrist_pronation")


@themed
def slices_figure(space: Workspace, body: BodyShapes | None = None) -> Figure:
    """Draw the points of each slice that are reached, and those that limits take away.

    Args:
        space: of `workspace`, with slices; the arm's ground has x to the right and y forward.
        body: whose inside is cut out of the slices, and drawn.
    """
    n_rows = -(-len(space.slices) // COLUMNS)
    figure, axes = new_figure(
        n_rows, COLUMNS, size=(7.2, 1.95 * n_rows + 0.4), share_x=True, share_y=True
    )
    flat = axes.ravel()
    for ax, part in zip(flat, space.slices, strict=False):
        _slice(ax, part, body)
    for ax in flat[len(space.slices) :]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("y, forward (m)")
    for ax in flat[max(0, len(space.slices) - COLUMNS) : len(space.slices)]:
        ax.set_xlabel("x, right (m)")
        ax.tick_params(labelbottom=True)
    legend_below(figure, flat[0], columns=2)
    return figure


@themed
def hulls_figure(space: Workspace, body: BodyShapes | None = None) -> Figure:
    """Draw the convex hulls, free and limited, in space from two sides ([DeBoon] fig. 6).

    Args:
        space: of `workspace`; the arm's ground has x to the right, y forward and z up.
        body: drawn inside the hulls.
    """
    figure = Figure(figsize=(7.2, 4.1), layout="constrained")
    views = (("from the right, in front", 12.0, 35.0), ("from the left, behind", 12.0, 215.0))
    kinds = [("free", LOST, 0.12, "all ranges"), ("limited", KEPT, 0.25, "limited")]
    for place, (title, height, turn) in enumerate(views, start=1):
        ax = cast(Axes3D, figure.add_subplot(1, 2, place, projection="3d"))
        for name, colour, alpha, _ in kinds:
            if name not in space.regions or not len(space.hull(name)):
                continue
            corners = _outermost(space.hull(name))
            hull = ConvexHull(corners)
            faces = Poly3DCollection(corners[hull.simplices], facecolors=colour, alpha=alpha)
            faces.set_edgecolor(to_rgba(colour, 0.45))
            faces.set_linewidth(0.3)
            ax.add_collection3d(faces)
        if body is not None:
            for shape in body.shapes.values():
                ax.plot_surface(*_surface(shape), color=BASELINE, alpha=0.9, linewidth=0)
        _square(ax, space.hull("free"))
        ax.view_init(elev=height, azim=turn)
        ax.set(xlabel="x, right (m)", ylabel="y, forward (m)")
        ax.set_title(title, y=0.94)
        ax.zaxis.set_rotate_label(False)
        ax.set_zlabel("z, up (m)", rotation=90)
    handles = [
        Patch(facecolor=c, alpha=0.4 + a, label=w) for n, c, a, w in kinds if n in space.regions
    ]
    if body is not None:
        handles.append(Patch(facecolor=BASELINE, label="body"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _outermost(corners: np.ndarray) -> np.ndarray:
    """Give the corners of a hull that lie outermost in one of `DIRECTIONS` directions.

    Thousands of faces look no rounder, and each is a path in the file.
    """
    i = np.arange(DIRECTIONS) + 0.5
    height, turn = 1.0 - 2.0 * i / DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * i
    across = np.sqrt(1.0 - height**2)
    ways = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
    return corners[np.unique((corners @ ways.T).argmax(axis=0))]


def _surface(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give x, y and z (m) of a grid on a shape's surface; a capsule is drawn by its tube."""
    if isinstance(shape, Capsule):
        along = shape.end - shape.start
        side = np.linalg.svd(along[None])[2][1:]
        turn = np.linspace(0, 2 * np.pi, 13)[:, None, None]
        around = shape.radius * (np.cos(turn) * side[0] + np.sin(turn) * side[1])
        grid = shape.start + np.linspace(0, 1, 3)[:, None] * along + around
    else:
        up, turn = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 9), np.linspace(0, 2 * np.pi, 13))
        ball = np.stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)], axis=-1)
        grid = shape.centre + (ball * shape.half) @ shape.axes.T
    return grid[..., 0], grid[..., 1], grid[..., 2]


def _square(ax: Axes3D, corners: np.ndarray) -> None:
    """Give all three axes one scale, so that a ball looks like one."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect((high - low).tolist())
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MultipleLocator(0.5))


@themed
def island_figure(island: Island, body: BodyShapes) -> Figure:
    """Draw the slice of [DeBoon] fig. 7: what is reached over the shoulder only, and its box."""
    figure, axes = new_figure(1, 2, size=(7.2, 4.7), share_x=True, share_y=True)
    points = island.part.regions["free"].points
    for ax, name, title in zip(
        axes[0], ("free", "limited"), ("elbow free", "splinted"), strict=True
    ):
        over, under = island.over[name], island.under[name]
        for mask, colour, size, label in (
            (under & ~over, KEPT, 2.6, "with the elbow below the shoulder"),
            (under & over, JOINT_COLOURS[1], 2.6, "either way"),
            (over & ~under, JOINT_COLOURS[2], 4.0, "over the shoulder only"),
        ):
            ax.plot(*points[mask, :2].T, ".", ms=size, color=colour, label=label, rasterized=True)
        body_outline(ax, body, island.part.height)
        (left, right), (behind, before) = island.box
        ax.plot(
            [left, right, right, left, left],
            [behind, behind, before, before, behind],
            "--", color=INK, lw=1.0, label="named region over the shoulder",
        )  # fmt: skip
        ax.set(title=title, xlabel="x, right (m)", aspect="equal")
        ax.grid(True, axis="both")
    axes[0, 0].set_ylabel("y, forward (m)")
    legend_below(figure, axes[0, 0], columns=2)
    return figure


def _slice(ax: Axes, part: Slice, body: BodyShapes | None) -> None:
    """Draw one slice, seen from above."""
    kept = part.regions.get("limited", part.regions["free"])
    sets = [(kept, KEPT, "reached")]
    if "lost" in part.regions:
        sets.append((part.regions["lost"], LOST, "reached without the limits only"))
    for region, colour, label in sets:
        x = region.points[region.inside]
        if body is not None:
            x = x[~body.inside(x)]
        ax.plot(x[:, 0], x[:, 1], ".", ms=2.2, color=colour, label=label, rasterized=True)
    ax.plot(0, 0, "+", color=INK, ms=6, label="sternoclavicular joint")
    if body is not None:
        body_outline(ax, body, part.height)
    ax.set_title(f"z = {1e3 * part.height:+.0f} mm")
    ax.set_aspect("equal")
    ax.grid(True, axis="both")


def body_outline(ax: Axes, body: BodyShapes, height: float) -> None:
    """Fill the body where a horizontal plane cuts it, in metres; x is right, y is forward."""
    x = np.arange(-OUTLINE, OUTLINE, OUTLINE_CELL)
    X, Y = np.meshgrid(x, x)
    points = np.stack([X.ravel(), Y.ravel(), np.full(X.size, height)], axis=1)
    depth = body.distance(points).reshape(X.shape)
    if depth.min() < 0:
        ax.contourf(X, Y, depth, levels=[-9, 0], colors=[BASELINE], alpha=0.6, zorder=2.5)
        ax.contour(X, Y, depth, levels=[0], colors=[INK], linewidths=0.8, zorder=3)
    ax.fill([], [], facecolor=BASELINE, alpha=0.6, edgecolor=INK, lw=0.8, label="body, cut out")


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
