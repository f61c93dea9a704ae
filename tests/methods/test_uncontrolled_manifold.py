"""UCM variances on cases that can be worked by hand."""

import numpy as np
import pytest

from selfmotion.errors import RangeError, ShapeError
from selfmotion.methods.uncontrolled_manifold import manifold_variance
from selfmotion.motion.recording import Recording

TIME = np.arange(3.0)


def trials(deviations, jacobian):
    J = np.repeat(np.asarray(jacobian, dtype=float)[None], 3, axis=0)
    return [
        Recording(TIME, q=np.repeat(np.asarray(d, dtype=float)[None], 3, axis=0), jacobian=J)
        for d in deviations
    ]


def test_two_joints_by_hand():
    """Hand = q1 + q2. Deviations ±(1, -1) keep it, ±(0.5, 0.5) do not."""
    found = manifold_variance(trials([(1, -1), (-1, 1), (0.5, 0.5), (-0.5, -0.5)], [[1, 1]]))
    # along: (2 + 2)/4 = 1; across: (0.5 + 0.5)/4 = 0.25; total per dof 0.625
    np.testing.assert_allclose(found.along, 1.0)
    np.testing.assert_allclose(found.across, 0.25)
    np.testing.assert_allclose(found.synergy, 0.75 / 0.625)
    np.testing.assert_allclose(found.synergy_z, 0.5 * np.log((2 + 1.2) / (2 - 1.2)))
    assert found.variable == "q" and found.n_trials == 4 and found.dof[0].tolist() == [1, 1]


def test_four_fingers_reach_the_bounds_of_the_index():
    """n = 4, m = 1: ΔV lies in [-4, 4/3]."""
    only_along = manifold_variance(trials([(1, -1, 0, 0), (-1, 1, 0, 0)], [[1, 1, 1, 1]]))
    only_across = manifold_variance(trials([(1, 1, 1, 1), (-1, -1, -1, -1)], [[1, 1, 1, 1]]))
    np.testing.assert_allclose(only_along.synergy, 4 / 3)
    np.testing.assert_allclose(only_across.synergy, -4.0)


def test_isotropic_variance_is_no_synergy():
    rng = np.random.default_rng(0)
    found = manifold_variance(trials(rng.standard_normal((1000, 4)), rng.standard_normal((2, 4))))
    assert abs(found.synergy[0]) < 0.1
    np.testing.assert_allclose(found.along[0], 1.0, atol=0.06)


def test_velocities_stand_in_for_postures_and_it_says_so():
    J = np.ones((3, 1, 2))
    made = [Recording(TIME, qd=np.full((3, 2), s), jacobian=J) for s in (1.0, -1.0)]
    found = manifold_variance(made)
    assert found.variable == "qd"
    np.testing.assert_allclose(found.along, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.across, 2.0)
    assert list(found.to_frame().columns)[0] == "phase"


def test_one_trial_is_refused():
    with pytest.raises(RangeError, match="1 trial; at least 2"):
        manifold_variance(trials([(1, 1)], [[1, 1]]))


def test_a_joint_that_never_moves_the_task_does_not_count():
    """The same two joints with an idle third: its variance is neither kept nor spent."""
    idle = [(1, -1, 3), (-1, 1, 0), (0.5, 0.5, -2), (-0.5, -0.5, 0)]
    found = manifold_variance(trials(idle, [[1, 1, 0]]))
    np.testing.assert_allclose(found.synergy, 0.75 / 0.625)
    assert found.joints == ("joint_1", "joint_2") and found.dof[0].tolist() == [1, 1]
    with pytest.raises(ShapeError, match="no joint moves the task"):
        manifold_variance(trials([(1, 1), (0, 0)], [[0, 0]]))
