"""Compiled kernels of inverse kinematics: orientation errors on the rotation group.

Any of roll, pitch and yaw may be held. An error is the least turn to an orientation that has the
angles held, so that it neither aliases nor stalls at gimbal lock.
"""

import numpy as np

from selfmotion.kinematics.compiled import compiled
from selfmotion.methods.reaching import ik_arrays
from selfmotion.methods.reaching.ik_arrays import (
    FREE_ROTATION,
    FULL_ROTATION,
    KERNEL,
    ONLY_PITCH,
    ONLY_ROLL,
    PITCH_FREE,
    ROLL_FREE,
    YAW_FREE,
)

CALLED = (ik_arrays,)


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
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


@compiled(*CALLED, **KERNEL)
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
