"""Compiled kernels: frames of all bodies, gravity torque, inertia matrix.

All of them work on `ZFrames`, where each joint axis is the z axis of its frame, and on values of
all N joints; coupling to free coordinates is applied by the callers. They share one file, since
numba's cache does not notice a change in a function that another file calls.
"""

import numpy as np
from numba import njit

GROUND = -1
REVOLUTE = 0


@njit(cache=True)
def _frames_of_sample(parent, joint_type, rotations, translations, values, R, p):
    """Fill R (N,3,3) and p (N,3): world frames of all joints for one sample."""
    for i in range(parent.shape[0]):
        j = parent[i]
        R0 = rotations[i]
        t0 = translations[i]
        for a in range(3):
            if j == GROUND:
                p[i, a] = t0[a]
                R[i, a, 0], R[i, a, 1], R[i, a, 2] = R0[a, 0], R0[a, 1], R0[a, 2]
            else:
                r0, r1, r2 = R[j, a, 0], R[j, a, 1], R[j, a, 2]
                p[i, a] = p[j, a] + r0 * t0[0] + r1 * t0[1] + r2 * t0[2]
                for b in range(3):
                    R[i, a, b] = r0 * R0[0, b] + r1 * R0[1, b] + r2 * R0[2, b]
        if joint_type[i] == REVOLUTE:
            c, s = np.cos(values[i]), np.sin(values[i])
            for a in range(3):
                x, y = R[i, a, 0], R[i, a, 1]
                R[i, a, 0] = c * x + s * y
                R[i, a, 1] = c * y - s * x
        else:
            for a in range(3):
                p[i, a] += R[i, a, 2] * values[i]


@njit(cache=True)
def body_frames(parent, joint_type, rotations, translations, values):
    """Give world frames of all joints: R (K,N,3,3) and p (K,N,3) for values (K,N)."""
    n_samples, n_joints = values.shape
    R = np.empty((n_samples, n_joints, 3, 3))
    p = np.empty((n_samples, n_joints, 3))
    for k in range(n_samples):
        _frames_of_sample(parent, joint_type, rotations, translations, values[k], R[k], p[k])
    return R, p


@njit(cache=True)
def _composite_bodies(parent, R, p, mass, com, inertia, m, h, inertia_o):
    """Fill mass, first moment and inertia about the world origin of each subtree."""
    n_joints = parent.shape[0]
    for i in range(n_joints):
        c = R[i] @ com[i] + p[i]
        I_world = R[i] @ inertia[i] @ R[i].T
        m[i] = mass[i]
        c2 = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
        for a in range(3):
            h[i, a] = mass[i] * c[a]
            for b in range(3):
                inertia_o[i, a, b] = I_world[a, b] - mass[i] * c[a] * c[b]
            inertia_o[i, a, a] += mass[i] * c2
    for i in range(n_joints - 1, -1, -1):
        j = parent[i]
        if j != GROUND:
            m[j] += m[i]
            for a in range(3):
                h[j, a] += h[i, a]
                for b in range(3):
                    inertia_o[j, a, b] += inertia_o[i, a, b]


@njit(cache=True)
def _cross(a, b):
    return np.array(
        (
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        )
    )


@njit(cache=True)
def gravity_and_inertia(
    parent, joint_type, rotations, translations, values, mass, com, inertia, gravity, M
):
    """Give gravity torque (K,N) and fill the inertia matrix M (K,N,N) unless that is empty.

    `com` (N,3) and `inertia` (N,3,3, about the centre of mass) are in the z-frames. The torque
    is what muscles must supply to hold the posture: minus the generalised force of gravity.
    """
    n_samples, n_joints = values.shape
    R, p = np.empty((n_joints, 3, 3)), np.empty((n_joints, 3))
    m, h = np.empty(n_joints), np.empty((n_joints, 3))
    inertia_o = np.empty((n_joints, 3, 3))
    w, v = np.empty((n_joints, 3)), np.empty((n_joints, 3))
    torque = np.empty((n_samples, n_joints))
    for k in range(n_samples):
        _frames_of_sample(parent, joint_type, rotations, translations, values[k], R, p)
        _composite_bodies(parent, R, p, mass, com, inertia, m, h, inertia_o)
        for i in range(n_joints):
            z = R[i, :, 2]
            if joint_type[i] == REVOLUTE:  # twist at the world origin
                w[i] = z
                v[i] = _cross(p[i], z)
            else:
                w[i] = 0.0
                v[i] = z
            moment = _cross(h[i], gravity)
            torque[k, i] = -(np.dot(w[i], moment) + m[i] * np.dot(v[i], gravity))
        if M.shape[0] == 0:
            continue
        M[k] = 0.0
        for j in range(n_joints):
            linear = m[j] * v[j] + _cross(w[j], h[j])
            angular = inertia_o[j] @ w[j] + _cross(h[j], v[j])
            i = j
            while i != GROUND:
                M[k, i, j] = np.dot(w[i], angular) + np.dot(v[i], linear)
                M[k, j, i] = M[k, i, j]
                i = parent[i]
    return torque
