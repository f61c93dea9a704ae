"""From checked input to what the integrators take: admittance, springs, and what pulls the hand."""

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.passive.arrays import KernelLaw
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.potentials import positive_definite
from selfmotion.methods.passive.settings import PlanSettings
from selfmotion.methods.passive.slopes import Drive
from selfmotion.methods.passive.task_planners import ForceField, TargetSpring
from selfmotion.methods.passive.tasks import kept_rows, whole_task
from selfmotion.redundancy.task import Task

# No target of an arm is so far away (m or rad).
FARTHEST = 1e4


def checked_movements(
    task: Task, arm: Arm, start: ArrayLike, targets: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Check start and targets and give one row of each for every movement."""
    q0 = arm.chain.as_samples(as_float_array("start", start))
    goals = np.atleast_2d(as_float_array("targets", targets))
    require_shape("targets", goals, (None, len(whole_task(task).units)))
    require_finite("targets", goals)
    if (np.abs(goals) > FARTHEST).any():
        row, column = (int(k) for k in np.argwhere(np.abs(goals) > FARTHEST)[0])
        raise RangeError(
            f"targets[{row}, {column}] = {goals[row, column]:g}: allowed is up to {FARTHEST:g}"
        )
    n_movements = max(len(q0), len(goals))
    if not n_movements or {len(q0), len(goals)} - {1, n_movements}:
        raise ShapeError(f"start has {len(q0)} rows, targets {len(goals)}: they must be as many")
    q0 = np.broadcast_to(q0, (n_movements, q0.shape[1]))
    return np.ascontiguousarray(q0), np.ascontiguousarray(
        np.broadcast_to(goals, (n_movements, goals.shape[1]))
    )


def free_joints(arm: Arm, locked: tuple[str, ...]) -> np.ndarray:
    """Give the indices of the joints that move."""
    fixed = {arm.chain.index(joint) for joint in locked}
    free = np.array([i for i in range(arm.n_joints) if i not in fixed], dtype=np.int64)
    if not len(free):
        raise RangeError(f"locked = {', '.join(locked)}: at least one joint must be free")
    return free


def admittance(
    law: JointLaw, settings: PlanSettings, q: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Give W⁻¹ of the free joints, (1 or K, f, f), checked."""
    n = law.n_joints
    if settings.damping is None:
        W = law.damping[None]
    elif callable(settings.damping):
        W = np.asarray(settings.damping(q), dtype=np.float64)
        require_shape("damping(q)", W, (len(q), n, n))
        positive_definite("damping(q)", W[0], n)
    else:
        given = as_float_array("damping", settings.damping)
        W = positive_definite("damping", np.diag(given) if given.ndim == 1 else given, n)[None]
    block = W[:, free[:, None], free]
    return np.linalg.solve(block, np.broadcast_to(np.eye(len(free)), block.shape))


def springs(
    task: Task, law: JointLaw, settings: PlanSettings, q0: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Give K of each movement (B, m, m): as given, or k = b_max/τ₀ (eq. 10)."""
    m = len(task.units)
    scale = np.asarray(task.row_scale)
    if isinstance(settings.spring, np.ndarray) and settings.spring.ndim == 2:
        K = positive_definite("spring", settings.spring, m)
        return np.broadcast_to(K, (len(q0), m, m)).copy()
    if isinstance(settings.spring, str):
        J = scale[:, None] * task.jacobian(q0)[:, :, free]
        mobility = J @ admittance(law, settings, q0, free) @ np.swapaxes(J, 1, 2)
        least = np.linalg.eigvalsh(mobility)[:, 0]  # b_max = 1 / least
        if not (least > 1e-12 * np.trace(mobility, axis1=1, axis2=2)).all():
            i = int(np.argmin(least))
            raise RangeError(
                f"spring = 'from-damping': the Jacobian has lost rank where movement {i + 1} "
                "starts, so that eq. 10 gives no number; give the spring"
            )
        k = 1.0 / (least * law.damping_time)
    else:
        k = np.full(len(q0), float(settings.spring))
        if not (np.isfinite(k[0]) and k[0] > 0.0):
            raise RangeError(f"spring = {k[0]:g}: must be above 0")
    return k[:, None, None] * np.diag(scale**2)


def drive_of(
    task: Task, settings: PlanSettings, q0: np.ndarray, goals: np.ndarray, spring: np.ndarray
) -> Drive:
    """Let the planner say what pulls the hand of each movement."""
    time = np.linspace(0.0, settings.duration, settings.n_steps + 1)
    planner = settings.planner
    if isinstance(planner, TargetSpring | ForceField):
        points, speeds, follow = goals[:, None, :], np.zeros_like(goals[:, None, :]), False
    else:
        points, speeds = planner.reference(time, whole_task(task).value(q0), goals)
        follow = planner.follow
    field = planner if isinstance(planner, ForceField) else None
    return Drive(q0, goals, time, spring, points, speeds, follow, field, kept_rows(task))


def kernel_law(law: JointLaw, settings: PlanSettings, free: np.ndarray) -> KernelLaw:
    """Give the law in the kernels' form; locked joints have no admittance."""
    n = law.n_joints
    whole = np.zeros((n, n))
    whole[free[:, None], free] = admittance(law, settings, law.rest[None], free)[0]
    relaxation = whole @ law.stiffness
    # W⁻¹K^J is similar to a symmetric matrix: its eigenvalues are real.
    rate = float(np.linalg.eigvals(relaxation).real.max())
    elastic = 0.0 if settings.model == "pmp1" else 1.0
    blocked = 1.0 if settings.model == "lambda0" else 0.0
    return KernelLaw(whole, relaxation, law.rest, rate, elastic, blocked, law.spring_time)
