"""Put a natural swivel angle on a robot arm of seven joints that holds the same hand pose.

[Li2022] section VI. The robot's base is the model's ground: the same axes, the same origin.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

from selfmotion.errors import ModelError, RangeError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.redundancy.feasible import FeasibleInterval
    from selfmotion.redundancy.manifold import ManifoldFinder

N_JOINTS = 7
# Places on each interval between which the swivel angle is looked for.
PLACES = 64
# Swivel angles closer than this (rad) are the same.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class RobotPosture:
    """What the robot does: q (rad) and swivel (rad), NaN-free, or None; and a sentence."""

    q: "np.ndarray | None"
    swivel: float | None
    ok: bool
    sentence: str


def held_joints(texts: list[str] | None, robot: str | Path | None) -> tuple[tuple[str, float], ...]:
    """Read --hold: joints and the angles (rad; m for slides typed as such) at which they rest.

    Raises:
        RangeError: a text is not joint=degrees, a joint stands twice, or there is no robot.
    """
    if texts and robot is None:
        raise RangeError(f"--hold {texts[0]!r}: name the robot too, with --robot FILE.urdf")
    found: dict[str, float] = {}
    for text in texts or []:
        name, _, number = (part.strip() for part in text.partition("="))
        try:
            angle = math.radians(float(number))
        except ValueError:
            angle = math.nan
        if not name or not math.isfinite(angle) or name in found:
            raise RangeError(f"--hold {text!r}: write each joint once, as in trunk=0 (degrees)")
        found[name] = angle
    return tuple(found.items())


def read_robot(path: str | Path, model: "Arm", held: tuple[tuple[str, float], ...] = ()) -> "Arm":
    """Read the robot, with up and forward as the model has them.

    Args:
        path: .urdf or .xml.
        model: the arm with muscles.
        held: joints that do not move, and where they rest (rad).

    Raises:
        SelfmotionError: the file cannot be read as an arm.
        ModelError: other than seven joints are left.
    """
    from selfmotion.arms.mjcf_urdf import ModelChoices, read_model

    u, f = model.up.tolist(), model.forward.tolist()
    up, forward = (u[0], u[1], u[2]), (f[0], f[1], f[2])
    robot = read_model(path, ModelChoices(held=dict(held), up=up, forward=forward))
    if robot.n_joints > N_JOINTS:
        raise ModelError(
            f"{path}: {robot.n_joints} joints move ({', '.join(robot.joints)}): {N_JOINTS} are "
            "needed; let the others rest with --hold JOINT=DEGREES"
        )
    if robot.n_joints < N_JOINTS:
        raise ModelError(
            f"{path}: {robot.n_joints} joints move: {N_JOINTS} are needed to choose a swivel angle"
        )
    return robot


def robot_posture(
    finder: "ManifoldFinder", T_hand: "np.ndarray", swivel: float | None
) -> RobotPosture:
    """Give the robot's posture with a swivel angle, or with the nearest that it can take.

    Of several with that swivel angle it is the one farthest from the joint limits.

    Args:
        finder: of the robot.
        T_hand: (4, 4) pose of the hand.
        swivel: natural swivel angle (rad); None if there is none.
    """
    import numpy as np

    if swivel is None:
        return RobotPosture(None, None, False, "no natural swivel angle")
    manifold = finder.find(T_hand)
    if not manifold.intervals:
        return RobotPosture(None, None, False, manifold.status.sentence)
    found = [_candidates(interval, swivel) for interval in manifold.intervals]
    q = np.concatenate([postures for postures, _ in found])
    off = np.concatenate([offsets for _, offsets in found])
    best = np.flatnonzero(np.abs(off) <= np.abs(off).min() + SAME)
    margin = np.minimum(q - finder.arm.lower, finder.arm.upper - q).min(axis=1)
    i = int(best[np.argmax(margin[best])])
    sentence = "natural swivel angle"
    if abs(off[i]) > SAME:
        sentence = f"joint limits keep it {np.degrees(abs(off[i])):.1f} deg from the natural swivel"
    return RobotPosture(q[i], float(_turned(swivel + off[i])), True, sentence)


def _candidates(interval: "FeasibleInterval", swivel: float) -> "tuple[np.ndarray, np.ndarray]":
    """Give postures (C, 7) of an interval with the swivel angle, or nearest to it, and how far."""
    import numpy as np
    from scipy.optimize import brentq

    def offset(arc: "np.ndarray | float") -> "np.ndarray":
        return _turned(interval.swivel_at(interval.at(arc)) - swivel)

    arcs = np.linspace(interval.arc[0], interval.arc[-1], PLACES)
    off = offset(arcs)
    known = np.isfinite(off)
    if not known.any():
        return np.empty((0, 7)), np.empty(0)
    crossed = (off[:-1] * off[1:] < 0.0) & (np.abs(np.diff(off)) < 0.5 * np.pi)
    places = [float(arcs[np.nanargmin(np.abs(off))])]
    for i in np.flatnonzero(crossed):
        root = brentq(lambda s: float(offset(s)[0]), arcs[i], arcs[i + 1], xtol=1e-13)
        places.append(cast(float, root))
    distance = np.zeros(len(places))
    distance[0] = offset(places[0])[0]
    return interval.at(places), distance


def _turned(angle: "np.ndarray | float") -> "np.ndarray":
    """Bring angles (rad) into half a turn either way."""
    import numpy as np

    return np.remainder(np.asarray(angle) + np.pi, 2.0 * np.pi) - np.pi
