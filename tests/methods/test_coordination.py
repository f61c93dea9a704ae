"""Comparators against NumPy and signals of known phase."""

import numpy as np
import pytest

from selfmotion.errors import SelfmotionError
from selfmotion.methods.coordination import (
    principal_components,
    relative_phase,
    velocity_correlation,
)
from selfmotion.motion.recording import Recording


def made(rng, trials=3, samples=40):
    mixing = rng.standard_normal((3, 3))
    return [
        Recording(
            np.arange(float(samples)),
            qd=rng.standard_normal((samples, 3)) @ mixing,
            jacobian=np.ones((samples, 1, 3)),
        )
        for _ in range(trials)
    ]


def test_correlation_is_numpys_over_pooled_whole_samples():
    recordings = made(np.random.default_rng(1))
    pooled = np.concatenate([r.array("qd") for r in recordings])
    np.testing.assert_allclose(velocity_correlation(recordings), np.corrcoef(pooled.T))
    gap = recordings[0].array("qd").copy()
    gap[7, 1] = np.nan
    less = [Recording(recordings[0].time, q=gap, qd=gap), *recordings[1:]]
    whole = np.delete(pooled, 7, axis=0)
    np.testing.assert_allclose(velocity_correlation(less), np.corrcoef(whole.T))


def test_principal_components_rebuild_the_covariance():
    recordings = made(np.random.default_rng(2))
    pooled = np.concatenate([r.array("qd") for r in recordings])
    found = principal_components(recordings)
    covariance = np.cov(pooled.T)
    rebuilt = found.loadings.T @ np.diag(found.share * np.trace(covariance)) @ found.loadings
    np.testing.assert_allclose(rebuilt, covariance, atol=1e-10)
    assert found.share.sum() == pytest.approx(1.0) and np.all(np.diff(found.share) <= 0)
    assert found.needed(1.0) == 3 and found.needed(0.01) == 1
    assert list(found.to_frame().columns) == ["share", "joint_1", "joint_2", "joint_3"]


@pytest.mark.parametrize("lag", [0.0, np.pi / 3, np.pi / 2, np.pi])
def test_relative_phase_of_shifted_sines(lag):
    t = np.linspace(0.0, 6.0, 1201)
    q = np.stack([np.cos(2 * np.pi * t), np.cos(2 * np.pi * t - lag)], axis=1)
    found = relative_phase(Recording(t, q=q), n_points=601)
    middle = found.curve[200:400, 0, 1]
    np.testing.assert_allclose(np.abs(np.exp(1j * middle) - np.exp(1j * lag)), 0.0, atol=0.1)
    assert found.mean_absolute[0, 1] == pytest.approx(lag, abs=0.2)
    assert np.isnan(found.variability[0, 1])


def test_variability_over_trials_is_zero_for_equal_trials():
    t = np.linspace(0.0, 1.0, 50)
    q = np.stack([np.sin(3 * t), np.cos(2 * t)], axis=1)
    found = relative_phase([Recording(t, q=q)] * 3)
    np.testing.assert_allclose(found.variability, 0.0, atol=1e-6)


def test_nothing_moving_is_refused():
    still = Recording(np.arange(4.0), qd=np.zeros((4, 2)), jacobian=np.ones((4, 1, 2)))
    with pytest.raises(SelfmotionError, match="motion is needed"):
        principal_components(still)
    assert np.isnan(velocity_correlation(still)).all()
