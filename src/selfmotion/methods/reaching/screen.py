"""Decide which points the hand can reach, and refuse most of the others without trying.

The distance from a point to the reachable set changes by no more than the point moves. So a
point that was found out of reach by the distance d puts all points within d out of reach, too:
a screen is a set of such balls. Points that no ball covers are decided by inverse kinematics.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.kinematics.fast_position import positions
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_seeds import (
    SeedTable,
    at_ends,
    evenly,
    finite_limits,
    seed_table,
)
from selfmotion.methods.reaching.ik_tasks import ROWS, HandRows
from selfmotion.methods.reaching.nearby import AWAY, decide_nearby

if TYPE_CHECKING:
    from scipy.spatial import KDTree

# A ball is smaller by this (m) and by this part than the distance found, or that to the nearest
# position known to be reached: inverse kinematics may miss the nearest posture, by up to 12 mm at
# points within 20 mm of the reach and by up to 8 mm at others. So points nearer than `AWAY`, which
# were not tried from the ends of ranges either, make no balls at all.
MARGIN, MARGIN_PART = 12e-3, 0.05
# The box is wider than what was reached by this (m) and by this part on each side.
BOX_MARGIN, BOX_PART = 2e-3, 0.005
# Balls looked at for a point: the nearest ones.
BALLS = 8
# Postures whose positions are known to be reached, most of them at the ends of ranges.
KNOWN = 32768
# A point counts as reached when the hand comes as near as this (m); so many starts are tried, and
# twice as many from postures at the ends of ranges.
REACHED, STARTS = 1e-5, 5
# Points decided before what was learned from them is used.
LEAST_ROUND = 1024


@dataclass(frozen=True, eq=False)
class Reach:
    """What was decided about points.

    Attributes:
        points: (K, 3) m.
        reachable: (K,) whether a posture inside the limits brings the hand there.
        distance: (K,) m from the nearest posture found; NaN where the screen refused.
        q: (K, n) that posture; NaN where the screen refused.
    """

    points: Float[np.ndarray, "points 3"]
    reachable: Bool[np.ndarray, " points"]
    distance: Float[np.ndarray, " points"]
    q: Float[np.ndarray, "points coords"]


@dataclass(frozen=True, eq=False)
class ReachScreen:
    """Balls of space that the hand cannot reach.

    Attributes:
        task: the arm, and the orientation rows held if any.
        seeds: where inverse kinematics starts.
        low: (3,) corner of a box that holds all the hand can reach (m).
        high: (3,) the opposite corner.
        centres: (B, 3) centres of the balls (m).
        radii: (B,) their radii (m).
        hands: (H, 3) where decided points brought the hand (m), and in which
        postures: (H, n); their neighbours are decided from there.
    """

    task: HandRows
    seeds: SeedTable
    low: Float[np.ndarray, "3"]
    high: Float[np.ndarray, "3"]
    centres: Float[np.ndarray, "balls 3"]
    radii: Float[np.ndarray, " balls"]
    hands: Float[np.ndarray, "hands 3"]
    postures: Float[np.ndarray, "hands coords"]

    @cached_property
    def _tree(self) -> "KDTree":
        from scipy.spatial import KDTree

        return KDTree(self.centres)

    @cached_property
    def _hand_tree(self) -> "KDTree":
        return _quick_tree(self.hands)

    @cached_property
    def _known(self) -> "KDTree":
        reached = self._hands_at(at_ends(KNOWN, *finite_limits(self.task.arm)))
        return _quick_tree(np.concatenate([self.seeds.positions, reached]))

    def _hands_at(self, q: np.ndarray) -> Float[np.ndarray, "samples 3"]:
        return positions(self.task.arm.chain, q, self.task.arm.tip(self.task.landmark))

    def refuses(self, points: ArrayLike, *, threads: int = 1) -> Bool[np.ndarray, " points"]:
        """Tell which points (K, 3) are certainly out of reach: outside the box or in a ball."""
        x = _points(points)
        refused: np.ndarray = np.any((x < self.low) | (x > self.high), axis=1)
        if len(self.centres):
            count = min(BALLS, len(self.centres))
            found = self._tree.query(x, k=count, workers=threads)
            away, ball = (np.reshape(a, (len(x), count)) for a in found)
            refused |= np.any(away < self.radii[ball], axis=1)
        return refused

    def at_least(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give a distance (m) that points (K, 3) are out of reach by at least; 0: not known."""
        x = _points(points)
        beyond = np.maximum(np.maximum(self.low - x, x - self.high), 0.0)
        least = np.linalg.norm(beyond, axis=1)
        if len(self.centres):
            count = min(BALLS, len(self.centres))
            away, ball = (np.reshape(a, (len(x), count)) for a in self._tree.query(x, k=count))
            least = np.maximum(least, (self.radii[ball] - away).max(axis=1))
        return np.maximum(least, 0.0)

    def decide(self, points: ArrayLike, *, options: IkOptions | None = None) -> Reach:
        """Decide points (K, 3): the screen first, inverse kinematics for what it leaves.

        Raises:
            ShapeError: the points are not (K, 3).
            NotFiniteError: a point is not finite.
        """
        x = _points(points)
        open_ = ~self.refuses(x)
        distance = np.full(len(x), np.nan)
        q = np.full((len(x), self.task.arm.n_joints), np.nan)
        reachable = np.zeros(len(x), dtype=np.bool_)
        if open_.any():
            found = solve_ik(
                self.task,
                _targets(self.task, x[open_]),
                options=options or reach_options(),
                seeds=self.seeds,
            )
            reachable[open_], q[open_] = found.solved, found.q
            turned = self.task.rotation_scale * found.rotation_error
            distance[open_] = np.hypot(found.position_error, turned)
        return Reach(*(freeze(a) for a in (x, reachable, distance, q)))

    def explore(self, points: ArrayLike, *, threads: int = 1) -> tuple[Reach, "ReachScreen"]:
        """Decide many points (K, 3) that lie close to one another; give what was learned, too.

        Each round, the points of which are no denser than those before, starts from the postures
        of neighbours. A task that holds angles, where these may be far apart, is decided as ever.

        Raises:
            ShapeError: the points are not (K, 3).
            NotFiniteError: a point is not finite.
        """
        x, screen, done, parts = _points(points), self, 0, []
        while done < len(x) or not parts:
            part = x[done : done + max(LEAST_ROUND, done)]
            if self.task.angles or not len(screen.hands):
                reach = screen.decide(part, options=reach_options(threads=threads))
            else:
                reach = screen._nearby(part, threads)
            screen, done = screen.learn(reach), done + len(part)
            parts.append(reach)
        q = np.concatenate([p.q for p in parts])
        reached = np.concatenate([p.reachable for p in parts])
        distance = np.concatenate([p.distance for p in parts])
        return Reach(*(freeze(a) for a in (x, reached, distance, q))), screen

    def _nearby(self, x: Float[np.ndarray, "points 3"], threads: int) -> Reach:
        """Decide points by the screen, then from postures of their neighbours."""
        distance, reachable = np.full(len(x), np.nan), np.zeros(len(x), dtype=np.bool_)
        q = np.full((len(x), self.task.arm.n_joints), np.nan)
        left, known = ~self.refuses(x, threads=threads), (self._hand_tree, self.postures)
        found = decide_nearby(self.seeds, x[left], known, REACHED, threads=threads)
        q[left], reachable[left], distance[left] = found.q, found.solved, found.errors[:, 0]
        return Reach(*(freeze(a) for a in (x, reachable, distance, q)))

    def learn(self, reach: Reach) -> "ReachScreen":
        """Give a screen that also knows the balls around points just found out of reach.

        It knows, too, where the hand came on the way to them, and to those that were reached; no
        new ball comes near that.
        """
        out = ~reach.reachable & np.isfinite(reach.distance)
        away = reach.distance[out] > AWAY
        points, nearest = reach.points[out][away], reach.distance[out][away]
        nearest = np.minimum(nearest, self._known.query(points)[0])
        hands, postures, tree = self.hands, self.postures, None
        if not self.task.angles:  # elsewhere a hand may be at a point, but turned
            hands = np.concatenate(
                [hands, reach.points[reach.reachable], self._hands_at(reach.q[out])]
            )
            postures = np.concatenate([postures, reach.q[reach.reachable], reach.q[out]])
            tree = _quick_tree(hands)
            nearest = np.minimum(nearest, tree.query(points)[0])
        radius = (1.0 - MARGIN_PART) * nearest - MARGIN
        new = radius > 0
        learned = replace(
            self,
            hands=freeze(hands),
            postures=freeze(postures),
            centres=freeze(np.concatenate([self.centres, points[new]])),
            radii=freeze(np.concatenate([self.radii, radius[new]])),
        )
        learned.__dict__["_known"] = self._known  # the same arm: found once
        if tree is not None:
            learned.__dict__["_hand_tree"] = tree
        return learned


def reach_screen(
    task: HandRows,
    *,
    n_points: int = 8192,
    seeds: SeedTable | None = None,
    options: IkOptions | None = None,
) -> ReachScreen:
    """Build a screen from points spread evenly over the box that the hand can reach.

    Args:
        task: rows held; x, y and z must be among them. Held angles are held at zero.
        n_points: points tried; more of them leave fewer points open.
        seeds: where inverse kinematics starts; left out: a table is made.
        options: of inverse kinematics.

    Raises:
        RangeError: the task leaves x, y or z free.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.reaching.ik_tasks import HandRows
        >>> screen = reach_screen(HandRows(load_arm("upper_limb"), ("x", "y", "z")), n_points=256)
        >>> screen.decide([[0.2, 0.4, 0.0], [0.2, 0.4, 0.9]]).reachable.tolist()
        [True, False]
    """
    if task.axes != (0, 1, 2):
        raise RangeError(f"rows = {','.join(task.rows)}: a screen needs x, y and z held")
    table = seed_table(task) if seeds is None else seeds
    low, high = reach_box(task)
    none = np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)), np.zeros((0, task.arm.n_joints))
    screen = ReachScreen(task, table, low, high, *none)
    points = evenly(n_points, low, high)
    first = 0
    while first < n_points:  # each round is refused the more, the more is known
        last = min(n_points, max(128, 2 * first))
        screen = screen.learn(screen.decide(points[first:last], options=options))
        first = last
    return screen


def reach_box(task: HandRows) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Give the box that holds all positions of the landmark: how far each axis can be reached.

    Each side is found by inverse kinematics towards a point just beyond what was reached so far.
    """
    ends = np.empty((2, 3))
    for axis in range(3):
        along = HandRows(task.arm, (ROWS[axis],), task.landmark)
        seeds = seed_table(along, n_seeds=512)
        for side, sign in enumerate((-1.0, 1.0)):
            reached = (sign * seeds.positions[:, axis]).max()
            start = seeds.q[[np.argmax(sign * seeds.positions[:, axis])]]
            for _ in range(6):
                step = 0.03
                found = solve_ik(
                    along,
                    [[sign * (reached + step)]],
                    start=start,
                    seeds=seeds,
                    options=IkOptions(restarts=8),
                )
                start = found.q
                gained = step - float(found.position_error[0])
                reached += max(gained, 0.0)
                if gained < 1e-3:
                    break
            ends[side, axis] = sign * reached
    margin = BOX_PART * (ends[1] - ends[0]) + BOX_MARGIN
    return freeze(ends[0] - margin), freeze(ends[1] + margin)


def reach_options(*, threads: int = 1) -> IkOptions:
    """Give the options by which points are decided."""
    return IkOptions(position_tolerance=REACHED, restarts=STARTS, threads=threads)


def _quick_tree(points: np.ndarray) -> "KDTree":
    """Give a tree that is made fast; a query takes a little longer."""
    from scipy.spatial import KDTree

    return KDTree(points, balanced_tree=False, compact_nodes=False)


def _points(points: ArrayLike) -> Float[np.ndarray, "points 3"]:
    x = np.atleast_2d(as_float_array("points", points))
    require_shape("points", x, (None, 3))
    require_finite("points", x)
    return x


def _targets(task: HandRows, x: np.ndarray) -> np.ndarray:
    """Give targets of the task's rows: points, and angles held at zero."""
    return np.concatenate([x, np.zeros((len(x), len(task.angles)))], axis=1)
