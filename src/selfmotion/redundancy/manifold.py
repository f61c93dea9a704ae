"""The self-motion manifold: all postures of a 7-DoF arm that hold the hand in one pose.

[Li2022] (doi 10.1109/TNSRE.2022.3198400) samples it by swivel angle (Table II). Here, beyond the
paper, it is traced by continuation, so that every interval of postures inside the joint limits
is found with its exact ends: there the pose and the limit that is met hold together, seven
equations for seven coordinates. Seeds for the traces come from the closed form of the arm's
relative, on all eight branches, with the shoulder centre of nine elevations, and at swivel angles
so dense that between two of them no coordinate turns fast (`kinematics.srs_kernels.StartChoice`).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, halton
from selfmotion.errors import ShapeError, Status
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.srs import SrsRelative
from selfmotion.kinematics.srs_kernels import StartChoice, srs_starts
from selfmotion.redundancy.feasible import Clearance, FeasibleInterval, clear_parts
from selfmotion.redundancy.nearest import nearest_posture
from selfmotion.redundancy.pose_kernels import PathArrays
from selfmotion.redundancy.refine import check_poses, path_arrays
from selfmotion.redundancy.tracing import Tracer, without_doubles

# The relative's wrist and shoulder centres are not quite the arm's, so that seeds outside the
# limits are worth refining up to a margin.
_CHOICE = StartChoice()
# Elevations of the girdle, ends of the range included, for whose shoulder centre starts are
# computed: with a centre some mm off, those for a nearly straight arm lead to other curves.
N_ELEVATIONS = 9
# Where the wrist is at this share of the relative's length, starts with a shoulder centre this
# much (m) nearer to it are added: a nearly straight elbow of the arm may be out of reach of the
# relative by a few mm.
_STRAIGHT, _NEARER = (0.98, 1.04), 6e-3
# How far inside the limits (rad) a second try starts.
_INSET = 0.3
# With fewer starts than this, more are taken from all over the box of limits.
_ENOUGH = 24
# Points of a Halton sequence in seven dimensions.
_HALTON = halton(24, 7)


@dataclass(frozen=True, eq=False)
class SelfMotionManifold:
    """All feasible postures for one hand pose.

    Attributes:
        arm: the arm.
        T_hand: the hand pose in the ground.
        intervals: stretches of feasible postures, by rising swivel angle.
        status: whether there is any; if not, whether the pose is out of reach or outside the
            joint limits, and how far the nearest pose inside them is.
    """

    arm: Arm
    T_hand: Transform
    intervals: tuple[FeasibleInterval, ...]
    status: Status

    @property
    def swivel_intervals(self) -> list[tuple[float, float]]:
        """Least and greatest swivel angle (rad) of each interval."""
        return [interval.swivel_range for interval in self.intervals]

    @property
    def swivel_width(self) -> float:
        """Sum of the widths of all intervals (rad)."""
        return float(sum(high - low for low, high in self.swivel_intervals))


def self_motion_manifold(
    arm: Arm, T_hand: ArrayLike, *, clearance: Clearance | None = None
) -> SelfMotionManifold:
    """Find all feasible postures for a hand pose, as intervals with exact ends.

    For many poses of one arm, build a `ManifoldFinder` once and call its `find`.

    Args:
        arm: with seven free coordinates.
        T_hand: (4, 4) hand pose in the ground (m).
        clearance: how far postures are outside bodies that the arm may not enter (m).

    Raises:
        ModelError: the arm has not seven free coordinates, or a shoulder of an unknown kind.
        RangeError: T_hand is not a rigid transform.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import srs7
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = srs7()
        >>> pose = forward_kinematics(arm.chain, arm.middle(), arm.tip("hand"))[0]
        >>> manifold = self_motion_manifold(arm, pose)
        >>> len(manifold.intervals) > 0
        True
    """
    return ManifoldFinder.of(arm).find(T_hand, clearance=clearance)


@dataclass(frozen=True, eq=False)
class ManifoldFinder:
    """What finding manifolds needs to know of an arm.

    Attributes:
        arm: the arm.
        path: the joints that carry the hand.
        relative: the closed-form relative.
        centres: (C, 3) where the girdle puts the shoulder centre at several elevations (m); one
            alone where the centre does not move.
        elevations: (C,) second coordinate (rad) for which each of them is right.
    """

    arm: Arm
    path: PathArrays
    relative: SrsRelative
    centres: Float[np.ndarray, "centres 3"]
    elevations: Float[np.ndarray, " centres"]

    @classmethod
    def of(cls, arm: Arm) -> "ManifoldFinder":
        """Prepare an arm.

        Raises:
            ModelError: the arm has not seven free coordinates, or a shoulder of another kind.
        """
        relative = SrsRelative.of(arm)
        home = np.clip(np.zeros(7), arm.lower, arm.upper)
        elevations = np.linspace(arm.lower[1], arm.upper[1], N_ELEVATIONS)
        postures = np.repeat(home[None], len(elevations), axis=0)
        postures[:, 1] = elevations
        centres = tip_positions(arm.chain, postures, [arm.tip("shoulder")])[:, 0]
        if np.ptp(centres, axis=0).max() < 1e-3:
            centres, elevations = centres[:1], elevations[:1]
        centres = np.ascontiguousarray(centres)
        return cls(arm, path_arrays(arm.chain, arm.tip("hand")), relative, centres, elevations)

    def find(
        self, T_hand: ArrayLike, *, clearance: Clearance | None = None, nearest: bool = True
    ) -> SelfMotionManifold:
        """Find all feasible postures for a hand pose; see `self_motion_manifold`.

        Args:
            T_hand: (4, 4) hand pose in the ground (m).
            clearance: how far postures are outside bodies that the arm may not enter (m).
            nearest: whether to say, where there is no posture, how near the hand comes; that takes
                twenty times as long as finding postures, which counts on a grid of poses.

        Raises:
            RangeError: T_hand is not a rigid transform.
        """
        goals = check_poses(T_hand)
        if len(goals) != 1:
            raise ShapeError(f"T_hand: {len(goals)} poses given; a manifold belongs to one")
        goal = np.ascontiguousarray(goals[0])
        tracer = Tracer(self.arm, goal, self.path)
        starts = self._starts(goal)
        pieces, failure = tracer.pieces(starts)
        if not pieces:
            # A nearly straight elbow, or an elevation near none: the refined seeds may all have
            # come out on the other side of the limit. Start once more from inside the box.
            room = np.minimum(_INSET, 0.25 * (self.arm.upper - self.arm.lower))
            inside = np.clip(starts, self.arm.lower + room, self.arm.upper - room)
            pieces, _ = tracer.pieces(inside)
        if not pieces and nearest:
            closest = nearest_posture(self.arm, goal, starts)
            failure = f"{failure}: {closest.sentence}"
            if closest.reached:  # all starts missed it; a limit may let in one posture only
                pieces, failure = tracer.pieces(closest.q[None])
        if clearance is not None:
            failure = "every posture meets an excluded body" if pieces else failure
            pieces = [part for piece in pieces for part in clear_parts(piece, clearance)]
        pieces = sorted(without_doubles(pieces), key=lambda piece: piece.swivel_range)
        if pieces:
            status = Status(True, f"{len(pieces)} feasible interval(s) of swivel angle")
        else:
            status = Status(False, failure or "no feasible posture")
        return SelfMotionManifold(self.arm, goal, tuple(pieces), status)

    def _starts(self, goal: np.ndarray) -> np.ndarray:
        """Give postures (S, 7) from the closed form that are near the limits' box."""
        limits = np.vstack([self.arm.lower, self.arm.upper])
        arrays = self.relative.arrays
        q, score = srs_starts(arrays, self.centres, self.elevations, goal, limits, _CHOICE)
        towards = goal[:3, 3] + goal[:3, :3] @ arrays.wrist_in_hand - self.centres
        far = np.linalg.norm(towards, axis=1)
        share = far / (np.linalg.norm(arrays.upper_arm) + np.linalg.norm(arrays.forearm))
        straight = (share > _STRAIGHT[0]) & (share < _STRAIGHT[1])
        if straight.any():
            nearer = self.centres + _NEARER * towards / far[:, None]
            some, elevations = nearer[straight], self.elevations[straight]
            more = srs_starts(arrays, some, elevations, goal, limits, _CHOICE)
            q, score = np.vstack([q, more[0]]), np.concatenate([score, more[1]])
        good = score < _CHOICE.margin
        if good.sum() >= _ENOUGH:
            return q[good]
        # Little or nothing in reach: the nearest starts, and a few postures across the box, tell
        # whether it is so.
        nearest = q[np.argsort(np.where(np.isfinite(score), score, np.inf))[:_ENOUGH]]
        spread = _HALTON * (self.arm.upper - self.arm.lower) + self.arm.lower
        return np.vstack([nearest[np.isfinite(nearest).all(axis=1)], spread])
