"""The posture that a joint law takes for a target: the least potential that the task allows.

Stationarity of ½(q - q*)ᵀK(q - q*) on the self-motion manifold x(q) = x_d ([Tommasino2017]: where
λ0-PMP comes to rest): ``K(q - q*) = Jᵀλ``. Newton's method on posture and multipliers, continued
from the rest posture outwards, since the surface of such postures folds far from it; the fold is
where the Hessian ``H = K - Σλ_a ∇²x_a`` is no longer positive in the null space.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite
from selfmotion.errors import Status
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.redundancy.task import Task

# Step of the central differences of the Jacobian (rad): their error is about 1e-10.
STEP = 1e-5
NEWTON_STEPS = 30
# Largest change of posture in the last Newton step (rad).
TOLERANCE = 1e-12
# Stages of the way from the rest posture to a target.
STAGES = 6


@dataclass(frozen=True, eq=False)
class DondersPostures:
    """One posture for each target.

    Attributes:
        q: (K, n) postures (rad), NaN where none was found.
        least: (K,) whether the posture is a minimum: False past a fold or where none was found.
        status: a sentence on all of them.
    """

    q: Float[np.ndarray, "samples joints"]
    least: Bool[np.ndarray, " samples"]
    status: Status


def donders_postures(task: Task, law: JointLaw, targets: ArrayLike) -> DondersPostures:
    """Give the posture of least elastic energy for each target.

    Args:
        task: a task whose error is the difference of its values (not orientation rows).
        law: stiffness and rest posture.
        targets: (m,) or (K, m).

    Returns:
        Postures, and whether each is a minimum.

    Raises:
        NotFiniteError: a target is not finite.
        ShapeError: the arrays do not fit.

    Example:
        >>> from selfmotion.arms import wrist
        >>> from selfmotion.redundancy.task import Pointing
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> found = donders_postures(Pointing(wrist()), law, [[0.0, 0.0]])
        >>> np.degrees(found.q[0]).round(6).tolist()
        [5.0, 0.0, 0.0]
    """
    goals = np.atleast_2d(as_float_array("targets", targets))
    require_finite("targets", goals)
    q = np.repeat(law.rest[None], len(goals), axis=0)
    task.error(q, goals)  # refuses targets that do not fit
    here = task.value(q)
    multipliers = np.zeros(here.shape)
    settled = np.zeros(len(q), dtype=bool)
    for stage in range(1, STAGES + 1):
        goal = here + (stage / STAGES) * (goals - here)
        q, multipliers, settled = _newton(task, law, goal, q, multipliers)
    least = settled.copy()
    if settled.any():
        least[settled] = _is_least(task, law, q[settled], multipliers[settled])
    out = np.where(settled[:, None], q, np.nan)
    return DondersPostures(out, least, _sentence(settled, least))


def task_hessian(
    task: Task, q: Float[np.ndarray, "samples joints"]
) -> Float[np.ndarray, "samples rows joints joints"]:
    """Give ∇²x of every row, by central differences of the Jacobian; symmetric."""
    n = q.shape[1]
    moved = np.concatenate([q + s * STEP * e for e in np.eye(n) for s in (1.0, -1.0)])
    J = task.jacobian(moved).reshape(n, 2, len(q), -1, n)
    H = np.moveaxis((J[:, 0] - J[:, 1]) / (2.0 * STEP), 0, -1)
    return 0.5 * (H + np.swapaxes(H, 2, 3))


def null_basis(
    jacobian: Float[np.ndarray, "samples rows joints"],
) -> Float[np.ndarray, "samples joints free"]:
    """Give orthonormal columns that span the null space of each Jacobian of full rank."""
    _, _, Vt = np.linalg.svd(jacobian)
    return np.swapaxes(Vt[:, jacobian.shape[1] :], 1, 2)


def _newton(
    task: Task, law: JointLaw, goals: np.ndarray, q: np.ndarray, multipliers: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Solve K(q - q*) = Jᵀλ, x(q) = goal from a posture nearby; say which settled."""
    n, m = q.shape[1], goals.shape[1]
    change = np.full(len(q), np.inf)
    for _ in range(NEWTON_STEPS):
        J = task.jacobian(q)
        matrix = np.zeros((len(q), n + m, n + m))
        curved = np.einsum("ka,kaij->kij", multipliers, task_hessian(task, q))
        matrix[:, :n, :n] = law.stiffness - curved
        matrix[:, :n, n:] = -np.swapaxes(J, 1, 2)
        matrix[:, n:, :n] = J
        torque = (q - law.rest) @ law.stiffness
        right = np.concatenate(
            [np.einsum("kai,ka->ki", J, multipliers) - torque, task.error(q, goals)], axis=1
        )
        try:
            step = np.linalg.solve(matrix, right[..., None])[..., 0]
        except np.linalg.LinAlgError:  # a fold, met exactly
            return q, multipliers, np.zeros(len(q), dtype=bool)
        size = np.abs(step[:, :n]).max(axis=1)
        step *= np.minimum(1.0, 0.5 / np.maximum(size, 1e-300))[:, None]
        q, multipliers = q + step[:, :n], multipliers + step[:, n:]
        change = size
        if (size < TOLERANCE).all():
            break
    return q, multipliers, change < 1e-8


def _is_least(task: Task, law: JointLaw, q: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
    """Tell where the energy curves upward in the null space."""
    Z = null_basis(task.jacobian(q))
    H = law.stiffness - np.einsum("ka,kaij->kij", multipliers, task_hessian(task, q))
    return np.linalg.eigvalsh(np.swapaxes(Z, 1, 2) @ H @ Z)[:, 0] > 0.0


def _sentence(settled: np.ndarray, least: np.ndarray) -> Status:
    if least.all():
        return Status(True, f"all {len(least)} postures found")
    lost, folded = int((~settled).sum()), int((settled & ~least).sum())
    parts = []
    if lost:
        parts.append(f"no posture found for {lost} of {len(least)} targets")
    if folded:
        parts.append(f"{folded} of {len(least)} lie past a fold of the surface")
    return Status(False, "; ".join(parts))
