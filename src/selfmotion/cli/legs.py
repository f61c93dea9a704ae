"""Movements from place to place: out from a centre and back, or through the targets of a file."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.tables import QUATERNION, read_rows, with_unit_quaternions
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.passive.joint_law import JointLaw
    from selfmotion.methods.passive_motion import PlannedMotion, PlanSettings
    from selfmotion.redundancy.task import Task


@dataclass(frozen=True, eq=False)
class Legs:
    """Planned movements with their names, and the places between which each runs."""

    motion: "PlannedMotion"
    targets: tuple[str, ...]
    directions: tuple[str | None, ...]
    origins: "np.ndarray"


def center_out_legs(
    task: "Task", law: "JointLaw", settings: "PlanSettings", start: "np.ndarray | None"
) -> Legs:
    """Plan out from the centre to eight targets, and back from where each movement ended.

    Raises:
        RangeError: the task is not pointing, or the law has no posture at the centre.
    """
    import numpy as np

    from selfmotion.methods.elasticity.posture import donders_postures
    from selfmotion.methods.passive_motion import plan as plan_motion
    from selfmotion.redundancy.task import Pointing
    from selfmotion.studies.center_out import CENTRE, NAMES, target_places

    if not isinstance(task, Pointing):
        raise RangeError("--center-out: needs a pointing task, as --arm wrist has; else --targets")
    q = start
    if q is None:
        rest = donders_postures(task, law, CENTRE)
        if not rest.least.all():
            raise RangeError(f"law: no stable posture at the centre ({rest.status.sentence})")
        q = rest.q[0]
    places = target_places()
    outward = plan_motion(task, law, q, places, settings)
    back = plan_motion(
        task, law, outward.end, np.repeat(CENTRE[None], len(places), axis=0), settings
    )
    both = joined(outward, back)
    origins = np.concatenate([np.repeat(CENTRE[None], len(places), axis=0), places])
    directions = ("outbound",) * len(NAMES) + ("inbound",) * len(NAMES)
    return Legs(both, NAMES * 2, directions, origins)


def joined(first: "PlannedMotion", second: "PlannedMotion") -> "PlannedMotion":
    """Put two sets of movements with the same time axis one after the other."""
    from dataclasses import replace

    import numpy as np

    names = ("q", "qd", "x", "xd", "targets", "spring", "end_error")
    arrays = {n: np.concatenate([getattr(first, n), getattr(second, n)]) for n in names}
    return replace(first, **arrays, statuses=(*first.statuses, *second.statuses))


def file_legs(
    path: Path,
    task: "Task",
    law: "JointLaw",
    settings: "PlanSettings",
    start: "np.ndarray | None",
) -> Legs:
    """Plan from each target of a file to the next.

    Raises:
        FileFormatError: a column is missing or a place is not known.
    """
    import numpy as np

    from selfmotion.methods.passive_motion import plan_sequence
    from selfmotion.redundancy.task import Pose

    axes = ("x", "y", "z")[: min(3, len(task.units))]
    rows = read_rows(path, [*axes, *(QUATERNION if isinstance(task, Pose) else ())])
    goals = rows.array(axes)
    if isinstance(task, Pose):
        from scipy.spatial.transform import Rotation

        rows = with_unit_quaternions(rows)
        refuse_problems(rows.problems)
        turns = Rotation.from_quat(rows.array(QUATERNION)).as_rotvec()
        goals = np.concatenate([goals, turns], axis=1)
    refuse_problems(rows.problems)
    q = law.rest if start is None else start
    motion = plan_sequence(task, law, q, goals, settings)
    origins = np.concatenate([task.value(q), goals[:-1]])
    names = rows.labels("target") or tuple(str(name) for name in rows.ids)
    directions = rows.labels("direction") or (None,) * len(rows)
    return Legs(motion, names, directions, origins)


def refuse_problems(problems: tuple[str, ...]) -> None:
    """Refuse a file with a bad row: the movements after it would start nowhere."""
    for problem in problems:
        if problem:
            raise FileFormatError(problem)


def areas(
    time: "np.ndarray", x: "np.ndarray", begin: "np.ndarray", end: "np.ndarray", arm: "Arm"
) -> tuple[float | None, float | None]:
    """Give A_R and A_L between onset and offset; None where the path has no right and left."""
    import numpy as np

    from selfmotion.methods.curvature import path_areas
    from selfmotion.motion.segment import movement_bounds

    if x.shape[1] not in (2, 3) or len(time) < 3:
        return None, None
    try:
        speed = np.linalg.norm(np.gradient(x, time, axis=0), axis=1)
        bounds = movement_bounds(speed)
        up = arm.up if x.shape[1] == 3 else None
        found = path_areas(x[bounds.onset : bounds.offset + 1], begin, end, up=up)
    except SelfmotionError:
        return None, None
    return found.right, found.left
