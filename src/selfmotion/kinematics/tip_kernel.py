"""Compiled kernel of one tip: its frames and its Jacobian, for a block of samples at once.

As in `fast_position`, every step is arithmetic on neighbouring numbers (structure of arrays) that
the compiler turns into vector instructions; here from the ground to the hand, since the Jacobian
needs the axis and the origin of each joint on the way. The three world coordinates of axes and
origins never mix, so each is carried by itself.
"""

from typing import Any, NamedTuple

import numpy as np

from selfmotion.kinematics import sine_cosine as trigonometry
from selfmotion.kinematics.compiled import compiled
from selfmotion.kinematics.sine_cosine import FAR, sine_cosine

GROUND = -1
REVOLUTE = 0
# Samples in a block: axes and origins of nine joints stay in the first-level cache.
BLOCK = 64

_KERNEL: dict[str, Any] = {"nogil": True, "fastmath": {"contract"}, "error_model": "numpy"}


class TipPath(NamedTuple):
    """The joints that carry a tip, in z-frames (see `chain.ZFrames`)."""

    joints: np.ndarray  # (P,) from the ground to the tip
    joint_type: np.ndarray  # (N,)
    rotations: np.ndarray  # (N, 3, 3)
    translations: np.ndarray  # (N, 3)
    tip_rotation: np.ndarray  # (3, 3) in the z-frame of the last joint
    tip_position: np.ndarray  # (3,)


@compiled(trigonometry, **_KERNEL)
def _sines(values, joint, s, c):
    """Fill sines and cosines of one joint's values (n, N)."""
    n, far = values.shape[0], 0
    for k in range(n):
        s[k] = values[k, joint]
    for k in range(n):
        far += np.int64(not abs(s[k]) < FAR)
    if far:
        for k in range(n):
            s[k], c[k] = np.sin(s[k]), np.cos(s[k])
    else:
        for k in range(n):
            s[k], c[k] = sine_cosine(s[k])


@compiled(**_KERNEL)
def _advance(frame, s, c, constants):
    """Carry one world coordinate of a frame (x, y, z axes and origin) through a turning joint."""
    x, y, z, p = frame[0], frame[1], frame[2], frame[3]
    (a, b, d), (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = constants
    for k in range(s.shape[0]):
        X, Y, Z = x[k], y[k], z[k]
        p[k] += X * a + Y * b + Z * d
        u, v = X * r00 + Y * r10 + Z * r20, X * r01 + Y * r11 + Z * r21
        z[k] = X * r02 + Y * r12 + Z * r22
        x[k] = c[k] * u + s[k] * v
        y[k] = c[k] * v - s[k] * u


@compiled(**_KERNEL)
def _note(frame, n, axis, origin):
    """Keep the axis and the origin of a joint."""
    z, p = frame[2], frame[3]
    for k in range(n):
        axis[k], origin[k] = z[k], p[k]


@compiled(**_KERNEL)
def _slide(frame, slide):
    """Move the origin along the axis."""
    z, p = frame[2], frame[3]
    for k in range(slide.shape[0]):
        p[k] += z[k] * slide[k]


@compiled(**_KERNEL)
def _store_frames(frames, tip_R, tip_p, hand, T):
    """Fill T (n, 4, 4) and the tip's positions `hand` (3, n)."""
    for a in range(3):
        x, y, z, p = frames[a, 0], frames[a, 1], frames[a, 2], frames[a, 3]
        for k in range(T.shape[0]):
            hand[a, k] = p[k] + x[k] * tip_p[0] + y[k] * tip_p[1] + z[k] * tip_p[2]
        for b in range(3):
            r0, r1, r2 = tip_R[0, b], tip_R[1, b], tip_R[2, b]
            for k in range(T.shape[0]):
                T[k, a, b] = x[k] * r0 + y[k] * r1 + z[k] * r2
        for k in range(T.shape[0]):
            T[k, a, 3] = hand[a, k]
    for k in range(T.shape[0]):
        T[k, 3, 0] = T[k, 3, 1] = T[k, 3, 2] = 0.0
        T[k, 3, 3] = 1.0


@compiled(**_KERNEL)
def _store_column(place, hand, turns, joint, J):
    """Fill a joint's column of J (n, 6, N): velocity of the tip, angular velocity."""
    axis, origin = place[0], place[1]
    for k in range(J.shape[0]):
        zx, zy, zz = axis[0, k], axis[1, k], axis[2, k]
        if turns:
            dx, dy, dz = (
                hand[0, k] - origin[0, k],
                hand[1, k] - origin[1, k],
                hand[2, k] - origin[2, k],
            )
            J[k, 0, joint] = zy * dz - zz * dy
            J[k, 1, joint] = zz * dx - zx * dz
            J[k, 2, joint] = zx * dy - zy * dx
            J[k, 3, joint], J[k, 4, joint], J[k, 5, joint] = zx, zy, zz
        else:
            J[k, 0, joint], J[k, 1, joint], J[k, 2, joint] = zx, zy, zz
            J[k, 3, joint] = J[k, 4, joint] = J[k, 5, joint] = 0.0


@compiled(trigonometry, **_KERNEL)
def tip_frames(path, values, T, J):
    """Fill frames T (K,4,4) of a tip, and its columns in J (K,6,N) unless that is empty.

    `values` (K,N) are those of all joints. Rows of J: linear velocity of the tip's origin, then
    angular velocity, both in world axes. Columns of joints that do not carry the tip stay.
    """
    n_path = path.joints.shape[0]
    work = np.empty((3, 4, BLOCK + 8))
    places = np.empty((n_path, 2, 3, BLOCK + 8))
    sc, hand = np.empty((2, BLOCK + 8)), np.empty((3, BLOCK + 8))
    for first in range(0, values.shape[0], BLOCK):
        n = min(BLOCK, values.shape[0] - first)
        block, s, c = values[first : first + n], sc[0, :n], sc[1, :n]
        for a in range(3):
            for b in range(4):
                work[a, b, :n] = 1.0 if a == b else 0.0
        for i in range(n_path):
            joint = path.joints[i]
            turns = path.joint_type[joint] == REVOLUTE
            if turns:
                _sines(block, joint, s, c)
            else:
                s[:], c[:] = 0.0, 1.0
            t, R = path.translations[joint], path.rotations[joint]
            constants = (
                (t[0], t[1], t[2]),
                (R[0, 0], R[0, 1], R[0, 2]),
                (R[1, 0], R[1, 1], R[1, 2]),
                (R[2, 0], R[2, 1], R[2, 2]),
            )
            for a in range(3):
                _advance(work[a], s, c, constants)
                _note(work[a], n, places[i, 0, a], places[i, 1, a])
                if not turns:
                    _slide(work[a], block[:, joint])
        _store_frames(work, path.tip_rotation, path.tip_position, hand, T[first : first + n])
        if J.shape[0]:
            for i in range(n_path):
                joint = path.joints[i]
                turns = path.joint_type[joint] == REVOLUTE
                _store_column(places[i], hand, turns, joint, J[first : first + n])
