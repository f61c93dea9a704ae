"""Identified weights against true ones, published numbers and an independent optimiser."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from selfmotion.errors import SelfmotionError
from selfmotion.methods.identification import (
    IdentificationOptions,
    MotionArrays,
    identify_weights,
    identify_weights_from_arrays,
)
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import GapWarning, Recording, Study
from tests.methods.ik_samples import (
    planar_reaches,
    projector,
    random_arm,
    reach_jacobian,
    two_joints,
)

TRUE = np.array([1.0, 0.8, 0.6, 0.4, 0.2])


def identify(qd, J, method: Any = "ml", **more):
    arrays = {k: more.pop(k) for k in ("trial", "q", "xd", "joints") if k in more}
    return identify_weights_from_arrays(MotionArrays(qd, J, **arrays), method=method, **more)


@pytest.mark.parametrize("method", ["ml", "paper", "feedback"])
@pytest.mark.parametrize("rows", [2, 3, 4])
def test_recovers_true_weights_without_null_space_motion(method, rows):
    rng = np.random.default_rng(rows)
    qd, J = random_arm(rng, TRUE, samples=300, rows=rows)
    found = identify(qd, J, method, q=rng.standard_normal(qd.shape), null_ratio=0.6)
    assert found.status
    np.testing.assert_allclose(found.weights, TRUE, atol=1e-6)
    np.testing.assert_allclose(found.contribution, (1 / TRUE) / (1 / TRUE).sum(), atol=1e-6)


@pytest.mark.parametrize("start", ["ones", (0.01, 1.0, 3.0, 0.1, 5.0)])
def test_reaches_the_same_weights_from_elsewhere(start):
    qd, J = random_arm(np.random.default_rng(3), TRUE, samples=300)
    found = identify(qd, J, options=IdentificationOptions(start=start))
    np.testing.assert_allclose(found.weights, TRUE, atol=1e-9)
    assert 1 < found.iterations <= 10


def test_example_one_of_the_paper_has_the_published_error():
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(100):  # as many as the paper
        qd, J = random_arm(rng, TRUE, samples=500, noise=0.2, projected=False)
        options = IdentificationOptions(tolerance=3e-3, hash_inputs=False)
        found = identify(qd, J, "paper", null_ratio=0.6, options=options)
        errors.append(np.linalg.norm(found.full_weights - TRUE))
    assert np.mean(errors) == pytest.approx(0.07, abs=0.01)


def test_maximum_likelihood_stands_independent_null_space_motion():
    rng = np.random.default_rng(5)
    qd, J = random_arm(rng, TRUE, samples=50_000, noise=0.5)
    assert np.linalg.norm(identify(qd, J).weights - TRUE) <= 0.01
    paper = identify(qd, J, "paper", null_ratio=0.6)
    assert np.linalg.norm(paper.full_weights - TRUE) > 0.1  # biased, at every γ


@pytest.mark.parametrize("gain", [2.0, 5.0])
def test_example_two_is_exact_with_posture_feedback_alone(gain):
    q, qd, J = two_joints(gain)
    found = identify(qd, J, "feedback", q=q)
    np.testing.assert_allclose(found.weights, [1.0, 0.01], rtol=1e-9)
    assert found.unexplained < 1e-20
    posture, constant = found.feedback_gains
    shown = projector(J[:1], [1.0, 0.01])[0] @ (posture * q[7] + constant)
    np.testing.assert_allclose(shown, projector(J[:1], [1.0, 0.01])[0] @ [-q[7, 0], 0.0], atol=1e-9)
    assert abs(np.log(identify(qd, J).full_weights[1] / 0.01)) > 0.2


def test_agrees_with_an_independent_optimiser():
    rng = np.random.default_rng(11)
    qd, J = random_arm(rng, TRUE, samples=120, noise=0.4, projected=False)

    def cost(theta):
        null = projector(J, np.exp(np.append(0.0, theta))) @ qd[..., None]
        return 0.5 * float((null**2).sum())

    best = minimize(cost, np.zeros(4), method="BFGS", options={"gtol": 1e-9})
    found = identify(qd, J)
    np.testing.assert_allclose(np.log(found.weights / found.weights[0])[1:], best.x, atol=1e-5)
    unexplained = 2 * best.fun / (qd**2).sum()
    assert found.unexplained == pytest.approx(unexplained, rel=1e-9)
    identity = (projector(J, np.ones(5)) @ qd[..., None]) ** 2
    assert found.unexplained_identity == pytest.approx(identity.sum() / (qd**2).sum(), rel=1e-9)
    assert found.error_history[-1] == pytest.approx(np.sqrt(2 * best.fun / 120), rel=1e-9)


def test_recordings_and_one_array_with_trials_give_the_same():
    sets = planar_reaches(np.random.default_rng(1), np.array([1.0, 0.5, 0.2]), trials=12)
    recordings = [
        Recording(
            np.arange(len(q)) / 50, q=q, qd=qd, jacobian=J, joints=("hip", "shoulder", "elbow")
        )
        for q, qd, J in sets
    ]
    pooled = identify_weights(Study(tuple(recordings)))
    arrays = [np.concatenate(part) for part in zip(*sets, strict=True)]
    trial = np.repeat(np.arange(12), 40)
    joined = identify(arrays[1], arrays[2], trial=trial)
    shuffled = np.random.default_rng(2).permutation(len(trial))
    mixed = identify(arrays[1][shuffled], arrays[2][shuffled], trial=trial[shuffled])
    assert pooled.n_trials == joined.n_trials == 12
    assert pooled.stderr_kind == "clustered by trial (jackknife)"
    assert pooled.joints == ("hip", "shoulder", "elbow")
    for other in (joined, mixed):
        np.testing.assert_allclose(other.weights, pooled.weights, rtol=1e-9)
        np.testing.assert_allclose(other.stderr_log, pooled.stderr_log, rtol=1e-6)


def test_does_not_depend_on_threads(monkeypatch):
    rng = np.random.default_rng(4)
    qd, J = random_arm(rng, TRUE, samples=70_000, noise=0.3)
    trial = np.repeat(np.arange(70), 1000)
    results = []
    for threads in (1, 2):
        monkeypatch.setattr(
            "selfmotion.methods.weights.samples.numba.get_num_threads", lambda t=threads: t
        )
        results.append(identify(qd, J, trial=trial))
    np.testing.assert_array_equal(results[0].weights, results[1].weights)
    np.testing.assert_array_equal(results[0].stderr_log, results[1].stderr_log)


def test_gaps_are_dropped_and_counted():
    qd, J = random_arm(np.random.default_rng(6), TRUE, samples=200)
    qd[3, 1], J[10, 0, 0] = np.nan, np.nan
    with pytest.warns(GapWarning, match="2 of 200 samples hold NaN"):
        found = identify(qd, J)
    assert (found.n_samples, found.n_dropped) == (198, 2)
    np.testing.assert_allclose(found.weights, TRUE, atol=1e-9)


def test_singular_samples_are_left_out_and_counted():
    qd, J = random_arm(np.random.default_rng(7), TRUE, samples=200)
    J[5, 1] = 2.0 * J[5, 0]
    with pytest.warns(UserWarning, match="1 of 200 samples are left out"):
        found = identify(qd, J)
    assert found.n_rank_deficient == 1
    np.testing.assert_allclose(found.weights, TRUE, atol=1e-9)


def test_inputs_are_neither_copied_nor_changed():
    qd, J = random_arm(np.random.default_rng(8), TRUE, samples=100, noise=0.1)
    before = qd.copy(), J.copy()
    qd.setflags(write=False)
    identify(qd, J)
    np.testing.assert_array_equal(qd, before[0])
    np.testing.assert_array_equal(J, before[1])
    assert J.flags.writeable


def test_one_sample_hand_case_is_not_trusted():
    found = identify(np.array([[0.1, 0.9], [0.1, 0.9]]), np.ones((2, 1, 2)))
    assert np.isnan(found.weights).all() and not found.status
    assert "too few samples" in found.unidentifiable["joint_1"]


def bad(**change):
    qd, J = random_arm(np.random.default_rng(9), TRUE, samples=50)
    fields = {"qd": qd, "jacobian": J} | change
    return MotionArrays(**fields)


GOOD_QD, GOOD_J = random_arm(np.random.default_rng(9), TRUE, samples=50)
INFINITE = GOOD_QD.copy()
INFINITE[4, 2] = np.inf


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"qd": INFINITE}, r"qd\[4, 2\] = inf; allowed are finite"),
        ({"qd": np.zeros((50, 5))}, "zero in all 50 samples"),
        ({"qd": np.full((50, 5), np.nan)}, "0 usable sample"),
        ({"qd": GOOD_QD[:1], "jacobian": GOOD_J[:1]}, "1 usable sample.* at least 2"),
        ({"qd": GOOD_QD[:40]}, r"jacobian: expected shape \(40, any, 5\), found \(50, 3, 5\)"),
        ({"qd": GOOD_QD[:, 0]}, "expected 2 dimension"),
        ({"qd": GOOD_QD[:0], "jacobian": GOOD_J[:0]}, "0 samples"),
        ({"xd": GOOD_QD[:, :3] + 5.0}, "xd differs from jacobian @ qd by .* allowed is 10 %"),
        ({"xd": GOOD_QD[:, :2]}, "xd: expected shape"),
        ({"jacobian": np.zeros((50, 3, 5))}, "rank-deficient in all 50 samples"),
        ({"jacobian": np.ones((50, 5, 5))}, "5 task rows for 5 joints"),
        ({"trial": np.arange(3)}, r"trial has shape \(3,\); allowed is \(50,\)"),
        ({"joints": ("a",)}, "1 joint names for 5 joints"),
    ],
)
def test_bad_data_is_refused_in_one_line(change, words):
    with pytest.raises(SelfmotionError, match=words) as caught:
        identify_weights_from_arrays(bad(**change))
    assert "\n" not in str(caught.value)


def test_bad_options_are_refused():
    arrays = bad()
    for call, words in [
        (lambda: identify_weights_from_arrays(arrays, method="feedback"), "q needed"),
        (lambda: identify_weights_from_arrays(arrays, null_ratio=1.5), "allowed is 0 to 1"),
        (lambda: identify_weights([]), "0 recordings"),
        (lambda: IdentificationOptions(feedback_terms=("speed",)), "posture, constant"),
        (lambda: IdentificationOptions(max_stderr=0.0), "more than 0"),
    ]:
        with pytest.raises(SelfmotionError, match=words):
            call()


def test_a_recording_without_jacobian_is_named():
    still = Recording(np.arange(4.0), q=np.zeros((4, 3)), labels=Labels(subject="P1"))
    with pytest.raises(SelfmotionError, match="P1.*qd and jacobian needed"):
        identify_weights(still)


def test_jacobian_of_the_helper_is_a_derivative():
    q = np.array([[0.2, 0.5, -0.4]])
    lengths = np.array([0.3, 0.25, 0.2])

    def hand(p):
        a = np.cumsum(p)
        return np.array([(lengths * np.cos(a)).sum(), (lengths * np.sin(a)).sum()])

    for i, step in enumerate(np.eye(3) * 1e-6):
        slope = (hand(q[0] + step) - hand(q[0] - step)) / 2e-6
        np.testing.assert_allclose(reach_jacobian(q)[0, :, i], slope, atol=1e-9)
