"""Bring postures onto a hand pose by damped least squares."""

import functools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import Chain, Tip
from selfmotion.kinematics.serial_path import SerialPath
from selfmotion.redundancy import pose_kernels
from selfmotion.redundancy.pose_kernels import PathArrays

POSITION_TOLERANCE = 1e-10  # m
ROTATION_TOLERANCE = 1e-10  # rad
# How far R'R of a pose may be from the identity, and a quaternion's length from 1.
POSE_TOLERANCE = 1e-6
FARTHEST = 1e4  # m: no pose of a hand is so far from an arm's ground frame


@dataclass(frozen=True, eq=False)
class Refined:
    """Postures brought onto hand poses.

    Attributes:
        q: (K, n) coordinates (rad), not confined to joint limits.
        reached: (K,) whether the pose is reached to the tolerances.
        iterations: (K,) steps taken; -1 where not reached.
        position_error: (K,) m.
        rotation_error: (K,) rad.
    """

    q: Float[np.ndarray, "samples coords"]
    reached: Bool[np.ndarray, " samples"]
    iterations: Int[np.ndarray, " samples"]
    position_error: Float[np.ndarray, " samples"]
    rotation_error: Float[np.ndarray, " samples"]


def refine(
    arm: Arm,
    q: ArrayLike,
    T_hand: ArrayLike,
    *,
    turns: Float[np.ndarray, "turns coords"] | None = None,
    max_iterations: int = 40,
) -> Refined:
    """Refine postures so that the hand has a pose, moving them as little as need be.

    Levenberg-Marquardt steps with a damping that shrinks with the error, so that the last steps
    are Newton's. Joint limits are not looked at: the caller decides what to do beyond them.

    Args:
        arm: the arm.
        q: (n,) or (K, n) postures to start from (rad).
        T_hand: (4, 4) or (K, 4, 4) poses of the hand in the ground (m).
        turns: (C, n) which coordinates move (1) or rest (0) in step 1, 2, ..., C, 1, ...;
            left out: all move.
        max_iterations: steps before giving up.

    Raises:
        ShapeError: the arrays do not fit the arm or each other.
        RangeError: T_hand is not a rigid transform.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import srs7
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = srs7()
        >>> goal = forward_kinematics(arm.chain, arm.middle(), arm.tip("hand"))
        >>> refine(arm, arm.middle() + 0.1, goal).reached.tolist()
        [True]
    """
    samples = arm.chain.as_samples(q).copy()
    goals = check_poses(T_hand)
    if len(goals) == 1:
        goals = np.repeat(goals, len(samples), axis=0)
    require_shape("T_hand", goals, (len(samples), 4, 4))
    free = np.ones((1, arm.n_joints)) if turns is None else turns
    require_shape("turns", free, (None, arm.n_joints))
    iterations = np.empty(len(samples), dtype=np.int64)
    errors = np.empty((len(samples), 2))
    pose_kernels.refine_many(
        path_arrays(arm.chain, arm.tip("hand")),
        samples,
        np.ascontiguousarray(goals),
        np.ascontiguousarray(free, dtype=np.float64),
        np.array([POSITION_TOLERANCE, ROTATION_TOLERANCE]),
        max_iterations,
        iterations,
        errors,
    )
    return Refined(samples, iterations >= 0, iterations, errors[:, 0], errors[:, 1])


def check_poses(T_hand: ArrayLike) -> Float[np.ndarray, "samples 4 4"]:
    """Check rigid transforms (4, 4) or (K, 4, 4), and give them as (K, 4, 4).

    Raises:
        ShapeError: the array has another shape.
        NotFiniteError: it holds NaN or infinite values.
        RangeError: a rotation part is not a rotation, or a position is out of this world.
    """
    T = as_float_array("T_hand", T_hand)
    T = T[None] if T.ndim == 2 else T
    require_shape("T_hand", T, (None, 4, 4))
    require_finite("T_hand", T)
    beyond = np.abs(T[:, :3, 3]) > FARTHEST
    if beyond.any():
        value = T[:, :3, 3][beyond][0]
        raise RangeError(f"T_hand: a position of {value:g} m; allowed is up to {FARTHEST:g} m")
    R = T[:, :3, :3]
    off = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2))
    bad = np.flatnonzero((off > POSE_TOLERANCE) | (np.linalg.det(R) < 0))
    if len(bad):
        raise RangeError(
            f"T_hand[{bad[0]}]: its upper left 3x3 is not a rotation "
            f"(R'R is {off[bad[0]]:.2g} from the identity, at most {POSE_TOLERANCE:g})"
        )
    return T


def pose_from_quaternion(quaternion: ArrayLike, position: ArrayLike) -> Transform:
    """Build a pose from a quaternion (x, y, z, w) and a position (m).

    Raises:
        RangeError: the quaternion has not length 1.
    """
    from scipy.spatial.transform import Rotation

    v = as_float_array("quaternion", quaternion)
    x = as_float_array("position", position)
    require_shape("quaternion", v, (4,))
    require_shape("position", x, (3,))
    require_finite("quaternion", v)
    require_finite("position", x)
    length = float(np.linalg.norm(v))
    if abs(length - 1.0) > 1e-3:
        raise RangeError(f"quaternion {v.tolist()} has length {length:.6g}; it must be 1 to 1e-3")
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat(v).as_matrix()
    T[:3, 3] = x
    return T


@functools.lru_cache(maxsize=32)
def path_arrays(chain: Chain, tip: Tip) -> PathArrays:
    """Give the joints that carry a tip as arrays for the kernels.

    Raises:
        ModelError: the tip is fixed to the ground.
    """
    path = SerialPath.of(chain, tip)
    n_path = len(path.joints)
    order = max((c.curve.c.shape[0] for c in path.curves), default=1)
    longest = max((len(c.curve.x) for c in path.curves), default=2)
    n_curves = max(len(path.curves), 1)
    which = np.full(n_path, -1, dtype=np.int64)
    lead = np.zeros(n_curves, dtype=np.int64)
    breaks = np.full((n_curves, longest), np.inf)
    coefficients = np.zeros((n_curves, order, longest - 1))
    for i, c in enumerate(path.curves):
        which[c.joint] = i
        lead[i] = c.coordinate
        breaks[i, : len(c.curve.x)] = c.curve.x
        k, pieces = c.curve.c.shape
        coefficients[i, order - k :, :pieces] = c.curve.c
    return PathArrays(
        path.prismatic.astype(np.int64),
        np.cos(path.twist),
        np.sin(path.twist),
        np.ascontiguousarray(path.shift),
        path.angle_offset.copy(),
        np.array([np.cos(path.base_angle), np.sin(path.base_angle)]),
        path.tip_rotation.copy(),
        path.tip_position.copy(),
        path.matrix.copy(),
        path.offset.copy(),
        which,
        lead,
        breaks,
        coefficients,
    )
