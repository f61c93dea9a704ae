"""Search the self-motion of a hand position for the posture that is best in some respect.

The hand stays where it is while the joints climb: the slope of what is wanted, projected on the
null space of the task and on the limits, is followed with a step that grows while it helps; each
step is brought back to the hand's target by inverse kinematics. The search is local.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.kinematics.forward import geometric_jacobian
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_tasks import HandRows

# What is to be large: postures (K, n) to (K,).
Objective = Callable[[np.ndarray], np.ndarray]
# Steps of the central differences (rad or m).
DIFFERENCE = 1e-4
# First and last step of a joint (rad or m), how it grows and shrinks.
FIRST_STEP, LAST_STEP, GROW, SHRINK = 0.2, 2e-3, 1.6, 0.35
# A slope below this part of the value per radian is none.
FLAT = 1e-6
# How near the hand stays to its target (m).
HELD = 1e-6


@dataclass(frozen=True)
class ClimbOptions:
    """How long to climb.

    Attributes:
        max_steps: steps tried from a posture.
    """

    max_steps: int = 40


def climb(
    task: HandRows,
    target: Float[np.ndarray, "samples rows"],
    q: Float[np.ndarray, "samples coords"],
    objective: Objective,
    *,
    options: ClimbOptions | None = None,
) -> tuple[Float[np.ndarray, "samples coords"], Float[np.ndarray, " samples"]]:
    """Climb from postures that meet their targets to others that meet them and are better.

    Args:
        task: rows held.
        target: values of the rows (m, rad).
        q: a posture that meets each target (rad or m).
        objective: what is to be large.
        options: how long to climb.

    Returns:
        Postures inside the limits, no worse than those given, and their values.
    """
    opts = options or ClimbOptions()
    best, value = q.copy(), objective(q)
    step = np.full(len(q), FIRST_STEP)
    slope = np.zeros_like(best)
    stale = np.ones(len(q), dtype=np.bool_)
    for _ in range(opts.max_steps):
        open_ = step > LAST_STEP
        if not open_.any():
            break
        new = open_ & stale
        if new.any():
            slope[new] = _uphill(task, best[new], objective, value[new])
            stale[new] = False
        step[open_ & ~slope.any(axis=1)] = 0.0
        rows = np.flatnonzero(step > LAST_STEP)
        if not len(rows):
            break
        length = np.abs(slope[rows]).max(axis=1)
        tried = best[rows] + slope[rows] * (step[rows] / length)[:, None]
        tried, met = _brought_back(task, target[rows], tried)
        found = np.where(met, objective(tried), -np.inf)
        better = found > value[rows]
        gained = rows[better]
        best[gained], value[gained], stale[gained] = tried[better], found[better], True
        step[gained] *= GROW
        step[rows[~better]] *= SHRINK
    return best, value


def _uphill(
    task: HandRows, q: np.ndarray, objective: Objective, value: np.ndarray
) -> Float[np.ndarray, "samples coords"]:
    """Give the slope of the objective along the self-motion; zero where there is none."""
    n = q.shape[1]
    shifted = q[:, None, None] + DIFFERENCE * np.stack([np.eye(n), -np.eye(n)], axis=1)
    low, high = task.arm.lower, task.arm.upper
    shifted = np.clip(shifted, low, high)
    values = objective(shifted.reshape(-1, n)).reshape(len(q), n, 2)
    apart = shifted[:, np.arange(n), 0, np.arange(n)] - shifted[:, np.arange(n), 1, np.arange(n)]
    slope = np.zeros_like(q)
    np.divide(values[:, :, 0] - values[:, :, 1], apart, out=slope, where=apart > 0)
    J = _rows(task, q)
    frozen = np.zeros(q.shape, dtype=np.bool_)
    along = slope
    for _ in range(n):
        free_slope = np.where(frozen, 0.0, slope)
        free_J = np.where(frozen[:, None], 0.0, J)
        along = free_slope - _in_rows(free_J, free_slope)
        out = ((q <= low) & (along < 0)) | ((q >= high) & (along > 0))
        if not (out & ~frozen).any():
            break
        frozen |= out
    flat = np.abs(along).max(axis=1) < FLAT * np.maximum(np.abs(value), 1e-12)
    along[flat] = 0.0
    return along


def _rows(task: HandRows, q: np.ndarray) -> np.ndarray:
    """Give the Jacobian of the rows held; without orientation all postures at once."""
    if task.angles:
        return task.jacobian(q)
    whole = geometric_jacobian(task.arm.chain, q, task.arm.tip(task.landmark))
    return whole[:, list(task.axes)]


def _in_rows(J: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Give the part of slopes that moves the hand.

    Where rows are dependent a trace of them keeps the solution finite; what is wrong then, the
    step back to the target mends.
    """
    JJ = J @ J.mT
    trace = np.trace(JJ, axis1=1, axis2=2)[:, None, None]
    JJ = JJ + (1e-12 * trace + 1e-300) * np.eye(J.shape[1])
    return (J.mT @ np.linalg.solve(JJ, J @ slope[..., None]))[..., 0]


def _brought_back(
    task: HandRows, target: np.ndarray, q: np.ndarray
) -> tuple[Float[np.ndarray, "samples coords"], Bool[np.ndarray, " samples"]]:
    options = IkOptions(restarts=0, position_tolerance=HELD)
    found = solve_ik(task, target, start=q, options=options)
    return found.q, found.solved
