"""Compiled kernels of inverse kinematics: one target, a batch of targets, a path.

A target is solved by Levenberg-Marquardt steps inside the box of joint limits, from a first posture
and then from seeds near the target.
"""

import numpy as np

from selfmotion.kinematics.compiled import compiled
from selfmotion.methods.reaching import ik_model, ik_steps
from selfmotion.methods.reaching.ik_arrays import DRIVER, FREE_ROTATION, FULL_ROTATION, KERNEL
from selfmotion.methods.reaching.ik_model import forward, make_work
from selfmotion.methods.reaching.ik_rotation import rotation_rows
from selfmotion.methods.reaching.ik_steps import (
    bounded_step,
    centred_step,
    n_rows,
    normal_matrix,
    residual,
    solve_positive,
    task_jacobian,
)

CALLED = (*ik_model.CALLED, ik_model, *ik_steps.CALLED, ik_steps)
# Damping of a step: this part of the squared error, and at least so much (m²).
DAMPING, LEAST_DAMPING = 1e-2, 1e-9
# A step moves no joint further than this (rad or m).
LONGEST_STEP = 1.2
# The posture is the nearest one when the squared gradient is below this part of the squared
# error, or when this many steps in a row leave more than this part of it.
STATIONARY, STILL_NEARER, SLOW_STEPS = 1e-6, 1e-9, 2
# That part for a start among many, for a single start, and for the last word on a target out of
# reach, where steps leave ever more of an error that cannot vanish.
HASTY, PATIENT, LAST = 0.6, 0.98, 1.0 - 1e-6
# On a path: longest step, and the step that counts as none.
LONGEST_PATH_STEP, STILL = 0.3, 1e-7
# Restarts from the nearest seeds; after them, so many seeds are passed over at each restart.
NEAREST_FIRST, SKIPPED = 6, 2


@compiled(*CALLED, **KERNEL)
def descend(model, rows, position, rotation, angles, options, slow_part, q, w):
    """Move q to the target, or to the nearest posture; give errors, evaluations and success."""
    lower, upper, step, trial, error, rest = (
        model.lower,
        model.upper,
        w.step,
        w.trial,
        w.error,
        w.held,
    )
    n, m, weight = q.shape[0], n_rows(rows), rows.scale**2
    near2, turn2 = options.position_tolerance**2, options.rotation_tolerance**2
    most = options.max_iterations
    forward(model, q, w)
    near, turned = residual(rows, position, rotation, angles, w)
    cost = near + weight * turned
    near_new, turned_new, cost_new = near, turned, cost
    factor, slow, evaluation = 1.0, 0, 1
    stationary = STATIONARY if slow_part < LAST else STILL_NEARER
    while evaluation < most:
        if near <= near2 and turned <= turn2:
            return near, turned, evaluation, True
        task_jacobian(model, rows, w)
        for r in range(m):
            rest[r] = error[r]
        while True:
            slope = bounded_step(model, rows, q, factor * DAMPING * cost + LEAST_DAMPING, w)
            if slope <= stationary * cost:
                return near, turned, evaluation, False
            longest = LONGEST_STEP
            for j in range(n):
                longest = max(longest, abs(step[j]))
            shrink = LONGEST_STEP / longest
            for j in range(n):
                trial[j] = min(max(q[j] + shrink * step[j], lower[j]), upper[j])
            forward(model, trial, w)
            near_new, turned_new = residual(rows, position, rotation, angles, w)
            cost_new = near_new + weight * turned_new
            evaluation += 1
            if cost_new < cost:
                break
            if evaluation >= most or factor > 1e8:
                return near, turned, evaluation, False
            factor = 10.0 * factor
            for r in range(m):
                error[r] = rest[r]
        slow = slow + 1 if cost_new > slow_part * cost else 0
        near, turned, cost = near_new, turned_new, cost_new
        factor = max(0.1 * factor, 1e-3)
        for j in range(n):
            q[j] = trial[j]
        if slow >= SLOW_STEPS:
            break
    return near, turned, evaluation, near <= near2 and turned <= turn2


@compiled(*CALLED, **KERNEL)
def _score_seeds(rows, seeds, position, rotation, angles, scores, w):
    """Fill the squared error of the seeds listed in the target's cell; give the cell."""
    cell = 0
    for a in range(3):
        i = int(np.floor((position[a] - seeds.low[a]) * seeds.per_metre[a]))
        cell = cell * seeds.counts[a] + min(max(i, 0), seeds.counts[a] - 1)
    cells, places, turns = seeds.cells, seeds.position, seeds.rotation
    held, mode, weight = rows.axes, rows.rotation, rows.scale**2
    for k in range(cells.shape[1]):
        i = cells[cell, k]
        score = 0.0
        for r in range(held.shape[0]):
            d = position[held[r]] - places[i, held[r]]
            score += d * d
        if mode == FULL_ROTATION:  # 3 - trace is the squared angle, nearly
            alike = 0.0
            for a in range(3):
                for b in range(3):
                    alike += turns[i, a, b] * rotation[a, b]
            score += weight * (3.0 - alike)
        elif mode != FREE_ROTATION:
            error = w.error
            n = rotation_rows(turns[i], rotation, angles, mode, error, w.turn, w.scratch)
            for r in range(n):
                score += weight * error[r] * error[r]
        scores[k] = score
    return cell


@compiled(*CALLED, **KERNEL)
def _next_seed(scores):
    """Give the place of the least score."""
    pick = 0
    for i in range(scores.shape[0]):
        if scores[i] < scores[pick]:
            pick = i
    return pick


@compiled(*CALLED, **KERNEL)
def solve_one(model, rows, goals, k, seeds, options, start, best, scores, w):
    """Solve target k from `start`, then from seeds; fill `best`.

    Gives squared errors, evaluations, restarts and success.
    """
    position, rotation, angles = goals.position[k], goals.rotation[k], goals.angles[k]
    q = w.q
    evaluations, best_cost, near, turned = 0, np.inf, np.inf, np.inf
    cell = -1
    patience = HASTY if options.restarts > 0 else PATIENT
    for attempt in range(options.restarts + 1):
        if attempt == 0 and not options.seed_first:
            for j in range(q.shape[0]):
                q[j] = start[j]
        else:
            if cell < 0:
                cell = _score_seeds(rows, seeds, position, rotation, angles, scores, w)
            pick = _next_seed(scores)
            if scores[pick] == np.inf:
                break
            for j in range(q.shape[0]):
                q[j] = seeds.q[seeds.cells[cell, pick], j]
            scores[pick] = np.inf
            if attempt >= NEAREST_FIRST:  # then further apart, to meet other ways of reaching
                for _ in range(SKIPPED):
                    scores[_next_seed(scores)] = np.inf
        e, t, n_done, solved = descend(
            model, rows, position, rotation, angles, options, patience, q, w
        )
        evaluations += n_done
        cost = e + rows.scale**2 * t
        if cost < best_cost or solved:
            best_cost, near, turned = cost, e, t
            for j in range(q.shape[0]):
                best[j] = q[j]
        if solved:
            return near, turned, evaluations, attempt, True
    if options.restarts > 0:
        near, turned, n_done, solved = descend(
            model, rows, position, rotation, angles, options, PATIENT, best, w
        )
        return near, turned, evaluations + n_done, options.restarts, solved
    return near, turned, evaluations, options.restarts, False


@compiled(*CALLED, **DRIVER)
def solve_batch(model, rows, goals, seeds, options, starts, out):
    """Solve every target; `starts` holds one posture a target, or one for all."""
    w = make_work(model.lead.shape[0], model.lower.shape[0])
    scores = np.empty(seeds.cells.shape[1])
    for k in range(out.q.shape[0]):
        start = starts[min(k, starts.shape[0] - 1)]
        near, turned, out.counts[k, 0], out.counts[k, 1], out.solved[k] = solve_one(
            model, rows, goals, k, seeds, options, start, out.q[k], scores, w
        )
        out.errors[k, 0], out.errors[k, 1] = np.sqrt(near), np.sqrt(turned)


@compiled(*CALLED, **DRIVER)
def descend_batch(model, rows, goals, seeds, starts, options, patience, out):
    """Descend from seeds near each target and from starts of its own (K,S,n); better what is out.

    As many seeds are tried as `options` allows starts; none if it does not begin with a seed.
    """
    w = make_work(model.lead.shape[0], model.lower.shape[0])
    q, scores = w.q, np.empty(seeds.cells.shape[1])
    n_seeds = min(options.restarts + 1, scores.shape[0]) if options.seed_first else 0
    for k in range(out.q.shape[0]):
        position, rotation, angles = goals.position[k], goals.rotation[k], goals.angles[k]
        weight, cell = rows.scale**2, 0
        least = out.errors[k, 0] ** 2 + weight * out.errors[k, 1] ** 2
        if n_seeds:
            cell = _score_seeds(rows, seeds, position, rotation, angles, scores, w)
        for attempt in range(n_seeds + starts.shape[1]):
            if attempt < n_seeds:
                pick = _next_seed(scores)
                scores[pick] = np.inf
                start = seeds.q[seeds.cells[cell, pick]]
            else:
                start = starts[k, attempt - n_seeds]
            for j in range(q.shape[0]):
                q[j] = start[j]
            near, turned, n_done, solved = descend(
                model, rows, position, rotation, angles, options, patience, q, w
            )
            out.counts[k, 0] += n_done
            out.counts[k, 1] += 1
            if solved or near + weight * turned < least:
                least, out.solved[k] = near + weight * turned, solved
                out.errors[k, 0], out.errors[k, 1] = np.sqrt(near), np.sqrt(turned)
                for j in range(q.shape[0]):
                    out.q[k, j] = q[j]
            if solved:
                break


@compiled(*CALLED, **DRIVER)
def published_batch(model, rows, goals, scheme, starts, out):
    """Solve every target by [DeBoon] eqs 10 to 16: steps in the unbounded variable."""
    q = out.q
    n, m = q.shape[1], n_rows(rows)
    w = make_work(model.lead.shape[0], n)
    free = np.ones(n, np.uint8)
    unbounded, slope = np.empty(n), np.empty(n)
    for k in range(q.shape[0]):
        start = starts[min(k, starts.shape[0] - 1)]
        for j in range(n):  # eq. 10
            middle = 0.5 * (model.upper[j] + model.lower[j])
            unbounded[j] = np.tan(np.pi * (start[j] - middle) / (model.upper[j] - model.lower[j]))
        near = turned = 0.0
        for step in range(scheme.max_iterations + 1):
            for j in range(n):  # eqs 11 and 13
                width = (model.upper[j] - model.lower[j]) / np.pi
                middle = 0.5 * (model.upper[j] + model.lower[j])
                q[k, j] = width * np.arctan(unbounded[j]) + middle
                slope[j] = width / (1.0 + unbounded[j] * unbounded[j])
            forward(model, q[k], w)
            near, turned = residual(rows, goals.position[k], goals.rotation[k], goals.angles[k], w)
            out.counts[k, 0] = step
            if near <= scheme.position_tolerance**2 and turned <= scheme.rotation_tolerance**2:
                out.solved[k] = True
                break
            task_jacobian(model, rows, w)
            for j in range(n):
                for r in range(m):
                    w.J[r, j] *= slope[j]  # eq. 12
            size = 0.0
            for r in range(m):
                size += w.error[r] * w.error[r]
            shrink = min(1.0, scheme.clip / max(np.sqrt(size), 1e-300))
            for r in range(m):
                w.rest[r] = scheme.gain * shrink * w.error[r]
            normal_matrix(w.J, m, free, rows.mobility, scheme.damping, w.A)
            solve_positive(w.A, m, w.rest, w.L, w.y)
            for j in range(n):  # eqs 14 to 16
                d = 0.0
                for r in range(m):
                    d += w.J[r, j] * w.y[r]
                unbounded[j] += rows.mobility[j] * d
        out.errors[k, 0], out.errors[k, 1] = np.sqrt(near), np.sqrt(turned)


@compiled(*CALLED, **KERNEL)
def follow_one(model, rows, goals, k, cost, options, best, w):
    """Move `best` to the cheapest posture near it that meets target k; give the error."""
    mobility, centre = cost
    position, rotation, angles = goals.position[k], goals.rotation[k], goals.angles[k]
    q, step, n, m = w.trial, w.step, best.shape[0], n_rows(rows)
    least = np.inf
    for j in range(n):
        q[j] = best[j]
    for _ in range(options.max_iterations):
        forward(model, q, w)
        near, turned = residual(rows, position, rotation, angles, w)
        error = np.sqrt(near + rows.scale**2 * turned)
        if error < least or error <= options.position_tolerance:
            least = error
            for j in range(n):
                best[j] = q[j]
        task_jacobian(model, rows, w)
        centred_step(model, q, mobility, centre, m, w)
        longest = 0.0
        for j in range(n):
            longest = max(longest, abs(step[j]))
        if error <= options.position_tolerance and longest < STILL:
            break
        shrink = min(1.0, LONGEST_PATH_STEP / max(longest, 1e-300))
        for j in range(n):
            q[j] = min(max(q[j] + shrink * step[j], model.lower[j]), model.upper[j])
    if least > options.position_tolerance:  # the cost may have led astray: descend without it
        near, turned, _, _ = descend(
            model, rows, position, rotation, angles, options, PATIENT, best, w
        )
        least = np.sqrt(near + rows.scale**2 * turned)
    return least


@compiled(*CALLED, **DRIVER)
def follow_batch(model, rows, goals, weights, rest, before, dt, options, q, errors):
    """Follow targets in turn; `weights` (3,n) are of displacement, velocity and acceleration."""
    n = q.shape[1]
    w = make_work(model.lead.shape[0], n)
    mobility, centre = np.empty(n), np.empty(n)
    last, earlier, now = before.copy(), before.copy(), before.copy()
    for k in range(q.shape[0]):
        for j in range(n):
            v, a = weights[1, j] / dt[k] ** 2, weights[2, j] / dt[k] ** 4
            h = weights[0, j] + v + a
            mobility[j] = 1.0 / h
            pull = weights[0, j] * rest[j] + v * last[j] + a * (2.0 * last[j] - earlier[j])
            centre[j] = pull / h
        errors[k] = follow_one(model, rows, goals, k, (mobility, centre), options, now, w)
        for j in range(n):
            q[k, j] = now[j]
            earlier[j], last[j] = last[j], now[j]
