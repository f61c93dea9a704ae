"""Sine and cosine by polynomials, which a compiler can turn into vector instructions.

A call of the C library cannot be vectorised, and numba's wheels bring no vector mathematics.
"""

import numpy as np
from numba import njit

# pi in two parts, and 1.5 * 2^52, which rounds to an integer when added and subtracted; then the
# last bit of the sum says whether that integer is odd.
_PI_HIGH, _PI_LOW = 3.141592653589793, 1.2246467991473532e-16
_PER_PI, _ROUND = 0.3183098861837907, 6755399441055744.0
# Angles (rad) beyond which the rounding above is felt: those go to the C library.
FAR = 1e4
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


@njit(cache=True, inline="always")
def sine_cosine(angle):
    """Give sine and cosine of an angle up to `FAR`, after taking off the nearest multiple of pi.

    An odd multiple turns both signs: the bit that says odd becomes the sign bit.
    """
    t = angle * _PER_PI + _ROUND
    turns = t - _ROUND
    r = (angle - turns * _PI_HIGH) - turns * _PI_LOW
    flip = np.float64(t).view(np.int64) << 63
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
    r = np.int64(np.float64(r).view(np.int64) ^ flip).view(np.float64)
    c = np.int64(np.float64(c).view(np.int64) ^ flip).view(np.float64)
    return s * r, c


@njit(cache=True, nogil=True)
def n_far(flat):
    """Count values that the polynomials are not for; NaN is one. Reads them in order, too."""
    count = 0
    for i in range(flat.shape[0]):
        count += np.int64(not abs(flat[i]) < FAR)
    return count
