"""Compiled passive motion: many movements of a serial chain, on all cores.

The equation is that of :mod:`selfmotion.methods.passive_motion` for constant damping W and an
elastic potential: with M = W⁻¹Jᵀ, A = J M = B⁻¹ and v = W⁻¹K^J(q - q*),

    q̇ = M (F + s A⁻¹ J v) - e v,        s = e for λ0-PMP and 0 otherwise.

Each output interval is divided so that one step of the classical Runge-Kutta method stays well
inside its stability region; where that would take too many steps the movement is handed back
as `TOO_STIFF`, and the caller uses an implicit method. All functions live in this one file, since
numba's cache does not notice a change in a function that another file calls.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from selfmotion.methods.passive.arrays import (
    DONE,
    MAX_STEPS,
    PIVOT_TOLERANCE,
    POSITION,
    RANK_LOST,
    REVOLUTE,
    STEP_RATE,
    TOO_STIFF,
)


class _Work(NamedTuple):
    frame: np.ndarray  # (3, 3)
    axes: np.ndarray  # (P, 3)
    origins: np.ndarray  # (P, 3)
    jac_joint: np.ndarray  # (m, P)
    jac: np.ndarray  # (m, n)
    through: np.ndarray  # (n, m) M
    mobility: np.ndarray  # (m, m) A
    factor: np.ndarray  # (m, m)
    x: np.ndarray  # (m,)
    force: np.ndarray  # (m,)
    sight: np.ndarray  # (2m + 1,)
    v: np.ndarray  # (n,)


@njit(cache=True)
def _work(n_joints, m, n):
    return _Work(
        np.empty((3, 3)),
        np.empty((n_joints, 3)),
        np.empty((n_joints, 3)),
        np.empty((m, n_joints)),
        np.empty((m, n)),
        np.empty((n, m)),
        np.empty((m, m)),
        np.empty((m, m)),
        np.empty(m),
        np.empty(m),
        np.empty(2 * m + 1),
        np.empty(n),
    )


@njit(cache=True)
def _chain(task, q, w):
    """Fill x and J of a pointing or position task of a chain."""
    n_joints, n = task.matrix.shape
    m = task.rows.shape[0]
    R, p0, p1, p2 = w.frame, 0.0, 0.0, 0.0
    for a in range(3):
        for b in range(3):
            R[a, b] = 1.0 if a == b else 0.0
    for i in range(n_joints):
        value = task.offset[i]
        for j in range(n):
            value += task.matrix[i, j] * q[j]
        t, R0 = task.translations[i], task.rotations[i]
        p0 += R[0, 0] * t[0] + R[0, 1] * t[1] + R[0, 2] * t[2]
        p1 += R[1, 0] * t[0] + R[1, 1] * t[1] + R[1, 2] * t[2]
        p2 += R[2, 0] * t[0] + R[2, 1] * t[1] + R[2, 2] * t[2]
        turning = task.joint_type[i] == REVOLUTE
        c, s = (np.cos(value), np.sin(value)) if turning else (1.0, 0.0)
        for a in range(3):
            r0, r1, r2 = R[a, 0], R[a, 1], R[a, 2]
            x = r0 * R0[0, 0] + r1 * R0[1, 0] + r2 * R0[2, 0]
            y = r0 * R0[0, 1] + r1 * R0[1, 1] + r2 * R0[2, 1]
            R[a, 0], R[a, 1] = c * x + s * y, c * y - s * x
            R[a, 2] = r0 * R0[0, 2] + r1 * R0[1, 2] + r2 * R0[2, 2]
            w.axes[i, a] = R[a, 2]
        if not turning:
            p0 += R[0, 2] * value
            p1 += R[1, 2] * value
            p2 += R[2, 2] * value
        w.origins[i, 0], w.origins[i, 1], w.origins[i, 2] = p0, p1, p2
    t = task.point
    e0 = R[0, 0] * t[0] + R[0, 1] * t[1] + R[0, 2] * t[2]
    e1 = R[1, 0] * t[0] + R[1, 1] * t[1] + R[1, 2] * t[2]
    e2 = R[2, 0] * t[0] + R[2, 1] * t[1] + R[2, 2] * t[2]
    position = task.kind == POSITION
    if position:
        e0, e1, e2 = e0 + p0, e1 + p1, e2 + p2
    for a in range(m):
        w.x[a] = task.rows[a, 0] * e0 + task.rows[a, 1] * e1 + task.rows[a, 2] * e2
    for i in range(n_joints):
        zx, zy, zz = w.axes[i, 0], w.axes[i, 1], w.axes[i, 2]
        gx, gy, gz = 0.0, 0.0, 0.0
        if task.joint_type[i] == REVOLUTE:
            dx, dy, dz = e0, e1, e2
            if position:
                dx, dy, dz = dx - w.origins[i, 0], dy - w.origins[i, 1], dz - w.origins[i, 2]
            gx, gy, gz = zy * dz - zz * dy, zz * dx - zx * dz, zx * dy - zy * dx
        elif position:
            gx, gy, gz = zx, zy, zz
        for a in range(m):
            w.jac_joint[a, i] = task.rows[a, 0] * gx + task.rows[a, 1] * gy + task.rows[a, 2] * gz
    for a in range(m):
        for j in range(n):
            total = 0.0
            for i in range(n_joints):
                total += w.jac_joint[a, i] * task.matrix[i, j]
            w.jac[a, j] = total


@njit(cache=True)
def _factorise(A, L):
    """Fill the Cholesky factor of A; False where a pivot vanishes (J has lost rank)."""
    m = A.shape[0]
    whole = True
    for i in range(m):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            if i == j:
                least = PIVOT_TOLERANCE * A[i, i]
                if not total > least:
                    whole = False
                    total = max(least, 1e-300)
                L[i, i] = np.sqrt(total)
            else:
                L[i, j] = total / L[j, j]
    return whole


@njit(cache=True)
def _solve(L, b):
    """Overwrite b with the solution of L Lᵀ y = b."""
    m = b.shape[0]
    for i in range(m):
        for k in range(i):
            b[i] -= L[i, k] * b[k]
        b[i] /= L[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            b[i] -= L[k, i] * b[k]
        b[i] /= L[i, i]


@njit(cache=True)
def growth_at(t, time_constant):
    """Give the share of the spring that has grown at time t, eq. 8."""
    if time_constant <= 0.0:
        return 1.0
    r = t / time_constant
    return 1.0 - np.exp(-r) * (1.0 + r)


@njit(cache=True)
def _sight(drive, movement, t, sight):
    """Fill the point that the spring is tied to at time t, its velocity, and the follow flag."""
    points = drive.points[movement]
    m = points.shape[1]
    sight[2 * m] = drive.follow
    if points.shape[0] == 1:
        for a in range(m):
            sight[a] = points[0, a]
            sight[m + a] = 0.0
        return
    h = drive.duration / drive.n_steps
    i = min(max(int(t / h), 0), drive.n_steps - 1)
    u = t / h - i
    speeds = drive.velocities[movement]
    for a in range(m):  # cubic Hermite between the points given
        y0, y1, d0, d1 = points[i, a], points[i + 1, a], h * speeds[i, a], h * speeds[i + 1, a]
        c2, c3 = 3.0 * (y1 - y0) - 2.0 * d0 - d1, 2.0 * (y0 - y1) + d0 + d1
        sight[a] = y0 + u * (d0 + u * (c2 + u * c3))
        sight[m + a] = (d0 + u * (2.0 * c2 + 3.0 * u * c3)) / h


@njit(cache=True)
def _velocity(task, law, drive, movement, t, q, w, out):
    """Fill out with q̇ and w with x, J; give if J has its rank, and the grown spring's rate."""
    m, n = w.jac.shape
    growth = growth_at(t, law.spring_time)
    K = drive.spring[movement]
    _sight(drive, movement, t, w.sight)
    _chain(task, q, w)
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += law.relaxation[i, j] * (q[j] - law.rest[j])
        w.v[i] = total
        for a in range(m):
            total = 0.0
            for j in range(n):
                total += law.admittance[i, j] * w.jac[a, j]
            w.through[i, a] = total
    for a in range(m):
        for b in range(a + 1):
            total = 0.0
            for i in range(n):
                total += w.jac[a, i] * w.through[i, b]
            w.mobility[a, b] = total
            w.mobility[b, a] = total
    needs_solve = law.blocked * law.elastic != 0.0 or drive.follow != 0.0
    whole = True
    if needs_solve:
        for a in range(m):
            total = drive.follow * w.sight[m + a]
            for i in range(n):
                total += law.blocked * law.elastic * w.jac[a, i] * w.v[i]
            w.force[a] = total
        whole = _factorise(w.mobility, w.factor)
        _solve(w.factor, w.force)
    else:
        for a in range(m):
            w.force[a] = 0.0
    fastest = 0.0
    for a in range(m):
        pull, rate = 0.0, 0.0
        for b in range(m):
            pull += K[a, b] * (w.sight[b] - w.x[b])
            total = 0.0
            for c in range(m):
                total += K[a, c] * w.mobility[c, b]
            rate += abs(total)
        w.force[a] += growth * pull
        fastest = max(fastest, rate)
    for i in range(n):
        total = -law.elastic * w.v[i]
        for a in range(m):
            total += w.through[i, a] * w.force[a]
        out[i] = total
    return whole, fastest


@njit(cache=True)
def _store(w, q, velocity, q_out, qd_out, x_out, xd_out):
    """Copy one sample to the output."""
    m, n = w.jac.shape
    for i in range(n):
        q_out[i], qd_out[i] = q[i], velocity[i]
    for a in range(m):
        total = 0.0
        for i in range(n):
            total += w.jac[a, i] * velocity[i]
        x_out[a], xd_out[a] = w.x[a], total


@njit(cache=True)
def _movement(task, law, drive, movement, q_out, qd_out, x_out, xd_out):
    """Integrate one movement; give DONE, TOO_STIFF or RANK_LOST and the time it happened."""
    n, m = drive.start.shape[1], task.rows.shape[0]
    w = _work(task.matrix.shape[0], m, n)
    k1, k2, k3, k4, stage = (np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n))
    q = drive.start[movement].copy()
    interval = drive.duration / drive.n_steps
    code, when = DONE, 0.0
    whole, rate = _velocity(task, law, drive, movement, 0.0, q, w, k1)
    for step in range(drive.n_steps + 1):
        if not whole and code == DONE:
            code, when = RANK_LOST, step * interval
        _store(w, q, k1, q_out[step], qd_out[step], x_out[step], xd_out[step])
        if step == drive.n_steps:
            break
        # The spring is stiffest at the end of the interval.
        growth = growth_at((step + 1) * interval, law.spring_time)
        bound = growth * rate + law.elastic * law.slow_rate
        n_steps = max(1, int(np.ceil(min(bound * interval / STEP_RATE, 1e6))))
        if n_steps > MAX_STEPS or not np.isfinite(bound):
            return TOO_STIFF, step * interval
        h = interval / n_steps
        for sub in range(n_steps):
            t = step * interval + sub * h
            if sub > 0:
                _velocity(task, law, drive, movement, t, q, w, k1)
            for i in range(n):
                stage[i] = q[i] + 0.5 * h * k1[i]
            _velocity(task, law, drive, movement, t + 0.5 * h, stage, w, k2)
            for i in range(n):
                stage[i] = q[i] + 0.5 * h * k2[i]
            _velocity(task, law, drive, movement, t + 0.5 * h, stage, w, k3)
            for i in range(n):
                stage[i] = q[i] + h * k3[i]
            _velocity(task, law, drive, movement, t + h, stage, w, k4)
            for i in range(n):
                q[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
        whole, rate = _velocity(task, law, drive, movement, (step + 1) * interval, q, w, k1)
    return code, when


@njit(cache=True, nogil=True)
def integrate(task, law, drive, out, begin, end):
    """Integrate movements begin to end into `out`; it holds no lock, so that threads share them."""
    for b in range(begin, end):
        q, qd, x, xd = out.q[b], out.qd[b], out.x[b], out.xd[b]
        out.code[b], out.when[b] = _movement(task, law, drive, b, q, qd, x, xd)


@njit(cache=True)
def velocity_at(task, law, drive, movement, t, q):
    """Give q̇ of one movement at time t and posture q (n,): for other integrators."""
    out = np.empty(q.shape[0])
    w = _work(task.matrix.shape[0], task.rows.shape[0], q.shape[0])
    _velocity(task, law, drive, movement, t, q, w, out)
    return out
