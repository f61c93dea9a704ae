import numpy as np
import pytest

from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.motion.segment import (
    equally_spaced,
    movement_bounds,
    path_length,
    stands_apart,
)


def test_bounds_are_the_last_and_first_slow_samples_around_the_peak():
    t = np.linspace(0.0, 1.0, 1001)
    speed = 30.0 * t**2 * (1.0 - t) ** 2  # minimum jerk: 20 % of the peak where (t(1-t))² = 1/80
    exact = 0.5 - np.sqrt(0.25 - np.sqrt(1.0 / 80.0))
    bounds = movement_bounds(speed)
    assert t[bounds.onset] <= exact < t[bounds.onset + 1]
    assert t[bounds.offset - 1] < 1.0 - exact <= t[bounds.offset]
    assert bounds.peak == 500
    assert bounds.complete


def test_an_earlier_twitch_does_not_count():
    speed = [0.0, 0.3, 0.0, 0.1, 1.0, 0.5, 0.1, 0.6, 0.0]
    assert (movement_bounds(speed).onset, movement_bounds(speed).offset) == (3, 6)


def test_a_cut_movement_is_not_complete():
    bounds = movement_bounds([0.5, 1.0, 0.7, 0.1])
    assert (bounds.onset, bounds.offset, bounds.complete) == (0, 3, False)


@pytest.mark.parametrize(
    ("speed", "error", "words"),
    [
        ([0.0, 0.0, 0.0], RangeError, "nothing moves"),
        ([0.0, -1.0, 2.0], RangeError, r"speed\[1\]"),
        ([0.0, np.nan, 2.0], NotFiniteError, "not finite"),
        ([1.0, 2.0], ShapeError, "at least 3"),
    ],
)
def test_bad_speeds_are_refused(speed, error, words):
    with pytest.raises(error, match=words):
        movement_bounds(speed)
    with pytest.raises(RangeError, match="share = 1"):
        movement_bounds([0.0, 1.0, 0.0], share=1.0)


def test_standing_apart_is_two_interquartile_ranges():
    # Quartiles of 0..8 are 2 and 6: more than 8 away from 4 stands apart.
    values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    assert not stands_apart(values).any()
    assert stands_apart([*values[:-1], 12.5]).tolist() == [False] * 8 + [True]
    assert len(stands_apart([])) == 0


def test_equally_spaced_samples_include_the_ends():
    t = np.array([0.0, 0.1, 0.4, 1.0])
    found = equally_spaced(t, np.stack([2 * t, 1 - t], axis=1))
    np.testing.assert_allclose(found[:, 0], np.linspace(0.0, 2.0, 20), atol=1e-15)
    with pytest.raises(RangeError, match="increase"):
        equally_spaced([0.0, 1.0, 0.5], np.zeros((3, 2)))


def test_length_of_a_path():
    assert path_length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == 6.0
