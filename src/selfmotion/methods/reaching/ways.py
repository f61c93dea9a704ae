"""Postures at a place of the hand that are as they should be: elbow raised, arm beside the body.

Inverse kinematics gives one posture of many. Where it is not as wanted, others are tried, and
then changed along the self-motion of the hand's place (`climb`). That is a search: a posture that
was found proves the way, none found proves nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import REACHED
from selfmotion.methods.reaching.self_motion_search import climb

# More than this is not wanted (m): climbing stops there.
ENOUGH = 1e-3


@dataclass(frozen=True, eq=False)
class Wanted:
    """What postures shall be, and where to come from.

    Attributes:
        worth: postures (K, n) to (K,): above 0 where they are as wanted (m).
        starts: places (K, 3) and the number of the attempt to postures (K, n).
        tries: attempts from other postures.
        climbs: how many of them are tried again with climbing.
    """

    worth: Callable[[np.ndarray], np.ndarray]
    starts: Callable[[np.ndarray, int], np.ndarray]
    tries: int = 10
    climbs: int = 2


def with_posture(
    task: HandRows,
    points: Float[np.ndarray, "points 3"],
    q: Float[np.ndarray, "points coords"],
    wanted: Wanted,
    *,
    threads: int = 1,
) -> Bool[np.ndarray, " points"]:
    """Tell for which places a posture was found that reaches them and is as wanted.

    Args:
        task: position of the hand.
        points: places that are reached (m).
        q: a posture for each.
        wanted: what is to be above 0, and other postures to come from.
        threads: how many threads share the points.
    """
    once = IkOptions(position_tolerance=REACHED, restarts=0, threads=threads)
    out = wanted.worth(q) > 0

    def capped(postures: np.ndarray) -> np.ndarray:
        return np.minimum(wanted.worth(postures), ENOUGH)

    def attempt(k: int, *, climbing: bool) -> None:
        rows = np.flatnonzero(~out)
        if not len(rows):
            return
        first = wanted.starts(points[rows], k)
        found = solve_ik(task, points[rows], start=first, options=once)
        rows, postures = rows[found.solved], found.q[found.solved]
        if not len(rows):
            return
        value = climb(task, points[rows], postures, capped)[1] if climbing else capped(postures)
        out[rows] = value > 0

    for k in range(wanted.tries):
        attempt(k, climbing=False)
    rows = np.flatnonzero(~out)
    if len(rows):
        out[rows] = climb(task, points[rows], q[rows], capped)[1] > 0
    for k in range(wanted.climbs):
        attempt(k, climbing=True)
    return out
