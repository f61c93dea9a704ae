"""The studio without a browser: what a drag, a slider or a button leads to."""

import json
from pathlib import Path

import numpy as np
import pytest

from selfmotion.errors import UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.natural_posture import natural_posture
from selfmotion.viewer.state import load_state, save_state

REACH = Path(__file__).parents[2] / "examples" / "reach.csv"


def test_a_moved_target_gives_the_natural_posture(studio):
    T = studio.posture.hand_pose()
    T[:3, 3] += [0.03, -0.02, 0.02]
    studio.posture.restore(T, None)
    assert studio.settle()
    shown, wanted = studio.posture.shown, natural_posture(studio.model, T)
    np.testing.assert_allclose(shown.q, wanted.q, atol=1e-6)
    hand = forward_kinematics(studio.model.arm.chain, shown.q, studio.model.arm.tip("hand"))[0]
    np.testing.assert_allclose(hand, T, atol=1e-6)


def test_a_chosen_swivel_angle_keeps_the_hand(studio):
    T = studio.posture.hand_pose()
    low, high = studio.posture.shown.found.feasible_swivel[0]
    studio.posture.restore(T, float(np.degrees(0.5 * (low + high))))
    assert studio.settle()
    shown = studio.posture.shown
    assert shown.swivel == pytest.approx(0.5 * (low + high), abs=np.radians(0.5))
    assert shown.effort >= shown.found.effort
    hand = forward_kinematics(studio.model.arm.chain, shown.q, studio.model.arm.tip("hand"))[0]
    np.testing.assert_allclose(hand, T, atol=1e-6)
    studio.posture.restore(T, None)


def test_a_target_out_of_reach_is_said_and_the_arm_stays(studio):
    T = studio.posture.hand_pose()
    far = T.copy()
    far[:3, 3] += [0.0, -3.0, 0.0]
    studio.posture.restore(far, None)
    assert studio.settle()
    assert "The arm stays" in studio.message.content
    studio.posture.restore(T, None)
    assert studio.settle()
    assert studio.message.content == ""


def test_a_splint_takes_workspace_away(studio):
    studio.reach.restore({}, splint=True)
    studio.reach.show()
    assert studio.settle()
    regions = studio.reach.shown.regions
    assert 0.3 < regions["limited"].volume / regions["free"].volume < 0.9
    assert "Lost" in studio.reach._words.content
    studio.reach.restore({}, splint=False)
    assert studio.settle()
    assert studio.reach.shown.regions["lost"].volume == 0.0


def test_a_recording_is_opened_sought_and_played(studio):
    studio.playback.open(REACH)
    studio.playback.seek(0.3)
    assert studio.playback.time() == pytest.approx(0.3)
    assert "exoskeleton" in studio.playback._words.content
    studio.playback.seek(99.0)
    assert studio.playback.time() == pytest.approx(studio.playback.playback.time[-1])


def test_a_saved_state_restores_what_was_set(studio, tmp_path):
    studio.playback.open(REACH)
    studio.playback.seek(0.25)
    studio.reach.restore({"elbow_flexion": (20.0, 100.0)}, splint=False)
    before = studio.state()
    path = save_state(tmp_path / "studio.json", before)
    studio.reach.restore({"elbow_flexion": (0.0, 130.0)}, splint=True)
    studio.playback.seek(0.0)
    studio.restore(load_state(path))
    assert studio.settle()
    after = studio.state()
    assert json.loads(path.read_text())["limits_deg"] == {"elbow_flexion": [20.0, 100.0]}
    assert after.limits_deg == before.limits_deg and after.splint == before.splint
    assert after.time == pytest.approx(before.time)
    np.testing.assert_allclose(np.array(after.hand), np.array(before.hand), atol=1e-6)
    with pytest.raises(UnknownNameError):
        studio.reach.restore({"knee": (0.0, 1.0)}, splint=False)


def test_the_scene_is_one_page_without_the_network(studio, tmp_path):
    page = studio.export(tmp_path / "scene.html").read_text(encoding="utf-8")
    assert "__VISER_EMBED_DATA__" in page
    assert 'src="http' not in page and "cdn." not in page
