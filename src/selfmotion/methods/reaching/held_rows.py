"""Rows of the hand that are held at values: checked, described, and whether they can be met."""

from collections.abc import Mapping

import numpy as np

from selfmotion.arrays import require_finite
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_seeds import seed_table
from selfmotion.methods.reaching.ik_tasks import ROWS, HandRows
from selfmotion.methods.reaching.screen import REACHED
from selfmotion.provenance import Provenance, hash_arrays

# Restarts before a set of constraints is said to be impossible, and those of a point: with the
# orientation held, single starts fail more often.
HARD, RESTARTS = 200, 20
# How near an angle must come (rad).
TURNED = 1e-4
POSITION = ROWS[:3]


def checked_rows(held: Mapping[str, float]) -> dict[str, float]:
    """Check rows and values; give them in the rows' order.

    Raises:
        UnknownNameError: there is no such row.
        RangeError: no row is held.
        NotFiniteError: a value is not finite.
    """
    if not held:
        raise RangeError(f"no row of the hand is held; allowed are {', '.join(ROWS)}")
    for row, value in held.items():
        if row not in ROWS:
            raise unknown_name("row", row, ROWS)
        require_finite(row, np.array([value]))
    if set(POSITION) <= set(held):
        raise RangeError("x, y and z are all held: one place is no workspace, ask ik for it")
    return {row: float(held[row]) for row in ROWS if row in held}


def require_possible(arm: Arm, held: Mapping[str, float]) -> None:
    """Check that the rows held can be met together somewhere.

    Raises:
        RangeError: they cannot; names the smallest set of them that cannot.
    """
    if _possible(arm, held):
        return
    least = dict(held)
    for row in held:  # leave out what is not needed for the conflict
        fewer = {name: value for name, value in least.items() if name != row}
        if fewer and not _possible(arm, fewer):
            least = fewer
    text = f"empty workspace: no posture of {arm.name} has {describe(least)}"
    if len(least) > 1:
        raise RangeError(f"{text} together; any of them fewer can be met")
    row = next(iter(least))
    if row in POSITION:
        ends = [_farthest(arm, row, sign) for sign in (-1.0, 1.0)]
        text += f"; allowed is about {ends[0]:.3f} to {ends[1]:.3f} m"
    raise RangeError(text)


def describe(held: Mapping[str, float]) -> str:
    """Write rows held as people do: "x = 150 mm and rot_y = 0 deg"."""
    words = [
        f"{row} = {1e3 * value:g} mm" if row in POSITION else f"{row} = {np.rad2deg(value):g} deg"
        for row, value in held.items()
    ]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _possible(arm: Arm, held: Mapping[str, float]) -> bool:
    task = HandRows(arm, tuple(held))
    target = [[held[row] for row in task.rows]]
    options = IkOptions(position_tolerance=REACHED, rotation_tolerance=TURNED, restarts=HARD)
    return bool(solve_ik(task, target, options=options).solved[0])


def _farthest(arm: Arm, row: str, sign: float) -> float:
    """Give how far the hand gets along an axis (m): aim far beyond and see where it ends."""
    task = HandRows(arm, (row,))
    start = seed_table(task, n_seeds=512).q
    value = task.value(start)[:, 0] * sign
    best = start[np.argmax(value)]
    found = solve_ik(task, [[sign * (value.max() + 0.05)]], start=best, options=IkOptions())
    return float(task.value(found.q)[0, 0])


def with_angles(points: np.ndarray, angles: Mapping[str, float]) -> np.ndarray:
    """Give targets of x, y, z and the angles held, in the rows' order."""
    return np.concatenate([points, np.tile(list(angles.values()), (len(points), 1))], axis=1)


def held_options(threads: int) -> IkOptions:
    """Give the options by which points are decided with the orientation held."""
    return IkOptions(
        position_tolerance=REACHED, rotation_tolerance=TURNED, restarts=RESTARTS, threads=threads
    )


def held_provenance(method: str, arm: Arm, held: Mapping[str, float]) -> Provenance:
    """Say where a result with rows held comes from."""
    return Provenance(
        method,
        inputs={"limits": hash_arrays(arm.lower, arm.upper)},
        choices={"arm": arm.name, "held": dict(held)},
    )
