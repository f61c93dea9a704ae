"""The natural posture while a hand is dragged: the posture shown, and effort over swivel angle."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.errors import Status
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.effort.curve import EffortCurve
from selfmotion.methods.effort.posture_result import NaturalPosture
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.muscles.static_optimization import muscle_effort
from selfmotion.redundancy.feasible import FeasibleInterval

# Where between their limits the seven coordinates of the MoBL family are at the start.
START = np.array([0.6, 0.35, 0.45, 0.55, 0.5, 0.4, 0.5])


def start_pose(arm: Arm) -> Float[np.ndarray, "4 4"]:
    """Give a hand pose in front of the person that is well inside reach (m)."""
    share = START if arm.n_joints == len(START) else np.full(arm.n_joints, 0.5)
    q = arm.lower + share * (arm.upper - arm.lower)
    return forward_kinematics(arm.chain, q, arm.tip("hand"))[0]


@dataclass(frozen=True, eq=False)
class LivePosture:
    """What is to be seen for one hand pose.

    Attributes:
        found: the posture of least effort, with its minima.
        curves: effort along each feasible interval.
        q: (n,) the posture shown (rad); NaN where there is none.
        swivel: its swivel angle (rad).
        effort: its muscle effort.
        activations: (M,).
        status: of the posture shown.
    """

    found: NaturalPosture
    curves: tuple[EffortCurve, ...]
    q: Float[np.ndarray, " coords"]
    swivel: float
    effort: float
    activations: Float[np.ndarray, " muscles"]
    status: Status


def live_posture(
    finder: PostureFinder, T_hand: Float[np.ndarray, "4 4"], *, swivel: float | None = None
) -> LivePosture:
    """Find the natural posture, or the one at a swivel angle, and effort all along.

    Args:
        finder: a model made ready, with the ranges that hold.
        T_hand: (4, 4) pose of the hand in the ground (m).
        swivel: angle (rad) to show; left out: that of least effort. The nearest feasible angle is
            shown where it is not feasible itself.

    Raises:
        RangeError: T_hand is not a rigid transform.
    """
    manifold = finder.manifolds.find(T_hand, clearance=finder.clearance)
    curves = tuple(finder.curves(manifold))
    found = finder.find_on(manifold, curves)
    if not curves:
        nothing = np.full(len(found.muscles), np.nan)
        return LivePosture(found, (), found.q, np.nan, np.nan, nothing, found.status)
    if swivel is None:
        shown = (found.q, found.swivel, found.effort, found.activations)
        return LivePosture(found, curves, *shown, found.status)
    interval, arc, angle = _nearest(manifold.intervals, swivel)
    q = interval.at(arc)[0]
    held = muscle_effort(finder.model, q, options=finder.effort)
    away = np.degrees(abs(_turn(angle - swivel)))
    message = "at the swivel angle asked for" if away < 0.5 else "at the nearest feasible angle"
    status = Status(bool(held.status[0]), message if held.status[0] else str(held.status[0]))
    shown = (q, angle, float(held.effort[0]), held.activations[0])
    return LivePosture(found, curves, *shown, status)


def _nearest(
    intervals: tuple[FeasibleInterval, ...], swivel: float
) -> tuple[FeasibleInterval, float, float]:
    """Give the interval, the place along it and the angle (rad) nearest to a swivel angle."""
    places = []
    for interval in intervals:
        arcs = np.linspace(interval.arc[0], interval.arc[-1], 721)
        angles = interval.swivel_near(arcs)
        away = np.abs(_turn(angles - swivel))
        i = int(np.nanargmin(away))
        places.append((float(away[i]), interval, float(arcs[i]), float(angles[i])))
    _, interval, arc, angle = min(places, key=lambda place: place[0])
    return interval, arc, angle


def _turn(angle: ArrayLike) -> np.ndarray:
    """Bring angles into -π to π."""
    return np.asarray(np.mod(np.asarray(angle) + np.pi, 2 * np.pi) - np.pi)


def effort_series(
    curves: tuple[EffortCurve, ...], n_series: int
) -> tuple[Float[np.ndarray, " points"], list[Float[np.ndarray, " points"]]]:
    """Give swivel angles (degrees, rising) and effort by interval, NaN outside of it.

    Args:
        curves: effort along each feasible interval.
        n_series: how many series a chart has; the longest intervals are kept.
    """
    longest = sorted(curves, key=lambda c: -c.interval.length)[:n_series]
    angles = [np.degrees(c.interval.swivel_near(c.arc)) for c in longest]
    grid = np.unique(np.concatenate(angles).round(3)) if angles else np.zeros(1)
    series = []
    for angle, curve in zip(angles, longest, strict=True):
        order = np.argsort(angle)
        effort = np.where(curve.held, curve.effort, np.nan)[order]
        series.append(np.interp(grid, angle[order], effort, left=np.nan, right=np.nan))
    series += [np.full(len(grid), np.nan)] * (n_series - len(series))
    return grid, series
