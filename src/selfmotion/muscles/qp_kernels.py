"""Compiled solver of the muscle problem: least effort that gives a torque.

The problem ``min sum(a**p)/p  with  A'a = b, lower <= a <= upper`` has n = 7 equations and M = 63
unknowns. Its dual has n unknowns only: ``a = clip(t**(1/(p-1)))`` with ``t = A x``, and x solves
``A'a(x) + x/penalty = b``. The penalty term stands for ``penalty/2 |b - A'a|^2`` in the primal:
with it the dual is bounded whether or not any activation gives the torque, and where none does,
the solution is the one of least residual ``x / penalty``.
"""

import numpy as np
from numba import njit

# Each N m of missing torque costs as much as this many squared activations, times N m.
PENALTY = 1e8
MAX_ITERATIONS = 200
# Slope of a(t) is bounded by this near t = 0, where it is infinite for p > 2.
STEEPEST = 1e3


@njit(cache=True)
def _activation(t, lower, upper, exponent):
    """Give a(t) and its slope for one muscle."""
    if exponent == 2.0:
        a = t
        slope = 1.0
    else:
        if t <= 0.0:
            a = 0.0
            slope = 0.0
        else:
            a = t ** (1.0 / (exponent - 1.0))
            slope = min(a / (t * (exponent - 1.0)), STEEPEST)
    if a <= lower:
        return lower, 0.0
    if a >= upper:
        return upper, 0.0
    return a, slope


@njit(cache=True)
def _cholesky_solve(H, g, n):
    """Solve H x = g in place (H symmetric positive definite, destroyed; g becomes x)."""
    for j in range(n):
        d = H[j, j]
        for k in range(j):
            d -= H[j, k] * H[j, k]
        if not d > 0.0:
            return False
        d = np.sqrt(d)
        H[j, j] = d
        for i in range(j + 1, n):
            s = H[i, j]
            for k in range(j):
                s -= H[i, k] * H[j, k]
            H[i, j] = s / d
    for i in range(n):
        s = g[i]
        for k in range(i):
            s -= H[i, k] * g[k]
        g[i] = s / H[i, i]
    for i in range(n - 1, -1, -1):
        s = g[i]
        for k in range(i + 1, n):
            s -= H[k, i] * g[k]
        g[i] = s / H[i, i]
    return True


@njit(cache=True)
def _slope_along(t, dt, x, p, b, lower, upper, exponent, alpha):
    """Give the dual's derivative along the step p at alpha, and its second derivative."""
    first = 0.0
    second = 0.0
    for j in range(p.shape[0]):
        first += p[j] * (b[j] - (x[j] + alpha * p[j]) / PENALTY)
        second -= p[j] * p[j] / PENALTY
    for i in range(t.shape[0]):
        a, s = _activation(t[i] + alpha * dt[i], lower[i], upper[i], exponent)
        first -= dt[i] * a
        second -= dt[i] * dt[i] * s
    return first, second


@njit(cache=True)
def _best_step(t, dt, x, p, b, lower, upper, exponent):
    """Find where the (concave) dual is greatest along p: bracketed Newton on its derivative."""
    low, high = 0.0, 1.0
    first, second = _slope_along(t, dt, x, p, b, lower, upper, exponent, 1.0)
    start = abs(_slope_along(t, dt, x, p, b, lower, upper, exponent, 0.0)[0])
    if abs(first) <= 1e-3 * start:
        return 1.0
    while first > 0.0 and high < 1e12:
        low = high
        high *= 4.0
        first, second = _slope_along(t, dt, x, p, b, lower, upper, exponent, high)
    alpha = 0.5 * (low + high)
    for _ in range(60):
        first, second = _slope_along(t, dt, x, p, b, lower, upper, exponent, alpha)
        if abs(first) <= 1e-3 * start:
            break
        if first > 0.0:
            low = alpha
        else:
            high = alpha
        if second < 0.0:
            alpha = alpha - first / second
        if not low < alpha < high:
            alpha = 0.5 * (low + high)
    return alpha


@njit(cache=True)
def solve_one(A, b, lower, upper, exponent, x, a):
    """Solve for one posture; x (n,) is the start and becomes the multipliers, a (M,) the answer.

    Returns the number of iterations, or -1 where the gradient did not vanish.
    """
    n_muscles, n = A.shape
    H = np.empty((n, n))
    g = np.empty(n)
    t = np.empty(n_muscles)
    dt = np.empty(n_muscles)
    size = 1.0
    for j in range(n):
        size = max(size, abs(b[j]))
    for iteration in range(MAX_ITERATIONS):
        for j in range(n):
            g[j] = b[j] - x[j] / PENALTY
            for k in range(n):
                H[j, k] = 0.0
            H[j, j] = 1.0 / PENALTY
        for i in range(n_muscles):
            s = 0.0
            for j in range(n):
                s += A[i, j] * x[j]
            t[i] = s
            a[i], slope = _activation(s, lower[i], upper[i], exponent)
            for j in range(n):
                g[j] -= A[i, j] * a[i]
            if slope > 0.0:
                for j in range(n):
                    w = slope * A[i, j]
                    for k in range(j + 1):
                        H[j, k] += w * A[i, k]
        worst = 0.0
        reach = 0.0
        for j in range(n):
            worst = max(worst, abs(g[j]))
            reach = max(reach, abs(x[j]))
        # The rounding of t = A x limits what can be reached where x is large (no feasible a).
        if worst <= 1e-11 * size + 1e-16 * reach * 1e3:
            return iteration
        trace = 0.0
        for j in range(n):
            trace += H[j, j]
        for j in range(n):
            H[j, j] += 1e-14 * trace
        if not _cholesky_solve(H, g, n):
            return -1
        for i in range(n_muscles):
            s = 0.0
            for j in range(n):
                s += A[i, j] * g[j]
            dt[i] = s
        alpha = _best_step(t, dt, x, g, b, lower, upper, exponent)
        for j in range(n):
            x[j] += alpha * g[j]
    return -1


@njit(cache=True)
def solve_many(A, b, lower, upper, exponent, activations, multipliers):
    """Solve for K postures, each started from the one before: A (K,M,n), b (K,n)."""
    n_samples, _, n = A.shape
    iterations = np.empty(n_samples, np.int64)
    x = np.zeros(n)
    for k in range(n_samples):
        iterations[k] = solve_one(A[k], b[k], lower, upper, exponent, x, activations[k])
        if iterations[k] < 0:  # once more from the origin
            x[:] = 0.0
            iterations[k] = solve_one(A[k], b[k], lower, upper, exponent, x, activations[k])
        for j in range(n):
            multipliers[k, j] = x[j]
            if abs(x[j]) > 1e3:  # no good start for the next one
                x[:] = 0.0
                break
    return iterations
