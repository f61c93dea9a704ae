"""The swivel angle on cases worked by hand, and on arms."""

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.kinematics.swivel import arm_swivel_angle, swivel_angle
from selfmotion.spatial import rotation_about

# x right, y forward, z up; the hand is 0.4 m straight in front of the shoulder.
SHOULDER, WRIST, DOWN = [0.0, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, -1.0]


@pytest.mark.parametrize(
    ("elbow", "degrees"),
    [
        ((0.0, 0.2, -0.2), 0.0),  # below
        ((0.2, 0.2, 0.0), 90.0),  # to the right
        ((-0.2, 0.2, 0.0), -90.0),  # to the left
        ((0.0, 0.2, 0.2), 180.0),  # straight above, where the printed form gives 0
        ((0.1, 0.1, -0.1), 45.0),
        ((0.1, 0.3, 0.1), 135.0),
        ((-0.1, 0.3, 0.1), -135.0),
        ((np.sin(1e-9), 0.2, -np.cos(1e-9)), np.degrees(1e-9)),  # exact near zero
    ],
)
def test_hand_cases(elbow, degrees):
    angle = swivel_angle(SHOULDER, elbow, WRIST, down=DOWN)
    assert np.degrees(angle[0]) == pytest.approx(degrees, rel=1e-6, abs=1e-12)


def test_it_is_how_far_the_elbow_has_turned_about_the_line():
    rng = np.random.default_rng(0)
    shoulder, wrist = rng.normal(size=3), rng.normal(size=3)
    line = wrist - shoulder
    down = np.array([0.3, -0.2, -0.9])
    below = shoulder + 0.4 * line + 0.1 * (down - line * (down @ line) / (line @ line))
    for turn in np.linspace(-3.0, 3.0, 13):
        # Seen along the line from shoulder to wrist, from below to the right is left-handed.
        elbow = shoulder + rotation_about(-line, turn) @ (below - shoulder)
        angle = swivel_angle(shoulder, elbow, wrist, down=down)[0]
        assert angle == pytest.approx(turn, abs=1e-12)


def test_printed_form_agrees_away_from_its_bad_points():
    rng = np.random.default_rng(1)
    S, E, W = rng.normal(size=(3, 50, 3))
    g = np.array(DOWN)
    arm, ref = np.cross(W - S, E - S), np.cross(W - S, g)
    norms = np.linalg.norm(arm, axis=1) * np.linalg.norm(ref, axis=1)
    printed = np.sign(arm @ g) * np.arccos(np.sum(arm * ref, axis=1) / norms)
    np.testing.assert_allclose(swivel_angle(S, E, W, down=g), printed, atol=1e-7)


@pytest.mark.parametrize(
    ("elbow", "wrist"),
    [
        ((0.0, 0.2, 0.0), (0.0, 0.4, 0.0)),  # a straight arm
        ((0.1, 0.0, -0.2), (0.0, 0.0, -0.4)),  # the hand straight below the shoulder
        ((0.1, 0.2, 0.0), (0.0, 0.0, 0.0)),  # the hand in the shoulder
        ((0.0, 0.0, 0.0), (0.0, 0.4, 0.0)),  # the elbow in the shoulder
    ],
)
def test_where_it_does_not_exist_it_is_nan(elbow, wrist):
    assert np.isnan(swivel_angle(SHOULDER, elbow, wrist, down=DOWN)).all()


def test_bad_input():
    with pytest.raises(ShapeError, match="shoulder, elbow and wrist have 1, 2 and 3 samples"):
        swivel_angle(SHOULDER, np.ones((2, 3)), np.ones((3, 3)), down=DOWN)
    with pytest.raises(ShapeError, match="elbow: expected shape"):
        swivel_angle(SHOULDER, [0.0, 1.0], WRIST, down=DOWN)
    with pytest.raises(NotFiniteError, match="wrist"):
        swivel_angle(SHOULDER, [0.0, 1.0, 0.0], [np.nan, 0.0, 0.0], down=DOWN)
    with pytest.raises(RangeError, match="down"):
        swivel_angle(SHOULDER, [0.0, 1.0, 0.0], WRIST, down=[0.0, 0.0, 0.0])


def test_elbow_of_the_anatomical_arm():
    arm = load_arm("upper_limb_anatomical")
    q = np.zeros(9)
    q[arm.joints.index("shoulder_adduction")] = np.pi / 2  # out to the right
    q[arm.joints.index("elbow_flexion")] = np.pi / 2  # forearm forward
    assert np.degrees(arm_swivel_angle(arm, q)[0]) == pytest.approx(90.0)


def test_shoulder_centre_is_taken_at_rest_where_it_moves():
    arm = load_arm("myoarm")
    q = np.array([0.6, 1.0, 0.2, 1.2, 0.1, 0.0, 0.0])
    points = {
        key: forward_kinematics(arm.chain, q, arm.tip(key))[:, :3, 3] for key in ("elbow", "wrist")
    }
    home = forward_kinematics(arm.chain, np.zeros(7), arm.tip("shoulder"))[0, :3, 3]
    expected = swivel_angle(home, points["elbow"], points["wrist"], down=DOWN)
    np.testing.assert_allclose(arm_swivel_angle(arm, q), expected, atol=1e-12)
