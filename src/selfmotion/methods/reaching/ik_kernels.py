"""Compiled kernels of the joint-limited inverse kinematics: one target, or a batch of them.

A target is solved by Levenberg-Marquardt steps inside the box of joint limits. Each step is the
weighted damped pseudo-inverse on the joints that are free to move; joints that the step would
push past a limit are set on it, and what they leave undone is shared by the others (active set).
All functions stand in this one (long) file, since numba's cache does not notice that a function
in another file has changed.
"""

from typing import Any

import numpy as np
from numba import njit

from selfmotion.kinematics.fast_position import sine_cosine
from selfmotion.methods.reaching.ik_arrays import (
    FREE_ROTATION,
    FULL_ROTATION,
    ONLY_PITCH,
    ONLY_ROLL,
    PITCH_FREE,
    ROLL_FREE,
    YAW_FREE,
    Work,
)

# Kernels do not allocate: without reference counts on their scratch arrays they run three times
# faster. Fused multiply-add is the one relaxation allowed; it keeps NaN as it is.
DRIVER: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},
}
KERNEL: dict[str, Any] = {**DRIVER, "_nrt": False}
# Damping of a step: this part of the squared error, and at least so much (m²).
DAMPING, LEAST_DAMPING = 1e-2, 1e-9
# A step moves no joint further than this (rad or m).
LONGEST_STEP = 1.2
# The posture is the nearest one when the squared gradient is below this part of the squared
# error, or when this many steps in a row leave more than this part of it.
STATIONARY, SLOW_STEPS = 1e-6, 2
# That part for a start among many, and for the last word on a target out of reach.
HASTY, PATIENT = 0.6, 0.98
# On a path: damping (squared rows over weight), longest step, and the step that counts as none.
PATH_DAMPING, LONGEST_PATH_STEP, STILL = 1e-10, 0.3, 1e-7
# Restarts from the nearest seeds; after them, so many seeds are passed over at each restart.
NEAREST_FIRST, SKIPPED = 6, 2


@njit(**DRIVER)
def make_work(n_path, n):
    """Allocate the scratch memory."""
    return Work(
        np.zeros(n_path),
        np.zeros(n_path),
        np.zeros(n_path),
        np.zeros(n_path),
        np.zeros((n_path, 3)),
        np.zeros((n_path, 3)),
        np.zeros((3, 4)),
        np.zeros(6),
        np.zeros((3, 3)),
        np.zeros((6, n)),
        np.zeros((6, 6)),
        np.zeros((6, 6)),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n, np.uint8),
        np.zeros(n),
        np.zeros((3, 3, 3)),
    )


@njit(**KERNEL)
def _curve(model, c, x):
    """Give value and slope of a piecewise polynomial."""
    breaks = model.curve_breaks[c]
    piece = 0
    while piece + 2 < breaks.shape[0] and x >= breaks[piece + 1] and breaks[piece + 2] < np.inf:
        piece += 1
    u = x - breaks[piece]
    value, slope = 0.0, 0.0
    for k in range(model.curve_coefficients.shape[1]):
        slope = slope * u + value
        value = value * u + model.curve_coefficients[c, k, piece]
    return value, slope


@njit(**KERNEL)
def joint_values(model, q, w):
    """Fill the values of the path's joints, then their sines and cosines."""
    lead, curve, offset, values = model.lead, model.curve, model.offset, w.values
    matrix, turning, angle_offset = model.matrix, model.turning, model.angle_offset
    sines, cosines = w.sines, w.cosines
    n_path = lead.shape[0]
    for i in range(n_path):
        if lead[i] >= 0:
            values[i] = q[lead[i]] + offset[i]
        elif curve[i] >= 0:
            c = curve[i]
            values[i], w.slope[i] = _curve(model, c, q[model.curve_lead[c]])
        else:
            value = offset[i]
            for j in range(q.shape[0]):
                value += matrix[i, j] * q[j]
            values[i] = value
    for i in range(n_path):
        sines[i], cosines[i] = sine_cosine(turning[i] * values[i] + angle_offset[i])


@njit(**KERNEL)
def forward(model, q, w):
    """Fill the axes and origins of the joints and the frame of the tip."""
    joint_values(model, q, w)
    shift, cos_twist, sin_twist, turning = (
        model.shift,
        model.cos_twist,
        model.sin_twist,
        model.turning,
    )
    axes, origins, values, sines, cosines = w.axes, w.origins, w.values, w.sines, w.cosines
    cb, sb = model.base[0], model.base[1]
    x0, x1, x2 = cb, sb, 0.0
    y0, y1, y2 = -sb, cb, 0.0
    z0, z1, z2 = 0.0, 0.0, 1.0
    p0, p1, p2 = 0.0, 0.0, 0.0
    for i in range(turning.shape[0]):
        a, b, d = shift[i, 0], shift[i, 1], shift[i, 2]
        p0 += x0 * a + y0 * b + z0 * d
        p1 += x1 * a + y1 * b + z1 * d
        p2 += x2 * a + y2 * b + z2 * d
        c, s = cos_twist[i], sin_twist[i]
        u0, u1, u2 = y0 * c + z0 * s, y1 * c + z1 * s, y2 * c + z2 * s
        z0, z1, z2 = z0 * c - y0 * s, z1 * c - y1 * s, z2 * c - y2 * s
        axes[i, 0], axes[i, 1], axes[i, 2] = z0, z1, z2
        origins[i, 0], origins[i, 1], origins[i, 2] = p0, p1, p2
        if turning[i] == 0.0:
            slide = values[i]
            p0, p1, p2 = p0 + z0 * slide, p1 + z1 * slide, p2 + z2 * slide
        c, s = cosines[i], sines[i]
        y0, y1, y2 = u0 * c - x0 * s, u1 * c - x1 * s, u2 * c - x2 * s
        x0, x1, x2 = x0 * c + u0 * s, x1 * c + u1 * s, x2 * c + u2 * s
    R, t, hand = model.tip_rotation, model.tip_position, w.hand
    for b in range(3):
        hand[0, b] = x0 * R[0, b] + y0 * R[1, b] + z0 * R[2, b]
        hand[1, b] = x1 * R[0, b] + y1 * R[1, b] + z1 * R[2, b]
        hand[2, b] = x2 * R[0, b] + y2 * R[1, b] + z2 * R[2, b]
    hand[0, 3] = p0 + x0 * t[0] + y0 * t[1] + z0 * t[2]
    hand[1, 3] = p1 + x1 * t[0] + y1 * t[1] + z1 * t[2]
    hand[2, 3] = p2 + x2 * t[0] + y2 * t[1] + z2 * t[2]


@njit(**KERNEL)
def _log(M, out):
    """Fill the rotation vector of a rotation matrix (3,3)."""
    v0, v1, v2 = M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]
    sine = 0.5 * np.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
    cosine = 0.5 * (M[0, 0] + M[1, 1] + M[2, 2] - 1.0)
    if cosine > 0.99999:
        f = 0.5 + sine * sine / 12.0
    elif sine > 1e-4:
        f = 0.5 * np.arctan2(sine, cosine) / sine
    else:  # half a turn: the axis is the largest column of M + I
        best = 0
        for a in range(3):
            if M[a, a] > M[best, best]:
                best = a
        length = np.sqrt(2.0 * (1.0 + M[best, best]))
        for a in range(3):
            out[a] = np.pi * (M[a, best] + (1.0 if a == best else 0.0)) / length
        return
    out[0], out[1], out[2] = f * v0, f * v1, f * v2


@njit(**KERNEL)
def _nearest_goal(R, goal, angles, mode, target):
    """Fill the rotation nearest to R among those that have the two held angles.

    Gives whether the free angle is held, too, since it is at the end of its range.
    """
    roll, yaw, held = angles[0], angles[2], False
    if mode == YAW_FREE:  # Rz(free) A with A = Rz(-yaw) goal: turn about the ground's z
        c = s = 0.0
        for k in range(3):
            c += goal[0, k] * R[0, k] + goal[1, k] * R[1, k]
            s += goal[0, k] * R[1, k] - goal[1, k] * R[0, k]
        h = max(np.hypot(c, s), 1e-300)
        c, s = c / h, s / h
        for k in range(3):
            target[0, k] = c * goal[0, k] - s * goal[1, k]
            target[1, k] = s * goal[0, k] + c * goal[1, k]
            target[2, k] = goal[2, k]
    elif mode == ROLL_FREE:  # goal Rx(free): turn about the hand's x
        c = s = 0.0
        for k in range(3):
            c += goal[k, 1] * R[k, 1] + goal[k, 2] * R[k, 2]
            s += goal[k, 2] * R[k, 1] - goal[k, 1] * R[k, 2]
        h = max(np.hypot(c, s), 1e-300)
        c, s = c / h, s / h
        for k in range(3):
            target[k, 0] = goal[k, 0]
            target[k, 1] = c * goal[k, 1] + s * goal[k, 2]
            target[k, 2] = -s * goal[k, 1] + c * goal[k, 2]
    else:  # Rz(yaw) Ry(free) Rx(roll)
        cy, sy, cr, sr = np.cos(yaw), np.sin(yaw), np.cos(roll), np.sin(roll)
        c = s = 0.0
        for k in range(3):  # M = Rz(-yaw) R Rx(-roll): trace with Ry(free)
            r0, r2 = cy * R[0, k] + sy * R[1, k], R[2, k]
            in0 = 1.0 if k == 0 else 0.0
            in2 = sr if k == 1 else (cr if k == 2 else 0.0)
            c += r0 * in0 + r2 * in2
            s += r0 * in2 - r2 * in0
        h = max(np.hypot(c, s), 1e-300)
        if c < 0.0:  # eq. 5 gives no pitch beyond a quarter turn
            c, s, held = 0.0, (1.0 if s >= 0.0 else -1.0), True
        else:
            c, s = c / h, s / h
        for k in range(3):
            in0 = c if k == 0 else s * (sr if k == 1 else cr)
            in1 = 0.0 if k == 0 else (cr if k == 1 else -sr)
            in2 = -s if k == 0 else c * (sr if k == 1 else cr)
            target[0, k] = cy * in0 - sy * in1
            target[1, k] = sy * in0 + cy * in1
            target[2, k] = in2
    return held


@njit(**KERNEL)
def _one_angle(R, angles, mode, e, turn):
    """Fill error and direction of one held angle; the error is an angle on the rotation group."""
    if mode == ONLY_PITCH:
        h = np.hypot(R[0, 0], R[1, 0])
        e[0] = angles[1] - np.arctan2(-R[2, 0], h)
        if h > 1e-9:
            turn[0, 0], turn[0, 1], turn[0, 2] = -R[1, 0] / h, R[0, 0] / h, 0.0
        else:  # gimbal lock: any horizontal axis serves
            turn[0, 0], turn[0, 1], turn[0, 2] = R[0, 1], R[1, 1], 0.0
        return
    if mode == ONLY_ROLL:  # the hand's direction that must be level, and up
        c, s = np.cos(angles[0]), np.sin(angles[0])
        d0, d1, d2 = c * R[0, 1] - s * R[0, 2], c * R[1, 1] - s * R[1, 2], c * R[2, 1] - s * R[2, 2]
        height, upright = d2, s * R[2, 1] + c * R[2, 2]
        a0, a1, a2 = d1, -d0, 0.0
    else:  # the hand's x must stay in the upright plane of the yaw
        c, s = np.cos(angles[2]), np.sin(angles[2])
        height = -s * R[0, 0] + c * R[1, 0]
        upright = c * R[0, 0] + s * R[1, 0]
        a0, a1, a2 = -R[2, 0] * c, -R[2, 0] * s, R[0, 0] * c + R[1, 0] * s
    if upright < 0.0:  # the same line the other way round: the nearest way is over gimbal lock
        h = max(np.hypot(R[0, 0], R[1, 0]), 1e-12)
        side = 1.0 if R[2, 0] >= 0.0 else -1.0
        e[0] = np.arctan2(h, abs(R[2, 0]))
        turn[0, 0], turn[0, 1], turn[0, 2] = side * R[1, 0] / h, -side * R[0, 0] / h, 0.0
        return
    cosine = np.sqrt(max(1.0 - height * height, 1e-12))
    e[0] = -np.arctan2(height, cosine)
    turn[0, 0], turn[0, 1], turn[0, 2] = a0 / cosine, a1 / cosine, a2 / cosine


@njit(**KERNEL)
def rotation_rows(R, goal, angles, mode, e, turn, scratch):
    """Fill errors e and directions `turn` (rows . angular velocity closes e); give their number.

    With two angles held, the error is the turn to the nearest rotation that has both, read along
    the two directions that change them. A free pitch has a third row, which is nothing unless
    the pitch is at the end of its range.
    """
    if mode == FREE_ROTATION:
        return 0
    if mode >= ONLY_PITCH:
        _one_angle(R, angles, mode, e, turn)
        return 1
    target, M, log = scratch[0], scratch[1], scratch[2, 0]
    if mode == FULL_ROTATION:
        for a in range(3):
            for b in range(3):
                target[a, b] = goal[a, b]
        at_end = False
    else:
        at_end = _nearest_goal(R, goal, angles, mode, target)
    for a in range(3):
        for b in range(3):
            M[a, b] = target[a, 0] * R[b, 0] + target[a, 1] * R[b, 1] + target[a, 2] * R[b, 2]
    _log(M, log)
    for a in range(3):
        for b in range(3):
            turn[a, b] = 0.0
    if mode == FULL_ROTATION:
        for a in range(3):
            e[a] = log[a]
            turn[a, a] = 1.0
        return 3
    if mode == YAW_FREE:
        turn[0, 0] = turn[1, 1] = 1.0
    elif mode == ROLL_FREE:
        cp, sp, cy, sy = np.cos(angles[1]), np.sin(angles[1]), np.cos(angles[2]), np.sin(angles[2])
        turn[0, 0], turn[0, 1] = -sy, cy
        turn[1, 0], turn[1, 1], turn[1, 2] = cy * sp, sy * sp, cp
    else:
        c, s = np.cos(angles[2]), np.sin(angles[2])
        turn[0, 0], turn[0, 1], turn[1, 2] = c, s, 1.0
        if at_end:
            turn[2, 0], turn[2, 1] = -s, c
    n = 3 if mode == PITCH_FREE else 2
    for a in range(n):
        e[a] = turn[a, 0] * log[0] + turn[a, 1] * log[1] + turn[a, 2] * log[2]
    return n


@njit(**KERNEL)
def residual(rows, position, rotation, angles, w):
    """Fill the scaled error of the held rows; give squared position and rotation errors."""
    axes, hand, error, scale = rows.axes, w.hand, w.error, rows.scale
    n_held = axes.shape[0]
    near = 0.0
    for r in range(n_held):
        e = position[axes[r]] - hand[axes[r], 3]
        error[r] = e
        near += e * e
    turned = 0.0
    if rows.rotation != FREE_ROTATION:
        k = rotation_rows(hand, rotation, angles, rows.rotation, error[n_held:], w.turn, w.scratch)
        for r in range(n_held, n_held + k):
            turned += error[r] * error[r]
            error[r] *= scale
    return near, turned


@njit(**KERNEL)
def n_rows(rows):
    """Give the number of held rows."""
    k = rows.axes.shape[0]
    if rows.rotation == FREE_ROTATION:
        return k
    if rows.rotation == FULL_ROTATION or rows.rotation == PITCH_FREE:
        return k + 3
    return k + (1 if rows.rotation >= ONLY_PITCH else 2)


@njit(**KERNEL)
def task_jacobian(model, rows, w):
    """Fill the Jacobian of the scaled rows from the axes, origins and directions at hand."""
    held, scale, matrix = rows.axes, rows.scale, model.matrix
    lead, curve, turning = model.lead, model.curve, model.turning
    axes, origins, turn, column, J = w.axes, w.origins, w.turn, w.column, w.J
    x0, x1, x2 = w.hand[0, 3], w.hand[1, 3], w.hand[2, 3]
    m, n_held, n = n_rows(rows), held.shape[0], matrix.shape[1]
    for r in range(m):
        for j in range(n):
            J[r, j] = 0.0
    for i in range(lead.shape[0]):
        z0, z1, z2 = axes[i, 0], axes[i, 1], axes[i, 2]
        if turning[i] == 0.0:
            v0, v1, v2 = z0, z1, z2
            z0, z1, z2 = 0.0, 0.0, 0.0
        else:
            d0, d1, d2 = x0 - origins[i, 0], x1 - origins[i, 1], x2 - origins[i, 2]
            v0, v1, v2 = z1 * d2 - z2 * d1, z2 * d0 - z0 * d2, z0 * d1 - z1 * d0
        for r in range(n_held):
            a = held[r]
            column[r] = v0 if a == 0 else (v1 if a == 1 else v2)
        for r in range(m - n_held):
            column[n_held + r] = scale * (turn[r, 0] * z0 + turn[r, 1] * z1 + turn[r, 2] * z2)
        if lead[i] >= 0:
            for r in range(m):
                J[r, lead[i]] += column[r]
        elif curve[i] >= 0:
            for r in range(m):
                J[r, model.curve_lead[curve[i]]] += column[r] * w.slope[i]
        else:
            for j in range(n):
                for r in range(m):
                    J[r, j] += column[r] * matrix[i, j]


@njit(**KERNEL)
def normal_matrix(J, m, free, mobility, damping, A):
    """Fill the lower triangle of J D Jᵀ + damping I over the free joints."""
    for a in range(m):
        for b in range(a):
            A[a, b] = 0.0
        A[a, a] = damping
    for j in range(J.shape[1]):
        if free[j]:
            add_joint(J, m, j, mobility[j], A)


@njit(**KERNEL)
def add_joint(J, m, j, factor, A):
    """Add a joint's part to the lower triangle of J D Jᵀ; take it away with a factor below 0."""
    for a in range(m):
        f = factor * J[a, j]
        for b in range(a + 1):
            A[a, b] += f * J[b, j]


@njit(**KERNEL)
def solve_positive(A, m, right, L, y):
    """Solve A y = right by Cholesky; A (lower triangle) stays, L is filled."""
    for a in range(m):
        for b in range(a):
            v = A[a, b]
            for k in range(b):
                v -= L[a, k] * L[b, k]
            L[a, b] = v * L[b, b]
        v = A[a, a]
        for k in range(a):
            v -= L[a, k] * L[a, k]
        L[a, a] = 1.0 / np.sqrt(max(v, 1e-300))  # the diagonal of L is kept inverted
        v = right[a]
        for k in range(a):
            v -= L[a, k] * y[k]
        y[a] = v * L[a, a]
    for a in range(m - 1, -1, -1):
        v = y[a]
        for k in range(a + 1, m):
            v -= L[k, a] * y[k]
        y[a] = v * L[a, a]


@njit(**KERNEL)
def bounded_step(model, rows, q, damping, w):
    """Fill the step: damped pseudo-inverse inside the limits. Give the gradient's length.

    The gradient is that of the joints that may move: 0 at the posture nearest to the target.
    """
    lower, upper, mobility, J, error = model.lower, model.upper, rows.mobility, w.J, w.error
    free, step, rest, y = w.free, w.step, w.rest, w.y
    m, n = n_rows(rows), q.shape[0]
    slope = 0.0
    for j in range(n):
        g = 0.0
        for r in range(m):
            g += J[r, j] * error[r]
        blocked = (g < 0.0 and q[j] <= lower[j]) or (g > 0.0 and q[j] >= upper[j])
        free[j] = 0 if blocked else 1
        step[j] = 0.0
        if not blocked:
            slope += mobility[j] * g * g
    for r in range(m):
        rest[r] = error[r]
    A, L = w.A, w.L
    normal_matrix(J, m, free, mobility, damping, A)
    for _ in range(n):
        solve_positive(A, m, rest, L, y)
        clamped = False
        for j in range(n):
            if not free[j]:
                continue
            d = 0.0
            for r in range(m):
                d += J[r, j] * y[r]
            d *= mobility[j]
            step[j] = d
            low, high = lower[j] - q[j], upper[j] - q[j]
            if d < low or d > high:
                step[j] = low if d < low else high
                free[j] = 0
                clamped = True
                add_joint(J, m, j, -mobility[j], A)
                for r in range(m):
                    rest[r] -= J[r, j] * step[j]
        if not clamped:
            break
    return slope


@njit(**KERNEL)
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
    while evaluation < most:
        if near <= near2 and turned <= turn2:
            return near, turned, evaluation, True
        task_jacobian(model, rows, w)
        for r in range(m):
            rest[r] = error[r]
        while True:
            slope = bounded_step(model, rows, q, factor * DAMPING * cost + LEAST_DAMPING, w)
            if slope <= STATIONARY * cost:
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


@njit(**KERNEL)
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


@njit(**KERNEL)
def _next_seed(scores):
    """Give the place of the least score."""
    pick = 0
    for i in range(scores.shape[0]):
        if scores[i] < scores[pick]:
            pick = i
    return pick


@njit(**KERNEL)
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


@njit(**DRIVER)
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


@njit(**DRIVER)
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


@njit(**KERNEL)
def centred_step(model, q, mobility, centre, m, w):
    """Fill the step of least ``½ Σ h (q + step - centre)²`` that closes the error in the limits.

    `mobility` is 1/h. Joints that pass a limit are set on it, in turn.
    """
    lower, upper, J, free = model.lower, model.upper, w.J, w.free
    step, rest, wanted, y, A, L = w.step, w.rest, w.q, w.y, w.A, w.L
    n = q.shape[0]
    largest = 0.0
    for r in range(m):
        rest[r] = w.error[r]
    for j in range(n):
        largest = max(largest, mobility[j])
        wanted[j] = min(max(centre[j], lower[j]), upper[j]) - q[j]
        free[j] = 1
        for r in range(m):
            rest[r] -= J[r, j] * wanted[j]
    normal_matrix(J, m, free, mobility, PATH_DAMPING * largest, A)
    for _ in range(n):
        solve_positive(A, m, rest, L, y)
        clamped = False
        for j in range(n):
            if not free[j]:
                continue
            d = 0.0
            for r in range(m):
                d += J[r, j] * y[r]
            d = wanted[j] + mobility[j] * d
            low, high = lower[j] - q[j], upper[j] - q[j]
            if d < low or d > high:
                d = low if d < low else high
                free[j] = 0
                clamped = True
                add_joint(J, m, j, -mobility[j], A)
                for r in range(m):
                    rest[r] -= J[r, j] * (d - wanted[j])
            step[j] = d
        if not clamped:
            break


@njit(**KERNEL)
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


@njit(**DRIVER)
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
