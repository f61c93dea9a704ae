"""Positions of a tip at many millions of postures a second.

A block of samples is turned into one array a joint (structure of arrays), and the tip's position
is carried from the hand down to the ground, one joint at a time, for the whole block: every step
is arithmetic on neighbouring numbers that the compiler turns into vector instructions. Sine and
cosine are polynomials, since a call of the C library cannot be vectorised.

`contract` (fused multiply-add) is the only relaxation allowed to the compiler: it keeps NaN and
infinity as they are and only removes a rounding.
"""

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numba import njit
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite
from selfmotion.errors import RangeError, ShapeError
from selfmotion.kinematics.chain import GROUND, Chain, Tip
from selfmotion.kinematics.serial_path import SerialPath

# Samples in a block: positions, angles and sines of one block stay in the first-level cache.
BLOCK = 256
# Samples below which a second thread costs more than it saves.
SAMPLES_PER_THREAD = 20_000

# pi in two parts, and 1.5 * 2^52, which rounds to an integer when added and subtracted.
_PI_HIGH, _PI_LOW = 3.141592653589793, 1.2246467991473532e-16
_ROUND = 6755399441055744.0
# Chebyshev interpolants of sin(sqrt u)/sqrt(u) and cos(sqrt u) for |angle| <= pi/2: 4e-18 off.
_S0, _S1, _S2, _S3, _S4, _S5, _S6, _S7, _S8 = (
    1.0,
    -0.16666666666666666,
    0.008333333333333186,
    -0.00019841269841208492,
    2.7557319211197846e-06,
    -2.5052106887595812e-08,
    1.6058940725155848e-10,
    -7.643022462141453e-13,
    2.721530691642785e-15,
)
_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8 = (
    1.0,
    -0.4999999999999997,
    0.041666666666663875,
    -0.0013888888888772643,
    2.4801587277354773e-05,
    -2.7557316385393876e-07,
    2.087656154954579e-09,
    -1.1462894144907947e-11,
    4.608893200186988e-14,
)


class PathArrays(NamedTuple):
    """What the kernel needs of a `SerialPath`."""

    column: np.ndarray
    prismatic: np.ndarray
    angle_offset: np.ndarray
    cos_twist: np.ndarray
    sin_twist: np.ndarray
    shift: np.ndarray
    base: np.ndarray
    tip: np.ndarray


@njit(cache=True, inline="always")
def sine_cosine(angle):
    """Give sine and cosine by polynomials, after taking off the nearest multiple of pi."""
    turns = (angle * 0.3183098861837907 + _ROUND) - _ROUND
    half = 0.5 * turns
    odd = half - ((half + _ROUND) - _ROUND)
    sign = 1.0 - 8.0 * odd * odd
    r = (angle - turns * _PI_HIGH) - turns * _PI_LOW
    u = r * r
    s = _S8
    s = s * u + _S7
    s = s * u + _S6
    s = s * u + _S5
    s = s * u + _S4
    s = s * u + _S3
    s = s * u + _S2
    s = s * u + _S1
    s = s * u + _S0
    c = _C8
    c = c * u + _C7
    c = c * u + _C6
    c = c * u + _C5
    c = c * u + _C4
    c = c * u + _C3
    c = c * u + _C2
    c = c * u + _C1
    c = c * u + _C0
    return sign * (s * r), sign * c


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
def _positions(path, values, out):
    """Fill out (K, 3) with tip positions for joint values (K, N)."""
    n_path = path.column.shape[0]
    angle = np.empty(BLOCK)
    x, y, z = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    for first in range(0, values.shape[0], BLOCK):
        n = min(BLOCK, values.shape[0] - first)
        x[:], y[:], z[:] = path.tip[0], path.tip[1], path.tip[2]
        for i in range(n_path - 1, -1, -1):
            j = path.column[i]
            for k in range(n):
                angle[k] = values[first + k, j]
            ct, st = path.cos_twist[i], path.sin_twist[i]
            a, b, d = path.shift[i, 0], path.shift[i, 1], path.shift[i, 2]
            start = path.angle_offset[i]
            if path.prismatic[i]:
                for k in range(n):
                    z[k] += angle[k]
                    angle[k] = 0.0
            for k in range(n):
                s, c = sine_cosine(angle[k] + start)
                u = s * x[k] + c * y[k]
                x[k] = (c * x[k] - s * y[k]) + a
                y[k] = (ct * u - st * z[k]) + b
                z[k] = (st * u + ct * z[k]) + d
        cb, sb = path.base[0], path.base[1]
        for k in range(n):
            out[first + k, 0] = cb * x[k] - sb * y[k]
            out[first + k, 1] = sb * x[k] + cb * y[k]
            out[first + k, 2] = z[k]


def positions(
    chain: Chain, q: ArrayLike, tip: Tip, *, threads: int = 1
) -> Float[np.ndarray, "samples 3"]:
    """Give the position of a tip in the ground for many postures, as fast as the machine can.

    The same numbers as ``forward_kinematics(chain, q, tip)[:, :3, 3]`` to 1e-12 m (angles up to
    10⁴ rad), for any chain.

    Args:
        chain: the joints.
        q: (n,) or (K, n) free coordinates (rad or m).
        tip: whose position.
        threads: how many threads share the samples.

    Returns:
        (K, 3) positions (m).

    Raises:
        ShapeError: q does not fit the chain.
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
    if threads < 1:
        raise RangeError(f"threads = {threads}: allowed is 1 and above")
    samples = np.atleast_2d(as_float_array("q", q))
    if samples.ndim != 2 or samples.shape[1] != chain.n_coordinates:
        raise ShapeError(
            f"q has shape {np.shape(q)}; expected (samples, {chain.n_coordinates}) "
            f"for {', '.join(chain.coordinates)}"
        )
    out = np.empty((len(samples), 3))
    if tip.joint == GROUND:
        require_finite("q", samples)
        out[:] = tip.transform[:3, 3]
        return out
    _run(path_arrays(SerialPath.of(chain, tip)), chain.coupling.value(samples), out, threads)
    # NaN and infinity in q come out as NaN: looking at the sum is cheaper than looking at q.
    if not np.isfinite(out.sum()):
        require_finite("q", samples)
    return out


def path_arrays(path: SerialPath) -> PathArrays:
    """Give the arrays of a path that the kernel wants."""
    return PathArrays(
        path.joints,
        path.prismatic,
        path.angle_offset,
        np.cos(path.twist),
        np.sin(path.twist),
        path.shift,
        np.array([np.cos(path.base_angle), np.sin(path.base_angle)]),
        path.tip_position,
    )


def _run(path: PathArrays, values: np.ndarray, out: np.ndarray, threads: int) -> None:
    """Run the kernel, in as many threads as there are samples for."""
    used = max(1, min(threads, len(values) // SAMPLES_PER_THREAD))
    if used == 1:
        _positions(path, values, out)
        return
    edges = np.linspace(0, len(values), used + 1).astype(int)
    with ThreadPoolExecutor(used) as pool:
        parts = [
            pool.submit(_positions, path, values[a:b], out[a:b])
            for a, b in zip(edges[:-1], edges[1:], strict=True)
        ]
        for part in parts:
            part.result()
