"""How near a task can come to a target, whatever the joint limits."""

import numpy as np
from jaxtyping import Float, Int

from selfmotion.redundancy.task import Task

MAX_ITERATIONS = 100
# A step that shortens the distance by less than this share ends the search.
PROGRESS = 1e-10
# Least damping, as a share of the problem's size: a target may lie where the Jacobian loses rank.
LEAST_DAMPING = 1e-12


def miss_distance(
    task: Task,
    start: Float[np.ndarray, "samples joints"],
    targets: Float[np.ndarray, "samples rows"],
    free: Int[np.ndarray, " moving"],
) -> Float[np.ndarray, " samples"]:
    """Give the distance that remains to each target after the best posture found (m or rad).

    Levenberg-Marquardt from the posture given, all targets at once; the rows are scaled by
    `task.row_scale` in the search. A local search: zero proves that a target can be reached,
    while anything else says that no way was found from this posture.
    """
    q = start.copy()
    scale = np.asarray(task.row_scale)
    mu = np.full(len(q), 1e-3)
    error = scale * task.error(q, targets)
    cost = (error**2).sum(axis=1)
    for _ in range(MAX_ITERATIONS):
        J = scale[:, None] * task.jacobian(q)[:, :, free]
        H = np.swapaxes(J, 1, 2) @ J
        size = np.trace(H, axis1=1, axis2=2) + 1e-30
        H = H + (mu * size)[:, None, None] * np.eye(len(free))
        g = np.einsum("bai,ba->bi", J, error)
        step = np.linalg.solve(H, g[..., None])[..., 0]
        step *= np.minimum(1.0, 1.0 / np.maximum(np.abs(step).max(axis=1), 1e-30))[:, None]
        tried = q.copy()
        tried[:, free] += step
        new = scale * task.error(tried, targets)
        new_cost = (new**2).sum(axis=1)
        better = new_cost < cost
        gained = better & (cost - new_cost > PROGRESS * cost)
        q[better], error[better], cost[better] = tried[better], new[better], new_cost[better]
        mu = np.where(better, np.maximum(0.1 * mu, LEAST_DAMPING), 10.0 * mu)
        if not (gained | (~better & (mu < 1e6))).any():
            break
    return np.linalg.norm(task.error(q, targets), axis=1)
