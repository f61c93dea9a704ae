"""The arrays that the kernels of inverse kinematics work on, grouped by what they describe."""

from typing import Any, NamedTuple

import numpy as np

# How kernels are compiled. They do not allocate: without reference counts on their scratch arrays
# they run three times faster; only the drivers do. Fused multiply-add is the one relaxation
# allowed; it keeps NaN as it is.
DRIVER: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
KERNEL: dict[str, Any] = {**DRIVER, "_nrt": False}

# How the orientation rows are held: not at all, all three, all but one, or one alone.
(
    FREE_ROTATION,
    FULL_ROTATION,
    YAW_FREE,
    ROLL_FREE,
    PITCH_FREE,
    ONLY_PITCH,
    ONLY_ROLL,
    ONLY_YAW,
) = range(8)


class Model(NamedTuple):
    """A serial path with limits, as arrays (see `kinematics.serial_path.SerialPath`)."""

    lead: np.ndarray  # (P,) coordinate that the joint equals, or -1
    turning: np.ndarray  # (P,) 1.0 for a revolute joint, 0.0 for a prismatic one
    angle_offset: np.ndarray
    cos_twist: np.ndarray
    sin_twist: np.ndarray
    shift: np.ndarray
    base: np.ndarray
    tip_rotation: np.ndarray
    tip_position: np.ndarray
    matrix: np.ndarray  # (P, n)
    offset: np.ndarray  # (P,)
    curve: np.ndarray  # (P,) index of the curve the joint follows, or -1
    curve_lead: np.ndarray  # (C,) coordinate
    curve_breaks: np.ndarray  # (C, B) padded with infinity
    curve_coefficients: np.ndarray  # (C, order, B)
    lower: np.ndarray
    upper: np.ndarray


class Rows(NamedTuple):
    """Which rows are held, and how the step weighs joints and rows."""

    axes: np.ndarray  # held ground axes of the position
    rotation: int  # one of the modes above
    scale: float  # metres that a radian counts as
    mobility: np.ndarray  # (n,) inverse weights of the joints


class Goals(NamedTuple):
    """Targets: positions (K,3), rotations (K,3,3) and roll, pitch, yaw (K,3)."""

    position: np.ndarray
    rotation: np.ndarray
    angles: np.ndarray


class Seeds(NamedTuple):
    """Postures to restart from, listed by cell of the space around the arm."""

    q: np.ndarray  # (S, n)
    position: np.ndarray  # (S, 3)
    rotation: np.ndarray  # (S, 3, 3)
    cells: np.ndarray  # (C, W) seeds near the centre of each cell
    low: np.ndarray  # (3,)
    per_metre: np.ndarray  # (3,)
    counts: np.ndarray  # (3,)


class Options(NamedTuple):
    """When a target counts as reached, and how long to try."""

    position_tolerance: float
    rotation_tolerance: float
    max_iterations: int
    restarts: int
    seed_first: bool


class Work(NamedTuple):
    """Scratch memory of one thread."""

    values: np.ndarray
    slope: np.ndarray
    sines: np.ndarray
    cosines: np.ndarray
    axes: np.ndarray
    origins: np.ndarray
    hand: np.ndarray  # (3,4) rotation and position
    error: np.ndarray
    turn: np.ndarray  # (3,3) directions of the orientation rows
    J: np.ndarray
    A: np.ndarray
    L: np.ndarray
    y: np.ndarray
    rest: np.ndarray
    held: np.ndarray
    column: np.ndarray
    step: np.ndarray
    trial: np.ndarray
    free: np.ndarray
    q: np.ndarray
    scratch: np.ndarray  # (3,3,3)


class Outputs(NamedTuple):
    """What a batch fills, one row a target."""

    q: np.ndarray  # (K, n)
    errors: np.ndarray  # (K, 2) position (m), rotation (rad)
    counts: np.ndarray  # (K, 2) evaluations, restarts
    solved: np.ndarray  # (K,)


class Published(NamedTuple):
    """Numbers of the published scheme."""

    gain: float
    damping: float
    clip: float
    position_tolerance: float
    rotation_tolerance: float
    max_iterations: int
