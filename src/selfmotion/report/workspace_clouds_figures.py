"""Pictures of recorded hand positions over the workspace that holds them."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.methods.reach_clouds import CloudReach
from selfmotion.methods.workspace import Workspace
from selfmotion.report.theme import (
    BASELINE,
    GRID,
    INK,
    NULL,
    TASK,
    legend_below,
    new_figure,
    themed,
)

# Views: title, axes across and up (right, forward, up), their labels.
VIEWS = (
    ("from the side", (1, 2), "forward (m)", "up (m)"),
    ("from above", (0, 1), "right (m)", "forward (m)"),
    ("from the front", (0, 2), "right (m)", "up (m)"),
)
# Points of a cloud that are drawn.
MOST = 4000


@themed
def clouds_figure(space: Workspace, clouds: Sequence[CloudReach]) -> Figure:
    """Draw recorded positions over the workspace in three views, and their signed distances."""
    figure, axes = new_figure(2, 2, size=(7.2, 6.6))
    turn = BodyFrame.of(space.arm).axes
    region = space.regions[clouds[0].region]
    known = region.points[region.inside] @ turn
    points = np.concatenate([cloud.points for cloud in clouds]) @ turn
    distance = np.concatenate([cloud.distance for cloud in clouds])
    step = max(1, len(points) // MOST)
    shoulder = BodyFrame.of(space.arm).shoulder @ turn
    for ax, view in zip(axes.ravel(), VIEWS, strict=False):
        _view(ax, view, known)
        across, up = view[1]
        for chosen, colour, label in (
            (distance <= 0, TASK, "recorded, inside"),
            (distance > 0, NULL, "recorded, outside"),
        ):
            x = points[chosen][:: step if chosen.sum() > MOST else 1]
            ax.plot(x[:, across], x[:, up], ".", ms=2, color=colour, label=label, rasterized=True)
        ax.plot(shoulder[across], shoulder[up], "+", ms=8, mew=1.5, color=INK, label="shoulder")
    _distances(axes[1, 1], clouds)
    legend_below(figure, axes[0, 0], columns=4)
    return figure


def _view(ax: Axes, view: tuple[str, tuple[int, int], str, str], known: np.ndarray) -> None:
    """Draw the outline of the workspace in one view."""
    from scipy.spatial import ConvexHull

    title, (across, up), x_label, y_label = view
    flat = known[:, [across, up]]
    hull = flat[ConvexHull(flat).vertices]
    ax.fill(*np.vstack([hull, hull[:1]]).T, color=GRID, lw=0, label="workspace (hull)")
    ax.set_title(title)
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    ax.set_aspect("equal")


def _distances(ax: Axes, clouds: Sequence[CloudReach]) -> None:
    """Draw how many positions lie how deep."""
    distance = 1e3 * np.concatenate([cloud.distance for cloud in clouds])
    edges = np.histogram_bin_edges(distance, bins=40)
    for chosen, colour in ((distance <= 0, TASK), (distance > 0, NULL)):
        ax.hist(distance[chosen], bins=edges.tolist(), color=colour)
    ax.axvline(0.0, color=BASELINE, lw=1.0)
    ax.set_title("distance to the boundary")
    ax.set_xlabel("inside  <  0 mm  <  outside")
    ax.set_ylabel("positions")
