import numpy as np
import pytest
from scipy.optimize import Bounds, approx_fprime, minimize

from selfmotion.arms import load_arm, srs7
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.redundancy import nearest
from selfmotion.redundancy.manifold import ManifoldFinder
from selfmotion.redundancy.nearest import METRES_A_RAD, nearest_posture
from selfmotion.spatial import log_rotation


@pytest.fixture(scope="module")
def arm():
    return load_arm("myoarm")


def pose_of(arm, q):
    return forward_kinematics(arm.chain, q, arm.tip("hand"))[0]


def cost(q, arm, T):
    here = pose_of(arm, q)
    turn = log_rotation(T[:3, :3].T @ here[:3, :3])
    return float(np.sum((here[:3, 3] - T[:3, 3]) ** 2) + METRES_A_RAD**2 * (turn @ turn))


def test_the_slope_is_that_of_the_residual(arm):
    rng = np.random.default_rng(0)
    for q, other in zip(arm.random_postures(4, rng), arm.random_postures(4, rng), strict=True):
        T = pose_of(arm, other)
        expected = np.array(approx_fprime(q, nearest._residual, 1e-7, arm, T))
        np.testing.assert_allclose(nearest._slope(q, arm, T), expected, atol=1e-5)


def test_no_other_solver_comes_nearer(arm):
    """Against SciPy's L-BFGS-B from many other starts."""
    rng = np.random.default_rng(1)
    for q in arm.random_postures(1, rng):
        T = pose_of(arm, q)
        T[:3, 3] += [0.2, -0.9, 0.1]
        found = nearest_posture(arm, T, arm.random_postures(12, rng))
        assert not found.reached
        bounds = Bounds(arm.lower, arm.upper)
        others = [
            float(minimize(cost, start, args=(arm, T), method="L-BFGS-B", bounds=bounds).fun)
            for start in arm.random_postures(3, rng)
        ]
        assert cost(found.q, arm, T) <= min(others) * (1 + 1e-4)
        total = found.distance**2 + (METRES_A_RAD * found.turn) ** 2
        assert total == pytest.approx(cost(found.q, arm, T))


def test_straight_ahead_the_distance_is_known():
    arm = srs7()
    home = np.clip(np.zeros(7), arm.lower, arm.upper)
    points = [
        forward_kinematics(arm.chain, home, arm.tip(n))[0, :3, 3] for n in ("shoulder", "hand")
    ]
    reach = float(np.linalg.norm(points[1] - points[0]))
    straight = pose_of(arm, home)
    if abs(reach - sum(arm.lengths.values())) > 1e-9:
        pytest.skip("the arm is not straight at home")
    along = (points[1] - points[0]) / reach
    straight[:3, 3] += 0.25 * along
    found = nearest_posture(arm, straight, arm.middle()[None])
    assert found.distance == pytest.approx(0.25, abs=1e-4)
    assert found.turn == pytest.approx(0.0, abs=1e-3)


def test_failures_say_which_kind_they_are(arm):
    finder = ManifoldFinder.of(arm)
    T = pose_of(arm, [0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1])
    far = T.copy()
    far[:3, 3] += 3.0
    assert finder.find(far).status.sentence.startswith("out of reach: the nearest hand pose found")
    narrow = arm.with_limits({"pro_sup": (1.3, 1.5), "elbow_flexion": (0.0, 0.2)})
    sentence = ManifoldFinder.of(narrow).find(T).status.sentence
    assert sentence.startswith("outside the joint limits (")
    assert "beyond its limit): the nearest hand pose found is" in sentence


def test_a_pose_that_is_reached_is_found_from_anywhere(arm):
    q = arm.random_postures(3, np.random.default_rng(5))
    for T in forward_kinematics(arm.chain, q, arm.tip("hand")):
        assert nearest_posture(arm, T, arm.random_postures(12, np.random.default_rng(6))).reached
