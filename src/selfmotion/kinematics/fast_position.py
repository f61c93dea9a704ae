"""Positions of a tip at many millions of postures a second.

A block of samples is turned into one array a joint (structure of arrays), and the tip's position
is carried from the hand down to the ground, one joint at a time, for the whole block: every step
is arithmetic on neighbouring numbers that the compiler turns into vector instructions. Joints that
cannot move the tip are passed over.

`contract` (fused multiply-add) is the only relaxation allowed to the compiler: it keeps NaN and
infinity as they are and only removes a rounding.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import freeze, require_fillable, require_finite
from selfmotion.kinematics import sine_cosine as trigonometry
from selfmotion.kinematics.chain import GROUND, Chain, Tip
from selfmotion.kinematics.compiled import compiled
from selfmotion.kinematics.serial_path import SerialPath
from selfmotion.kinematics.sine_cosine import n_far, sine_cosine
from selfmotion.kinematics.threads import share

# Samples in a block: angles and positions of one block stay in the first-level cache.
BLOCK = 256
# Samples below which a second thread costs more than it saves.
SAMPLES_PER_THREAD = 20_000
# A tip no further than this from the last axis (m) is not moved by that joint.
ON_AXIS = 1e-15

_KERNEL: dict[str, Any] = {"nogil": True, "fastmath": {"contract"}, "error_model": "numpy"}


class PathArrays(NamedTuple):
    """What the kernel needs of a `SerialPath`."""

    column: np.ndarray  # of q, for each joint that moves the tip
    prismatic: np.ndarray
    angle_offset: np.ndarray
    cos_twist: np.ndarray
    sin_twist: np.ndarray
    shift: np.ndarray
    base: np.ndarray
    tip: np.ndarray


@compiled(**_KERNEL)
def _load(values, column, offset, angle):
    """Copy the samples of a column into `angle`."""
    for k in range(values.shape[0]):
        angle[k] = values[k, column] + offset


@compiled(**_KERNEL)
def _slide(angle, z, n, offset):
    """Move along z by the values at hand, and put the constant turn in their place."""
    for k in range(n):
        z[k] += angle[k] - offset
        angle[k] = offset


@compiled(trigonometry, **_KERNEL)
def _turn(angle, x, y, z, step):
    """Carry n positions through a joint: turn about z, twist about x, shift."""
    n, ct, st, a, b, d = step
    for k in range(n):
        s, c = sine_cosine(angle[k])
        u, v = x[k], z[k]
        w = s * u + c * y[k]
        x[k] = c * u + (a - s * y[k])
        y[k] = ct * w + (b - st * v)
        z[k] = st * w + (ct * v + d)


@compiled(**_KERNEL)
def _turn_far(angle, x, y, z, offset, step):
    """Do the same for angles of any size, to which the offset cannot be added without loss."""
    n, ct, st, a, b, d = step
    so, co = np.sin(offset), np.cos(offset)
    for k in range(n):
        sine, cosine = np.sin(angle[k]), np.cos(angle[k])
        s, c = sine * co + cosine * so, cosine * co - sine * so
        u, v = x[k], z[k]
        w = s * u + c * y[k]
        x[k] = c * u + (a - s * y[k])
        y[k] = ct * w + (b - st * v)
        z[k] = st * w + (ct * v + d)


@compiled(**_KERNEL)
def _store(x, y, z, base, out):
    """Turn positions about the ground's z into out (n, 3)."""
    cb, sb = base[0], base[1]
    for k in range(out.shape[0]):
        out[k, 0] = cb * x[k] - sb * y[k]
        out[k, 1] = sb * x[k] + cb * y[k]
        out[k, 2] = z[k]


@compiled(trigonometry, **_KERNEL)
def _positions(path, values, flat, out):
    """Fill out (K, 3) with tip positions for joint values (K, N), which `flat` (K N) holds, too.

    Gives how many values are very large or not finite.
    """
    work = np.empty((4, BLOCK + 8))  # rows a multiple of 4 kB apart would wait for each other
    angle, x, y, z = work[0], work[1], work[2], work[3]
    n_columns, all_far = values.shape[1], 0
    for first in range(0, values.shape[0], BLOCK):
        n = min(BLOCK, values.shape[0] - first)
        block = values[first : first + n]
        far = n_far(flat[first * n_columns : (first + n) * n_columns])
        all_far += far
        x[:], y[:], z[:] = path.tip[0], path.tip[1], path.tip[2]
        for i in range(path.column.shape[0] - 1, -1, -1):
            offset, shift = path.angle_offset[i], path.shift[i]
            added = 0.0 if far else offset
            _load(block, path.column[i], added, angle)
            if path.prismatic[i]:
                _slide(angle, z, n, added)
            step = (n, path.cos_twist[i], path.sin_twist[i], shift[0], shift[1], shift[2])
            if far:
                _turn_far(angle, x, y, z, offset, step)
            else:
                _turn(angle, x, y, z, step)
        _store(x, y, z, path.base, out[first : first + n])
    return all_far


def positions(
    chain: Chain,
    q: ArrayLike,
    tip: Tip,
    *,
    threads: int = 1,
    out: Float[np.ndarray, "samples 3"] | None = None,
) -> Float[np.ndarray, "samples 3"]:
    """Give the position of a tip in the ground for many postures, as fast as the machine can.

    The same numbers as ``forward_kinematics(chain, q, tip)[:, :3, 3]`` to 1e-12 m, for any chain.

    Args:
        chain: the joints.
        q: (n,) or (K, n) free coordinates (rad or m).
        tip: whose position.
        threads: how many threads share the samples.
        out: (K, 3) array to fill, in C order; memory that is used again spares the time that a
            system takes to hand out new pages.

    Returns:
        (K, 3) positions (m); `out` if that was given.

    Raises:
        ShapeError: q does not fit the chain, or out does not fit q.
        NotFiniteError: q holds NaN or infinite values.
        RangeError: fewer than one thread.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import planar
        >>> arm = planar([0.3, 0.25])
        >>> q = [np.pi / 2, -np.pi / 2]
        >>> positions(arm.chain, q, arm.tip("hand")).round(6)[0, :2].tolist()
        [0.25, 0.3]
    """
    samples = chain.shaped(q)
    if out is None:
        out = np.empty((len(samples), 3))
    require_fillable("out", out, (len(samples), 3))
    if tip.joint == GROUND:
        require_finite("q", samples)
        out[:] = tip.transform[:3, 3]
        return out
    path = path_arrays(SerialPath.of(chain, tip))
    # Always read-only: the kernel would be compiled once more for arrays that are not.
    values = freeze(chain.coupling.value(samples).view())
    suspects = []

    def work(a: int, b: int) -> None:
        part = values[a:b]
        suspects.append(_positions(path, part, part.reshape(-1), out[a:b]))

    share(work, len(values), threads, least=SAMPLES_PER_THREAD)
    if any(suspects):
        require_finite("q", samples)
    return out


def path_arrays(path: SerialPath) -> PathArrays:
    """Give the arrays of a path that the kernel wants, without joints that only spin the tip."""
    cosine, sine, tip = np.cos(path.twist), np.sin(path.twist), path.tip_position
    n = len(path.joints)
    while n and not path.prismatic[n - 1] and np.hypot(tip[0], tip[1]) <= ON_AXIS:
        n -= 1
        twisted = np.array([0.0, -sine[n] * tip[2], cosine[n] * tip[2]])
        tip = path.shift[n] + twisted
    columns = path.joints[:n]
    return PathArrays(
        columns,
        path.prismatic[:n],
        path.angle_offset[:n],
        cosine[:n],
        sine[:n],
        path.shift[:n],
        path.base,
        np.array(tip),
    )
