"""Where a movement begins and ends, which movements stand apart, and movements on one time scale.

The rules are those of Charles & Hogan (Exp. Brain Res. 203:63, 2010) as [Tommasino2017] uses them:
20 % of peak speed, two interquartile ranges from the median, 20 samples equally spaced in time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError
from selfmotion.motion.checks import check_time
from selfmotion.motion.filters import resample

if TYPE_CHECKING:
    import pandas as pd

# Share of the peak speed below which the hand counts as at rest.
REST_SHARE = 0.2
# Interquartile ranges from the median beyond which a movement stands apart.
SPREADS = 2.0
N_SAMPLES = 20


@dataclass(frozen=True)
class Bounds:
    """First and last sample of a movement, and its fastest.

    Attributes:
        onset: last sample before the peak that is below the threshold.
        peak: fastest sample.
        offset: first sample after the peak that is below the threshold.
        complete: False where the recording begins or ends above the threshold, and `onset` or
            `offset` is simply its first or last sample.
    """

    onset: int
    peak: int
    offset: int
    complete: bool


def movement_bounds(speed: ArrayLike, *, share: float = REST_SHARE) -> Bounds:
    """Find onset and offset of a movement around its peak speed.

    Args:
        speed: (K,) tangential speed, any unit, without gaps.
        share: share of the peak speed that counts as rest, between 0 and 1.

    Raises:
        ShapeError: fewer than 3 samples.
        NotFiniteError: a value is not finite.
        RangeError: the share is not allowed, a speed is negative, or nothing moves.

    Example:
        >>> movement_bounds([0.0, 0.1, 0.5, 1.0, 0.4, 0.1, 0.0])
        Bounds(onset=1, peak=3, offset=5, complete=True)
    """
    v = as_float_array("speed", speed, ndim=1)
    if len(v) < 3:
        raise ShapeError(f"speed: {len(v)} samples; at least 3 are needed")
    require_finite("speed", v)
    if not 0.0 < share < 1.0:
        raise RangeError(f"share = {share:g}: allowed is above 0 and below 1")
    if v.min() < 0.0:
        raise RangeError(f"speed[{int(v.argmin())}] = {v.min():g}: a speed is not negative")
    peak = int(v.argmax())
    if not v[peak] > 0.0:
        raise RangeError("speed: all values are 0, nothing moves")
    slow = v < share * v[peak]
    before, after = np.flatnonzero(slow[:peak]), np.flatnonzero(slow[peak:])
    onset = int(before[-1]) if before.size else 0
    offset = peak + int(after[0]) if after.size else len(v) - 1
    return Bounds(onset, peak, offset, bool(before.size and after.size))


def path_length(path: Float[np.ndarray, "samples rows"]) -> float:
    """Give the length of a path (its unit)."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def stands_apart(values: ArrayLike, *, spreads: float = SPREADS) -> Bool[np.ndarray, " movements"]:
    """Mark values farther from the median than `spreads` interquartile ranges.

    Args:
        values: (B,) one number a movement: path length (m), duration (s).
        spreads: interquartile ranges allowed.

    Raises:
        NotFiniteError: a value is not finite.
        RangeError: `spreads` is not above 0.

    Example:
        >>> stands_apart([1.0, 1.1, 0.9, 1.0, 3.0]).tolist()
        [False, False, False, False, True]
    """
    x = as_float_array("values", values, ndim=1)
    require_finite("values", x)
    if not spreads > 0.0:
        raise RangeError(f"spreads = {spreads:g}: must be above 0")
    if not len(x):
        return np.zeros(0, dtype=bool)
    low, middle, high = np.percentile(x, [25.0, 50.0, 75.0])
    return np.abs(x - middle) > spreads * (high - low)


def equally_spaced(
    time: ArrayLike, values: ArrayLike, *, n_samples: int = N_SAMPLES
) -> Float[np.ndarray, "samples columns"]:
    """Interpolate linearly at samples equally spaced in time, the ends included.

    Args:
        time: (K,) increasing (s).
        values: (K, c).
        n_samples: number of samples wanted.

    Raises:
        ShapeError: the arrays do not fit, or fewer than 2 samples.
        RangeError: time does not increase, or `n_samples` is below 2.

    Example:
        >>> equally_spaced([0.0, 1.0, 4.0], [[0.0], [1.0], [4.0]], n_samples=3).ravel().tolist()
        [0.0, 2.0, 4.0]
    """
    t = as_float_array("time", time, ndim=1)
    x = as_float_array("values", values, ndim=2)
    require_shape("values", x, (len(t), None))
    check_time(t)
    if len(t) < 2:
        raise ShapeError(f"time: {len(t)} sample; at least 2 are needed")
    if n_samples < 2:
        raise RangeError(f"n_samples = {n_samples}: at least 2")
    wanted = np.linspace(t[0], t[-1], n_samples)
    return np.stack([np.interp(wanted, t, column) for column in x.T], axis=1)


def normalised_parts(
    time: ArrayLike,
    columns: Mapping[str, ArrayLike],
    parts: Sequence[tuple[str, int, int]],
    *,
    n_samples: int = 101,
) -> "pd.DataFrame":
    """Bring parts of a recording to 0 to 100 % of their time, one below the other.

    Args:
        time: (K,) of the recording (s).
        columns: name to (K,) values; NaN is a gap.
        parts: name, first and last sample of each; a part of one sample is left out.
        n_samples: rows of a part.

    Returns:
        Columns part, percent, time (s) and those given, by cubic splines.

    Raises:
        RangeError: `n_samples` is below 2.

    Example:
        >>> t = np.linspace(0.0, 2.0, 21)
        >>> table = normalised_parts(t, {"x": t**2}, [("stroke 1", 10, 20)], n_samples=3)
        >>> table["percent"].tolist(), table["x"].round(9).tolist()
        ([0.0, 50.0, 100.0], [1.0, 2.25, 4.0])
    """
    import pandas as pd

    if n_samples < 2:
        raise RangeError(f"n_samples = {n_samples}: at least 2")
    t = as_float_array("time", time, ndim=1)
    values = np.stack([as_float_array(k, v, ndim=1) for k, v in columns.items()], axis=1)
    require_shape("columns", values, (len(t), None))
    tables = []
    for name, first, last in parts:
        if last > first:
            part = slice(first, last + 1)
            instants, found = resample(values[part], t[part], n_samples)
            head = {"part": name, "percent": np.linspace(0.0, 100.0, n_samples), "time": instants}
            tables.append(pd.DataFrame(head | dict(zip(columns, found.T, strict=True))))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
