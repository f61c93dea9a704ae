"""Smoothing, differentiation and resampling of recorded motion; time is axis 0.

NaN marks a gap. No function here reaches across one unless it is told to: each stretch between
gaps is treated on its own and a gap stays a gap. :func:`fill_gaps` bridges short ones, up to a
stated length, and says which samples it made up.
"""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.errors import RangeError, ShapeError
from selfmotion.motion.checks import check_time, refuse_infinite, require_even_steps
from selfmotion.motion.recording import Recording

# The ends are continued by point reflection over this many periods of the cutoff, after which
# the filter has forgotten how it started.
SETTLING_PERIODS = 3.0
Signal: TypeAlias = Float[np.ndarray, " samples *columns"]
Mask: TypeAlias = Bool[np.ndarray, " samples *columns"]

# A local polynomial through this many samples is differentiated: exact up to degree 4.
STENCIL = 5
# The fewest samples to which SciPy fits a cubic smoothing spline, and a quintic one.
SPLINE_MINIMUM = {"cubic": 5, "quintic": 6}
# Nodes used beside a gap to bridge it: a spline feels little of what is farther away.
NEIGHBOURS = 8


def low_pass(x: ArrayLike, rate: float, cutoff: float, *, order: int = 4) -> Signal:
    """Low-pass without phase shift: a Butterworth filter run forward and backward.

    Args:
        x: samples (K, ...), any unit; NaN is a gap, and stretches between gaps are filtered alone.
        rate: sampling rate, Hz.
        cutoff: frequency at which the gain of both passes together is 1/sqrt(2), Hz.
        order: order of both passes together, even (4: second order each way).

    Returns:
        The filtered samples, same shape.

    Raises:
        RangeError: the cutoff is not between 0 and half the rate, or the order is odd.

    Example:
        >>> t = np.arange(1000) / 100
        >>> reach, tremor = np.sin(2 * np.pi * t), np.sin(2 * np.pi * 30 * t)
        >>> bool(np.abs(low_pass(reach + tremor, 100.0, 6.0) - reach)[100:-100].max() < 0.01)
        True
    """
    if not (np.isfinite(rate) and rate > 0.0):
        raise RangeError(f"rate = {rate:g} Hz: must be positive")
    if not 0.0 < cutoff < rate / 2.0:
        raise RangeError(f"cutoff = {cutoff:g} Hz: allowed is above 0 and below {rate / 2:g} Hz")
    if order < 2 or order % 2:
        raise RangeError(f"order = {order}: must be even and at least 2 (half of it each way)")
    each = order // 2
    # Two passes square the gain; the design frequency moves up so that 1/sqrt(2) stays at cutoff.
    # The shift is exact in the warped frequency tan(pi f / rate) of the bilinear transform.
    shift = (np.sqrt(2.0) - 1.0) ** (-1.0 / (2 * each))
    design = 2.0 / np.pi * np.arctan(np.tan(np.pi * cutoff / rate) * shift)
    from scipy import signal  # SciPy's parts are slow to import, and velocities need none of them

    sections = np.asarray(signal.butter(each, design, output="sos"))
    longest = int(np.ceil(SETTLING_PERIODS * rate / cutoff))

    def both_ways(part: np.ndarray, _start: int) -> np.ndarray:
        padding = min(longest, len(part) - 1)
        return signal.sosfiltfilt(sections, part, axis=0, padlen=padding)

    return _by_stretch(_signal("x", x), both_ways)


def smoothing_spline(
    x: ArrayLike, time: ArrayLike, *, noise: float | None = None, derivative: int = 0
) -> Signal:
    """Smooth by a spline that weighs closeness against roughness, or give its derivative.

    Args:
        x: samples (K, ...); NaN is a gap, and stretches between gaps are smoothed alone.
        time: instants (K,), s; need not be evenly spaced.
        noise: standard deviation of the measurement noise, unit of x: a quintic spline whose
            residual is that large. None: a cubic spline whose smoothness is chosen by generalised
            cross-validation (which takes drifts and tremor for signal: check by eye).
        derivative: 0 for the values, 1 for the velocity, 2 for the acceleration.

    Raises:
        RangeError: `noise` is not positive, or the derivative is not 0, 1 or 2.
        ShapeError: a stretch is too short for a spline.

    Example:
        >>> t = np.linspace(0, 1, 50)
        >>> bool(np.allclose(smoothing_spline(3 * t, t, derivative=1), 3.0))
        True
    """
    if derivative not in (0, 1, 2):
        raise RangeError(f"derivative = {derivative}: allowed is 0, 1 or 2")
    if noise is not None and not (np.isfinite(noise) and noise > 0.0):
        raise RangeError(f"noise = {noise:g}: must be positive")
    samples = _signal("x", x)
    instants = _instants(time, len(samples))
    least = SPLINE_MINIMUM["cubic" if noise is None else "quintic"]

    def fit(part: np.ndarray, start: int) -> np.ndarray:
        t = instants[start : start + len(part)]
        if len(part) < least:
            raise ShapeError(
                f"x: {len(part)} samples between gaps at sample {start}; a smoothing spline "
                f"needs at least {least}"
            )
        return _fit_spline(t, part, noise)(t, derivative)

    return _by_stretch(samples, fit)


def differentiate(x: ArrayLike, time: ArrayLike, *, points: int = STENCIL) -> Signal:
    """Differentiate by time with the polynomial through neighbouring samples.

    Args:
        x: samples (K, ...); NaN is a gap: differences are one-sided beside it.
        time: instants (K,), s; need not be evenly spaced.
        points: samples in the polynomial, odd; exact up to degree ``points - 1``. Fewer samples
            between gaps lower the degree; a lone sample has no derivative (NaN).

    Returns:
        The derivative, same shape, unit of x per second.

    Raises:
        RangeError: `points` is even or below 3.

    Example:
        >>> t = np.array([0.0, 0.1, 0.3, 0.4, 0.7, 0.8])
        >>> bool(np.allclose(differentiate(t**3, t), 3 * t**2, rtol=0, atol=1e-12))
        True
    """
    if points < 3 or points % 2 == 0:
        raise RangeError(f"points = {points}: must be odd and at least 3")
    samples = _signal("x", x)
    instants = _instants(time, len(samples))

    def derive(part: np.ndarray, start: int) -> np.ndarray:
        if len(part) == 1:
            return np.full_like(part, np.nan)
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                return _local_derivative(part, instants[start : start + len(part)], points)
        except FloatingPointError:
            steps = np.diff(instants)
            raise RangeError(
                f"time: steps from {steps.min():g} to {steps.max():g} s: too uneven or too small "
                "to differentiate"
            ) from None

    return _by_stretch(samples, derive)


def fill_gaps(x: ArrayLike, time: ArrayLike, *, max_gap: float) -> tuple[Signal, Mask]:
    """Bridge short gaps by a cubic spline through the samples on both sides.

    Gaps at either end and gaps longer than `max_gap` stay.

    Args:
        x: samples (K, ...) with NaN in the gaps.
        time: instants (K,), s.
        max_gap: longest gap to bridge, s, from the last sample before to the first one after.

    Returns:
        The samples, and where they were made up.

    Example:
        >>> t = np.arange(8.0)
        >>> filled, made_up = fill_gaps(np.where(t == 3, np.nan, 2 * t), t, max_gap=2.0)
        >>> float(filled[3]), int(made_up.sum())
        (6.0, 1)
    """
    if not max_gap >= 0.0:
        raise RangeError(f"max_gap = {max_gap:g} s: must not be negative")
    from scipy.interpolate import CubicSpline

    samples = _signal("x", x).copy()
    instants = _instants(time, len(samples))
    columns = samples.reshape(len(samples), -1)
    for column in columns.T:
        whole = list(_stretches(~np.isnan(column)))
        known = np.flatnonzero(~np.isnan(column))
        for (_, left), (right, _) in zip(whole[:-1], whole[1:], strict=True):
            if instants[right] - instants[left - 1] > max_gap:
                continue
            at = int(np.searchsorted(known, left))
            near = known[max(0, at - NEIGHBOURS) : at + NEIGHBOURS]
            column[left:right] = CubicSpline(instants[near], column[near])(instants[left:right])
    return samples, np.isnan(_signal("x", x)) & ~np.isnan(samples)


def resample(
    x: ArrayLike, time: ArrayLike, n_samples: int = 101
) -> tuple[Float[np.ndarray, " samples"], Signal]:
    """Normalise time: read the samples at `n_samples` evenly spaced instants (0 to 100 %).

    Args:
        x: samples (K, ...); an instant inside a gap gives NaN.
        time: instants (K,), s.
        n_samples: how many to give, at least 2 (101: one each percent).

    Returns:
        The instants (n_samples,), s, and the cubic spline's values there.

    Example:
        >>> t = np.array([0.0, 0.2, 0.5, 0.9, 1.0])
        >>> instants, values = resample(t**2, t, 5)
        >>> instants.tolist(), np.round(values, 12).tolist()
        ([0.0, 0.25, 0.5, 0.75, 1.0], [0.0, 0.0625, 0.25, 0.5625, 1.0])
    """
    if n_samples < 2:
        raise RangeError(f"n_samples = {n_samples}: must be at least 2")
    samples = _signal("x", x)
    instants = _instants(time, len(samples))
    if len(samples) < 2:
        raise ShapeError("x: 1 sample; resampling needs at least 2")
    from scipy.interpolate import CubicSpline

    wanted = np.linspace(instants[0], instants[-1], n_samples)
    columns = samples.reshape(len(samples), -1)
    if not np.isnan(columns).any():
        values = CubicSpline(instants, columns)(wanted)
        return wanted, values.reshape(n_samples, *samples.shape[1:])
    out = np.full((n_samples, columns.shape[1]), np.nan)
    for i, column in enumerate(columns.T):
        for start, stop in _stretches(~np.isnan(column)):
            t = instants[start:stop]
            inside = (wanted >= t[0]) & (wanted <= t[-1])
            if len(t) == 1:
                out[inside, i] = column[start]
            elif inside.any():
                out[inside, i] = CubicSpline(t, column[start:stop])(wanted[inside])
    return wanted, out.reshape(n_samples, *samples.shape[1:])


def with_velocities(recording: Recording, *, cutoff: float | None = None) -> Recording:
    """Give `qd` and `xd` by differentiating `q` and `x`, after a low-pass at `cutoff` (Hz).

    Velocities that were recorded are kept. The low-pass also replaces the positions, so that
    positions and velocities belong together.

    Raises:
        RangeError: the recording has no seconds, or one sample, or a hole that a low-pass would
            smear across.

    Example:
        >>> t = np.linspace(0, 1, 101)
        >>> moving = with_velocities(Recording(t, q=np.stack([t, t**2], axis=1)))
        >>> np.round(moving.array("qd")[50], 9).tolist()
        [1.0, 1.0]
    """
    rate = recording.rate
    if rate is None:
        raise RangeError(f"{recording.name}: velocities need a time in seconds and two samples")
    changes: dict[str, np.ndarray] = {}
    for position, velocity in (("q", "qd"), ("x", "xd")):
        if position not in recording.held or velocity in recording.held:
            continue
        values = recording.array(position)
        if cutoff is not None:
            require_even_steps(recording.name, recording.time)
            values = changes[position] = low_pass(values, rate, cutoff)
        changes[velocity] = differentiate(values, recording.time)
    return replace(recording, **changes)


def normalise_time(recording: Recording, n_samples: int = 101) -> Recording:
    """Resample every array of a recording to `n_samples` evenly spaced instants.

    Example:
        >>> t = np.linspace(0, 2, 50)
        >>> normalise_time(Recording(t, q=t[:, None]), 5).time.tolist()
        [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    parts = {
        name: resample(recording.array(name), recording.time, n_samples)[1]
        for name in recording.held
    }
    instants = np.linspace(recording.time[0], recording.time[-1], n_samples)
    return replace(recording, time=instants, **parts)


def _signal(name: str, x: ArrayLike) -> np.ndarray:
    samples = as_float_array(name, x)
    if samples.ndim == 0 or samples.size == 0:
        raise ShapeError(f"{name}: expected samples along axis 0, found shape {samples.shape}")
    refuse_infinite(name, samples)
    return samples


def _instants(time: ArrayLike, n_samples: int) -> np.ndarray:
    instants = as_float_array("time", time, ndim=1)
    require_shape("time", instants, (n_samples,))
    check_time(instants)
    return instants


def _stretches(whole: np.ndarray) -> Iterator[tuple[int, int]]:
    """Yield start and stop of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], whole, [False]])))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _by_stretch(
    samples: np.ndarray, function: Callable[[np.ndarray, int], np.ndarray]
) -> np.ndarray:
    """Apply `function(columns, start)` to the stretches of columns that hold no NaN."""
    columns = samples.reshape(len(samples), -1)
    gaps = np.isnan(columns)
    if not gaps.any():
        return function(columns, 0).reshape(samples.shape)
    out = np.full_like(columns, np.nan)
    # Columns with the same gaps go together: those of a marker, and all markers without any.
    kinds, which = np.unique(gaps, axis=1, return_inverse=True)
    for k, gap in enumerate(kinds.T):
        alike = np.flatnonzero(which == k)
        for start, stop in _stretches(~gap):
            out[start:stop, alike] = function(columns[start:stop, alike], start)
    return out.reshape(samples.shape)


def _fit_spline(
    time: np.ndarray, columns: np.ndarray, noise: float | None
) -> Callable[[np.ndarray, int], np.ndarray]:
    from scipy.interpolate import UnivariateSpline, make_smoothing_spline

    if noise is None:
        # One column at a time: each has its own noise, so each gets its own smoothness.
        splines = [make_smoothing_spline(time, column) for column in columns.T]
        return lambda t, nu: np.stack([spline(t, nu=nu) for spline in splines], axis=1)
    fits = []
    for column in columns.T:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                fits.append(UnivariateSpline(time, column, k=5, s=len(time) * noise**2))
            except UserWarning:
                raise RangeError(
                    f"noise = {noise:g}: no spline with so small a residual was found; raise it"
                ) from None
    return lambda t, nu: np.stack([fit(t, nu) for fit in fits], axis=1)


def _local_derivative(columns: np.ndarray, time: np.ndarray, points: int) -> np.ndarray:
    """Differentiate the polynomial through each sample and its neighbours (barycentric form)."""
    n = len(time)
    size = min(points, n)
    first = np.clip(np.arange(n) - size // 2, 0, n - size)
    nodes = first[:, None] + np.arange(size)
    here = np.arange(n) - first
    apart = time[nodes][:, :, None] - time[nodes][:, None, :]
    apart[:, np.arange(size), np.arange(size)] = 1.0
    barycentric = 1.0 / apart.prod(axis=2)
    rows = np.arange(n)
    weights = barycentric / barycentric[rows, here][:, None] / apart[rows, here]
    weights[rows, here] = 0.0
    weights[rows, here] = -weights.sum(axis=1)
    return np.einsum("kp,kpc->kc", weights, columns[nodes])
