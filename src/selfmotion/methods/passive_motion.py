"""Plan movements by passive motion: λ0-PMP, PMP1 and PMP2, on any arm and task.

Implements [Tommasino2017], doi 10.3389/fnbot.2017.00065, eqs 3 to 5, 7, 8 and 10. With damping W,
joint potential U (elastic: K^J(q - q*) is its gradient g), task spring K(t) and target x_d:

    W q̇ = Jᵀ(F + λ0) - g,   F = K(t)(x_d - x),   λ0 = B J W⁻¹ g,   B = (J W⁻¹ Jᵀ)⁻¹

so that B ẋ = K(t)(x_d - x) exactly (eq. 5), whatever the potential. Without λ0 it is PMP2, without
the potential PMP1.

Deviations: the paper's joint torque K^J(q - q*) gets the minus sign that makes it restore. The
spring constant can be given (22.5 in the paper's Fig. 3) or follow eq. 10, with b_max where the
movement starts; the two differ by a factor of ten. In tasks of mixed units eq. 10 is read in the
rows scaled by `task.row_scale`.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.methods.passive.arrays import RANK_LOST, TOO_STIFF
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.lockstep import StepControl, integrate_lockstep
from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.methods.passive.settings import PlanSettings, inertia_damping
from selfmotion.methods.passive.setup import (
    admittance,
    checked_movements,
    drive_of,
    free_joints,
    kernel_law,
    springs,
)
from selfmotion.methods.passive.slopes import Drive, PassiveSlopes
from selfmotion.methods.passive.task_planners import TargetSpring
from selfmotion.methods.passive.tasks import (
    arm_of,
    has_rotation_vectors,
    kernel_task,
    run_kernels,
)
from selfmotion.methods.reach import miss_distance
from selfmotion.provenance import Provenance, hash_arrays
from selfmotion.redundancy.task import Pointing, Task

__all__ = ["JointLaw", "PlanSettings", "PlannedMotion", "inertia_damping", "plan", "plan_sequence"]

# A movement that ends farther from its target than this share of the way is looked into.
SHORT = 0.1
# Distance up to which a target counts as within reach, as a share of the way there.
REACHED = 1e-6
# What brings the implicit integration to a halt, to steps beyond number or out of the numbers.
WHY = "a joint is too soft beside the others, or the spring too stiff"


def plan(
    task: Task,
    law: JointLaw,
    start: ArrayLike,
    targets: ArrayLike,
    settings: PlanSettings | None = None,
) -> PlannedMotion:
    """Plan movements from postures to targets ([Tommasino2017]).

    Args:
        task: what the targets are, as ``Pointing(wrist())``.
        law: stiffness, rest posture and time constants.
        start: (n,) posture at the beginning (rad), or (B, n), one for each movement.
        targets: (m,) or (B, m) in the units of the task.
        settings: model, spring, duration and further choices.

    Returns:
        The movements. One that cannot reach its target, or meets a posture where the Jacobian
        loses rank, says so in its status.

    Raises:
        ShapeError: the arrays do not fit the task's arm.
        NotFiniteError: an array holds NaN or infinite values.
        RangeError: a setting is not allowed; the message names it.
        UnknownNameError: a locked joint does not exist.

    Example:
        Point 15° to the east with the wrist of the paper's Fig. 3:

        >>> from selfmotion.arms import wrist
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> motion = plan(Pointing(wrist()), law, law.rest, [np.pi / 12, 0.0],
        ...               PlanSettings(spring=22.5))
        >>> bool(np.abs(motion.x[0, -1] - [np.pi / 12, 0.0]).max() < 1e-9)
        True
    """
    settings = PlanSettings() if settings is None else settings
    arm = arm_of(task)
    if law.n_joints != arm.n_joints:
        raise ShapeError(f"law has {law.n_joints} joints, {arm.name!r} has {arm.n_joints}")
    q0, goals = checked_movements(task, arm, start, targets)
    free = free_joints(arm, settings.locked)
    if has_rotation_vectors(task) and not isinstance(settings.planner, TargetSpring):
        raise RangeError(
            f"planner {type(settings.planner).__name__}: rows of orientation take TargetSpring only"
        )
    spring = springs(task, law, settings, q0, free)
    drive = drive_of(task, settings, q0, goals, spring)
    motion = _integrate(task, law, settings, drive, free)
    return _judged(task, motion, q0, free)


def plan_sequence(
    task: Task,
    law: JointLaw,
    start: ArrayLike,
    targets: ArrayLike,
    settings: PlanSettings | None = None,
) -> PlannedMotion:
    """Plan movements one after the other, each from the posture in which the last ended.

    Time restarts at each movement, and with it the growth of the spring.

    Args:
        task: what the targets are.
        law: stiffness, rest posture and time constants.
        start: (n,) posture at the beginning (rad).
        targets: (T, m) targets in order.
        settings: as for `plan`.

    Returns:
        T movements.

    Raises:
        SelfmotionError: as `plan`.

    Example:
        Out and back ends where it began:

        >>> from selfmotion.arms import wrist
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> there_and_back = plan_sequence(Pointing(wrist()), law, law.rest,
        ...                                [[0.0, 0.26], [0.0, 0.0]], PlanSettings(spring=22.5))
        >>> bool(np.abs(there_and_back.x[1, -1]).max() < 1e-9)
        True
    """
    goals = as_float_array("targets", targets, ndim=2)
    if not len(goals):
        raise ShapeError("targets: 0 targets; at least one is needed")
    legs: list[PlannedMotion] = []
    q = as_float_array("start", start, ndim=1)
    for goal in goals:
        legs.append(plan(task, law, q, goal, settings))
        q = legs[-1].end[0]
        if not np.isfinite(q).all():
            break
    return _joined(legs, goals)


def _integrate(
    task: Task, law: JointLaw, settings: PlanSettings, drive: Drive, free: np.ndarray
) -> PlannedMotion:
    """Integrate with the kernels where they serve, and implicitly where they do not."""
    simple = not (callable(settings.damping) or settings.potentials or drive.field)
    served = kernel_task(task) if simple else None
    n_movements, n = drive.start.shape
    shape = (n_movements, len(drive.time))
    statuses = [Status(True, "done")] * n_movements
    if served is None:
        left = np.arange(n_movements)
        arrays = (
            np.empty((*shape, n)),
            np.empty((*shape, n)),
            np.empty((*shape, len(task.units))),
            np.empty((*shape, len(task.units))),
        )
    else:
        out = run_kernels(served, kernel_law(law, settings, free), drive)
        arrays = (out.q, out.qd, out.x, out.xd)
        left = np.flatnonzero(out.code == TOO_STIFF)
        for i in np.flatnonzero(out.code == RANK_LOST):
            statuses[i] = _rank_lost(out.when[i])
    if len(left):
        part = drive.take(left)
        slopes = PassiveSlopes(task, law, settings, part, free, admittance)
        control = StepControl(settings.tolerance)
        q, reached = integrate_lockstep(slopes, part.start[:, free], drive.time, control)
        *found, lost = slopes.samples(q)
        for whole, some in zip(arrays, found, strict=True):
            whole[left] = some
        for i, t_lost in zip(left, lost, strict=True):
            if reached < drive.time[-1]:
                statuses[i] = Status(False, f"the integration stopped at {reached:.3g} s: {WHY}")
            elif np.isfinite(t_lost):
                statuses[i] = _rank_lost(t_lost)
    return PlannedMotion(
        drive.time,
        *arrays,
        targets=drive.goals,
        spring=drive.spring,
        end_error=np.linalg.norm(_error(task, arrays[0][:, -1], drive.goals), axis=1),
        statuses=tuple(statuses),
        joints=arm_of(task).joints,
        units=task.units,
        provenance=_provenance(task, law, settings, drive),
    )


def _judged(task: Task, motion: PlannedMotion, q0: np.ndarray, free: np.ndarray) -> PlannedMotion:
    """Say of each movement that stayed far from its target whether that can be reached."""
    way = np.linalg.norm(_error(task, q0, motion.targets), axis=1)
    far = (motion.end_error > SHORT * way) & (way > 0.0)
    suspects = np.flatnonzero(far & np.array([s.ok for s in motion.statuses]))
    if isinstance(task, Pointing):
        beyond = np.linalg.norm(motion.targets, axis=1) > task.distance
        suspects = np.union1d(suspects, np.flatnonzero(beyond))
    if not len(suspects):
        return motion
    ends = np.where(np.isfinite(motion.end[suspects]), motion.end[suspects], q0[suspects])
    missing = miss_distance(task, ends, motion.targets[suspects], free)
    statuses = list(motion.statuses)
    for i, short in zip(suspects, missing, strict=True):
        if short > REACHED * max(way[i], 1e-3):
            sentence = f"target out of reach: the nearest place found is {short:.3g} from it"
            statuses[i] = Status(False, sentence)
    return replace(motion, statuses=tuple(statuses))


def _error(task: Task, q: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Give what is missing to the targets, NaN where the posture is not known."""
    known = np.isfinite(q).all(axis=1)
    out = np.full((len(q), len(task.units)), np.nan)
    if known.any():
        out[known] = task.error(q[known], goals[known])
    return out


def _rank_lost(when: float) -> Status:
    return Status(False, f"the Jacobian lost rank at {when:.3g} s: what follows means nothing")


def _joined(legs: list[PlannedMotion], goals: np.ndarray) -> PlannedMotion:
    """Put movements one after the other; those that could not begin are NaN and say so."""
    first = legs[0]
    n_left = len(goals) - len(legs)

    def put(name: str) -> np.ndarray:
        array = np.concatenate([getattr(leg, name) for leg in legs])
        return np.concatenate([array, np.full((n_left, *array.shape[1:]), np.nan)])

    statuses = [leg.statuses[0] for leg in legs]
    statuses += [Status(False, "not begun: the movement before it failed")] * n_left
    return PlannedMotion(
        time=first.time,
        q=put("q"),
        qd=put("qd"),
        x=put("x"),
        xd=put("xd"),
        spring=put("spring"),
        end_error=put("end_error"),
        targets=goals,
        statuses=tuple(statuses),
        joints=first.joints,
        units=first.units,
        provenance=Provenance(
            "plan_sequence",
            inputs=first.provenance.inputs | {"targets": hash_arrays(goals)},
            choices=first.provenance.choices,
        ),
    )


def _damping_of(settings: PlanSettings) -> str | list[float]:
    """Say what the damping is: τ₀ K^J, a function of posture, or the numbers given."""
    if settings.damping is None:
        return "law"
    if callable(settings.damping):
        return "function of posture"
    return np.asarray(settings.damping, dtype=np.float64).ravel().tolist()


def _provenance(task: Task, law: JointLaw, settings: PlanSettings, drive: Drive) -> Provenance:
    spring = settings.spring
    return Provenance(
        "plan",
        inputs={
            "start": hash_arrays(drive.start),
            "targets": hash_arrays(drive.goals),
            "law": hash_arrays(law.stiffness, law.rest),
        },
        choices={
            "arm": arm_of(task).name,
            "task": type(task).__name__,
            "model": settings.model,
            "spring": spring.tolist() if isinstance(spring, np.ndarray) else spring,
            "duration": settings.duration,
            "damping_time": law.damping_time,
            "spring_time": law.spring_time,
            "planner": type(settings.planner).__name__,
            "locked": list(settings.locked),
            "potentials": [type(potential).__name__ for potential in settings.potentials],
            "damping": _damping_of(settings),
        },
    )
