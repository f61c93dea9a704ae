"""Inverse kinematics of many points close to others that have been decided before.

The postures of neighbours are better starts than any table: to a point out of reach the
six nearest lead nearer than a score of seeds do, and they find rare ways of reaching, too.
"""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.methods.reaching.attempts import Problem, descend_from
from selfmotion.methods.reaching.ik_arrays import Options, Outputs, Rows
from selfmotion.methods.reaching.ik_kernels import HASTY, PATIENT
from selfmotion.methods.reaching.ik_seeds import SeedTable, model_of
from selfmotion.methods.reaching.ik_tasks import goals_of

if TYPE_CHECKING:
    from scipy.spatial import KDTree

# Starts: seeds, then neighbours of what is left; steps tried from one start.
SEEDS, NEIGHBOURS, MOST_STEPS = 2, 6, 40
# A point still missed by this (m) is tried from so many postures at the ends of ranges as well: it
# will speak for all around it.
AWAY, AT_ENDS = 0.02, 6


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
    rows = Rows(np.arange(3), task.mode, task.rotation_scale, np.ones(task.arm.n_joints))
    problem = Problem(model_of(task), rows, goals_of(task, points), seeds.arrays, threads)
    out = Outputs(
        np.zeros((n, task.arm.n_joints)),
        np.tile([np.inf, 0.0], (n, 1)),
        np.zeros((n, 2), dtype=np.int64),
        np.zeros(n, dtype=np.bool_),
    )

    seeded, alone = (Options(reached, np.inf, MOST_STEPS, SEEDS - 1, s) for s in (True, False))
    none = np.empty((n, 0, task.arm.n_joints))
    descend_from(problem, np.arange(n), none, seeded, HASTY, out)
    left, (tree, postures) = np.flatnonzero(~out.solved), known
    count = min(NEIGHBOURS, len(postures))
    near = np.reshape(tree.query(points[left], k=count, workers=threads)[1], (len(left), count))
    descend_from(problem, left, postures[near], alone, HASTY, out)
    away = np.flatnonzero(out.errors[:, 0] > AWAY)
    ends = problem._replace(seeds=seeds.at_ends.arrays)
    at_ends = seeded._replace(restarts=AT_ENDS - 1)
    descend_from(ends, away, none[away], at_ends, HASTY, out)
    left = np.flatnonzero(~out.solved)
    descend_from(problem, left, out.q[left][:, None], alone, PATIENT, out)
    return out
