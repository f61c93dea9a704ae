"""Strokes of recordings with several movements."""

import numpy as np
import pytest

from selfmotion.errors import NotFiniteError, RangeError
from selfmotion.motion.strokes import StrokeRules, find_strokes, movement_span

TIME = np.arange(0.0, 6.0, 0.01)


def bell(start: float, duration: float, length: float) -> np.ndarray:
    """Give the speed of a minimum-jerk movement."""
    s = np.clip((TIME - start) / duration, 0.0, 1.0)
    return length / duration * 30.0 * s**2 * (1.0 - s) ** 2


def test_three_strokes_with_pauses_are_found_with_their_lengths():
    speed = bell(0.5, 0.8, 0.3) + bell(2.0, 1.0, 0.5) + bell(4.0, 0.8, 0.5)
    strokes = find_strokes(speed, TIME, rules=StrokeRules(share=0.01))
    assert [round(float(TIME[s.peak]), 2) for s in strokes] == [0.9, 2.5, 4.4]
    np.testing.assert_allclose([s.length for s in strokes], [0.3, 0.5, 0.5], rtol=0.01)
    assert [s.peak_speed for s in strokes] == [speed[s.peak] for s in strokes]


def test_a_deep_valley_parts_two_strokes_and_a_shallow_one_does_not():
    deep = bell(0.5, 1.0, 0.4) + bell(1.25, 1.0, 0.4)
    shallow = bell(0.5, 1.0, 0.4) + bell(1.0, 1.0, 0.4)
    assert len(find_strokes(deep, TIME)) == 2
    assert len(find_strokes(shallow, TIME)) == 1


def test_twitches_do_not_count():
    speed = bell(0.5, 1.0, 0.4) + bell(3.0, 0.06, 0.004) + bell(4.0, 0.5, 0.01)
    assert len(find_strokes(speed, TIME)) == 1


def test_the_span_holds_all_strokes():
    speed = bell(0.5, 0.8, 0.3) + bell(4.0, 0.8, 0.5)
    first, last = movement_span(speed)
    assert 0.5 < TIME[first] < 0.65 and 4.65 < TIME[last] < 4.8
    assert speed[first] < 0.05 * speed.max() <= speed[first + 1]
    gappy = speed.copy()
    gappy[100:120] = np.nan
    assert movement_span(gappy) == (first, last)


def test_refusals():
    with pytest.raises(RangeError, match="nothing moves"):
        find_strokes(np.zeros(600), TIME)
    with pytest.raises(RangeError, match="nothing moves"):
        movement_span([np.nan, 0.0])
    with pytest.raises(NotFiniteError):
        find_strokes(np.full(600, np.nan), TIME)
    with pytest.raises(RangeError, match="valley = 2"):
        StrokeRules(valley=2.0)
