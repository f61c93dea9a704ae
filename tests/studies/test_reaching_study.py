"""Generated people move as they should, and their weights are found again."""

import numpy as np
import pytest

from selfmotion.motion.recording import Study
from selfmotion.studies.reaching_study import analyse_reaching, experiment_1, null_rms
from selfmotion.studies.simulated_people import ReachingProtocol, simulate_reaching

QUIET = ReachingProtocol(
    n_people=3,
    n_trials=4,
    posture_rate=(("Natural", 0.0), ("Viscous", 0.0)),
    noise=(("Natural", 0.0), ("Viscous", 0.0)),
)
NOISY = ReachingProtocol(n_people=5, n_trials=4, noise=(("Natural", 0.04), ("Viscous", 0.10)))


@pytest.fixture(scope="module")
def quiet():
    return simulate_reaching(QUIET, rng=np.random.default_rng(1))


@pytest.fixture(scope="module")
def noisy():
    return experiment_1(rng=np.random.default_rng(2), protocol=NOISY, paper_iterations=10)


def test_recordings_are_consistent(quiet):
    one = quiet.study[3]
    assert one.n_samples == 100 and one.rate == pytest.approx(1 / 0.009)
    slope = np.gradient(one.array("q"), one.time, axis=0)
    np.testing.assert_allclose(slope[2:-2], one.array("qd")[2:-2], atol=0.02)


def test_without_null_space_motion_the_weights_are_found_exactly(quiet):
    truth = {(p.name, c): w for p in quiet.people for c, w in p.weights.items()}
    found = analyse_reaching(
        quiet.study, rng=np.random.default_rng(0), truth=truth, methods=("ml",)
    )
    assert found.recovery is not None
    assert np.abs(found.recovery.table["bias"]).max() < 1e-6
    assert not found.weights.loc[found.weights["joint"] == "elbow_flexion", "identified"].any()


def test_field_takes_the_work_from_shoulder_flexion(noisy):
    natural, viscous = noisy.beta["ml"]["Natural"], noisy.beta["ml"]["Viscous"]
    assert viscous[2] < natural[2]
    assert (np.delete(viscous, 2) > np.delete(natural, 2)).all()


def test_truth_is_found_within_the_noise(noisy):
    table = noisy.recovery.table
    ml = table[table["method"] == "ml"]
    assert (ml["bias"].abs() < 0.5).all()
    assert (ml["people"] >= 3).all()


def test_null_space_speed_as_in_figure_7(noisy):
    rms = null_rms(noisy.null)
    for condition in ("Natural", "Viscous"):
        assert rms[condition, "identified"] < rms[condition, "identity"]
    assert rms["Viscous", "identified"] > rms["Natural", "identified"]


def test_test_has_the_degrees_of_freedom_of_its_people(noisy):
    assert noisy.test is not None
    assert noisy.test.df == (2, noisy.test.n_people - 2)
    assert noisy.test.mean[1] > 0.5  # flexion has become dearer than elevation


def test_same_seed_same_result(noisy):
    again = experiment_1(rng=np.random.default_rng(2), protocol=NOISY, paper_iterations=10)
    np.testing.assert_array_equal(again.weights["full_weight"], noisy.weights["full_weight"])


def test_one_condition_is_refused(quiet):
    half = Study(tuple(quiet.study.select(condition="Natural")))
    with pytest.raises(ValueError, match=r"1 condition\(s\) .* two conditions"):
        analyse_reaching(half, rng=np.random.default_rng(0))
