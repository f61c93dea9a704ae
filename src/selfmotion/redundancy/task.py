"""Tasks: what the hand must do, as rows whose velocity is a Jacobian times joint velocity."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite
from selfmotion.errors import RangeError, ShapeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.spatial import exp_rotation, log_rotation, skew


class Task(Protocol):
    """What every task offers.

    `jacobian(q) @ qd` is the velocity of the rows. For rows of position and angle that is the
    derivative of `value`; for the orientation rows of a `Pose` it is angular velocity in ground
    axes, and `error` is the difference that this velocity closes.
    """

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row of `value`, as "m" or "rad"."""
        ...

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """Factor of each row that brings metres and radians to one scale."""
        ...

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give the rows for postures q, (n,) or (K, n)."""
        ...

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give the Jacobian of the rows."""
        ...

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give what is missing to a target: (m,) or (K, m)."""
        ...


@dataclass(frozen=True, eq=False)
class Position:
    """The position of a landmark in the ground: x, y, z (m)."""

    arm: Arm
    landmark: str = "hand"

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m", "m", "m")

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """All rows count alike."""
        return np.ones(3)

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give positions (K, 3) in m."""
        return forward_kinematics(self.arm.chain, q, self.arm.tip(self.landmark))[:, :3, 3]

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give (K, 3, n)."""
        return geometric_jacobian(self.arm.chain, q, self.arm.tip(self.landmark))[:, :3]

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give target minus value (m)."""
        return _target(target, 3) - self.value(q)


@dataclass(frozen=True, eq=False)
class Planar:
    """The position of a landmark in a plane of the ground: two of its axes (m)."""

    arm: Arm
    landmark: str = "hand"
    axes: tuple[int, int] = (0, 1)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m", "m")

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """Both rows count alike."""
        return np.ones(2)

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give (K, 2) in m."""
        T = forward_kinematics(self.arm.chain, q, self.arm.tip(self.landmark))
        return T[:, list(self.axes), 3]

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give (K, 2, n)."""
        J = geometric_jacobian(self.arm.chain, q, self.arm.tip(self.landmark))
        return J[:, list(self.axes)]

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give target minus value (m)."""
        return _target(target, 2) - self.value(q)


@dataclass(frozen=True, eq=False)
class Pose:
    """Position (m) and orientation (rad) of a landmark: x, y, z and a rotation vector.

    Orientation errors are rotation vectors in ground axes, taken on the rotation group and not
    between angles, so that they do not alias or meet gimbal lock.

    Attributes:
        arm: the arm.
        landmark: the frame that has the pose.
        rotation_scale: metres that one radian counts as, in `row_scale`.
    """

    arm: Arm
    landmark: str = "hand"
    rotation_scale: float = 1.0

    @property
    def units(self) -> tuple[str, ...]:
        """Metres, then radians."""
        return ("m", "m", "m", "rad", "rad", "rad")

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """Ones for position, `rotation_scale` for orientation."""
        return np.array([1.0, 1.0, 1.0] + 3 * [self.rotation_scale])

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give position (m) and rotation vector (rad) of the frame in the ground, (K, 6)."""
        T = forward_kinematics(self.arm.chain, q, self.arm.tip(self.landmark))
        return pose_rows(T)

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give (K, 6, n): linear velocity, then angular velocity, in ground axes."""
        return geometric_jacobian(self.arm.chain, q, self.arm.tip(self.landmark))

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give position error (m) and the rotation vector (rad) that turns frame to target."""
        goal = _target(target, 6)
        T = forward_kinematics(self.arm.chain, q, self.arm.tip(self.landmark))
        turn = exp_rotation(goal[:, 3:]) @ np.swapaxes(T[:, :3, :3], 1, 2)
        return np.concatenate([goal[:, :3] - T[:, :3, 3], log_rotation(turn)], axis=1)


@dataclass(frozen=True, eq=False)
class Pointing:
    """Where a direction fixed to a landmark points, projected on a screen ([Tommasino2017] eq. 6).

    The rows are ``distance * screen @ R(q) @ direction``: an orthographic projection, so that
    the row of a direction at the angle a from the screen's normal is ``distance * sin(a)``.

    Attributes:
        arm: the arm.
        landmark: the frame that points.
        direction: (3,) unit direction in that frame.
        screen: (2, 3) the screen's axes in the ground; the paper's are -y and z.
        distance: distance of the screen (m).
    """

    arm: Arm
    landmark: str = "hand"
    direction: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    screen: Float[np.ndarray, "2 3"] = field(
        default_factory=lambda: np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
    )
    distance: float = 1.0

    @property
    def units(self) -> tuple[str, ...]:
        """Metres on the screen."""
        return ("m", "m")

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """Both rows count alike."""
        return np.ones(2)

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give (K, 2) points on the screen (m)."""
        T = forward_kinematics(self.arm.chain, q, self.arm.tip(self.landmark))
        return self.distance * (T[:, :3, :3] @ self.direction) @ self.screen.T

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give (K, 2, n)."""
        T = forward_kinematics(self.arm.chain, q, self.arm.tip(self.landmark))
        turning = geometric_jacobian(self.arm.chain, q, self.arm.tip(self.landmark))[:, 3:]
        return -self.distance * self.screen @ skew(T[:, :3, :3] @ self.direction) @ turning

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give target minus value (m)."""
        return _target(target, 2) - self.value(q)


@dataclass(frozen=True, eq=False)
class RowMask:
    """Some rows of another task: the rest is left free.

    Raises:
        RangeError: a row does not exist, or stands twice, or none is left.
    """

    task: Task
    rows: tuple[int, ...]

    def __post_init__(self) -> None:
        """Check the rows."""
        n_rows = len(self.task.units)
        if not self.rows or len(set(self.rows)) != len(self.rows):
            raise RangeError(f"rows = {self.rows}: name at least one row, each once")
        if not all(0 <= row < n_rows for row in self.rows):
            raise RangeError(f"rows = {self.rows}: allowed are 0 to {n_rows - 1}")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the rows kept."""
        return tuple(self.task.units[row] for row in self.rows)

    @property
    def row_scale(self) -> Float[np.ndarray, " rows"]:
        """Scales of the rows kept."""
        return self.task.row_scale[list(self.rows)]

    def value(self, q: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give the rows kept."""
        return self.task.value(q)[:, list(self.rows)]

    def jacobian(self, q: ArrayLike) -> Float[np.ndarray, "samples rows coords"]:
        """Give the Jacobian of the rows kept."""
        return self.task.jacobian(q)[:, list(self.rows)]

    def error(self, q: ArrayLike, target: ArrayLike) -> Float[np.ndarray, "samples rows"]:
        """Give what is missing in the rows kept, for a target of the whole task."""
        return self.task.error(q, target)[:, list(self.rows)]


def task_for(arm: Arm, kind: str | None = None, landmark: str = "hand") -> Task:
    """Build a task by its kind.

    Args:
        arm: the arm.
        kind: position, pose, planar or pointing; left out: the arm's own kind.
        landmark: what has the task.

    Raises:
        UnknownNameError: there is no such kind of task, or no such landmark.
    """
    kinds = {"position": Position, "pose": Pose, "planar": Planar, "pointing": Pointing}
    kind = arm.task if kind is None else kind
    if kind not in kinds:
        raise unknown_name("task", kind, tuple(kinds))
    arm.tip(landmark)
    return kinds[kind](arm, landmark)


def pose_rows(T: Float[np.ndarray, "samples 4 4"]) -> Float[np.ndarray, "samples 6"]:
    """Turn frames (K, 4, 4) into rows of a `Pose`: position (m) and rotation vector (rad)."""
    return np.concatenate([T[:, :3, 3], log_rotation(T[:, :3, :3])], axis=1)


def _target(target: ArrayLike, n_rows: int) -> Float[np.ndarray, "samples rows"]:
    array = np.atleast_2d(as_float_array("target", target))
    if array.ndim != 2 or array.shape[1] != n_rows:
        raise ShapeError(f"target has shape {array.shape}; expected (samples, {n_rows})")
    require_finite("target", array)
    return array
