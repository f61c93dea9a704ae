"""The split against its identities and the paper's hand-worked case."""

import numpy as np
import pytest

from selfmotion.errors import SelfmotionError
from selfmotion.methods.identification import identify_weights
from selfmotion.methods.velocity_split import split, velocity_bands
from selfmotion.motion.recording import Recording, Study
from tests.methods.ik_samples import planar_reaches, random_arm

W = np.array([1.0, 0.5, 0.2])


def study(trials=8, noise=0.1):
    sets = planar_reaches(np.random.default_rng(2), W, trials=trials, noise=noise)
    return Study(
        tuple(
            Recording(np.arange(len(q)) / 50, q=q, qd=qd, jacobian=J, source=f"trial {i}")
            for i, (q, qd, J) in enumerate(sets)
        )
    )


def test_equations_13_and_14():
    one = Recording(np.zeros(1), qd=np.array([[0.0, 1.0]]), jacobian=np.ones((1, 1, 2)))
    plain, weighted = split(one), split(one, weights=[1.0, 1.0 / 9.0])
    np.testing.assert_allclose(plain.task, [[0.5, 0.5]])
    np.testing.assert_allclose(plain.null, [[-0.5, 0.5]])
    np.testing.assert_allclose(weighted.task, [[0.1, 0.9]])
    np.testing.assert_allclose(weighted.null, [[-0.1, 0.1]])
    assert plain.task_share == pytest.approx(0.5)
    assert weighted.task_share == pytest.approx(0.82 / 0.84)
    # W metric: (0.01 + 0.81/9)/(1/9) = 0.9
    assert weighted.task_share_weighted == pytest.approx(0.9)
    assert weighted.unexplained == pytest.approx(0.02)


def test_identities_of_the_split():
    qd, J = random_arm(np.random.default_rng(1), W, samples=50, rows=2, noise=0.5)
    one = Recording(np.arange(50.0), qd=qd, jacobian=J)
    parts = split(one, weights=W)
    np.testing.assert_allclose(parts.task + parts.null, qd, atol=1e-12)
    np.testing.assert_allclose(J @ parts.null[..., None], 0.0, atol=1e-10)
    np.testing.assert_allclose((parts.task * W * parts.null).sum(axis=1), 0.0, atol=1e-10)
    in_metric = (W * parts.null**2).sum() / (W * qd**2).sum()
    assert parts.task_share_weighted + in_metric == pytest.approx(1.0)
    assert parts.task_share + parts.null_share == 1.0
    scaled = split(one, weights=10.0 * W)
    assert scaled.task_share == pytest.approx(parts.task_share)
    assert list(parts.to_frame().columns)[:3] == ["time", "joint_1_task", "joint_1_null"]


def test_identified_weights_leave_less_to_the_null_space_than_identity():
    trials = study()
    found = identify_weights(trials)
    with_weights = sum(float(np.sum(split(t, weights=found).null ** 2)) for t in trials)
    identity = sum(float(np.sum(split(t).null ** 2)) for t in trials)
    energy = sum(float(np.sum(t.array("qd") ** 2)) for t in trials)
    assert with_weights < identity
    assert found.unexplained == pytest.approx(with_weights / energy)
    assert found.unexplained_identity == pytest.approx(identity / energy)


def test_gaps_stay_gaps():
    trial = study(1)[0]
    qd = trial.array("qd").copy()
    qd[3] = np.nan
    parts = split(Recording(trial.time, qd=qd, jacobian=trial.array("jacobian")), weights=W)
    assert np.isnan(parts.task[3]).all() and np.isfinite(parts.task[4]).all()
    assert np.isfinite(parts.task_share)


def test_bands_add_up():
    bands = velocity_bands(study(), weights=W, n_points=21)
    np.testing.assert_allclose(bands.mean["task"] + bands.mean["null"], bands.mean["total"])
    assert bands.spread["null"].shape == (21, 3) and bands.n_trials == 8
    assert np.isnan(velocity_bands(study(1)).spread["task"]).all()


@pytest.mark.parametrize(
    ("weights", "words"),
    [([1.0, 2.0], "weights: expected shape"), ([1.0, np.nan, 1.0], "joint_2 has nan; allowed")],
)
def test_bad_weights_are_refused(weights, words):
    with pytest.raises(SelfmotionError, match=words):
        split(study(1)[0], weights=weights)
