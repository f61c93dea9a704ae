"""Compiled kernel of one tip: its frames and its Jacobian, for a block of samples at once.

As in `fast_position`, every step is arithmetic on neighbouring numbers (structure of arrays) that
the compiler turns into vector instructions; here from the ground to the hand, since the Jacobian
needs the axis and the origin of each joint on the way. The three world coordinates of axes and
origins never mix, so each is carried by itself.

A compiler asks whether arrays overlap before it turns a loop into vector instructions, and gives
up where there are many of them: hence loops that write to one or two arrays at a time, and a store
of its own, sample by sample, at the end.
"""

from typing import Any, NamedTuple

import numpy as np

from selfmotion.kinematics import sine_cosine as trigonometry
from selfmotion.kinematics.chain import Chain, Tip
from selfmotion.kinematics.compiled import compiled
from selfmotion.kinematics.serial_path import SerialPath, tip_in_path
from selfmotion.kinematics.sine_cosine import n_far, sine_cosine

# Samples in a block: axes, origins and columns of nine joints stay in the second-level cache.
BLOCK = 128

# Only the driver allocates: without reference counts on slices the rest runs three times faster.
_DRIVER: dict[str, Any] = {"nogil": True, "fastmath": {"contract"}, "error_model": "numpy"}
_KERNEL: dict[str, Any] = {**_DRIVER, "_nrt": False}


class TipPath(NamedTuple):
    """The joints that carry a tip (see `serial_path.SerialPath`)."""

    joints: np.ndarray  # (P,) from the ground to the tip
    prismatic: np.ndarray  # (P,)
    steps: np.ndarray  # (P, 6)
    base: np.ndarray  # (2,) cosine and sine of the first turn
    tip_rotation: np.ndarray  # (3, 3) in the frame of the last joint
    tip_position: np.ndarray  # (3,)


def tip_path(chain: Chain, tip: Tip) -> TipPath:
    """Give the arrays that the kernel wants, for a tip that a joint carries."""
    path = SerialPath.up_to(chain, int(tip.joint))
    return TipPath(path.joints, path.prismatic, path.steps, path.base, *tip_in_path(chain, tip))


@compiled(trigonometry, **_KERNEL)
def _sines(values, joint, offset, far, s, c):
    """Fill sines and cosines of one joint's values (n, N) plus an offset."""
    n = values.shape[0]
    for k in range(n):
        s[k] = values[k, joint]
    if far:  # the offset cannot be added to those without loss
        so, co = np.sin(offset), np.cos(offset)
        for k in range(n):
            sine, cosine = np.sin(s[k]), np.cos(s[k])
            s[k], c[k] = sine * co + cosine * so, cosine * co - sine * so
    else:
        for k in range(n):
            s[k], c[k] = sine_cosine(s[k] + offset)


@compiled(**_KERNEL)
def _shift(x, y, z, p, shift):
    """Move the origin along the three axes."""
    a, b, d = shift[0], shift[1], shift[2]
    if a == 0.0 and b == 0.0 and d == 0.0:
        return
    for k in range(p.shape[0]):
        p[k] += x[k] * a + y[k] * b + z[k] * d


@compiled(**_KERNEL)
def _twist(y, z, cosine, sine):
    """Turn two axes about the third by one angle."""
    for k in range(y.shape[0]):
        u, v = y[k], z[k]
        y[k] = cosine * u + sine * v
        z[k] = cosine * v - sine * u


@compiled(**_KERNEL)
def _turn(x, y, s, c):
    """Turn two axes about the third by an angle a sample."""
    for k in range(x.shape[0]):
        u, v = x[k], y[k]
        x[k] = c[k] * u + s[k] * v
        y[k] = c[k] * v - s[k] * u


@compiled(**_KERNEL)
def _slide(z, p, values, joint, axis):
    """Move the origin along the axis by a joint's values, and keep the axis."""
    for k in range(p.shape[0]):
        p[k] += z[k] * values[k, joint]
        axis[k] = z[k]


@compiled(**_KERNEL)
def _copy(source, out):
    """Copy as many samples as `source` has."""
    for k in range(source.shape[0]):
        out[k] = source[k]


@compiled(**_KERNEL)
def _weighted(x, y, z, weights, out):
    """Fill a weighted sum of three arrays."""
    a, b, d = weights[0], weights[1], weights[2]
    for k in range(out.shape[0]):
        out[k] = x[k] * a + y[k] * b + z[k] * d


@compiled(**_KERNEL)
def _lever(zy, zz, hy, hz, oy, oz, out):
    """Fill one coordinate of the velocity of the tip as a joint turns."""
    for k in range(out.shape[0]):
        out[k] = zy[k] * (hz[k] - oz[k]) - zz[k] * (hy[k] - oy[k])


@compiled(**_KERNEL)
def _tip(frames, path, n, whole):
    """Fill the rows of the tip's frame (12, n) from the last joint's, row by row of the matrix."""
    for a in range(3):
        x, y, z = frames[a, 0, :n], frames[a, 1, :n], frames[a, 2, :n]
        for b in range(3):
            _weighted(x, y, z, path.tip_rotation[:, b], whole[4 * a + b, :n])
        _weighted(x, y, z, path.tip_position, whole[4 * a + 3, :n])
        p, hand = frames[a, 3, :n], whole[4 * a + 3, :n]
        for k in range(n):
            hand[k] += p[k]


@compiled(**_KERNEL)
def _columns(places, path, whole, n, columns):
    """Fill the columns (6 N, n) of the joints that carry the tip, rows of J one after the other."""
    n_columns = columns.shape[0] // 6
    for i in range(path.joints.shape[0]):
        j, axis, origin = path.joints[i], places[i, 0], places[i, 1]
        for a in range(3):
            linear, angular = columns[a * n_columns + j, :n], columns[(a + 3) * n_columns + j, :n]
            b, d = (a + 1) % 3, (a + 2) % 3
            if path.prismatic[i]:
                _copy(axis[a, :n], linear)
                angular[:] = 0.0
                continue
            _copy(axis[a, :n], angular)
            hy, hz = whole[4 * b + 3, :n], whole[4 * d + 3, :n]
            _lever(axis[b, :n], axis[d, :n], hy, hz, origin[b, :n], origin[d, :n], linear)


@compiled(**_KERNEL)
def _store(rows, out):
    """Turn rows (M, n or more) into samples: out (n, M)."""
    for k in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[k, i] = rows[i, k]


@compiled(**_KERNEL)
def _start(frames, n, base):
    """Set all frames to that of the ground after the first turn."""
    frames[:, :, :n] = 0.0
    frames[0, 0, :n], frames[0, 1, :n] = base[0], -base[1]
    frames[1, 0, :n], frames[1, 1, :n] = base[1], base[0]
    frames[2, 2, :n] = 1.0


@compiled(trigonometry, **_KERNEL)
def _block(path, values, far, T, J, work):
    """Fill T (n, 16) and J (n, 6 N) of one block, which may hold far values."""
    frames, places, whole, columns, sc = work
    n = values.shape[0]
    s, c = sc[0, :n], sc[1, :n]
    _start(frames, n, path.base)
    for i in range(path.joints.shape[0]):
        joint, slides, step = path.joints[i], path.prismatic[i], path.steps[i]
        offset = step[0]
        if slides:
            s[:], c[:] = np.sin(offset), np.cos(offset)
        else:
            _sines(values, joint, offset, far, s, c)
        for a in range(3):
            x, y, z, p = frames[a, 0, :n], frames[a, 1, :n], frames[a, 2, :n], frames[a, 3, :n]
            _shift(x, y, z, p, step[3:])
            _twist(y, z, step[1], step[2])
            _turn(x, y, s, c)
            if slides:
                _slide(z, p, values, joint, places[i, 0, a])
            else:
                _copy(z, places[i, 0, a])
                _copy(p, places[i, 1, a])
    _tip(frames, path, n, whole)
    _store(whole, T)
    if columns.shape[0]:
        _columns(places, path, whole, n, columns)
        _store(columns, J)


@compiled(trigonometry, **_DRIVER)
def tip_frames(path, values, flat, T, J):
    """Fill frames T (K,16) of a tip, and its Jacobians J (K,6N) unless it has no columns.

    `values` (K,N) are those of all joints, which `flat` (K N) holds, too. Rows of J: linear
    velocity of the tip's origin, then angular velocity, both in world axes. Gives how many values
    are very large or not finite.
    """
    width = BLOCK + 8  # rows a multiple of 4 kB apart would wait for each other
    places = np.empty((path.joints.shape[0], 2, 3, width))
    whole, columns = np.zeros((16, width)), np.zeros((J.shape[1], width))
    whole[15] = 1.0
    work = np.empty((3, 4, width)), places, whole, columns, np.empty((2, width))
    n_columns, all_far = values.shape[1], 0
    for first in range(0, values.shape[0], BLOCK):
        last = min(first + BLOCK, values.shape[0])
        far = n_far(flat[first * n_columns : last * n_columns])
        all_far += far
        _block(path, values[first:last], far, T[first:last], J[first:last], work)
    return all_far
