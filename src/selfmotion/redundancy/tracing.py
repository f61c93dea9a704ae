"""Traces curves of postures for one hand pose, and cuts them at the joint limits."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.kinematics.arm import Arm
from selfmotion.redundancy import limit_kernels, pose_kernels
from selfmotion.redundancy.feasible import FeasibleInterval, arm_swivel, hermite, unwrapped
from selfmotion.redundancy.pose_kernels import PathArrays
from selfmotion.redundancy.refine import POSITION_TOLERANCE, ROTATION_TOLERANCE

BEYOND = 0.3  # how far outside the limits the curve is followed (rad)
MAX_STEP = 0.15  # longest step along the curve (rad, norm over coordinates)
MAX_NODES = 800
_REFINE_ITERATIONS = 25
# Starts that are so close to the pose by then (m, rad) get more iterations.
_CLOSE, _MANY_ITERATIONS = (2e-3, 1e-2), 250
# A posture so far off a traced curve (rad) is not on it: farther than the cubics between nodes
# are off the true curve, nearer than another curve may run beside it.
_ON_CURVE = 3e-3
# Two intervals whose exact postures are so close (rad) are one.
_SAME = 1e-5
# Intervals between limits shorter than this (rad along the curve) are touches, not intervals.
_SHORTEST = 1e-9


@dataclass(frozen=True, eq=False)
class Tracer:
    """Traces curves for one arm and pose."""

    arm: Arm
    goal: np.ndarray
    path: PathArrays

    def pieces(self, starts: np.ndarray) -> tuple[list[FeasibleInterval], str]:
        """Give the feasible parts of all curves that starts lead to, and why there is none."""
        seeds, failure = self.refined(starts)
        pieces: list[FeasibleInterval] = []
        while len(seeds):
            nodes, tangents, arc, closed = self.curve(seeds[0])
            pieces += self.intervals(nodes, tangents, arc, closed=closed)
            seeds = seeds[1:][off_curve(seeds[1:], nodes, tangents, arc)]
        return pieces, failure

    def refined(self, starts: np.ndarray) -> tuple[np.ndarray, str]:
        """Give postures (S, 7) on the pose, the one deepest inside the limits first.

        The sentence says why none is feasible, if none is.
        """
        arm = self.arm
        q, reached = self._refined(starts)
        if not reached.any():
            return q[:0], "out of reach"
        q = q[reached]
        q = inside_turn(arm, q)
        excess = np.maximum(arm.lower - q, q - arm.upper)
        worst = excess.max(axis=1)
        i = int(np.argmin(worst))
        joint = int(np.argmax(excess[i]))
        sentence = (
            f"outside the joint limits ({arm.joints[joint]} would be "
            f"{np.rad2deg(worst[i]):.1f} deg beyond its limit)"
        )
        order = np.argsort(worst)
        return q[order][worst[order] < BEYOND], sentence

    def _refined(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        reached, errors = self._refine(q, _REFINE_ITERATIONS)
        # A straight elbow at the edge of reach: the last millimetres come slowly.
        close = ~reached & (errors[:, 0] < _CLOSE[0]) & (errors[:, 1] < _CLOSE[1])
        if close.any():
            again = q[close]
            reached[close], _ = self._refine(again, _MANY_ITERATIONS)
            q[close] = again
        return q, reached

    def _refine(self, q: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
        """Refine postures (S, 7) in place; gives which reach the pose, and errors (m, rad)."""
        iterations = np.empty(len(q), dtype=np.int64)
        errors = np.empty((len(q), 2))
        pose_kernels.refine_many(
            self.path,
            q,
            np.broadcast_to(self.goal, (len(q), 4, 4)).copy(),
            np.ones((1, 7)),
            np.array([POSITION_TOLERANCE, ROTATION_TOLERANCE]),
            most,
            iterations,
            errors,
        )
        return iterations >= 0, errors

    def curve(self, seed: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
        """Trace the curve through a seed both ways; the last says whether it is a loop."""
        box = np.vstack([self.arm.lower - BEYOND, self.arm.upper + BEYOND])
        direction = np.empty(7)
        if not pose_kernels.null_direction(self.path, seed, direction):
            return seed[None], np.zeros((1, 7)), np.zeros(1), False
        ahead = self._walk(seed, direction, box)
        if ahead[3] == pose_kernels.CLOSED:
            return (*ahead[:3], True)
        behind = self._walk(seed, -direction, box)
        nodes = np.vstack([behind[0][:0:-1], ahead[0]])
        tangents = np.vstack([-behind[1][:0:-1], ahead[1]])
        arc = np.concatenate([-behind[2][:0:-1], ahead[2]])
        return nodes, tangents, arc, False

    def _walk(
        self, seed: np.ndarray, direction: np.ndarray, box: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        nodes, tangents = np.empty((MAX_NODES, 7)), np.empty((MAX_NODES, 7))
        arc = np.empty(MAX_NODES)
        count, reason = pose_kernels.trace(
            self.path, seed, self.goal, direction, box, MAX_STEP, nodes, tangents, arc
        )
        count = max(count, 1)
        nodes[0] = seed
        return nodes[:count], tangents[:count], arc[:count], reason

    def intervals(
        self, nodes: np.ndarray, tangents: np.ndarray, arc: np.ndarray, *, closed: bool
    ) -> list[FeasibleInterval]:
        """Cut a curve at the joint limits and give the parts inside."""
        limits = np.vstack([self.arm.lower, self.arm.upper])
        if len(nodes) < 2:
            return []
        found = np.empty((64 + 4 * len(nodes), 4))
        count = limit_kernels.limit_crossings(nodes, tangents, arc, limits, found)
        events = found[:count][np.argsort(found[:count, 0])]
        if count == 0:
            if not self._inside(nodes[0]):
                return []
            name = "closed" if closed else "end of the curve"
            return [self._interval(nodes, tangents, arc, (name, name))]
        if closed:  # twice round, from the first crossing to the first crossing
            nodes, tangents, arc = _twice(nodes, tangents, arc)
            again = events[0] + [arc[-1] - arc[len(arc) // 2], 0.0, 0.0, 0.0]
            stops = [*events, again]
        else:
            stops = [None, *events, None]
        cuts = np.array([arc[0], *events[:, 0], arc[-1]])
        if closed:
            cuts = np.array([stop[0] for stop in stops])
        middles = self._exact(*hermite(arc, nodes, tangents, 0.5 * (cuts[:-1] + cuts[1:])))
        inside = np.array([self._inside(q) for q in middles])
        # Between nodes the cubics may cross a limit that the curve itself all but touches.
        real = np.concatenate([[True], ~(inside[:-1] & inside[1:]), [True]])
        stops = [stop for stop, keep in zip(stops, real, strict=True) if keep]
        cuts, inside = cuts[real], inside[real[:-1]]
        parts = []
        for i in np.flatnonzero(inside):
            if cuts[i + 1] - cuts[i] >= _SHORTEST:
                parts.append(self._cut(nodes, tangents, arc, (stops[i], stops[i + 1])))
        return parts

    def _exact(self, q: np.ndarray, tangents: np.ndarray) -> np.ndarray:
        """Bring postures (K, 7) near the curve onto it, square to the tangents, where they go."""
        exact = q.copy()
        wanted = (q * tangents).sum(axis=1)
        good = pose_kernels.correct_many(self.path, exact, tangents, wanted, self.goal)
        return np.where(np.asarray(good)[:, None], exact, q)

    def _inside(self, q: np.ndarray) -> bool:
        return bool((q >= self.arm.lower).all() and (q <= self.arm.upper).all())

    def _cut(
        self,
        nodes: np.ndarray,
        tangents: np.ndarray,
        arc: np.ndarray,
        events: tuple[np.ndarray | None, np.ndarray | None],
    ) -> FeasibleInterval:
        """Give the part between two events, its ends solved for exactly."""
        low = arc[0] if events[0] is None else events[0][0]
        high = arc[-1] if events[1] is None else events[1][0]
        inner = (arc > low + 1e-6) & (arc < high - 1e-6)
        ends, slopes = hermite(arc, nodes, tangents, np.array([low, high]))
        names = []
        for i, event in enumerate(events):
            name = "end of the curve"
            if event is not None:
                joint, side = int(event[1]), int(event[2])
                self._meet_limit(ends[i], joint, side)
                name = f"{self.arm.joints[joint]} {('lower', 'upper')[side]}"
            names.append(name)
        q = np.concatenate([ends[:1], nodes[inner], ends[1:]])
        t = np.concatenate([slopes[:1], tangents[inner], slopes[1:]])
        s = np.concatenate([[low], arc[inner], [high]])
        return self._interval(q, t, s, (names[0], names[1]))

    def _meet_limit(self, end: np.ndarray, joint: int, side: int) -> None:
        """Bring an end exactly onto pose and limit."""
        limit = (self.arm.lower, self.arm.upper)[side][joint]
        exact, row = end[None].copy(), np.zeros((1, 7))
        row[0, joint] = 1.0
        wanted = np.array([limit])
        solved = pose_kernels.correct_many(self.path, exact, row, wanted, self.goal)
        # Where the curve touches the limit along it, the two do not fix a point.
        if solved[0] and np.abs(exact[0] - end).max() < 0.02:
            end[:] = exact[0]
        end[joint] = limit

    def _interval(
        self, q: np.ndarray, t: np.ndarray, arc: np.ndarray, ends: tuple[str, str]
    ) -> FeasibleInterval:
        swivel = unwrapped(arm_swivel(self.arm, q))
        if len(swivel) > 1 and swivel[-1] < swivel[0]:
            q, t, swivel = q[::-1], -t[::-1], swivel[::-1]
            arc, ends = arc[-1] - arc[::-1], (ends[1], ends[0])
        parts = (q, t, arc - arc[0], swivel)
        q, t, arc, swivel = (np.ascontiguousarray(part) for part in parts)
        return FeasibleInterval(self.arm, self.goal, q, t, arc, swivel, ends, self.path)


def inside_turn(arm: Arm, q: Float[np.ndarray, "samples 7"]) -> Float[np.ndarray, "samples 7"]:
    """Take whole turns off coordinates, into the turn around the middle of their limits.

    Coordinates that other joints follow by a share or along a curve are left: a whole turn of
    shoulder elevation is none of the girdle.
    """
    coupling = arm.chain.coupling
    whole = (coupling.matrix == np.round(coupling.matrix)).all(axis=0)
    whole[[c.coordinate for c in coupling.curves]] = False
    return q - 2 * np.pi * whole * np.round((q - arm.middle()) / (2 * np.pi))


def off_curve(
    seeds: np.ndarray, nodes: np.ndarray, tangents: np.ndarray, arc: np.ndarray
) -> np.ndarray:
    """Tell which seeds (S, 7) are not on a traced curve."""
    distance = np.empty(len(seeds))
    q, n, t, s = (np.ascontiguousarray(part) for part in (seeds, nodes, tangents, arc))
    limit_kernels.distance_to_curve(q, n, t, s, 0.5 * MAX_STEP, distance)
    return distance > _ON_CURVE


def _twice(
    nodes: np.ndarray, tangents: np.ndarray, arc: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Go twice round a loop whose last node is its first."""
    twice = (np.vstack([nodes, nodes[1:]]), np.vstack([tangents, tangents[1:]]))
    return *twice, np.concatenate([arc, arc[1:] + arc[-1] - arc[0]])


def without_doubles(pieces: list[FeasibleInterval]) -> list[FeasibleInterval]:
    """Leave out intervals found twice (two seeds of one curve that the first trace missed)."""
    kept: list[FeasibleInterval] = []
    for piece in sorted(pieces, key=lambda piece: -piece.length):
        middle = piece.at(0.5 * piece.arc[-1])
        if not any(_lies_on(middle, other) for other in kept):
            kept.append(piece)
    return kept


def _lies_on(q: np.ndarray, interval: FeasibleInterval) -> bool:
    """Tell whether a posture (1, 7) is one of an interval's exact postures."""
    if off_curve(q, interval.q, interval.tangents, interval.arc)[0]:
        return False
    i = int(np.argmin(np.linalg.norm(interval.q - q, axis=1)))
    place = interval.arc[i]
    for _ in range(6):
        exact, tangent = interval.at_with_tangent(place)
        place = np.clip(place + ((q - exact) * tangent).sum(), interval.arc[0], interval.arc[-1])
    return bool(np.abs(interval.at(place) - q).max() < _SAME)
