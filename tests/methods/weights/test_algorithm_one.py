"""Algorithm 1 against its printed form, line by line, and its known habits."""

import numpy as np
import pytest

from selfmotion.errors import RangeError
from selfmotion.methods.identification import (
    IdentificationOptions,
    MotionArrays,
    identify_weights_from_arrays,
)
from selfmotion.methods.weights.algorithm_one import NullSchedule
from tests.methods.ik_samples import pseudo_inverse, random_arm, two_joints

TRUE = np.array([1.0, 0.8, 0.6, 0.4, 0.2])


def printed_algorithm(qd, J, ratio, iterations):
    """Algorithm 1 as printed, lines 1 to 22; H is diagonal, so the box QP is exact by clipping."""
    K, n = qd.shape
    w, V, errors, history = np.ones(n), np.zeros((K, n)), [], [np.ones(n)]
    for _ in range(iterations):
        inverse = pseudo_inverse(J, w)
        xd = (J @ qd[..., None])[..., 0]
        task = (inverse @ xd[..., None])[..., 0]
        errors.append(np.linalg.norm(qd - (task + V), axis=1).mean())
        U = task * w  # line 9: Jᵀ(JW⁻¹Jᵀ)⁻¹ẋ = W J#ẋ
        V = ratio * (qd - task)
        psi, omega = (qd - V).T @ qd, U.T @ qd
        tall = np.concatenate([np.diag(psi[:, j]) for j in range(n)])
        flat = omega.T.ravel()
        H, F = tall.T @ tall, -flat @ tall
        assert np.allclose(H, np.diag(np.diag(H)))
        w = np.clip(-F / np.diag(H), 1e-9, 1.0)
        w = w / w.max()
        history.append(w)
    return np.array(history), np.array(errors)


@pytest.mark.parametrize("ratio", [0.0, 0.6, 0.9])
def test_every_iterate_is_that_of_the_printed_algorithm(ratio):
    qd, J = random_arm(np.random.default_rng(1), TRUE, samples=80, noise=0.3, projected=False)
    history, errors = printed_algorithm(qd, J, ratio, 12)
    options = IdentificationOptions(max_iterations=12)
    found = identify_weights_from_arrays(
        MotionArrays(qd, J), method="paper", null_ratio=ratio, options=options
    )
    np.testing.assert_allclose(found.history, history, atol=1e-10)
    np.testing.assert_allclose(found.error_history[:12], errors, atol=1e-10)
    assert not found.status


def test_more_null_ratio_needs_more_iterations():
    """Fig 2: iterations to come within 0.01 grow with γ on independent data."""
    qd, J = random_arm(np.random.default_rng(2), TRUE, samples=500)
    counts = []
    for ratio in (0.0, 0.6, 0.9):
        found = identify_weights_from_arrays(MotionArrays(qd, J), method="paper", null_ratio=ratio)
        close = np.linalg.norm(found.history - TRUE, axis=1) < 0.01
        counts.append(int(np.argmax(close)))
    assert sorted(counts) == counts and 5 < counts[2] / counts[0] < 20


def test_example_two_without_null_ratio_takes_the_wrong_joint():
    q, qd, J = two_joints()
    options = IdentificationOptions(max_iterations=400)

    def end(ratio):
        return identify_weights_from_arrays(
            MotionArrays(qd, J), method="paper", null_ratio=ratio, options=options
        )

    assert end(0.0).full_weights[0] < 0.01 and end(0.0).full_weights[1] == 1.0
    high = end(0.9)
    assert high.full_weights[0] == 1.0 and high.full_weights[1] < 0.05
    assert len(q) == 60


def test_full_null_ratio_changes_nothing():
    qd, J = random_arm(np.random.default_rng(3), TRUE, samples=100)
    found = identify_weights_from_arrays(MotionArrays(qd, J), method="paper", null_ratio=1.0)
    np.testing.assert_array_equal(found.history, np.ones((1, 5)))
    assert not found.status and "changes nothing" in found.status.sentence
    assert np.isnan(found.weights).all()


def test_printed_schedule_freezes_and_a_given_one_is_followed():
    qd, J = random_arm(np.random.default_rng(4), TRUE, samples=200)
    frozen = identify_weights_from_arrays(
        MotionArrays(qd, J), method="paper", null_ratio=0.6, null_schedule="printed"
    )
    assert not frozen.status and "froze" in frozen.status.sentence
    assert np.linalg.norm(frozen.full_weights - TRUE) > 0.1
    given = identify_weights_from_arrays(
        MotionArrays(qd, J), method="paper", null_ratio=[0.9, 0.5, 0.0]
    )
    assert given.status
    np.testing.assert_allclose(given.weights, TRUE, atol=1e-6)


def test_schedule():
    assert [NullSchedule((0.1, 0.2)).at(t) for t in (0, 1, 5)] == [0.1, 0.2, 0.2]
    steps = 1.0 - np.array([NullSchedule(0.6, "printed").at(t) for t in range(60)])
    assert steps.sum() == pytest.approx(2 / 3)  # of one iteration with γ = 0
    with pytest.raises(RangeError, match="allowed is 0 to 1"):
        NullSchedule((0.5, 1.2))
