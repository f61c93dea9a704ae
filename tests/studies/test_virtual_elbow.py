"""Eq. 25 and the simulated person against cases worked by hand."""

import numpy as np
import pytest

from selfmotion.arms import hip_shoulder_elbow
from selfmotion.redundancy.projection import project
from selfmotion.redundancy.task import Planar
from selfmotion.studies.simulated_screen import short_protocol, simulate_screen
from selfmotion.studies.virtual_elbow import OBEYS, AssistiveElbow, commanded_velocity


def test_one_step_of_eq_25_by_hand():
    """J = [1 1 1], W = diag(1, 1, .15): J#_3 = (20/3)/(26/3) = 10/13, N_3 = (-10, -10, 3)/13."""
    elbow = AssistiveElbow()
    J = np.array([[[1.0, 1.0, 1.0]]])
    q = np.array([[0.1, -2.2, 0.5]])  # K (q - q̂) = (2·0.1, 0.2·0.5, 0) = (0.2, 0.1, 0)
    found = elbow.velocity(J, q, np.array([[0.26]]))
    assert found[0] == pytest.approx(0.26 * 10 / 13 + (0.2 + 0.1) * 10 / 13, abs=1e-12)


def test_filter_solves_its_differential_equation():
    elbow = AssistiveElbow()
    v, hand, h = np.array([[0.0, 0.3]]), np.array([[1.0, -0.5]]), 1e-6
    rate = (elbow.filter(v, hand, h) - v) / h
    np.testing.assert_allclose(rate, -40.0 * (v - hand), rtol=1e-4)


def test_limits_stop_the_elbow_at_zero_and_pi():
    elbow, step = AssistiveElbow(), 0.02
    q3, wanted = np.array([0.01, np.pi - 0.01, 1.0]), np.array([-5.0, 5.0, 2.0])
    after = q3 + step * elbow.within_limits(q3, wanted, step)
    np.testing.assert_allclose(after, [0.0, np.pi, 1.04], atol=1e-12)


def test_person_without_damping_follows_the_weighted_inverse():
    rng = np.random.default_rng(3)
    J, w = rng.standard_normal((4, 2, 3)), np.array([1.0, 0.6, 0.02])
    wanted = rng.standard_normal((4, 2))
    found = commanded_velocity(J, np.tile(w, (4, 1)), wanted, np.zeros((4, 3)), 1e-9)
    expected = np.einsum("kij,kj->ki", project(J, w).inverse, wanted)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("condition", list(OBEYS))
def test_what_obeys(condition):
    own = np.array([0.1, 0.2, 0.3])
    expected = {"Natural": 0.3, "Locked": 0.0, "Coupled": 0.2, "Assistive": 0.0}[condition]
    np.testing.assert_allclose(OBEYS[condition] @ own, [0.1, 0.2, expected])


@pytest.fixture(scope="module")
def screen():
    return simulate_screen(hip_shoulder_elbow(), short_protocol(), rng=np.random.default_rng(4))


def test_everybody_reaches_the_targets(screen):
    assert screen.miss.max() < 0.01


def test_elbow_rules_hold_in_the_recordings(screen):
    for recording in screen.study.select(condition="Locked"):
        assert not recording.array("qd")[:, 2].any()
    for recording in screen.study.select(condition="Coupled"):
        np.testing.assert_allclose(
            recording.array("qd")[:, 2], recording.array("qd")[:, 1], atol=1e-12
        )
    for recording in screen.study.select(condition="Assistive"):
        assert (
            -1e-9 <= recording.array("q")[:, 2].min()
            and recording.array("q")[:, 2].max() <= np.pi + 1e-9
        )


def test_jacobians_belong_to_the_postures(screen):
    recording = screen.study[5]
    task = Planar(hip_shoulder_elbow())
    np.testing.assert_allclose(task.value(recording.array("q")), recording.array("x"), atol=1e-12)
    step = 1e-6
    moved = task.value(recording.array("q") + step * recording.array("qd")) - recording.array("x")
    np.testing.assert_allclose(moved / step, recording.array("xd"), atol=1e-4)


def test_same_seed_same_people():
    arm, few = hip_shoulder_elbow(), short_protocol(n_people=1, n_targets=1)
    one, two = (simulate_screen(arm, few, rng=np.random.default_rng(4)).study for _ in range(2))
    np.testing.assert_array_equal(one[3].array("q"), two[3].array("q"))
