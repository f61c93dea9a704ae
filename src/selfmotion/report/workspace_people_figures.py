"""The hands of recorded people in the workspaces predicted for them."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.report.theme import (
    BASELINE,
    GRID,
    INK,
    NULL,
    joint_colour,
    legend_below,
    new_figure,
    themed,
)
from selfmotion.studies.workspace_people import TOLERANCE, PersonReach, arm_length

VIEWS = (
    ("from the side", (1, 2), "forward (arm lengths)", "up (arm lengths)"),
    ("from above", (0, 1), "outwards (arm lengths)", "forward (arm lengths)"),
)


@themed
def people_figure(people: Sequence[PersonReach]) -> Figure:
    """Draw everybody's hand from the shoulder in lengths of the arm, and the depths."""
    figure, axes = new_figure(1, 3, size=(9.6, 4.0))
    conditions = list(dict.fromkeys(name for one in people for name in one.clouds))
    for ax, (title, (across, up), x_label, y_label) in zip(axes[0], VIEWS, strict=False):
        for one in people:
            region = one.space.regions["free"]
            known = scaled(one, region.points[region.inside])
            ax.plot(*outline(known[:, [across, up]]), color=GRID, lw=1.2, zorder=0.5)
        for i, condition in enumerate(conditions):
            x = np.concatenate(
                [scaled(p, p.clouds[condition].points) for p in people if condition in p.clouds]
            )
            style = {"ms": 1.6, "color": joint_colour(i), "rasterized": True}
            ax.plot(x[::3, across], x[::3, up], ".", label=condition, **style)
        out = [
            scaled(p, c.points[c.distance > TOLERANCE]) for p in people for c in p.clouds.values()
        ]
        y = np.concatenate(out)
        ax.plot(y[:, across], y[:, up], "x", ms=3.5, color=NULL, label="outside")
        ax.plot(0, 0, "+", ms=9, mew=1.5, color=INK, label="shoulder")
        ax.set_title(title)
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        ax.set_aspect("equal")
    _depths(axes[0, 2], people)
    legend_below(figure, axes[0, 0], columns=6)
    return figure


def scaled(one: PersonReach, points: np.ndarray) -> np.ndarray:
    """Give points as outwards, forward and up of the shoulder, in lengths of the arm."""
    frame = BodyFrame.of(one.arm)
    away = (points - frame.shoulder) @ frame.axes / arm_length(one.arm)
    return away * [frame.side, 1.0, 1.0]


def outline(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the closed convex outline of points in a plane."""
    from scipy.spatial import ConvexHull

    corners = points[ConvexHull(points).vertices]
    closed = np.vstack([corners, corners[:1]])
    return closed[:, 0], closed[:, 1]


def _depths(ax: object, people: Sequence[PersonReach]) -> None:
    from matplotlib.axes import Axes

    assert isinstance(ax, Axes)
    for i, one in enumerate(people):
        d = np.sort(np.concatenate([1e3 * c.distance for c in one.clouds.values()]))
        ax.plot(d, np.linspace(0, 100, len(d)), lw=1.0, color=BASELINE)
        level = (i + 1) / (len(people) + 1)
        ax.text(d[int(level * len(d))] + 6, 100 * level, one.subject, fontsize=7)
    ax.axvline(0.0, color=INK, lw=0.8)
    ax.set_title("distance to the boundary")
    ax.set_xlabel("inside  <  0 mm  <  outside")
    ax.set_ylabel("places at most so far out (%)")
