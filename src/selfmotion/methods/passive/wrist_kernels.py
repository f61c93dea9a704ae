"""Compiled passive motion of the wrist of [Tommasino2017] eq. 6 towards fixed targets.

The same equation and the same steps as in :mod:`selfmotion.methods.passive.kernels`, written
out for three joints and two rows: ten times as fast. All functions live in this one file, since
numba's cache does not notice a change in a function that another file calls.
"""

import numpy as np
from numba import njit

from selfmotion.methods.passive.arrays import (
    DONE,
    MAX_STEPS,
    PIVOT_TOLERANCE,
    RANK_LOST,
    STEP_RATE,
    TOO_STIFF,
)


@njit(cache=True)
def wrist_rows(q):
    """Give x1, x2 of eq. 6 for d = 1 m, and the six entries of its Jacobian."""
    cp, sp = np.cos(q[0]), np.sin(q[0])
    cf, sf = np.cos(q[1]), np.sin(q[1])
    cr, sr = np.cos(q[2]), np.sin(q[2])
    across = sf * cr  # of the pointing direction, before pronation turns it
    x1, x2 = -(across * cp - sr * sp), -(across * sp + sr * cp)
    flexing, deviating = cf * cr, sf * sr
    return (
        (x1, x2),
        (-x2, -flexing * cp, deviating * cp + cr * sp),
        (x1, -flexing * sp, deviating * sp - cr * cp),
    )


@njit(cache=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _apply(rows, v):
    return _dot(rows[0], v), _dot(rows[1], v), _dot(rows[2], v)


@njit(cache=True)
def _rows(matrix):
    return (
        (matrix[0, 0], matrix[0, 1], matrix[0, 2]),
        (matrix[1, 0], matrix[1, 1], matrix[1, 2]),
        (matrix[2, 0], matrix[2, 1], matrix[2, 2]),
    )


@njit(cache=True)
def wrist_velocity(q, joints, pull, growth):
    """Give q̇, whether J has its rank, the spring's fastest rate at full growth, x and ẋ.

    All on tuples, which stay in registers: `joints` is (W⁻¹, W⁻¹K^J, q*, e, s), `pull` is
    (K11, K12, K22, x_d).
    """
    admittance, relaxation, rest, e, s = joints
    x, a, b = wrist_rows(q)
    v = _apply(relaxation, (q[0] - rest[0], q[1] - rest[1], q[2] - rest[2]))
    ma, mb = _apply(admittance, a), _apply(admittance, b)
    aa, ab, bb = _dot(a, ma), _dot(a, mb), _dot(b, mb)
    k11, k12, k22, goal = pull
    e1, e2 = goal[0] - x[0], goal[1] - x[1]
    f1, f2 = growth * (k11 * e1 + k12 * e2), growth * (k12 * e1 + k22 * e2)
    whole = True
    area = aa * bb - ab * ab
    if s != 0.0:
        p1, p2 = s * _dot(a, v), s * _dot(b, v)
        least = PIVOT_TOLERANCE * aa * bb
        if not area > least:
            whole, area = False, max(least, 1e-300)
        f1 += (bb * p1 - ab * p2) / area
        f2 += (aa * p2 - ab * p1) / area
    velocity = (
        ma[0] * f1 + mb[0] * f2 - e * v[0],
        ma[1] * f1 + mb[1] * f2 - e * v[1],
        ma[2] * f1 + mb[2] * f2 - e * v[2],
    )
    # The larger eigenvalue of K A: both matrices are positive semi-definite.
    half = 0.5 * (k11 * aa + 2.0 * k12 * ab + k22 * bb)
    product = (k11 * k22 - k12 * k12) * area
    fastest = half + np.sqrt(max(half * half - product, 0.0))
    return velocity, whole, fastest, x, (_dot(a, velocity), _dot(b, velocity))


@njit(cache=True)
def _ahead(q, h, v):
    return q[0] + h * v[0], q[1] + h * v[1], q[2] + h * v[2]


@njit(cache=True)
def _growth(t, time_constant):
    """Give the share of the spring that has grown at time t, eq. 8."""
    if time_constant <= 0.0:
        return 1.0
    r = t / time_constant
    return 1.0 - np.exp(-r) * (1.0 + r)


@njit(cache=True)
def _movement(law, drive, movement, q_out, qd_out, x_out, xd_out):
    """Integrate one movement; give DONE, TOO_STIFF or RANK_LOST and the time it happened."""
    joints = (
        _rows(law.admittance),
        _rows(law.relaxation),
        (law.rest[0], law.rest[1], law.rest[2]),
        law.elastic,
        law.elastic * law.blocked,
    )
    slow, tau, K = law.elastic * law.slow_rate, law.spring_time, drive.spring[movement]
    q = (drive.start[movement, 0], drive.start[movement, 1], drive.start[movement, 2])
    interval = drive.duration / drive.n_steps
    code, when = DONE, 0.0
    goal = (drive.points[movement, 0, 0], drive.points[movement, 0, 1])
    pull = (K[0, 0], K[0, 1], K[1, 1], goal)
    growth = _growth(0.0, tau)
    k1, whole, rate, x, xd = wrist_velocity(q, joints, pull, growth)
    for step in range(drive.n_steps + 1):
        if not whole and code == DONE:
            code, when = RANK_LOST, step * interval
        for i in range(3):
            q_out[step, i], qd_out[step, i] = q[i], k1[i]
        for a in range(2):
            x_out[step, a], xd_out[step, a] = x[a], xd[a]
        if step == drive.n_steps:
            break
        bound = _growth((step + 1) * interval, tau) * rate + slow
        n_steps = max(1, int(np.ceil(min(bound * interval / STEP_RATE, 1e6))))
        if n_steps > MAX_STEPS or not np.isfinite(bound):
            return TOO_STIFF, step * interval
        h = interval / n_steps
        for sub in range(n_steps):
            t = step * interval + sub * h
            growth = _growth(t + 0.5 * h, tau)
            k2 = wrist_velocity(_ahead(q, 0.5 * h, k1), joints, pull, growth)[0]
            k3 = wrist_velocity(_ahead(q, 0.5 * h, k2), joints, pull, growth)[0]
            growth = _growth(t + h, tau)
            k4 = wrist_velocity(_ahead(q, h, k3), joints, pull, growth)[0]
            q = (
                q[0] + h / 6.0 * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]),
                q[1] + h / 6.0 * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]),
                q[2] + h / 6.0 * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2]),
            )
            k1, whole, rate, x, xd = wrist_velocity(q, joints, pull, growth)
    return code, when


@njit(cache=True, nogil=True)
def integrate(law, drive, out, begin, end):
    """Integrate movements begin to end into `out`; it holds no lock, so that threads share them."""
    for b in range(begin, end):
        out.code[b], out.when[b] = _movement(
            law, drive, b, out.q[b], out.qd[b], out.x[b], out.xd[b]
        )
