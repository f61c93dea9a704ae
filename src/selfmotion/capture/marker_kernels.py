"""Compiled kernels of marker-based inverse kinematics: Levenberg-Marquardt inside joint limits.

They work on `ZFrames`; joints follow coordinates linearly or along piecewise polynomials. All of
them stand in this file, since numba's cache does not notice a change in a function that another
file calls.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

GROUND = -1
REVOLUTE = 0
# Damping at the start and its factors after a step that failed or helped.
FIRST_DAMPING, RAISE, LOWER = 1e-3, 8.0, 0.2
LARGEST_DAMPING = 1e12


class MarkerArrays(NamedTuple):
    """An arm with markers, as plain arrays.

    `body` (M) and `local` (M,3) place markers in z-frames; `above` (N,N) marks the joints that
    move a body: ``above[body, joint]``. `curve` (N) gives the curve that a joint follows, or -1:
    `lead` (C) its coordinate, `breaks` (C,B) padded with infinity, `coefficients` (C,order,B-1).
    """

    parent: np.ndarray
    joint_type: np.ndarray
    rotations: np.ndarray
    translations: np.ndarray
    matrix: np.ndarray
    offset: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    body: np.ndarray
    local: np.ndarray
    weight: np.ndarray
    above: np.ndarray
    curve: np.ndarray
    lead: np.ndarray
    breaks: np.ndarray
    coefficients: np.ndarray


class SolverNumbers(NamedTuple):
    """Tolerance (rad), most iterations, pull to the posture before (m²/rad²), retry (m)."""

    tolerance: float
    max_iterations: int
    pull: float
    retry: float


@njit(cache=True, error_model="numpy")
def follow_curve(arm, k, x):
    """Give value and slope at x of the joint that follows curve k; its end pieces go on."""
    breaks = arm.breaks[k]
    piece = 0
    while piece + 2 < breaks.shape[0] and x >= breaks[piece + 1] and breaks[piece + 2] < np.inf:
        piece += 1
    u = x - breaks[piece]
    value, slope = 0.0, 0.0
    for a in range(arm.coefficients.shape[1]):
        slope = slope * u + value
        value = value * u + arm.coefficients[k, a, piece]
    return value, slope


@njit(cache=True, error_model="numpy")
def frames(arm, values, R, p):
    """Fill R (N,3,3) and p (N,3): frames of all joints in the ground, for their values (N,2)."""
    for i in range(arm.parent.shape[0]):
        j = arm.parent[i]
        R0, t0 = arm.rotations[i], arm.translations[i]
        for a in range(3):
            if j == GROUND:
                p[i, a] = t0[a]
                R[i, a, 0], R[i, a, 1], R[i, a, 2] = R0[a, 0], R0[a, 1], R0[a, 2]
            else:
                r0, r1, r2 = R[j, a, 0], R[j, a, 1], R[j, a, 2]
                p[i, a] = p[j, a] + r0 * t0[0] + r1 * t0[1] + r2 * t0[2]
                for b in range(3):
                    R[i, a, b] = r0 * R0[0, b] + r1 * R0[1, b] + r2 * R0[2, b]
        if arm.joint_type[i] == REVOLUTE:
            c, s = np.cos(values[i, 0]), np.sin(values[i, 0])
            for a in range(3):
                x, y = R[i, a, 0], R[i, a, 1]
                R[i, a, 0] = c * x + s * y
                R[i, a, 1] = c * y - s * x
        else:
            for a in range(3):
                p[i, a] += R[i, a, 2] * values[i, 0]


@njit(cache=True, error_model="numpy")
def place(arm, q, values, R, p, markers):
    """Fill the markers' places (M,3) for a posture, and values (N,2): the joints and slopes."""
    n_joints, n = arm.matrix.shape
    for i in range(n_joints):
        value, slope = arm.offset[i], 0.0
        for j in range(n):
            value += arm.matrix[i, j] * q[j]
        if arm.curve[i] >= 0:
            value, slope = follow_curve(arm, arm.curve[i], q[arm.lead[arm.curve[i]]])
        values[i, 0], values[i, 1] = value, slope
    frames(arm, values, R, p)
    for m in range(arm.body.shape[0]):
        b = arm.body[m]
        u = arm.local[m]
        for a in range(3):
            if b == GROUND:
                markers[m, a] = u[a]
            else:
                markers[m, a] = p[b, a] + R[b, a, 0] * u[0] + R[b, a, 1] * u[1] + R[b, a, 2] * u[2]


@njit(cache=True, error_model="numpy")
def cost_of(arm, markers, target, seen, q, anchor, pull):
    """Give the weighted sum of squared distances, with the pull to the anchor (m²)."""
    cost = 0.0
    for m in range(markers.shape[0]):
        if seen[m]:
            d0 = markers[m, 0] - target[m, 0]
            d1 = markers[m, 1] - target[m, 1]
            d2 = markers[m, 2] - target[m, 2]
            cost += arm.weight[m] * (d0 * d0 + d1 * d1 + d2 * d2)
    for j in range(q.shape[0]):
        cost += pull * (q[j] - anchor[j]) ** 2
    return cost


@njit(cache=True, error_model="numpy")
def normal_equations(arm, values, R, p, markers, target, seen, q, anchor, pull, A, g, column):
    """Fill A = JᵀWJ + pull (n,n) and g = -Jᵀ W e (n), e the distances to the targets."""
    n_joints, n = arm.matrix.shape
    for i in range(n):
        g[i] = pull * (anchor[i] - q[i])
        for j in range(n):
            A[i, j] = 0.0
        A[i, i] = pull
    for m in range(markers.shape[0]):
        b = arm.body[m]
        if not seen[m] or b == GROUND:
            continue
        w = arm.weight[m]
        for j in range(n):
            column[0, j] = column[1, j] = column[2, j] = 0.0
        for i in range(n_joints):
            if not arm.above[b, i]:
                continue
            z0, z1, z2 = R[i, 0, 2], R[i, 1, 2], R[i, 2, 2]
            if arm.joint_type[i] == REVOLUTE:
                d0, d1, d2 = (
                    markers[m, 0] - p[i, 0],
                    markers[m, 1] - p[i, 1],
                    markers[m, 2] - p[i, 2],
                )
                z0, z1, z2 = z1 * d2 - z2 * d1, z2 * d0 - z0 * d2, z0 * d1 - z1 * d0
            for j in range(n):
                f = arm.matrix[i, j]
                if arm.curve[i] >= 0 and arm.lead[arm.curve[i]] == j:
                    f = values[i, 1]
                if f != 0.0:
                    column[0, j] += f * z0
                    column[1, j] += f * z1
                    column[2, j] += f * z2
        e0, e1, e2 = (
            target[m, 0] - markers[m, 0],
            target[m, 1] - markers[m, 1],
            target[m, 2] - markers[m, 2],
        )
        for i in range(n):
            c0, c1, c2 = w * column[0, i], w * column[1, i], w * column[2, i]
            g[i] += c0 * e0 + c1 * e1 + c2 * e2
            for j in range(i + 1):
                A[i, j] += c0 * column[0, j] + c1 * column[1, j] + c2 * column[2, j]


@njit(cache=True, error_model="numpy")
def bounded_step(A, g, damping, q, lower, upper, free, L, step):
    """Fill the damped step inside the limits: joints that would leave are held at their limit.

    The system over the free joints is solved by Cholesky; A holds its lower triangle. Damping is
    relative to the mean of the diagonal, so that joints which no marker sees stay where they are.
    """
    n = q.shape[0]
    mean = 0.0
    for i in range(n):
        mean += A[i, i] / n
        step[i] = 0.0
        leaves = (q[i] <= lower[i] and g[i] < 0.0) or (q[i] >= upper[i] and g[i] > 0.0)
        free[i] = 0 if leaves else 1
    extra = damping * mean + 1e-12 * mean + 1e-300
    for _ in range(n):
        for i in range(n):
            if not free[i]:
                continue
            for j in range(i + 1):
                if not free[j]:
                    continue
                v = A[i, j] + (extra if i == j else 0.0)
                for k in range(j):
                    if free[k]:
                        v -= L[i, k] * L[j, k]
                L[i, j] = np.sqrt(max(v, 1e-300)) if i == j else v / L[j, j]
        for i in range(n):
            if free[i]:
                v = g[i]
                for k in range(n):  # what the held joints' steps take from the rest
                    if not free[k] and step[k] != 0.0:
                        v -= (A[i, k] if k < i else A[k, i]) * step[k]
                for k in range(i):
                    if free[k]:
                        v -= L[i, k] * step[k]
                step[i] = v / L[i, i]
        for i in range(n - 1, -1, -1):
            if free[i]:
                v = step[i]
                for k in range(i + 1, n):
                    if free[k]:
                        v -= L[k, i] * step[k]
                step[i] = v / L[i, i]
        clamped = False
        for i in range(n):
            if free[i]:
                low, high = lower[i] - q[i], upper[i] - q[i]
                if step[i] < low or step[i] > high:
                    step[i] = low if step[i] < low else high
                    free[i] = 0
                    clamped = True
        if not clamped:
            break


@njit(cache=True, error_model="numpy")
def solve_frame(arm, target, seen, q, anchor, numbers, work):
    """Move q to the least cost; give the cost, the iterations and whether steps became small."""
    values, R, p, markers, trial_q, A, g, column, L, step, free = work
    pull = numbers.pull
    n = q.shape[0]
    place(arm, q, values, R, p, markers)
    cost = cost_of(arm, markers, target, seen, q, anchor, pull)
    damping = FIRST_DAMPING
    for iteration in range(numbers.max_iterations):
        normal_equations(arm, values, R, p, markers, target, seen, q, anchor, pull, A, g, column)
        while True:
            bounded_step(A, g, damping, q, arm.lower, arm.upper, free, L, step)
            longest = 0.0
            for j in range(n):
                longest = max(longest, abs(step[j]))
                trial_q[j] = min(max(q[j] + step[j], arm.lower[j]), arm.upper[j])
            if longest <= numbers.tolerance:
                return cost, iteration, True
            place(arm, trial_q, values, R, p, markers)
            new = cost_of(arm, markers, target, seen, trial_q, anchor, pull)
            if new <= cost:
                break
            damping *= RAISE
            if damping > LARGEST_DAMPING:
                return cost, iteration, False
        q[:] = trial_q
        settled = cost - new <= 1e-14 * cost and longest < 1e3 * numbers.tolerance
        cost = new
        damping = max(damping * LOWER, 1e-12)
        if settled:
            return cost, iteration + 1, True
    return cost, numbers.max_iterations, False


@njit(cache=True, error_model="numpy")
def make_work(arm):
    """Allocate the scratch memory of one frame."""
    n_joints, n = arm.matrix.shape
    return (
        np.zeros((n_joints, 2)),
        np.zeros((n_joints, 3, 3)),
        np.zeros((n_joints, 3)),
        np.zeros((arm.body.shape[0], 3)),
        np.zeros(n),
        np.zeros((n, n)),
        np.zeros(n),
        np.zeros((3, n)),
        np.zeros((n, n)),
        np.zeros(n),
        np.zeros(n, np.uint8),
    )


@njit(cache=True, error_model="numpy")
def solve_frames(arm, targets, starts, numbers, q_out, error, iterations, converged):
    """Solve all frames (K,M,3) one after the other, each from the posture before.

    The first frame, the first after one without markers and any whose error is above `retry` try
    all `starts` (S,n) and keep the best. Frames without any marker get NaN.
    """
    n_frames, n_markers = targets.shape[0], targets.shape[1]
    n = starts.shape[1]
    work = make_work(arm)
    markers = work[3]
    seen = np.zeros(n_markers, np.uint8)
    q, best, before = starts[0].copy(), np.zeros(n), starts[0].copy()
    fresh = True
    for k in range(n_frames):
        count = 0
        for m in range(n_markers):
            seen[m] = 0 if np.isnan(targets[k, m, 0]) or arm.weight[m] == 0.0 else 1
            count += seen[m]
        if count == 0:
            q_out[k] = np.nan
            error[k] = np.nan
            fresh = True
            continue
        mass = 0.0
        for m in range(n_markers):
            mass += arm.weight[m] * seen[m]
        least, iterations[k], converged[k] = solve_frame(
            arm, targets[k], seen, q, before, numbers, work
        )
        if fresh or least > mass * numbers.retry**2:
            best[:] = q
            for s in range(starts.shape[0]):
                q[:] = starts[s]
                cost, used, good = solve_frame(arm, targets[k], seen, q, before, numbers, work)
                iterations[k] += used
                if cost < least * (1.0 - 1e-9):
                    least, converged[k] = cost, good
                    best[:] = q
            q[:] = best
            fresh = False
        before[:] = q
        q_out[k] = q
        place(arm, q, work[0], work[1], work[2], markers)
        for m in range(n_markers):
            d = 0.0
            for a in range(3):
                d += (markers[m, a] - targets[k, m, a]) ** 2
            error[k, m] = np.sqrt(d)  # NaN where the marker was not seen
