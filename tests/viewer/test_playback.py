from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.motion.recording import Recording
from selfmotion.viewer.open_recording import open_recording
from selfmotion.viewer.playback import make_playback, plan_beside

REACH = Path(__file__).parents[2] / "examples" / "reach.csv"


@pytest.fixture(scope="module")
def opened():
    return open_recording(REACH)


def test_the_arm_is_found_by_its_joints(opened):
    assert opened[1].name == "exoskeleton"


def test_hand_velocity_is_the_slope_of_the_path_drawn(opened):
    playback = make_playback(*opened)
    slope = np.gradient(playback.line[:, 3], playback.time, axis=0)
    error = np.linalg.norm(slope - playback.hand_velocity, axis=1)[2:-2]
    assert error.max() < 0.05 * np.linalg.norm(playback.hand_velocity, axis=1).max()


def test_task_and_null_space_add_up(opened):
    playback = make_playback(*opened)
    both = playback.parted.task + playback.parted.null
    assert (playback.task_speed**2 + playback.null_speed**2).sum() == pytest.approx(
        (both**2).sum(), rel=1e-9
    )  # all weights alike: the parts are orthogonal


def test_the_plan_starts_and_ends_with_the_recording(opened):
    playback, planned = make_playback(*opened), plan_beside(*opened)
    np.testing.assert_allclose(planned.line[0], playback.line[0], atol=1e-9)
    way = np.linalg.norm(playback.line[-1, 3] - playback.line[0, 3])
    assert np.linalg.norm(planned.line[-1, 3] - playback.line[-1, 3]) < 0.1 * way
    assert planned.time[-1] == pytest.approx(playback.time[-1])


def test_weights_as_damping_change_the_posture_and_not_the_end(opened):
    alike = plan_beside(*opened)
    weighted = plan_beside(*opened, weights=np.array([1.0, 0.1, 1.0, 0.1]))
    assert np.abs(alike.line[-1, 1] - weighted.line[-1, 1]).max() > 1e-4
    np.testing.assert_allclose(alike.line[-1, 3], weighted.line[-1, 3], atol=0.03)


def test_gaps_inside_are_refused():
    arm = load_arm("wrist")
    q = np.zeros((20, 3))
    q[:, 1] = np.linspace(0, 0.3, 20)
    q[10] = np.nan
    recording = Recording(np.arange(20) / 100, q=q, joints=arm.joints)
    with pytest.raises(RangeError, match="gaps"):
        make_playback(recording, arm)


def test_a_file_of_another_creature_is_refused(tmp_path):
    path = tmp_path / "horse.csv"
    path.write_text("time,fetlock,stifle\n0,0.1,0.2\n0.01,0.1,0.2\n")
    with pytest.raises(FileFormatError, match="fetlock, stifle"):
        open_recording(path)
