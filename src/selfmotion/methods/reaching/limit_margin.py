"""How far postures keep from the joint limits, and how far they could at a place of the hand."""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.ik_seeds import SeedTable, seed_table
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import reach_options

# Halvings that find the margin: it is known to 1/64. Seeds of inverse kinematics at each.
MARGIN_STEPS, SEEDS = 6, 256


def limit_margin(arm: Arm, q: ArrayLike) -> Float[np.ndarray, " samples"]:
    """Give the least share of half range that the joints of postures (K, n) keep from limits.

    1: all joints in the middle; below 0: outside the limits. Joints without a range or without
    limits do not count.
    """
    postures = np.atleast_2d(as_float_array("q", q))
    half = 0.5 * (arm.upper - arm.lower)
    counts = np.isfinite(half) & (half > 0)
    if not counts.any():
        return np.ones(len(postures))
    room = np.minimum(postures - arm.lower, arm.upper - postures)[:, counts] / half[counts]
    return room.min(axis=1)


def best_margin(
    task: HandRows, x: Float[np.ndarray, "points 3"], q: Float[np.ndarray, "points coords"]
) -> tuple[Float[np.ndarray, "points coords"], Float[np.ndarray, " points"]]:
    """Find the postures that keep farthest from the limits at points that are reached.

    All limits are narrowed alike by halving; a point's margin is that of the posture found at the
    narrowest limits that still reach it, at most 1/64 below the largest.
    """
    best, margin = q.copy(), np.maximum(limit_margin(task.arm, q), 0.0)
    inner: dict[float, tuple[HandRows, SeedTable]] = {}
    low, high = np.floor(margin * 2**MARGIN_STEPS), np.full(len(x), 2.0**MARGIN_STEPS)
    while True:
        level = np.floor(0.5 * (low + high))
        open_ = np.flatnonzero(level > low)
        if not len(open_):
            return best, margin
        for step in np.unique(level[open_]).tolist():
            rows = open_[level[open_] == step]
            if step not in inner:
                narrow = narrowed(task.arm, step / 2**MARGIN_STEPS)
                part = HandRows(narrow, task.rows, task.landmark)
                inner[step] = part, seed_table(part, n_seeds=SEEDS)
            found = solve_ik(inner[step][0], x[rows], options=reach_options(), seeds=inner[step][1])
            low[rows[found.solved]], high[rows[~found.solved]] = step, step
            kept = limit_margin(task.arm, found.q)
            better = rows[found.solved & (kept > margin[rows])]
            best[better] = found.q[found.solved & (kept > margin[rows])]
            margin[better] = kept[found.solved & (kept > margin[rows])]


def narrowed(arm: Arm, share: float) -> Arm:
    """Give the arm with all finite limits moved towards the middle by a share of half range."""
    with np.errstate(invalid="ignore"):
        inwards = share * 0.5 * (arm.upper - arm.lower)
    inwards = np.where(np.isfinite(inwards), inwards, 0.0)
    bounds = zip(arm.lower + inwards, arm.upper - inwards, strict=True)
    return arm.with_limits(
        {
            name: (float(min(a, b)), float(max(a, b)))
            for name, (a, b) in zip(arm.joints, bounds, strict=True)
        }
    )
