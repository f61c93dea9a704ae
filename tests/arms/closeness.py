"""What the tests of arms compare with, and how closely."""

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.kinematics.forward import forward_kinematics

RNG_SEED = 3


def equal(actual: ArrayLike, expected: ArrayLike, message: str = "") -> None:
    a, b = np.asarray(actual), np.asarray(expected)
    np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-13, err_msg=message)


def random_angles(n: int, k: int = 20) -> np.ndarray:
    return np.random.default_rng(RNG_SEED).uniform(-np.pi, np.pi, (k, n))


def hand(arm, q) -> np.ndarray:
    return forward_kinematics(arm.chain, q, arm.tip("hand"))
