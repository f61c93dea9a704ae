"""A device's circle: its feasible arcs, and the joints along them."""

import numpy as np
from matplotlib.figure import Figure

from selfmotion.methods.constrained_path import PLANES
from selfmotion.methods.hand_circle import CircleReach
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


@themed
def circle_figure(found: CircleReach) -> Figure:
    """Draw the circle with its feasible arcs, and all joints along them."""
    figure, axes = new_figure(1, 2, size=(7.2, 4.0))
    first, second = PLANES[found.circle.plane]
    left, right = axes[0]
    turn = np.linspace(0, 2 * np.pi, 200)
    whole = found.circle.points(turn)
    left.plot(whole[:, first], whole[:, second], ":", color=BASELINE)
    for number, arc in enumerate(found.arcs):
        part = found.circle.points(np.linspace(arc.first, arc.last, 200))
        left.plot(part[:, first], part[:, second], color=TASK, lw=2.4)
        for j, joint in enumerate(found.arm.joints):
            right.plot(
                np.rad2deg(arc.path.time),
                np.rad2deg(arc.path.q[:, j]),
                joint_dash(j),
                color=joint_colour(j),
                label=words(joint) if number == 0 else None,
            )
    left.set_aspect("equal")
    left.set_title("feasible arcs")
    left.set_xlabel(f"{'xyz'[first]} (m)")
    left.set_ylabel(f"{'xyz'[second]} (m)")
    right.set_title("joints")
    right.set_xlabel("angle on the circle (degrees)")
    right.set_ylabel("joint angle (degrees)")
    legend_below(figure, right, columns=4)
    return figure
