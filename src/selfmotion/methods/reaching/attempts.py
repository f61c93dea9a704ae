"""All starts of inverse kinematics for a batch of targets: in threads, again, and to the end."""

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from selfmotion.errors import RangeError
from selfmotion.kinematics.threads import share
from selfmotion.methods.reaching import ik_kernels
from selfmotion.methods.reaching.ik_arrays import (
    Goals,
    Model,
    Options,
    Outputs,
    Published,
    Rows,
    Seeds,
)
from selfmotion.methods.reaching.ik_seeds import SeedTable, evenly, finite_limits, model_of
from selfmotion.methods.reaching.ik_tasks import HandRows

if TYPE_CHECKING:
    from selfmotion.methods.joint_limited_ik import IkOptions

# The published mapping is infinite at a limit: it starts at least this part of the range inside.
INSIDE = 1e-6
# Targets below which a second thread costs more than it saves.
TARGETS_PER_THREAD = 256
# The same for descents, which are what is left when the quick targets are met: each costs more.
DESCENTS_PER_THREAD = 64
# A pose missed by less than this (m, with angles times the rotation scale) is tried again from so
# many postures for each restart, most of which have joints at their limits: poses at the end of
# several ranges have small basins, which evenly spread postures rarely meet.
NEAR_MISS, AGAIN, MOST_AGAIN, STRETCH = 0.1, 4, 200, 2.0
# What is missed is tried again from postures at the ends of ranges, so many times for each restart
# and no more often than the table has postures for.
AT_ENDS, MOST_AT_ENDS = 2, 20
# Steps tried to settle at the nearest posture: near the end they gain ever less.
SETTLING = 400


def run(
    model: Model,
    rows: Rows,
    goals: Goals,
    start: tuple[np.ndarray, bool],
    options: "IkOptions",
    seeds: SeedTable | None,
) -> Outputs:
    """Run the kernel over all targets, in one thread or several."""
    n_targets, n = len(goals.position), len(model.lower)
    out = Outputs(
        np.empty((n_targets, n)),
        np.zeros((n_targets, 2)),
        np.zeros((n_targets, 2), dtype=np.int64),
        np.zeros(n_targets, dtype=np.bool_),
    )
    # Never read-only: the kernels would be compiled anew for that.
    first = np.array(start[0], order="C")
    if options.scheme == "published":
        scheme, first = _published(model, options, first)

        def work(a: int, b: int) -> None:
            part = Goals(*(g[a:b] for g in goals))
            begin = first if len(first) == 1 else first[a:b]
            views = Outputs(*(o[a:b] for o in out))
            ik_kernels.published_batch(model, rows, part, scheme, begin, views)
    else:
        table = _seed_arrays(seeds, model)
        limits = Options(
            options.position_tolerance,
            options.rotation_tolerance,
            options.max_iterations,
            options.restarts,
            start[1],
        )

        def work(a: int, b: int) -> None:
            part = Goals(*(g[a:b] for g in goals))
            begin = first if len(first) == 1 else first[a:b]
            views = Outputs(*(o[a:b] for o in out))
            ik_kernels.solve_batch(model, rows, part, table, limits, begin, views)

    share(work, n_targets, options.threads, least=TARGETS_PER_THREAD)
    return out


class Problem(NamedTuple):
    """A batch of targets, as the kernels want it, and the threads that share them."""

    model: Model
    rows: Rows
    goals: Goals
    seeds: Seeds
    threads: int


def descend_from(
    problem: Problem,
    chosen: Int[np.ndarray, " chosen"],
    starts: Float[np.ndarray, "chosen starts coords"],
    options: Options,
    patience: float,
    out: Outputs,
) -> None:
    """Descend to chosen targets from seeds and from starts of their own; better what is out."""
    part = Goals(*(g[chosen] for g in problem.goals))
    views = Outputs(*(o[chosen] for o in out))

    def work(a: int, b: int) -> None:
        ik_kernels.descend_batch(
            problem.model,
            problem.rows,
            Goals(*(g[a:b] for g in part)),
            problem.seeds,
            starts[a:b],
            options,
            patience,
            Outputs(*(v[a:b] for v in views)),
        )

    share(work, len(chosen), problem.threads, least=DESCENTS_PER_THREAD)
    for whole, filled in zip(out, views, strict=True):
        whole[chosen] = filled


def persist(
    task: HandRows,
    rows: Rows,
    goals: Goals,
    options: "IkOptions",
    seeds: SeedTable,
    out: Outputs,
) -> None:
    """Try again what was missed: with joints that all move alike, from the ends of ranges.

    What is missed then has its best posture settled.
    """
    _try_again(task, rows, goals, options, seeds, out)
    missed = np.flatnonzero(~out.solved)
    if not missed.size:
        return
    alike = rows._replace(mobility=np.ones_like(rows.mobility))
    problem = Problem(model_of(task), alike, goals, seeds.arrays, options.threads)
    limits = Options(options.position_tolerance, options.rotation_tolerance, SETTLING, 0, False)
    best, restarts = out.q[missed][:, None], out.counts[missed, 1]
    descend_from(problem, missed, best, limits, ik_kernels.LAST, out)
    out.counts[missed, 1] = restarts


def _try_again(
    task: HandRows,
    rows: Rows,
    goals: Goals,
    options: "IkOptions",
    seeds: SeedTable,
    out: Outputs,
) -> None:
    model, alike = model_of(task), rows._replace(mobility=np.ones_like(rows.mobility))

    def again(missed: np.ndarray, start: np.ndarray, how: "IkOptions", table: SeedTable) -> None:
        part, from_table = Goals(*(g[missed] for g in goals)), not start.size
        first = model.lower[None] if from_table else start
        found = run(model, alike, part, (first, from_table), how, table)
        _keep_better(out, missed, found, task.rotation_scale)

    if not np.array_equal(alike.mobility, rows.mobility):
        missed = np.flatnonzero(~out.solved)
        again(missed, out.q[missed], options, seeds)
    often = replace(options, restarts=min(AT_ENDS * options.restarts, MOST_AT_ENDS) - 1)
    again(np.flatnonzero(~out.solved), np.empty(0), often, seeds.at_ends)
    if not task.angles:
        return
    single, (low, high) = replace(options, restarts=0), finite_limits(task.arm)
    middle = 0.5 * (low + high)
    for q in evenly(min(AGAIN * options.restarts, MOST_AGAIN), low, high):
        cost = np.hypot(out.errors[:, 0], task.rotation_scale * out.errors[:, 1])
        missed = np.flatnonzero(~out.solved & (cost < NEAR_MISS))
        if not missed.size:
            return
        again(missed, np.clip(middle + STRETCH * (q - middle), low, high)[None], single, seeds)


def _keep_better(out: Outputs, places: np.ndarray, new: Outputs, scale: float) -> None:
    """Take over what is solved, or nearer; count the steps and the starts."""
    before = np.hypot(out.errors[places, 0], scale * out.errors[places, 1])
    better = new.solved | (np.hypot(new.errors[:, 0], scale * new.errors[:, 1]) < before)
    out.q[places[better]] = new.q[better]
    out.errors[places[better]] = new.errors[better]
    out.solved[places] = new.solved
    out.counts[places, 0] += new.counts[:, 0]
    out.counts[places, 1] += 1 + new.counts[:, 1]


def _published(
    model: Model, options: "IkOptions", first: np.ndarray
) -> tuple[Published, np.ndarray]:
    """Give the numbers of the published scheme and starts that its mapping can take."""
    width = model.upper - model.lower
    if not ((width > 0).all() and np.isfinite(width).all()):
        raise RangeError("the published scheme needs a finite range above 0 in every joint")
    middle, reach = 0.5 * (model.lower + model.upper), (0.5 - INSIDE) * width
    numbers = Published(
        options.gain_step,
        options.damping,
        options.error_clip,
        options.position_tolerance,
        options.rotation_tolerance,
        options.max_iterations,
    )
    return numbers, np.clip(first, middle - reach, middle + reach)


def _seed_arrays(seeds: SeedTable | None, model: Model) -> Seeds:
    """Give the kernels' table; an empty one where there is a single start."""
    n = len(model.lower)
    if seeds is None:
        none = np.zeros((1, 0), dtype=np.int64)
        zero, one = np.zeros(3), np.ones(3, dtype=np.int64)
        return Seeds(np.zeros((0, n)), np.zeros((0, 3)), np.zeros((0, 3, 3)), none, zero, zero, one)
    return seeds.arrays
