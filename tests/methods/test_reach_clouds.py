"""Recorded positions against a workspace: depths known by hand, shares, refusals."""

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import NotFiniteError, RangeError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.reach_clouds import clouds_frame, compare_clouds
from selfmotion.methods.workspace import WorkspaceOptions, workspace
from tests.methods.test_workspace import telescope


@pytest.fixture(scope="module")
def shell():
    return workspace(telescope(), options=WorkspaceOptions(n_points=2048, shifts=4))


def test_signed_distance_to_a_shell(shell):
    """The telescope reaches what lies between 0.3 and 0.5 m from the origin."""
    r = np.array([0.1, 0.25, 0.32, 0.4, 0.47, 0.55, 0.8])
    rng = np.random.default_rng(4)
    u = rng.standard_normal((len(r), 3))
    points = r[:, None] * u / np.linalg.norm(u, axis=1, keepdims=True)
    (cloud,) = compare_clouds(shell, {"a": points})
    true = np.maximum(0.3 - r, r - 0.5)
    outside = true > 0
    np.testing.assert_array_equal(cloud.inside, ~outside)
    np.testing.assert_allclose(cloud.distance[outside], true[outside], atol=1e-4)
    depth, known = -cloud.distance[~outside], -true[~outside]
    assert (depth >= known - 1e-9).all()  # never less than it is, and over by the spacing at most
    assert (depth <= known + cloud.spacing).all()
    assert cloud.spacing < 0.04


def test_share_used(shell):
    """A cloud all over the shell uses all of it; one point the ball around it."""
    free = shell.regions["free"]
    everywhere, single = compare_clouds(
        shell, {"all": free.points[free.inside], "one": [[0.4, 0.0, 0.0]]}
    )
    assert everywhere.used[0] == 1.0
    ball = 0.05**3 / (0.5**3 - 0.3**3)
    assert single.used[0] == pytest.approx(ball, abs=5e-4)
    table = clouds_frame((everywhere, single))
    assert table["inside_percent"].tolist() == [100.0, 100.0]
    assert table["outside_most_mm"].tolist() == [0.0, 0.0]


def test_sides_body_and_limits():
    arm = load_arm("upper_limb")
    limited = arm.with_limits({"elbow_flexion": (1.12, 1.99)})
    options = WorkspaceOptions(n_points=256, shifts=2)
    space = workspace(arm, limited=limited, options=options, blocked=lambda x: x[:, 2] < -0.3)
    q = arm.random_postures(200, np.random.default_rng(5))
    x = forward_kinematics(arm.chain, q, arm.tip("hand"))[:, :3, 3]
    (free,) = compare_clouds(space, {"r": x})
    (kept,) = compare_clouds(space, {"r": x}, region="limited")
    assert free.inside.all() and 0.3 < kept.inside.mean() < 1.0
    assert (kept.distance[~kept.inside] > 0).all()
    np.testing.assert_array_equal(free.in_body, x[:, 2] < -0.3)
    assert free.sides["in_front"] == pytest.approx((x[:, 1] > 0).mean())
    assert free.sides["above"] == pytest.approx((x[:, 2] > 0).mean())
    assert free.sides["outwards"] == pytest.approx((x[:, 0] > 0.188).mean())


def test_what_is_refused(shell):
    with pytest.raises(UnknownNameError, match="unknown region 'limited'"):
        compare_clouds(shell, {"a": [[0.4, 0.0, 0.0]]}, region="limited")
    with pytest.raises(RangeError, match="0 points"):
        compare_clouds(shell, {"a": np.zeros((0, 3))})
    with pytest.raises(NotFiniteError):
        compare_clouds(shell, {"a": [[np.nan, 0.0, 0.0]]})
