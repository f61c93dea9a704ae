"""What `selfmotion plan` takes as text: potentials of the joints, and a path to imitate."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.errors import FileFormatError, RangeError, SelfmotionError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.passive.potentials import Potential
    from selfmotion.methods.passive.task_planners import MovementPrimitive
    from selfmotion.redundancy.task import Task

KINDS = "gravity[=SHARE], limits[=MARGIN_DEG:STRENGTH], effort=JOULES"
# Strip inside each limit (degrees), and stiffness of the wall (N m/rad), where none are typed.
MARGIN_DEG, STRENGTH = 10.0, 10.0
# Step of the differences of effort (rad).
EFFORT_STEP = 1e-3


def typed_potentials(texts: Sequence[str], name: str, arm: "Arm") -> "tuple[Potential, ...]":
    """Give the potentials that --potential means.

    Args:
        texts: one for each time the option was given.
        name: of the arm, to find its muscles by.
        arm: the arm.

    Raises:
        SelfmotionError: a text is none of `KINDS`, a number is not allowed, or the arm has no
            masses or no muscles.
    """
    return tuple(_potential(text, name, arm) for text in texts)


def _potential(text: str, name: str, arm: "Arm") -> "Potential":
    from selfmotion.methods.passive.potentials import GravityPotential, JointLimitPotential

    kind, _, given = text.partition("=")
    numbers = _numbers(text, given)
    if kind == "gravity" and len(numbers) <= 1:
        if not arm.mass.sum() > 0.0:
            raise RangeError(f"--potential {text!r}: {arm.name!r} has no masses")
        return GravityPotential(arm, *numbers)
    if kind == "limits" and len(numbers) in (0, 2):
        margin, strength = numbers or (MARGIN_DEG, STRENGTH)
        return JointLimitPotential(arm.lower, arm.upper, math.radians(margin), strength)
    if kind == "effort" and len(numbers) == 1:
        return _effort(name, numbers[0])
    raise RangeError(f"--potential {text!r}: allowed are {KINDS}")


def _effort(name: str, scale: float) -> "Potential":
    """Give muscle effort E(q), [Li2022] eq. 3.1, as so many joules for the value 1."""
    import numpy as np

    from selfmotion.cli.models import load_muscles
    from selfmotion.methods.passive.potentials import EffortPotential
    from selfmotion.muscles.static_optimization import muscle_effort

    if not scale > 0.0:
        raise RangeError(f"--potential effort={scale:g}: must be above 0 J")
    model = load_muscles(name, None)

    def effort(q: "np.ndarray") -> "np.ndarray":
        return np.asarray(muscle_effort(model, q).effort)

    # Effort has jumps and its numbers come from a solver: a step that is not too small.
    return EffortPotential(effort, scale=scale, step=EFFORT_STEP)


def _numbers(text: str, given: str) -> list[float]:
    try:
        values = [float(word) for word in given.split(":")] if given else []
    except ValueError:
        values = [math.nan]
    if not all(math.isfinite(v) and v >= 0.0 for v in values):
        raise RangeError(f"--potential {text!r}: allowed are {KINDS}, numbers from 0")
    return values


def path_to_imitate(path: Path, task: "Task") -> "MovementPrimitive":
    """Learn the shape of a recorded path: a .csv with time (s) and the rows of the task (m).

    Raises:
        FileFormatError: a column is missing, a number is not finite, time does not increase, or
            the path is too short; the message names the file.
    """
    import numpy as np

    from selfmotion.cli.tables import read_rows
    from selfmotion.methods.passive.task_planners import MovementPrimitive

    axes = ("x", "y", "z")[: len(task.units)]
    rows = read_rows(path, axes)
    for problem in rows.problems:
        if problem:
            raise FileFormatError(problem)
    if "time" not in rows.table.header:
        raise FileFormatError(f"{path}: no column time (s)")
    try:
        places = np.ascontiguousarray(rows.array(axes))
        return MovementPrimitive.from_path(rows.table.numbers("time"), places)
    except SelfmotionError as error:
        raise FileFormatError(f"{path}: {error}") from None
