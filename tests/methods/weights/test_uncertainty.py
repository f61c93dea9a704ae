"""Standard errors against the scatter of repeated data."""

import numpy as np
import pytest

from selfmotion.methods.identification import (
    IdentificationOptions,
    MotionArrays,
    identify_weights_from_arrays,
)
from selfmotion.methods.weights.uncertainty import eliminate_feedback, scaled_pseudo_inverse
from tests.methods.ik_samples import planar_reaches, random_arm

TRUE = np.array([1.0, 0.5, 0.2])


def reaching_people(runs, trials=20, noise=0.15):
    rng = np.random.default_rng(7)
    for _ in range(runs):
        sets = planar_reaches(rng, TRUE, trials=trials, samples=12, noise=noise)
        q, qd, J = (np.concatenate(part) for part in zip(*sets, strict=True))
        yield MotionArrays(qd, J, q=q, trial=np.repeat(np.arange(trials), 12))


@pytest.mark.parametrize("kind", ["sandwich", "jackknife"])
def test_clustered_errors_match_the_scatter(kind):
    """Null-space bumps are shared by a whole trial, so errors by sample would be far too small."""
    estimates, errors = [], []
    options = IdentificationOptions(stderr=kind, hash_inputs=False)
    for arrays in reaching_people(80):
        found = identify_weights_from_arrays(arrays, options=options)
        ratios = [found.log_ratio(name, "joint_1") for name in ("joint_2", "joint_3")]
        estimates.append([value for value, _ in ratios])
        errors.append([error for _, error in ratios])
    scatter = np.std(estimates, axis=0, ddof=1)
    low, high = (0.7, 1.2) if kind == "sandwich" else (0.8, 1.4)
    ratio = np.sqrt(np.mean(np.square(errors), axis=0)) / scatter
    assert np.all((ratio > low) & (ratio < high)), ratio


def test_errors_of_algorithm_one_match_its_scatter():
    rng = np.random.default_rng(9)
    estimates, errors = [], []
    options = IdentificationOptions(tolerance=1e-4, hash_inputs=False)
    for _ in range(40):
        qd, J = random_arm(rng, TRUE, samples=300, rows=2, noise=0.2)
        arrays = MotionArrays(qd, J, trial=np.repeat(np.arange(30), 10))
        found = identify_weights_from_arrays(
            arrays, method="paper", null_ratio=0.3, options=options
        )
        value, error = found.log_ratio("joint_3", "joint_1")
        estimates.append(value)
        errors.append(error)
    assert 0.7 < np.sqrt(np.mean(np.square(errors))) / np.std(estimates, ddof=1) < 1.35


def test_interval_and_kinds():
    arrays = next(reaching_people(1))
    found = identify_weights_from_arrays(arrays)
    interval = found.interval(0.9)
    assert np.all(interval[:, 0] <= found.weights) and np.all(found.weights <= interval[:, 1])
    top = int(np.nanargmax(found.weights))
    assert found.stderr_log[top] == 0.0 and interval[top].tolist() == [1.0, 1.0]
    one = identify_weights_from_arrays(MotionArrays(arrays.qd, arrays.jacobian))
    assert one.stderr_kind.startswith("single trial: 5 stretches")
    frame = found.to_frame()
    assert list(frame["joint"]) == list(found.joints) and frame["reason"].tolist() == [""] * 3


def test_scaled_pseudo_inverse_is_a_generalised_inverse():
    rng = np.random.default_rng(1)
    A = rng.standard_normal((6, 3)) * [1.0, 1e-3, 1e3]
    M = np.zeros((4, 4))
    M[:3, :3] = A.T @ A
    np.testing.assert_allclose(M @ scaled_pseudo_inverse(M) @ M, M, rtol=1e-9)


def test_eliminating_feedback_is_solving_for_it():
    rng = np.random.default_rng(2)
    A = rng.standard_normal((20, 5))
    M, g = A.T @ A, rng.standard_normal(5)
    schur, profiled = eliminate_feedback(M, g, 2)
    np.testing.assert_allclose(np.linalg.solve(schur, profiled), np.linalg.solve(M, g)[:2])
