"""Compiled sums against plain NumPy and finite differences."""

import numpy as np
import pytest

from selfmotion.methods.weights import kernels
from selfmotion.methods.weights.passes import (
    NO_FEEDBACK,
    Feedback,
    algorithm_sums,
    normal_equations,
    survey,
)
from selfmotion.methods.weights.samples import part_from_arrays, plan_chunks
from tests.methods.ik_samples import projector

THETA = np.array([0.0, -0.7, -0.2, -1.6, -3.0])


def samples_of(rng, K=150, m=3, n=5, trials=7):
    qd, J, q = (
        rng.standard_normal((K, n)),
        rng.standard_normal((K, m, n)),
        rng.standard_normal((K, n)),
    )
    trial = np.arange(K) * trials // K
    part = part_from_arrays("made", qd, J, q=q, trial=trial)
    names = tuple(f"j{i}" for i in range(n))
    samples = plan_chunks(names, (part,), min_clusters=1)
    return samples, survey(samples), (qd, J, q, trial)


def make_feedback(rng, n=5):
    gains = 0.3 * rng.standard_normal((2, n))
    return Feedback(np.array([kernels.POSTURE, kernels.CONSTANT]), gains)


def residuals(arrays, theta, feedback):
    qd, J, q, _ = arrays
    driven = qd.copy()
    if len(feedback.kinds):
        driven -= q * feedback.gains[0] + feedback.gains[1]
    return (projector(J, np.exp(theta)) @ driven[..., None])[..., 0]


@pytest.mark.parametrize("rows", [1, 3, 4])
@pytest.mark.parametrize("fed", [False, True])
def test_normal_equations_are_those_of_the_residual(rows, fed):
    """Cost, gradient and Gauss-Newton matrix from finite differences of plain-NumPy residuals."""
    rng = np.random.default_rng(rows)
    samples, _, arrays = samples_of(rng, m=rows)
    feedback = make_feedback(rng) if fed else NO_FEEDBACK
    U = 15 if fed else 5

    def moved(step):
        gains = feedback.gains + step[5:].reshape(-1, 5) if fed else feedback.gains
        return residuals(arrays, THETA + step[:5], Feedback(feedback.kinds, gains)).ravel()

    sums = normal_equations(samples, np.exp(-0.5 * THETA), feedback, exact=True)
    base, size = moved(np.zeros(U)), 1e-6
    slope = np.stack([(moved(size * e) - moved(-size * e)) / (2 * size) for e in np.eye(U)], axis=1)
    assert sums.cost == pytest.approx(0.5 * base @ base, rel=1e-12)
    np.testing.assert_allclose(sums.gradient, slope.T @ base, atol=1e-6)
    np.testing.assert_allclose(sums.curvature, slope.T @ slope, atol=1e-6)
    np.testing.assert_allclose(sums.gradient_by_cluster.sum(axis=0), sums.gradient, atol=1e-10)
    np.testing.assert_allclose(sums.exact_by_cluster.sum(axis=0), sums.exact, atol=1e-10)


@pytest.mark.parametrize("fed", [False, True])
def test_hessian_is_the_derivative_of_the_gradient(fed):
    rng = np.random.default_rng(3)
    samples, _, _ = samples_of(rng)
    feedback = make_feedback(rng) if fed else NO_FEEDBACK
    U = 15 if fed else 5

    def gradient(step):
        gains = feedback.gains + step[5:].reshape(-1, 5) if fed else feedback.gains
        h = np.exp(-0.5 * (THETA + step[:5]))
        return normal_equations(samples, h, Feedback(feedback.kinds, gains)).gradient

    exact = normal_equations(samples, np.exp(-0.5 * THETA), feedback, exact=True).exact
    slope = np.stack([(gradient(1e-6 * e) - gradient(-1e-6 * e)) / 2e-6 for e in np.eye(U)], axis=1)
    np.testing.assert_allclose(exact, slope, atol=1e-5)


def test_scale_of_the_weights_is_free():
    samples, _, _ = samples_of(np.random.default_rng(4))
    sums = normal_equations(samples, np.exp(-0.5 * THETA))
    np.testing.assert_allclose(sums.curvature @ np.ones(5), 0.0, atol=1e-9)
    assert sums.gradient.sum() == pytest.approx(0.0, abs=1e-9)


def test_a_joint_with_infinite_weight_is_a_chain_without_it():
    rng = np.random.default_rng(5)
    qd, J = rng.standard_normal((60, 5)), rng.standard_normal((60, 2, 5))
    qd[:, 3] = 0.0
    keep = [0, 1, 2, 4]
    whole = plan_chunks(tuple("abcde"), (part_from_arrays("x", qd, J),), min_clusters=1)
    part = part_from_arrays("x", qd[:, keep], J[:, :, keep])
    less = plan_chunks(tuple("abce"), (part,), min_clusters=1)
    survey(whole)
    survey(less)
    h = np.array([1.0, 0.5, 2.0, 0.0, 1.5])
    with_, without = normal_equations(whole, h), normal_equations(less, h[keep])
    assert with_.cost == pytest.approx(without.cost, rel=1e-12)
    np.testing.assert_allclose(with_.curvature[np.ix_(keep, keep)], without.curvature, atol=1e-12)


def test_survey_against_numpy():
    samples, found, (qd, J, _, trial) = samples_of(np.random.default_rng(6))
    null = projector(J, np.ones(5))
    np.testing.assert_allclose(found.moment, qd.T @ qd, atol=1e-10)
    np.testing.assert_allclose(found.coupling, np.abs(null).max(axis=0), atol=1e-10)
    linear = np.einsum("ki,kij,kj->ij", qd, null, qd)
    np.testing.assert_allclose(found.linear, linear, atol=1e-10)
    np.testing.assert_array_equal(found.used_by_cluster, np.bincount(trial))


def test_algorithm_sums_against_numpy():
    samples, _, (qd, J, _, _) = samples_of(np.random.default_rng(7))
    now, before = np.exp(THETA), np.exp(0.5 * THETA)
    sums = algorithm_sums(samples, now, w_before=before, ratio_before=0.6)
    null = (projector(J, now) @ qd[..., None])[..., 0]
    lagged = (projector(J, before) @ qd[..., None])[..., 0]
    np.testing.assert_allclose(sums.cross, null.T @ qd, atol=1e-10)
    error = np.linalg.norm(null - 0.6 * lagged, axis=1).sum()
    assert sums.error == pytest.approx(error, rel=1e-12)


def test_dependent_rows_are_seen_and_nearly_dependent_ones_kept():
    rng = np.random.default_rng(8)
    qd, J = rng.standard_normal((3, 4)), rng.standard_normal((3, 2, 4))
    J[0, 1] = J[0, 0]
    J[1, 1] = J[1, 0] + 1e-4 * J[1, 1]
    samples = plan_chunks(tuple("abcd"), (part_from_arrays("x", qd, J),), min_clusters=1)
    assert survey(samples).n_rank_deficient == 1
    assert samples.keep[0].tolist() == [kernels.RANK_DEFICIENT, kernels.KEPT, kernels.KEPT]
