"""Filters against what they must satisfy: known gains, no phase, exact polynomials."""

import numpy as np
import pytest

from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.motion import Recording
from selfmotion.motion.filters import (
    differentiate,
    fill_gaps,
    low_pass,
    normalise_time,
    resample,
    smoothing_spline,
    with_velocities,
)

RATE = 200.0
TIME = np.arange(4000) / RATE
MIDDLE = slice(1000, 3000)  # away from the ends, where the filter has settled


def gain_and_phase(x: np.ndarray, frequency: float) -> tuple[float, float]:
    wave = np.exp(-2j * np.pi * frequency * TIME[MIDDLE])
    value = 2j * np.mean(x[MIDDLE] * wave)
    return float(abs(value)), float(np.angle(value))


@pytest.mark.parametrize("order", [2, 4, 8])
@pytest.mark.parametrize("cutoff", [5.0, 40.0])
def test_gain_at_cutoff_is_one_over_root_two_without_phase(cutoff, order):
    gain, phase = gain_and_phase(
        low_pass(np.sin(2 * np.pi * cutoff * TIME), RATE, cutoff, order=order), cutoff
    )
    assert gain == pytest.approx(np.sqrt(0.5), abs=1e-6)
    assert phase == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("frequency", [2.0, 8.0, 20.0])
def test_gain_is_that_of_two_butterworth_passes(frequency):
    """By hand: |H|^2 = 1 / (1 + r^(2n)), r the ratio of warped frequencies, n the order a pass."""
    cutoff, each = 6.0, 2
    ratio = np.tan(np.pi * frequency / RATE) / np.tan(np.pi * cutoff / RATE)
    expected = 1.0 / (1.0 + (np.sqrt(2.0) - 1.0) * ratio ** (2 * each))
    gain, phase = gain_and_phase(
        low_pass(np.sin(2 * np.pi * frequency * TIME), RATE, cutoff), frequency
    )
    assert gain == pytest.approx(expected, abs=1e-6)
    assert phase == pytest.approx(0.0, abs=1e-6)


def test_low_pass_is_symmetric_in_time():
    x = np.random.default_rng(0).normal(size=(400, 2))
    forward, backward = low_pass(x, 100.0, 6.0), low_pass(x[::-1], 100.0, 6.0)[::-1]
    np.testing.assert_allclose(forward[60:-60], backward[60:-60], atol=1e-6)


def test_low_pass_keeps_lines_and_gaps():
    line = np.stack([np.linspace(0, 1, 100), np.linspace(3, -2, 100)], axis=1)
    holed = line.copy()
    holed[40:45, 1] = np.nan
    holed[98, 1] = np.nan  # leaves a lone sample at the end
    out = low_pass(holed, 100.0, 5.0)
    np.testing.assert_array_equal(np.isnan(out), np.isnan(holed))
    np.testing.assert_allclose(out[~np.isnan(holed)], line[~np.isnan(holed)], atol=1e-5)


def test_a_gap_never_leaks():
    """What lies on one side of a gap must not depend on the other side."""
    x = np.random.default_rng(1).normal(size=300)
    x[150:160] = np.nan
    y = x.copy()
    y[160:] += 5.0
    for f in (
        lambda v: low_pass(v, 100.0, 8.0),
        lambda v: differentiate(v, np.arange(300) / 100),
        lambda v: smoothing_spline(v, np.arange(300) / 100, noise=1.0),
    ):
        np.testing.assert_array_equal(f(x)[:150], f(y)[:150])


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"cutoff": 50.0}, "cutoff = 50 Hz"),
        ({"cutoff": 0.0}, "cutoff = 0 Hz"),
        ({"rate": 0.0}, "rate = 0 Hz"),
        ({"order": 3}, "order = 3"),
    ],
)
def test_low_pass_refuses(arguments, word):
    options = {"rate": 100.0, "cutoff": 6.0, "order": 4} | arguments
    with pytest.raises(RangeError, match=word):
        low_pass(np.zeros(50), options["rate"], options["cutoff"], order=options["order"])


def test_infinite_samples_are_refused():
    with pytest.raises(NotFiniteError, match=r"x\[3\] = inf"):
        low_pass(np.where(np.arange(50) == 3, np.inf, 0.0), 100.0, 6.0)


@pytest.mark.parametrize("points", [3, 5, 7])
def test_derivative_of_polynomials_is_exact_on_uneven_time(points):
    rng = np.random.default_rng(2)
    time = np.cumsum(rng.uniform(0.5, 1.5, 40)) * 0.02
    for _ in range(5):
        p = np.polynomial.Polynomial(rng.normal(size=points))  # degree points - 1
        np.testing.assert_allclose(
            differentiate(p(time), time, points=points), p.deriv()(time), atol=1e-9
        )


def test_derivative_shapes_gaps_and_short_stretches():
    time = np.arange(10.0)
    q = np.stack([time**2, -time], axis=1)
    jac = np.stack([q, 2 * q], axis=1)
    np.testing.assert_allclose(differentiate(jac, time)[:, 1, 0], 4 * time, atol=1e-9)
    q[[3, 5], 0] = np.nan  # leaves 0:3, a lone sample at 4, and 6:10
    out = differentiate(q, time)
    np.testing.assert_allclose(out[:, 1], -1.0, atol=1e-12)
    assert np.flatnonzero(np.isnan(out[:, 0])).tolist() == [3, 4, 5]
    np.testing.assert_allclose(out[[0, 1, 2, 6, 7], 0], 2 * time[[0, 1, 2, 6, 7]], atol=1e-9)


@pytest.mark.parametrize("noise", [None, 1e-9, 0.01])
def test_smoothing_spline_of_a_parabola(noise):
    """A cubic or quintic holds a parabola; a smooth curve costs the cubic next to nothing."""
    time = np.linspace(0.0, 2.0, 60)
    x = np.stack([time, 1 - 0.5 * time], axis=1)
    np.testing.assert_allclose(smoothing_spline(x, time, noise=noise), x, atol=1e-6)
    np.testing.assert_allclose(
        smoothing_spline(x, time, noise=noise, derivative=1), [[1.0, -0.5]] * 60, atol=1e-5
    )


def test_smoothing_spline_removes_noise():
    time = np.linspace(0, 2, 400)
    clean = np.sin(2 * np.pi * time)
    noisy = clean + np.random.default_rng(3).normal(scale=0.05, size=400)
    for noise in (None, 0.05):
        left = smoothing_spline(noisy, time, noise=noise) - clean
        assert np.sqrt(np.mean(left**2)) < 0.015  # less than a third of what went in
        velocity = smoothing_spline(noisy, time, noise=noise, derivative=1)
        error = velocity - 2 * np.pi * np.cos(2 * np.pi * time)
        assert np.sqrt(np.mean(error[20:-20] ** 2)) < 0.5


def test_smoothing_spline_refuses():
    time = np.arange(10.0)
    with pytest.raises(RangeError, match="derivative = 3"):
        smoothing_spline(time, time, derivative=3)
    with pytest.raises(RangeError, match="noise = 0"):
        smoothing_spline(time, time, noise=0.0)
    with pytest.raises(ShapeError, match="4 samples between gaps at sample 6"):
        smoothing_spline(np.where(time == 5, np.nan, time), time)


def test_fill_gaps_bridges_only_short_inner_ones():
    time = np.arange(30) / 10
    x = time**3 - time
    holed = np.stack([x, x], axis=1)
    holed[:2, 0] = np.nan  # at the start: stays
    holed[10:12, 0] = np.nan  # 0.3 s from sample to sample: bridged
    holed[20:26, 0] = np.nan  # 0.7 s: stays
    filled, made_up = fill_gaps(holed, time, max_gap=0.31)
    assert np.flatnonzero(made_up[:, 0]).tolist() == [10, 11] and not made_up[:, 1].any()
    np.testing.assert_allclose(filled[10:12, 0], x[10:12], atol=1e-9)  # a cubic holds a cubic
    assert np.isnan(filled[[0, 1, 20, 25], 0]).all()
    assert np.isnan(holed[10, 0])  # the input is untouched


def test_resample_ends_gaps_and_cubic():
    time = np.linspace(1.0, 3.0, 21)
    x = np.stack([time**3, time], axis=1)
    instants, values = resample(x, time, 41)
    assert instants[0] == 1.0 and instants[-1] == 3.0 and values.shape == (41, 2)
    np.testing.assert_allclose(values[:, 0], instants**3, atol=1e-9)
    x[10, 1] = np.nan  # 2.0 s
    holed = resample(x, time, 41)[1]
    assert np.isnan(holed[:, 1]).tolist() == [bool(1.9 + 1e-9 < t < 2.1 - 1e-9) for t in instants]
    np.testing.assert_allclose(holed[:, 0], instants**3, atol=1e-9)


def test_velocities_of_a_recording():
    time = np.linspace(0, 2, 201)
    q = np.stack([np.sin(time), time**2], axis=1)
    moving = with_velocities(Recording(time, q=q, x=q[:, :1]))
    np.testing.assert_allclose(moving.array("qd")[:, 0], np.cos(time), atol=1e-8)
    np.testing.assert_allclose(moving.array("xd")[:, 0], np.cos(time), atol=1e-8)
    smoothed = with_velocities(Recording(time, q=q), cutoff=10.0)
    np.testing.assert_allclose(
        smoothed.array("qd"), differentiate(low_pass(q, 100.0, 10.0), time), atol=1e-9
    )
    kept = with_velocities(Recording(time, q=q, qd=q))
    np.testing.assert_array_equal(kept.array("qd"), q)
    with pytest.raises(RangeError, match="time in seconds"):
        with_velocities(Recording(np.arange(5.0), q=np.zeros((5, 1)), timed=False))


def test_normalise_time_resamples_every_array():
    time = np.linspace(0, 2, 33)
    rec = Recording(
        time, qd=np.stack([time, -time], axis=1), jacobian=np.ones((33, 1, 2)) * time[:, None, None]
    )
    out = normalise_time(rec, 11)
    assert out.n_samples == 11 and out.array("jacobian").shape == (11, 1, 2)
    np.testing.assert_allclose(out.array("qd")[:, 1], -np.linspace(0, 2, 11), atol=1e-12)


def test_holes_in_time_are_refused_where_a_filter_would_smear_across_them():
    t = np.concatenate([np.arange(50), np.arange(90, 150)]) / 100.0
    with pytest.raises(RangeError, match="steps by 0.41 s after 0.49 s"):
        with_velocities(Recording(t, q=t[:, None]), cutoff=6.0)
    unfiltered = with_velocities(Recording(t, q=t[:, None]))
    np.testing.assert_allclose(unfiltered.array("qd"), 1.0, atol=1e-9)
    rounded = np.round(np.arange(100) / 480.0, 3)  # steps of 2 and 3 ms
    with_velocities(Recording(rounded, q=rounded[:, None]), cutoff=6.0)
