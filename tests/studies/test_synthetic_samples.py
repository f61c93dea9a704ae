"""The samples of the numerical examples have the structure that the paper gives them."""

import numpy as np
import pytest

from selfmotion.redundancy.projection import project
from selfmotion.studies.synthetic_samples import TwoJointSettings, random_samples, two_joint_run


def test_projected_noise_does_not_move_the_hand():
    quiet = random_samples(rng=np.random.default_rng(1), sigma=0.0, n_samples=50)
    noisy = random_samples(rng=np.random.default_rng(1), sigma=0.5, n_samples=50, projected=True)
    hands = [np.einsum("kij,kj->ki", r.array("jacobian"), r.array("qd")) for r in (quiet, noisy)]
    np.testing.assert_allclose(hands[0], hands[1], atol=1e-12)


def test_without_noise_nothing_is_left_to_the_null_space():
    w = [1.0, 0.5, 0.1]
    made = random_samples(w, rng=np.random.default_rng(2), n_rows=2, sigma=0.0, n_samples=40)
    rest = np.einsum("kij,kj->ki", project(made.array("jacobian"), w).null, made.array("qd"))
    assert np.abs(rest).max() < 1e-12


def test_first_step_of_example_2_by_hand():
    """x = x_g at the start: only the pull on the first joint acts, -1/s · 0.5."""
    run = two_joint_run(TwoJointSettings(gain=3.0))
    np.testing.assert_allclose(run.array("qd")[0], [-0.5, 0.0], atol=1e-15)
    # Then x = 0.95: the hand wants 3·0.05 = 0.15, shared 0.01 : 1 by the inverse weights.
    share = np.array([0.01, 1.0]) / 1.01
    np.testing.assert_allclose(run.array("qd")[1], share * 0.15 - [0.45, 0.0], atol=1e-12)


def test_example_2_has_the_papers_length():
    run = two_joint_run()
    assert run.n_samples == 60 and run.rate == pytest.approx(10.0)
