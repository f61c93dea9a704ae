"""Ranges from single-joint recordings: hand-worked ends, spikes, repeats, and what is refused."""

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.capture.ranges import RangeRule, joint_moved, joint_range
from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.motion.recording import Recording


def swing(low: float, high: float, *, repeats: int = 3, rate: float = 100.0) -> np.ndarray:
    """Give angles (rad) that hold each end for half a second."""
    hold = int(0.5 * rate)
    up = np.linspace(low, high, int(rate))
    once = [np.full(hold, low), up, np.full(hold, high), up[::-1]]
    return np.deg2rad(np.concatenate(once * repeats))


def recorded(angles: np.ndarray, *, rate: float = 100.0, timed: bool = True) -> Recording:
    time = np.arange(len(angles)) / (rate if timed else 1.0)
    return Recording(time, q=angles[:, None], joints=("elbow_flexion",), timed=timed)


def test_ends_that_are_held_are_the_limits() -> None:
    found = joint_range("elbow_flexion", [recorded(swing(64.2, 114.0))])
    assert np.degrees([found.low, found.high]) == pytest.approx([64.2, 114.0], abs=1e-9)
    assert found.repeats == 3
    assert found.scatter == pytest.approx(0.0, abs=1e-9)


def test_a_spike_of_a_few_frames_sets_no_limit_and_resting_longer_changes_nothing() -> None:
    angles = swing(10.0, 130.0)
    angles[1000:1005] = np.deg2rad(175.0)
    rest = np.concatenate([angles, np.full(20_000, np.deg2rad(10.0))])
    for q in (angles, rest):
        found = joint_range("elbow_flexion", [recorded(q)])
        assert np.degrees([found.low, found.high]) == pytest.approx([10.0, 130.0], abs=1e-9)


def test_the_end_is_where_the_joint_was_for_the_time_asked() -> None:
    # 100 degrees in a second at 100 Hz: 0.1 s beyond an end is ten samples of a degree.
    ramp = recorded(np.deg2rad(np.arange(101.0)))
    found = joint_range("elbow_flexion", [ramp], rule=RangeRule(held=0.1))
    assert np.degrees([found.low, found.high]) == pytest.approx([9.0, 91.0])
    untimed = recorded(np.deg2rad(np.arange(1001.0) / 10), timed=False)
    found = joint_range("elbow_flexion", [untimed], rule=RangeRule(tail=0.01))
    assert np.degrees([found.low, found.high]) == pytest.approx([0.9, 99.1])


def test_the_farthest_of_several_recordings_counts_and_scatter_is_of_the_turns() -> None:
    parts = [recorded(swing(0.0, high, repeats=1)) for high in (100.0, 104.0, 102.0)]
    found = joint_range("elbow_flexion", parts)
    assert np.degrees(found.high) == pytest.approx(104.0)
    assert np.degrees(found.scatter) == pytest.approx(2.0)
    assert found.repeats == 3


def test_gaps_are_left_out() -> None:
    angles = swing(5.0, 95.0)
    angles[30:60] = np.nan
    found = joint_range("elbow_flexion", [recorded(angles)])
    assert np.degrees([found.low, found.high]) == pytest.approx([5.0, 95.0], abs=1e-9)


def test_a_joint_that_cannot_move_has_a_range_of_nothing() -> None:
    found = joint_range("elbow_flexion", [recorded(np.full(50, 1.0))])
    assert (found.low, found.high, found.repeats) == (1.0, 1.0, 0)


def test_which_joint_is_tested() -> None:
    arm = load_arm("upper_limb")
    q = np.zeros((300, 9))
    q[:, 5] = swing(20.0, 120.0, repeats=1)
    q[:, 2] = 0.1 * q[:, 5]
    time = np.arange(300) / 100
    assert joint_moved(Recording(time, q=q, joints=arm.joints), arm) == "elbow_flexion"
    q[:, 2] = 1.5 * q[:, 5]
    with pytest.raises(RangeError, match="shoulder_flexion and elbow_flexion both move|elbow_flex"):
        joint_moved(Recording(time, q=q, joints=arm.joints), arm)
    with pytest.raises(RangeError, match="holds no angles of upper_limb"):
        joint_moved(Recording(time, q=q[:, :1], joints=("knee",)), arm)


def test_bad_recordings_are_refused() -> None:
    wrapped = swing(100.0, 260.0)
    wrapped[wrapped > np.pi] -= 2 * np.pi
    with pytest.raises(RangeError, match=r"elbow_flexion jumps by 3\d\d degrees at"):
        joint_range("elbow_flexion", [recorded(wrapped)])
    with pytest.raises(RangeError, match="5 samples of elbow_flexion; a range needs at least 10"):
        joint_range("elbow_flexion", [recorded(np.zeros(5))])
    with pytest.raises(RangeError, match="0 recordings"):
        joint_range("elbow_flexion", [])
    two = Recording(np.arange(20.0), q=np.zeros((20, 2)), joints=("a", "b"))
    with pytest.raises(UnknownNameError, match="elbow_flexion"):
        joint_range("elbow_flexion", [two])
    with pytest.raises(RangeError, match="held = -1"):
        RangeRule(held=-1.0)
