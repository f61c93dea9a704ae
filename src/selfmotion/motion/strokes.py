"""Several strokes in one recording: reach, transport, return.

A recording of a task such as drinking holds several movements with pauses or mere slow moments
between them. A stroke is a stretch of speed above a share of the peak; where speed falls deeply
between two peaks without passing that threshold, the slowest moment parts two strokes.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.motion.checks import check_time


@dataclass(frozen=True)
class StrokeRules:
    """What counts as a stroke.

    Attributes:
        share: of the recording's peak speed below which the hand counts as at rest.
        valley: two peaks belong to two strokes if speed between them falls below this share of
            the lower one.
        least_duration: shorter strokes are no strokes (s).
        least_length: strokes shorter than this share of the longest are no strokes.
    """

    share: float = 0.05
    valley: float = 0.5
    least_duration: float = 0.1
    least_length: float = 0.05

    def __post_init__(self) -> None:
        """Check that shares are shares."""
        for name in ("share", "valley", "least_length"):
            value = getattr(self, name)
            if not 0.0 <= value < 1.0:
                raise RangeError(f"{name} = {value:g}: allowed is 0 to below 1")
        if not self.least_duration >= 0.0:
            raise RangeError(f"least_duration = {self.least_duration:g} s: must not be negative")


@dataclass(frozen=True)
class Stroke:
    """One stroke: its samples and what it does.

    Attributes:
        onset: first sample.
        peak: fastest sample.
        offset: last sample.
        duration: from onset to offset (s).
        length: of the path (unit of speed times s).
        peak_speed: unit of speed.
    """

    onset: int
    peak: int
    offset: int
    duration: float
    length: float
    peak_speed: float


def movement_span(speed: ArrayLike, *, share: float = 0.05) -> tuple[int, int]:
    """Give the first and the last sample of all movement in a recording.

    They are the last sample at rest before, and the first after, any speed above the threshold.

    Args:
        speed: (K,), any unit; NaN in gaps.
        share: of the peak speed that counts as rest.

    Raises:
        RangeError: nothing moves, or nothing was seen.

    Example:
        >>> movement_span([0, 0, 1, 2, 0, 0, 2, 1, 0, 0])
        (1, 8)
    """
    v = as_float_array("speed", speed, ndim=1)
    if not np.nanmax(v, initial=0.0) > 0.0:
        raise RangeError("speed: nothing moves")
    fast = np.flatnonzero(v >= share * np.nanmax(v))
    return max(int(fast[0]) - 1, 0), min(int(fast[-1]) + 1, len(v) - 1)


def find_strokes(
    speed: ArrayLike, time: ArrayLike, *, rules: StrokeRules | None = None
) -> tuple[Stroke, ...]:
    """Part a recording into strokes, in order.

    Args:
        speed: (K,) of the hand, any unit, without gaps.
        time: (K,), s.
        rules: what counts; left out: 5 % of the peak, valleys of one half.

    Raises:
        NotFiniteError: a speed is not finite.
        RangeError: nothing moves.

    Example:
        >>> t = np.linspace(0, 2, 201)
        >>> out_and_back = np.abs(np.sin(np.pi * t))
        >>> [(s.onset, s.peak, s.offset) for s in find_strokes(out_and_back, t)]
        [(2, 50, 98), (102, 150, 198)]
    """
    chosen = rules or StrokeRules()
    v = as_float_array("speed", speed, ndim=1)
    t = as_float_array("time", time, ndim=1)
    require_shape("speed", v, (len(t),))
    require_finite("speed", v)
    check_time(t)
    if not v.max() > 0.0:
        raise RangeError("speed: nothing moves")
    found = []
    for start, stop in _runs(v >= chosen.share * v.max()):
        found += [_stroke(v, t, a, b) for a, b in _parted(v, start, stop, chosen.valley)]
    longest = max(stroke.length for stroke in found)
    return tuple(
        s
        for s in found
        if s.duration >= chosen.least_duration and s.length >= chosen.least_length * longest
    )


def _runs(marked: Bool[np.ndarray, " samples"]) -> list[tuple[int, int]]:
    """Give start and stop (exclusive) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _parted(
    v: Float[np.ndarray, " samples"], start: int, stop: int, valley: float
) -> list[tuple[int, int]]:
    """Cut a run at its deepest valley, and the parts again."""
    inner = np.arange(start + 1, stop - 1)
    if inner.size:
        left = np.maximum.accumulate(v[start:stop])[inner - start]
        right = np.maximum.accumulate(v[start:stop][::-1])[::-1][inner - start]
        depth = v[inner] / np.minimum(left, right)
        at = int(np.argmin(depth))
        if depth[at] < valley:
            cut = int(inner[at])
            return [*_parted(v, start, cut, valley), *_parted(v, cut, stop, valley)]
    return [(start, stop)]


def _stroke(v: np.ndarray, t: np.ndarray, start: int, stop: int) -> Stroke:
    part, instants = v[start:stop], t[start:stop]
    length = float(np.trapezoid(part, instants)) if len(part) > 1 else 0.0
    peak = start + int(part.argmax())
    last = stop - 1
    return Stroke(start, peak, last, float(instants[-1] - instants[0]), length, float(v[peak]))
