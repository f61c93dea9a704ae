"""Which arcs of a closed path the hand can reach, and whether it can follow them without a jump."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import freeze
from selfmotion.errors import RangeError
from selfmotion.methods.constrained_path import Arc, FollowedPath, PathCosts, follow
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.ik_seeds import SeedTable, evenly, finite_limits, seed_table
from selfmotion.methods.reaching.ik_tasks import HandRows

# How far from its ends an arc is followed (rad), and samples of the second, finer attempt: a steep
# but continuous motion takes smaller steps there, a jump does not.
END, FINER, FINEST = 0.005, 6, 300
# Halvings that find the end of an arc, and postures from which an arc is tried.
HALVINGS, STARTS = 12, 6

# Targets of the task's rows at parameters (rad): (K,) to (K, m).
Path = Callable[[np.ndarray], np.ndarray]


def feasible_arcs(
    task: HandRows,
    path: Path,
    *,
    n_samples: int = 120,
    costs: PathCosts | None = None,
) -> tuple[Arc, ...]:
    """Find the arcs of a closed path on which the task can be met inside the limits.

    Every sample is decided by inverse kinematics with restarts; the ends of arcs are halved down
    to 3e-4 of a sample. Each arc is then followed, from several postures, until one gets to its
    end without a jump.

    Args:
        task: rows held.
        path: gives targets (K, m) at parameters (K,) from 0 to 2 pi (rad).
        n_samples: parameters tried.
        costs: what the joints pay along the path.

    Returns:
        The arcs, in order; none where nothing is feasible.

    Raises:
        RangeError: fewer than 8 samples.
    """
    if n_samples < 8:
        raise RangeError(f"n_samples = {n_samples}: allowed is 8 and above")
    angles = np.arange(n_samples) * (2 * np.pi / n_samples)
    seeds = seed_table(task)
    search = task, seeds
    reached = solve_ik(task, path(angles), seeds=seeds).solved
    if reached.all():
        return (_followed(search, path, (0.0, 2 * np.pi), n_samples, costs),)
    step = 2 * np.pi / n_samples

    def feasible(angle: float) -> bool:
        return bool(solve_ik(task, path(np.array([angle])), seeds=seeds).solved[0])

    arcs = []
    for first, count in _runs(reached):
        low = _edge(feasible, angles[first], angles[first] - step)
        last = angles[first] + (count - 1) * step
        high = _edge(feasible, last, last + step)
        arcs.append(_followed(search, path, (low, high), max(count, 2), costs))
    return tuple(arcs)


def _runs(reached: Bool[np.ndarray, " samples"]) -> list[tuple[int, int]]:
    """Give first index and length of the runs of True on a closed path."""
    firsts = np.flatnonzero(reached & ~np.roll(reached, 1))
    runs = []
    for first in firsts.tolist():
        count = 1
        while reached[(first + count) % len(reached)]:
            count += 1
        runs.append((first, count))
    return runs


def _edge(feasible: Callable[[float], bool], inside: float, outside: float) -> float:
    """Halve towards the last parameter that is feasible."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        if feasible(middle):
            inside = middle
        else:
            outside = middle
    return float(inside)


def _followed(
    search: tuple[HandRows, SeedTable],
    path: Path,
    ends: tuple[float, float],
    n_samples: int,
    costs: PathCosts | None,
) -> Arc:
    """Follow an arc from its middle to both ends, then from either end; keep the best.

    Near its ends few postures are left, so a way that starts there is on the only branch.
    """
    task, seeds = search
    whole_turn = ends[1] - ends[0] >= 2 * np.pi
    # At its very ends an arm is singular, and joints move infinitely fast.
    inside = 0.0 if whole_turn else min(END, 0.25 * (ends[1] - ends[0]))
    parameters = np.linspace(ends[0] + inside, ends[1] - inside, n_samples)
    targets = path(parameters)
    best: FollowedPath | None = None
    for at in (0,) if whole_turn else (n_samples // 2, 0, n_samples - 1):
        for start in _starts(task, targets[at], seeds):
            found = _both_ways(task, targets, parameters, (at, start), costs)
            if found.status.ok:
                return Arc(*ends, found)
            if best is None or found.met.sum() > best.met.sum():
                best = found
    if best is not None and n_samples < FINEST:
        return _followed(search, path, ends, FINER * n_samples, costs)
    if best is None:  # no posture met the middle once more: say where the nearest one is
        best = follow(task, targets, time=parameters, costs=costs)
    return Arc(*ends, best)


def _both_ways(
    task: HandRows,
    targets: np.ndarray,
    time: np.ndarray,
    begin: tuple[int, np.ndarray],
    costs: PathCosts | None,
) -> FollowedPath:
    """Follow a path from one of its samples, and a posture there, to both ends."""
    at, start = begin
    last = len(targets) - 1
    back = ahead = None
    if at < last:
        ahead = follow(task, targets[at:], time=time[at:], start=start, costs=costs)
    if at > 0:
        back = follow(task, targets[at::-1], time=-time[at::-1], start=start, costs=costs)
    if back is None or ahead is None:
        one = ahead if back is None else _turned(back)
        return follow(task, targets, time=time, start=start, costs=costs) if one is None else one
    return _joined(back, ahead)


def _turned(back: FollowedPath) -> FollowedPath:
    """Turn round a way that was followed backwards."""
    return replace(
        back,
        time=freeze(-back.time[::-1]),
        q=freeze(back.q[::-1]),
        error=freeze(back.error[::-1]),
        met=freeze(back.met[::-1]),
    )


def _joined(back: FollowedPath, ahead: FollowedPath) -> FollowedPath:
    """Join the way back, turned round, and the way ahead; both begin at one sample."""
    failed = [part.status for part in (back, ahead) if not part.status.ok]
    turned = _turned(back)
    return FollowedPath(
        ahead.task,
        np.concatenate([turned.time[:-1], ahead.time]),
        np.concatenate([turned.q[:-1], ahead.q]),
        np.concatenate([turned.error[:-1], ahead.error]),
        np.concatenate([turned.met[:-1], ahead.met]),
        max(back.largest_step, ahead.largest_step),
        failed[0] if failed else ahead.status,
    )


def _starts(
    task: HandRows, target: np.ndarray, seeds: SeedTable
) -> Float[np.ndarray, "starts coords"]:
    """Give different postures that meet the first target."""
    first = np.concatenate([[task.arm.middle()], evenly(STARTS - 1, *finite_limits(task.arm))])
    found = solve_ik(task, np.repeat(target[None], STARTS, axis=0), start=first, seeds=seeds)
    return found.q[found.solved]
