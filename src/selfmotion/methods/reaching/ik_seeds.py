"""Where inverse kinematics starts again: postures spread over the limits, found by place."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import freeze
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.kinematics.serial_path import SerialPath
from selfmotion.methods.reaching.ik_arrays import Model, Seeds
from selfmotion.methods.reaching.ik_tasks import HandRows

# A revolute joint without limits starts within this turn (rad).
UNLIMITED_TURN = np.pi
# Cells along each held axis, and seeds listed for each cell.
CELLS, LISTED = 12, 48
# Postures at the ends of ranges: spread over a box so many times as wide, then moved to its sides.
TO_THE_ENDS = 4.0


@dataclass(frozen=True, eq=False)
class SeedTable:
    """Postures spread evenly over the limits, listed by where they bring the hand.

    Building one takes some milliseconds: give it to `solve_ik` when you call that often.

    Attributes:
        arrays: what the kernels look up.
        task: the arm, with its limits, and the rows for which the table was made.
    """

    arrays: Seeds
    task: HandRows

    @cached_property
    def at_ends(self) -> "SeedTable":
        """A table of postures that have most joints at an end of their range.

        Such is the posture nearest to a target out of reach, as a rule.
        """
        return seed_table(self.task, n_seeds=len(self.q), stretch=TO_THE_ENDS)

    @property
    def q(self) -> Float[np.ndarray, "samples coords"]:
        """The postures (rad or m)."""
        return self.arrays.q

    @property
    def positions(self) -> Float[np.ndarray, "samples 3"]:
        """Where they bring the hand (m)."""
        return self.arrays.position


def seed_table(task: HandRows, *, n_seeds: int = 4096, stretch: float = 1.0) -> SeedTable:
    """Spread postures over the limits and list, for each cell of space, those nearest to it.

    Args:
        task: the arm and the rows held.
        n_seeds: how many postures.
        stretch: above 1, postures are spread over a box so many times as wide as the limits and
            then moved inside, so that many joints lie at the ends of their ranges.

    Raises:
        RangeError: fewer than 16 seeds, or a sliding joint has no limit.
    """
    from scipy.spatial import KDTree

    if n_seeds < 16:
        raise RangeError(f"n_seeds = {n_seeds}: allowed is 16 and above")
    arm = task.arm
    q = at_ends(n_seeds, *finite_limits(arm), stretch=stretch)
    T = forward_kinematics(arm.chain, q, arm.tip(task.landmark))
    position = np.ascontiguousarray(T[:, :3, 3])
    held = list(task.axes)
    counts = np.ones(3, dtype=np.int64)
    counts[held] = CELLS
    low, high = position.min(axis=0), position.max(axis=0)
    width = np.maximum(high - low, 1e-9)
    listed = min(LISTED, n_seeds)
    if held:
        steps = [(np.arange(c) + 0.5) / c for c in counts]
        centres = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
        tree = KDTree(position[:, held])
        cells = tree.query((low + centres * width)[:, held], k=listed)[1]
    else:  # orientation only: any seed may be the nearest
        cells = np.arange(n_seeds)[None]
    arrays = Seeds(
        freeze(q),
        freeze(position),
        freeze(np.ascontiguousarray(T[:, :3, :3])),
        freeze(np.ascontiguousarray(cells, dtype=np.int64)),
        freeze(low),
        freeze(counts / width),
        freeze(counts),
    )
    return SeedTable(arrays, task)


def evenly(n_points: int, low: np.ndarray, high: np.ndarray) -> Float[np.ndarray, "points dims"]:
    """Give points spread evenly over a box: Roberts' sequence, the golden ratio in d dimensions.

    Each further point falls into the largest gap that the points before it have left, nearly.
    """
    return low + (high - low) * ((0.5 + golden_steps(len(low)) * _count(n_points)) % 1.0)


def at_ends(
    n_points: int, low: np.ndarray, high: np.ndarray, *, stretch: float = TO_THE_ENDS
) -> Float[np.ndarray, "points dims"]:
    """Give points spread evenly over a box `stretch` times as wide, moved inside this one.

    Above 1 many lie on sides, edges and corners, where the nearest posture to a target out of
    reach mostly is.
    """
    middle = 0.5 * (low + high)
    return np.clip(middle + stretch * (evenly(n_points, low, high) - middle), low, high)


def golden_steps(n_dimensions: int) -> Float[np.ndarray, " dims"]:
    """Give the steps of Roberts' sequence: powers of 1/g with ``g^(d+1) = g + 1``."""
    g = 2.0
    for _ in range(60):
        g = (1.0 + g) ** (1.0 / (n_dimensions + 1))
    return g ** -np.arange(1.0, n_dimensions + 1)


def _count(n_points: int) -> np.ndarray:
    return np.arange(1, n_points + 1)[:, None]


def finite_limits(arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Give the limits, with ±pi where a revolute joint has none.

    Raises:
        RangeError: a joint that slides has no limit.
    """
    lower, upper = arm.lower.copy(), arm.upper.copy()
    open_ended = ~(np.isfinite(lower) & np.isfinite(upper))
    for j in np.flatnonzero(open_ended):
        moved = np.flatnonzero(arm.chain.coupling.matrix[:, j])
        if (arm.chain.joint_type[moved] != 0).any():
            raise RangeError(f"{arm.joints[j]}: a sliding joint needs limits")
    lower[~np.isfinite(lower)] = -UNLIMITED_TURN
    upper[~np.isfinite(upper)] = UNLIMITED_TURN
    return lower, upper


def model_of(task: HandRows) -> Model:
    """Give the arrays of the task's arm for the kernels."""
    chain = task.arm.chain
    path = SerialPath.of(chain, task.arm.tip(task.landmark))
    n_path = len(path.joints)
    lead = np.full(n_path, -1, dtype=np.int64)
    for i, row in enumerate(path.matrix):
        ones = np.flatnonzero(row)
        if len(ones) == 1 and row[ones[0]] == 1.0:
            lead[i] = ones[0]
    curve = np.full(n_path, -1, dtype=np.int64)
    order = max((c.curve.c.shape[0] for c in path.curves), default=1)
    pieces = max((c.curve.c.shape[1] for c in path.curves), default=1)
    breaks = np.full((len(path.curves), pieces + 1), np.inf)
    coefficients = np.zeros((len(path.curves), order, pieces + 1))
    for i, c in enumerate(path.curves):
        curve[c.joint] = i
        k, m = c.curve.c.shape
        breaks[i, : m + 1] = c.curve.x
        coefficients[i, order - k :, :m] = c.curve.c
    return Model(
        lead,
        1.0 - path.prismatic,
        path.angle_offset,
        np.cos(path.twist),
        np.sin(path.twist),
        path.shift,
        path.base,
        path.tip_rotation,
        path.tip_position,
        path.matrix,
        path.offset,
        curve,
        np.array([c.coordinate for c in path.curves], dtype=np.int64),
        breaks,
        coefficients,
        chain.lower,
        chain.upper,
    )
