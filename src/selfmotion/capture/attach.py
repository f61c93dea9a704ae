"""Give a recording of joint angles the velocities, task motion and Jacobian of an arm."""

import warnings

import numpy as np

from selfmotion.errors import NotFiniteError, UnknownNameError
from selfmotion.kinematics.arm import Arm
from selfmotion.motion.filters import with_velocities
from selfmotion.motion.recording import Frame, Recording, Study
from selfmotion.redundancy.task import Task, task_for

# A slower recording (samples a second) is no recording of a movement.
SLOWEST_RATE = 2.0
# Angles so far beyond an arm's limits (rad) count as outside: limits are those of adults at large.
BEYOND_LIMITS = 0.2


def attach_arm(
    recording: Recording, arm: Arm, *, task: Task | None = None, cutoff: float | None = None
) -> Recording:
    """Compute what the methods need from joint angles: q, qd, x, xd and the Jacobian.

    Joints are matched by name, in any order; columns that the arm does not have are left out.
    Velocities that the recording holds are kept; else they are differentiated from the angles,
    after the zero-phase low-pass where one is asked for.

    Args:
        recording: with q (rad).
        arm: whose joints the columns are.
        task: what the hand does; left out: the arm's own kind of task.
        cutoff: corner frequency of the low-pass (Hz); left out: none.

    Returns:
        The recording with all fields filled, for the joints of the arm in its order.

    Raises:
        ShapeError: the recording holds no angles.
        UnknownNameError: a joint of the arm is missing among the columns.
        RangeError: the recording is not timed, or the cutoff is not below half its rate.
        NotFiniteError: no sample has every joint and its velocity.
    """
    recording.array("q")  # refuses a recording without angles
    columns = _columns(recording, arm)
    held = recording.qd is not None
    moving = recording if held else with_velocities(recording, cutoff=cutoff)
    q, qd = moving.array("q")[:, columns], moving.array("qd")[:, columns]
    task = task_for(arm) if task is None else task
    known = np.asarray(np.isfinite(np.concatenate([q, qd], axis=1)).all(axis=1))
    if not known.any():
        raise NotFiniteError(f"{recording.name}: no sample has every joint and its velocity")
    J = _filled(task.jacobian(q[known]), known)
    return Recording(
        time=recording.time,
        q=q,
        qd=qd,
        x=_filled(task.value(q[known]), known),
        xd=np.einsum("kmn,kn->km", J, qd),
        jacobian=J,
        joints=arm.joints,
        labels=recording.labels,
        frame=frame_of(arm),
        source=recording.source,
        timed=recording.timed,
    )


def attach_arm_to_study(
    study: Study, arm: Arm, *, task: Task | None = None, cutoff: float | None = None
) -> Study:
    """Do the same for every recording of a study.

    Warns, once for all, where the sampling rate or the angles are hardly those of a person:
    a time in milliseconds or angles in another unit would otherwise give plausible numbers.
    """
    _warn_of_units(study, arm)
    return Study(tuple(attach_arm(r, arm, task=task, cutoff=cutoff) for r in study))


def _warn_of_units(study: Study, arm: Arm) -> None:
    slow = [r for r in study if r.rate is not None and r.rate < SLOWEST_RATE]
    if slow:
        warnings.warn(
            f"{slow[0].name}: {slow[0].rate:.3g} samples a second; is its time in seconds?",
            stacklevel=3,
        )
    lower, upper = arm.lower - BEYOND_LIMITS, arm.upper + BEYOND_LIMITS
    outside = np.zeros(arm.n_joints, dtype=int)
    for recording in study:
        q = recording.array("q")[:, _columns(recording, arm)]
        outside += ((q < lower) | (q > upper)).sum(axis=0)
    if outside.any():
        worst = int(np.argmax(outside))
        warnings.warn(
            f"{arm.joints[worst]}: {outside[worst]} of {study.n_samples} samples lie outside the "
            f"limits of arm {arm.name} ({np.degrees(arm.lower[worst]):.0f} to "
            f"{np.degrees(arm.upper[worst]):.0f} deg); are unit and sign those of the arm?",
            stacklevel=3,
        )


def frame_of(arm: Arm) -> Frame:
    """Name the directions of an arm's ground frame as a recording's frame does."""
    return Frame(up=_axis_name(arm.up), forward=_axis_name(arm.forward))


def _axis_name(direction: np.ndarray) -> str | None:
    i = int(np.argmax(np.abs(direction)))
    if abs(abs(direction[i]) - 1.0) > 1e-9:  # oblique to the axes: no name for it
        return None
    return ("-" if direction[i] < 0 else "") + "xyz"[i]


def _columns(recording: Recording, arm: Arm) -> list[int]:
    """Find the arm's joints among the columns, by name; nameless columns count by order."""
    nameless = recording.joints == tuple(f"joint_{i + 1}" for i in range(arm.n_joints))
    if nameless and len(recording.joints) == arm.n_joints:
        return list(range(arm.n_joints))
    missing = [joint for joint in arm.joints if joint not in recording.joints]
    if missing:
        raise UnknownNameError(
            f"{recording.name}: no column for {', '.join(missing)} of arm {arm.name} "
            f"(columns: {', '.join(recording.joints)})"
        )
    return [recording.joints.index(joint) for joint in arm.joints]


def _filled(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Spread values of the known samples over all samples, NaN between."""
    out = np.full((len(known), *values.shape[1:]), np.nan)
    out[known] = values
    return out
