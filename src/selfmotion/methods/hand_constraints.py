"""Where the hand can be while something holds it: its orientation, a plane, a line.

[DeBoon] scenarios 2 and 3 hold the hand on a plane and its roll at zero; here any of x, y, z,
rot_x, rot_y and rot_z (φ, ψ, γ of eqs 4 to 6) may be held. What is left is a volume, the area of
a plane, or a length, measured by evenly spread points as `workspace` does. Where nothing is left,
the smallest set of constraints that cannot be met together is named. Circles: `circle_reach`.

Points out of reach by position alone are refused first; for the others inverse kinematics tries
the orientation from many postures. The body's shapes may block points, not postures.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import freeze
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.held_rows import (
    POSITION,
    checked_rows,
    describe,
    held_options,
    held_provenance,
    require_possible,
    with_angles,
)
from selfmotion.methods.reaching.ik_seeds import golden_steps
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import reach_options, reach_screen
from selfmotion.methods.reaching.volumes import Blocked, Region
from selfmotion.methods.workspace import WorkspaceOptions
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

MEASURES = ("point", "m", "m²", "m³")


@dataclass(frozen=True, eq=False)
class HeldReach:
    """What the hand reaches while some of its rows are held.

    Attributes:
        arm: with the limits that hold.
        held: row to value (m, rad).
        region: points reached; its `volume` is in `unit`.
        by_position: the same points reached with the orientation free.
        unit: m³, m² in a plane, m on a line.
        q: (K, n) postures of the points reached; NaN elsewhere.
        provenance: version, hashes, choices.
    """

    arm: Arm
    held: Mapping[str, float]
    region: Region
    by_position: Region
    unit: str
    q: Float[np.ndarray, "points coords"]
    provenance: Provenance

    def to_frame(self) -> "pd.DataFrame":
        """Give the points reached: x, y, z (m), and a posture for each (rad or m)."""
        import pandas as pd

        rows = self.region.inside
        columns = dict(zip(("x", "y", "z"), self.region.points[rows].T, strict=True))
        return pd.DataFrame(columns | dict(zip(self.arm.joints, self.q[rows].T, strict=True)))

    def summary(self) -> str:
        """Say what is left."""
        size, error = self.region.volume, self.region.standard_error
        share = 100.0 * size / self.by_position.volume
        text = f"With {describe(self.held)} the hand reaches {size:.3g} ± {error:.1g} {self.unit}"
        if set(self.held) <= set(POSITION):
            return f"{text}."
        return f"{text}: {share:.0f} % of what it reaches there with its orientation free."


def held_reach(
    arm: Arm,
    held: Mapping[str, float],
    *,
    blocked: Blocked | None = None,
    options: WorkspaceOptions | None = None,
    rng: np.random.Generator | None = None,
) -> HeldReach:
    """Find what the hand reaches while some of its rows are held.

    Args:
        arm: with the limits that hold.
        held: row (x, y, z in m; rot_x, rot_y, rot_z in rad) to its value.
        blocked: which points do not count, as the body's ``inside``.
        options: how finely to look.
        rng: draws the shifts; left out: ``np.random.default_rng(0)``.

    Raises:
        UnknownNameError: there is no such row.
        RangeError: no row is held, or nothing is reached: the message names the constraints that
            cannot be met together.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> few = WorkspaceOptions(n_points=64, shifts=2)
        >>> found = held_reach(load_arm("upper_limb"), {"x": 0.15, "rot_y": 0.0}, options=few)
        >>> found.unit, bool(0 < found.region.volume <= found.by_position.volume)
        ('m²', True)
    """
    opts = options or WorkspaceOptions(n_points=1024)
    values = checked_rows(held)
    require_possible(arm, values)
    low, high = _span(arm, values)
    points, shift = _spread(low, high, opts, rng or np.random.default_rng(0))
    counts = np.ones(len(points), dtype=np.bool_) if blocked is None else ~blocked(points)
    screen = reach_screen(HandRows(arm, POSITION), n_points=1024)
    near = np.zeros(len(points), dtype=np.bool_)
    q = np.full((len(points), arm.n_joints), np.nan)
    first = screen.decide(points[counts], options=reach_options(threads=opts.threads))
    near[counts], q[counts] = first.reachable, first.q
    inside = near.copy()
    angles = {row: value for row, value in values.items() if row not in POSITION}
    if angles and near.any():
        task = HandRows(arm, (*POSITION, *angles))
        targets = with_angles(points[near], angles)
        found = solve_ik(task, targets, options=held_options(opts.threads))
        inside[near], q[near] = found.solved, found.q
    q[~inside] = np.nan
    if not inside.any():
        why = "the body blocks what is left" if blocked is not None and not counts.all() else ""
        why = why or f"less is left than {len(points)} points can show"
        raise RangeError(f"empty workspace with {describe(values)}: {why}")
    free = high > low
    size = float(np.prod((high - low)[free]))
    return HeldReach(
        arm,
        MappingProxyType(values),
        Region("held", freeze(points), freeze(inside), shift, size),
        Region("by position", freeze(points), freeze(near), shift, size),
        MEASURES[int(free.sum())],
        freeze(q),
        held_provenance("held_reach", arm, values),
    )


def _span(arm: Arm, held: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Give the box of positions: all that is reached, and the values held."""
    screen = reach_screen(HandRows(arm, POSITION), n_points=128)
    low, high = screen.low.copy(), screen.high.copy()
    for axis, row in enumerate(POSITION):
        if row in held:
            low[axis] = high[axis] = held[row]
    return low, high


def _spread(
    low: np.ndarray, high: np.ndarray, options: WorkspaceOptions, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Give points spread evenly over a box that may be flat, and the shift of each."""
    free = np.flatnonzero(high > low)
    base = golden_steps(len(free)) * np.arange(options.n_points)[:, None]
    points = np.tile(low, (options.shifts * options.n_points, 1))
    shares = np.concatenate([(base + rng.random(len(free))) % 1.0 for _ in range(options.shifts)])
    points[:, free] += shares * (high - low)[free]
    return points, freeze(np.repeat(np.arange(options.shifts), options.n_points))
