"""What the hand must do, for inverse kinematics: any of x, y, z, roll, pitch and yaw held.

Roll, pitch and yaw are the angles φ, ψ, γ about the ground's x, y and z of [DeBoon] eqs 4 to 6,
``R = Rz(γ) Ry(ψ) Rx(φ)``, with the arctangent of two arguments (the printed one aliases poses).
They only name what is held: errors are turns on the rotation group, which neither alias nor
stall at gimbal lock.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite
from selfmotion.errors import RangeError, ShapeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import frames_and_jacobian
from selfmotion.methods.reaching import ik_arrays
from selfmotion.methods.reaching.ik_rotation import rotation_rows
from selfmotion.redundancy.task import Pose, Position
from selfmotion.spatial import exp_rotation

ROWS = ("x", "y", "z", "rot_x", "rot_y", "rot_z")
# Targets beyond this (m, rad) are slips of a unit, and their squares lose every arm.
FARTHEST = 1e6
# How far a frame's rotation may be from one (entries of RᵀR - I).
ORTHONORMAL = 1e-6
_MODES = {
    (): ik_arrays.FREE_ROTATION,
    (0, 1, 2): ik_arrays.FULL_ROTATION,
    (0, 1): ik_arrays.YAW_FREE,
    (1, 2): ik_arrays.ROLL_FREE,
    (0, 2): ik_arrays.PITCH_FREE,
    (1,): ik_arrays.ONLY_PITCH,
    (0,): ik_arrays.ONLY_ROLL,
    (2,): ik_arrays.ONLY_YAW,
}


@dataclass(frozen=True, eq=False)
class HandRows:
    """Some of x, y, z (m), rot_x, rot_y, rot_z (rad) of a landmark, held at a target.

    Attributes:
        arm: the arm.
        rows: the rows held, in the order x, y, z, rot_x, rot_y, rot_z.
        landmark: the frame that has them.
        rotation_scale: metres that one radian counts as while solving.

    Example:
        The rows of the paper's second scenario (FACTS: x, y, z and ψ):

        >>> from selfmotion.arms import planar
        >>> HandRows(planar([0.3, 0.25]), ("x", "y", "rot_z")).units
        ('m', 'm', 'rad')
    """

    arm: Arm
    rows: tuple[str, ...]
    landmark: str = "hand"
    rotation_scale: float = 0.25

    def __post_init__(self) -> None:
        """Check the rows and put them in order."""
        for row in self.rows:
            if row not in ROWS:
                raise unknown_name("row", row, ROWS)
        if not self.rows or len(set(self.rows)) != len(self.rows):
            raise RangeError(f"rows = {','.join(self.rows)}: name at least one row, each once")
        if not self.rotation_scale > 0.0:
            raise RangeError(f"rotation_scale = {self.rotation_scale:g} m: must be above 0")
        object.__setattr__(self, "rows", tuple(r for r in ROWS if r in self.rows))
        self.arm.tip(self.landmark)

    @property
    def axes(self) -> tuple[int, ...]:
        """Ground axes of the position that are held."""
        return tuple(i for i in range(3) if ROWS[i] in self.rows)

    @property
    def angles(self) -> tuple[int, ...]:
        """Which of roll, pitch and yaw are held."""
        return tuple(i for i in range(3) if ROWS[3 + i] in self.rows)

    @property
    def mode(self) -> int:
        """How the kernels hold the orientation."""
        return _MODES[self.angles]

    @property
    def units(self) -> tuple[str, ...]:
        """Metres, then radians."""
        return tuple("m" if row in ROWS[:3] else "rad" for row in self.rows)

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """Ones for position, `rotation_scale` for orientation."""
        return np.array([1.0 if unit == "m" else self.rotation_scale for unit in self.units])

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give the rows (m, rad) for postures q, (n,) or (K, n)."""
        T = frames_and_jacobian(self.arm.chain, q, self.arm.tip(self.landmark))[0]
        both = np.concatenate([T[:, :3, 3], roll_pitch_yaw(T[:, :3, :3])], axis=1)
        return both[:, [ROWS.index(row) for row in self.rows]]

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give the velocity of the rows per joint velocity; orientation rows are turns.

        With roll and yaw held and pitch free there is one row more, for a pitch that is at the
        end of its range (a quarter turn); it is zero otherwise.
        """
        return self._error_and_jacobian(q, None)[1]

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give what is missing to targets (see `goals`) in the rows held (m, rad)."""
        return self._error_and_jacobian(q, self.goals(target))[0]

    def _error_and_jacobian(
        self, q: ArrayLike, goals: ik_arrays.Goals | None
    ) -> tuple[np.ndarray, np.ndarray]:
        T, J = frames_and_jacobian(self.arm.chain, q, self.arm.tip(self.landmark))
        if goals is None:  # where the hand is: no error, and the directions of the rows
            angles = roll_pitch_yaw(T[:, :3, :3])
            goals = ik_arrays.Goals(T[:, :3, 3].copy(), T[:, :3, :3].copy(), angles)
        axes = list(self.axes)
        n_rows = len(axes) + (3 if self.mode == ik_arrays.PITCH_FREE else len(self.angles))
        error, rows = np.zeros((len(T), n_rows)), np.zeros((len(T), n_rows, J.shape[2]))
        one = len(goals.position) == 1
        turn, scratch = np.zeros((3, 3)), np.zeros((3, 3, 3))
        for k in range(len(T)):
            g = 0 if one else k
            error[k, : len(axes)] = goals.position[g][axes] - T[k, axes, 3]
            rows[k, : len(axes)] = J[k, axes]
            n = rotation_rows(
                np.ascontiguousarray(T[k, :3]),
                goals.rotation[g],
                goals.angles[g],
                self.mode,
                error[k, len(axes) :],
                turn,
                scratch,
            )
            rows[k, len(axes) :] = turn[:n] @ J[k, 3:]
        return error, rows

    def goals(self, target: ArrayLike) -> ik_arrays.Goals:
        """Turn targets into what the kernels want.

        Args:
            target: (m,) or (K, m) values of the rows held (m, rad), or (K, 4, 4) frames, of
                which the rows held are taken; for all six rows, (K, 6) holds position and
                **rotation vector** if the task came from a `Pose`, else roll, pitch and yaw.

        Raises:
            ShapeError: the target has another shape.
            NotFiniteError: it holds NaN or infinite values.
            RangeError: a value is beyond `FARTHEST`, or a frame holds no rotation.
        """
        array = as_float_array("target", target)
        _require_sensible(array)
        # Four samples of four rows are rows; a single frame is then asked for as (1, 4, 4).
        one_frame = array.shape == (4, 4) and len(self.rows) != 4
        if one_frame or (array.ndim == 3 and array.shape[1:] == (4, 4)):
            T = array.reshape(-1, 4, 4)
            _require_rotations(T)
            angles = roll_pitch_yaw(T[:, :3, :3])
            return ik_arrays.Goals(T[:, :3, 3].copy(), T[:, :3, :3].copy(), angles)
        values = np.atleast_2d(array)
        if values.ndim != 2 or values.shape[1] != len(self.rows):
            raise ShapeError(
                f"target has shape {array.shape}; expected (samples, {len(self.rows)}) for "
                f"{', '.join(self.rows)}, or (samples, 4, 4)"
            )
        full = np.zeros((len(values), 6))
        full[:, [ROWS.index(row) for row in self.rows]] = values
        rotation = rotation_of(full[:, 3:])
        return ik_arrays.Goals(full[:, :3].copy(), rotation, full[:, 3:].copy())


def as_hand_rows(task: HandRows | Position | Pose) -> HandRows:
    """Give a `Position` or `Pose` as rows of the hand."""
    if isinstance(task, HandRows):
        return task
    rows = ROWS[:3] if isinstance(task, Position) else ROWS
    return HandRows(task.arm, rows, task.landmark)


def goals_of(task: HandRows | Position | Pose, target: ArrayLike) -> ik_arrays.Goals:
    """Turn targets of any of these tasks into what the kernels want.

    A (K, 6) target of a `Pose` holds position and rotation vector, as its `value` does.
    """
    array = as_float_array("target", target)
    if isinstance(task, Pose) and array.shape[-1:] == (6,) and array.ndim <= 2:
        _require_sensible(array)
        rows = np.atleast_2d(array)
        rotation = exp_rotation(rows[:, 3:])
        return ik_arrays.Goals(rows[:, :3].copy(), rotation, roll_pitch_yaw(rotation))
    return as_hand_rows(task).goals(array)


def _require_sensible(target: np.ndarray) -> None:
    require_finite("target", target)
    far = np.abs(target) > FARTHEST
    if far.any():
        at = tuple(int(i) for i in np.argwhere(far)[0])
        where = ", ".join(map(str, at))
        raise RangeError(f"target[{where}] = {target[at]:g}: allowed is up to {FARTHEST:g}")


def _require_rotations(T: np.ndarray) -> None:
    R = T[:, :3, :3]
    off = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2)) > ORTHONORMAL
    off |= np.linalg.det(R) < 0
    if off.any():
        i = int(np.argmax(off))
        raise RangeError(
            f"target[{i}]: its first three rows and columns are no rotation (orthonormal and "
            f"right-handed to {ORTHONORMAL:g})"
        )


def roll_pitch_yaw(R: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 3"]:
    """Give φ, ψ, γ (rad) of rotations ([DeBoon] eqs 4 to 6, with atan2)."""
    roll = np.arctan2(R[..., 2, 1], R[..., 2, 2])
    pitch = np.arctan2(-R[..., 2, 0], np.hypot(R[..., 2, 1], R[..., 2, 2]))
    yaw = np.arctan2(R[..., 1, 0], R[..., 0, 0])
    return np.stack([roll, pitch, yaw], axis=-1)


def rotation_of(angles: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Give rotations from φ, ψ, γ (rad): ``Rz(γ) Ry(ψ) Rx(φ)``."""
    (cr, cp, cy), (sr, sp, sy) = (np.moveaxis(f(angles), -1, 0) for f in (np.cos, np.sin))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.ascontiguousarray(np.moveaxis(np.array(rows), (0, 1), (-2, -1)))
