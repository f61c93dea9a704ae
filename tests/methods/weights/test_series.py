"""Weights by trial and by window: what changes is seen, what fails says so."""

import numpy as np
import pytest

from selfmotion.errors import RangeError
from selfmotion.methods.weights.series import weights_by_trial, weights_by_window
from selfmotion.motion.recording import Recording, Study
from tests.methods.ik_samples import random_arm

EARLY, LATE = np.array([1.0, 0.5, 0.2, 0.3]), np.array([0.2, 1.0, 0.4, 0.3])


def changing(trials=8):
    rng = np.random.default_rng(1)
    recordings = []
    for _ in range(trials):
        halves = [random_arm(rng, w, samples=50, rows=2) for w in (EARLY, LATE)]
        qd, J = (np.concatenate(part) for part in zip(*halves, strict=True))
        recordings.append(Recording((np.arange(100) + 0.5) / 100, qd=qd, jacobian=J))
    return Study(tuple(recordings))


def test_windows_see_weights_change():
    series = weights_by_window(changing(), windows=2)
    assert series.names == ("0-0.5", "0.5-1")
    np.testing.assert_allclose(series.estimates[0].weights, EARLY, atol=1e-6)
    np.testing.assert_allclose(series.estimates[1].weights, LATE, atol=1e-6)
    assert sum(e.n_samples for e in series.estimates) == 800
    assert series.estimates[0].stderr_kind.startswith("clustered by trial")


def test_each_trial_alone_and_failures_as_data():
    trials = changing(2)
    still = Recording(np.arange(9.0), qd=np.zeros((9, 4)), jacobian=np.ones((9, 2, 4)))
    series = weights_by_trial([*trials, still])
    assert len(series.estimates) == 3
    assert np.isfinite(series.estimates[0].weights).all()
    failed = series.estimates[2]
    assert not failed.status and "rank-deficient" in failed.status.sentence
    assert np.isnan(failed.weights).all()
    frame = series.to_frame()
    assert len(frame) == 12 and frame["status"].iloc[-1] == failed.status.sentence


def test_empty_window_is_data_and_bad_edges_are_not():
    sparse = Recording(np.array([0.0, 1.0]), qd=np.ones((2, 3)), jacobian=np.ones((2, 1, 3)))
    series = weights_by_window(sparse, windows=[0.0, 0.4, 0.6, 1.0])
    assert series.estimates[1].status.sentence == "no samples in this window"
    for windows in (0, [0.5, 0.2], [0.0, 1.2]):
        with pytest.raises(RangeError, match="windows"):
            weights_by_window(sparse, windows=windows)
