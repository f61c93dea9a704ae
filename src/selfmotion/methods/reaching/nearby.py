"""Inverse kinematics of many points close to others that have been decided before.

The postures of neighbours are better starts than any table: to a point out of reach the
six nearest lead nearer than a score of seeds do, and they find rare ways of reaching, too.
"""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.kinematics.threads import share
from selfmotion.methods.reaching import ik_kernels
from selfmotion.methods.reaching.ik_arrays import Goals, Options, Outputs, Rows
from selfmotion.methods.reaching.ik_seeds import SeedTable, model_of
from selfmotion.methods.reaching.ik_tasks import goals_of

if TYPE_CHECKING:
    from scipy.spatial import KDTree

# Starts: seeds, then neighbours of what is left; steps tried from one start.
SEEDS, NEIGHBOURS, MOST_STEPS = 2, 6, 40
# Targets below which a second thread costs more than it saves.
TARGETS_PER_THREAD = 256


def decide_nearby(
    seeds: SeedTable,
    points: Float[np.ndarray, "points 3"],
    known: tuple["KDTree", Float[np.ndarray, "known coords"]],
    reached: float,
    *,
    threads: int = 1,
) -> Outputs:
    """Find postures for points, from seeds and then from the postures of known points near them.

    Args:
        seeds: of a task that holds x, y and z alone.
        points: targets (m).
        known: where the hand has been, and in which postures.
        reached: distance that counts as reached (m).
        threads: how many threads share the points.
    """
    task, n = seeds.task, len(points)
    model = model_of(task)
    rows = Rows(np.arange(3), task.mode, task.rotation_scale, np.ones(task.arm.n_joints))
    goals = goals_of(task, points)
    out = Outputs(
        np.zeros((n, task.arm.n_joints)),
        np.tile([np.inf, 0.0], (n, 1)),
        np.zeros((n, 2), dtype=np.int64),
        np.zeros(n, dtype=np.bool_),
    )

    def descend(left: np.ndarray, starts: np.ndarray, n_seeds: int, patience: float) -> None:
        options = Options(reached, np.inf, MOST_STEPS, n_seeds - 1, n_seeds > 0)
        part, views = Goals(*(g[left] for g in goals)), Outputs(*(o[left] for o in out))

        def work(a: int, b: int) -> None:
            ik_kernels.descend_batch(
                model,
                rows,
                Goals(*(g[a:b] for g in part)),
                seeds.arrays,
                starts[a:b],
                options,
                patience,
                Outputs(*(v[a:b] for v in views)),
            )

        share(work, len(left), threads, least=TARGETS_PER_THREAD)
        for whole, filled in zip(out, views, strict=True):
            whole[left] = filled

    descend(np.arange(n), np.empty((n, 0, task.arm.n_joints)), SEEDS, ik_kernels.HASTY)
    left, (tree, postures) = np.flatnonzero(~out.solved), known
    count = min(NEIGHBOURS, len(postures))
    near = np.reshape(tree.query(points[left], k=count, workers=threads)[1], (len(left), count))
    descend(left, postures[near], 0, ik_kernels.HASTY)
    left = np.flatnonzero(~out.solved)
    descend(left, out.q[left][:, None], 0, ik_kernels.PATIENT)
    return out
