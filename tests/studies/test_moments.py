"""Moments of movements, on speeds whose strokes are known."""

import numpy as np
import pytest

from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError, UnknownNameError
from selfmotion.studies.moments import ConditionMoments, MomentRule, find_moments, read_moments

TIME = np.arange(0.0, 8.0, 0.01)
# Onset, duration and way of reach, transport to the mouth, back, and withdrawal (s, m).
DRINK = ((0.5, 0.8, 0.15), (1.5, 1.2, 0.5), (3.5, 1.2, -0.5), (5.2, 0.8, -0.15))


def moved(strokes) -> tuple[np.ndarray, np.ndarray]:
    """Give path and speed of minimum-jerk strokes along one line."""
    x = np.zeros(len(TIME))
    for start, duration, way in strokes:
        s = np.clip((TIME - start) / duration, 0.0, 1.0)
        x += way * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    path = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    return path, np.abs(np.gradient(x, TIME))


def drink_rules(**more) -> ConditionMoments:
    table = {
        "strokes": 4,
        "grasp": {"stroke": 1, "at": "end"},
        "mid_drink": {"between": [2, 3], "at": "slowest"},
        "halfway": {"between": [2, 3], "at": "middle"},
        "at_mouth": {"at": "farthest"},
    }
    return read_moments({"drink": table | more})["drink"]


def test_the_moments_of_a_drink_are_where_they_were_put():
    path, speed = moved(DRINK)
    at = find_moments(drink_rules(), path, TIME, speed).samples
    assert 0.5 < TIME[at["start"]] < 0.65 and 5.85 < TIME[at["end"]] <= 6.0
    assert 1.15 < TIME[at["grasp"]] <= 1.3
    assert 2.7 <= TIME[at["mid_drink"]] <= 3.5
    assert TIME[at["halfway"]] == pytest.approx(3.1, abs=0.02)
    assert path[at["at_mouth"], 0] == pytest.approx(0.65)


def test_a_movement_with_another_number_of_strokes_says_so():
    path, speed = moved(DRINK[:2])
    found = find_moments(drink_rules(), path, TIME, speed)
    assert set(found.samples) == {"start", "end", "at_mouth"}
    assert found.missing["grasp"] == "2 strokes instead of 4"
    loose = read_moments({"drink": {"late": {"stroke": 3, "at": "peak"}}})["drink"]
    assert "no stroke 3" in find_moments(loose, path, TIME, speed).missing["late"]


def test_a_shallow_hesitation_is_no_stroke_where_four_are_wanted():
    # The reach falls to 36 % of its peak and goes on: five strokes by the usual rule.
    halting = ((0.2, 0.55, 0.08), (0.62, 0.55, 0.08), *DRINK[1:])
    path, speed = moved(halting)
    loose = read_moments({"drink": {"last": {"stroke": 5, "at": "end"}}})["drink"]
    assert "last" in find_moments(loose, path, TIME, speed).samples
    assert not find_moments(drink_rules(), path, TIME, speed).missing


def test_gaps_count_as_rest_and_a_hand_never_seen_is_refused():
    path, speed = moved(DRINK)
    path[:20], speed[:20] = np.nan, np.nan
    assert find_moments(drink_rules(), path, TIME, speed).samples["grasp"] > 100
    with pytest.raises(NotFiniteError, match="never seen"):
        find_moments(drink_rules(), path * np.nan, TIME, speed * np.nan)


def test_without_a_rest_share_start_and_end_are_those_of_the_recording():
    path, speed = moved(DRINK)
    found = find_moments(ConditionMoments(), path, TIME, speed, rest_share=0.0)
    assert dict(found.samples) == {"start": 0, "end": len(TIME) - 1}


@pytest.mark.parametrize(
    ("table", "error", "words"),
    [
        ({"drink": 3}, RangeError, "a table of moments"),
        ({"drink": {"grasp": "end"}}, RangeError, "grasp = 'end'"),
        ({"drink": {"grasp": {"stroke": 1}}}, RangeError, "at = one of"),
        ({"drink": {"grasp": {"stroke": 0, "at": "end"}}}, RangeError, "count from 1"),
        ({"drink": {"grasp": {"stroke": True, "at": "end"}}}, RangeError, "whole number"),
        ({"drink": {"grasp": {"stroke": 1, "at": "stop"}}}, UnknownNameError, "known: start"),
        ({"drink": {"grasp": {"stroke": 1, "at": "slowest"}}}, RangeError, "between = "),
        ({"drink": {"grasp": {"at": "peak"}}}, RangeError, "stroke = N"),
        ({"drink": {"grasp": {"stroke": 1, "at": "farthest"}}}, RangeError, "neither"),
        ({"drink": {"grasp": {"stroke": 1, "when": "end"}}}, UnknownNameError, "when"),
        ({"drink": {"mid": {"between": [3, 2], "at": "slowest"}}}, RangeError, "earlier first"),
        ({"drink": {"mid": {"between": [2], "at": "slowest"}}}, RangeError, "two whole numbers"),
        ({"drink": {"mid": {"between": "23", "at": "slowest"}}}, RangeError, "two whole numbers"),
        (
            {"drink": {"mid": {"between": [1, 2], "stroke": 1, "at": "slowest"}}},
            RangeError,
            "not both",
        ),
        ({"drink": {"strokes": 1, "end2": {"stroke": 2, "at": "end"}}}, RangeError, "2 of 1"),
        ({"drink": {"strokes": 1.5}}, RangeError, "strokes = 1.5"),
        ({"drink": {"strokes": 0}}, RangeError, "at least 1"),
        ({"drink": {"start": {"stroke": 1, "at": "start"}}}, RangeError, "takes no rule"),
    ],
)
def test_broken_rules_are_one_line_that_names_the_condition(table, error, words):
    with pytest.raises(error) as refused:
        read_moments(table)
    assert "moments.drink" in str(refused.value) and words in str(refused.value)
    assert "\n" not in str(refused.value) and isinstance(refused.value, SelfmotionError)


def test_rules_can_be_made_in_code():
    path, speed = moved(DRINK)
    rules = ConditionMoments({"peak": MomentRule("peak", stroke=2)})
    assert TIME[find_moments(rules, path, TIME, speed).samples["peak"]] == pytest.approx(
        2.1, abs=0.02
    )
