import numpy as np
import pytest

from selfmotion.arms import planar, upper_limb
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.methods.passive.potentials import (
    EffortPotential,
    ElasticPotential,
    GravityPotential,
    JointLimitPotential,
    positive_definite,
)

ARM = upper_limb()
POTENTIALS = {
    "elastic": ElasticPotential(np.diag(np.arange(1.0, 10.0)) + 0.2, np.linspace(-0.3, 0.5, 9)),
    "gravity": GravityPotential(ARM, share=0.7),
    "limits": JointLimitPotential(np.full(9, -0.6), np.full(9, 0.6), margin=0.3, strength=4.0),
    "effort": EffortPotential(lambda q: np.sin(q).prod(axis=1) + (q**3).sum(axis=1), scale=0.5),
}


@pytest.mark.parametrize("name", POTENTIALS)
def test_gradient_and_hessian_agree_with_differences(name):
    potential = POTENTIALS[name]
    q = np.random.default_rng(0).uniform(-0.55, 0.55, (3, 9))
    g, H, h = potential.gradient(q), potential.hessian(q), 1e-5
    for i, e in enumerate(np.eye(9)):
        slope = (potential.energy(q + h * e) - potential.energy(q - h * e)) / (2 * h)
        np.testing.assert_allclose(g[:, i], slope, atol=2e-6)
        bend = (potential.gradient(q + h * e) - potential.gradient(q - h * e)) / (2 * h)
        np.testing.assert_allclose(H[:, :, i], bend, atol=2e-4)


def test_limits_are_not_felt_in_the_middle():
    wall = POTENTIALS["limits"]
    assert wall.energy(np.zeros((1, 9)))[0] == 0.0
    with pytest.raises(RangeError, match="more than twice the margin"):
        JointLimitPotential(np.array([-0.1]), np.array([0.1]), margin=0.2)


def test_weight_of_a_straight_arm_by_hand():
    arm = planar([0.3, 0.25])
    # The force of gravity is the share that is not supported.
    full, half = (GravityPotential(arm, share=s).gradient(np.zeros((1, 2))) for s in (1.0, 0.5))
    np.testing.assert_allclose(half, 0.5 * full)


@pytest.mark.parametrize(
    ("matrix", "error", "words"),
    [
        ([[1.0, 0.5], [0.4, 1.0]], RangeError, r"stiffness\[0, 1\] = 0.5 but \[1, 0\] = 0.4"),
        ([[1.0, 2.0], [2.0, 1.0]], RangeError, "smallest eigenvalue is -1"),
        ([[1.0, np.inf], [np.inf, 1.0]], NotFiniteError, "not finite"),
        ([[1.0]], ShapeError, r"expected shape \(2, 2\)"),
    ],
)
def test_stiffness_must_be_symmetric_and_positive_definite(matrix, error, words):
    with pytest.raises(error, match=words):
        positive_definite("stiffness", matrix, 2)
