"""Compiled kernels of inverse kinematics: rows of the task, and steps inside the joint limits.

A step is the weighted damped pseudo-inverse on the joints that are free to move; joints that it
would push past a limit are set on it, and what they leave undone is shared by the others (active
set).
"""

import numpy as np

from selfmotion.kinematics.compiled import compiled
from selfmotion.methods.reaching import ik_rotation
from selfmotion.methods.reaching.ik_arrays import (
    FREE_ROTATION,
    FULL_ROTATION,
    KERNEL,
    ONLY_PITCH,
    PITCH_FREE,
)
from selfmotion.methods.reaching.ik_rotation import rotation_rows

CALLED = (*ik_rotation.CALLED, ik_rotation)
# Damping of a step along a path (squared rows over weight).
PATH_DAMPING = 1e-10


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
def n_rows(rows):
    """Give the number of held rows."""
    k = rows.axes.shape[0]
    if rows.rotation == FREE_ROTATION:
        return k
    if rows.rotation == FULL_ROTATION or rows.rotation == PITCH_FREE:
        return k + 3
    return k + (1 if rows.rotation >= ONLY_PITCH else 2)


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
def normal_matrix(J, m, free, mobility, damping, A):
    """Fill the lower triangle of J D Jᵀ + damping I over the free joints."""
    for a in range(m):
        for b in range(a):
            A[a, b] = 0.0
        A[a, a] = damping
    for j in range(J.shape[1]):
        if free[j]:
            add_joint(J, m, j, mobility[j], A)


@compiled(*CALLED, **KERNEL)
def add_joint(J, m, j, factor, A):
    """Add a joint's part to the lower triangle of J D Jᵀ; take it away with a factor below 0."""
    for a in range(m):
        f = factor * J[a, j]
        for b in range(a + 1):
            A[a, b] += f * J[b, j]


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
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
