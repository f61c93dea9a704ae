"""Hotelling's T² against the published numbers, a t test, and its invariances."""

from typing import Any

import numpy as np
import pytest
from scipy import stats

from selfmotion.errors import SelfmotionError
from selfmotion.methods.hotelling import (
    compare_weights,
    f_from_t2,
    hotelling_one_sample,
    hotelling_paired,
    log_ratios,
)


def people(rng, n=17, change=0.6):
    natural = np.exp(rng.normal([0.0, -2.0, -3.0], 0.4, (n, 3)))
    return natural, natural * np.exp(rng.normal([0.0, 0.0, change], 0.5, (n, 3)))


def test_published_test_of_experiment_one():
    f, df, p = f_from_t2(225.3, 17, 2)
    assert df == (2, 15)
    assert f == pytest.approx(105.6, abs=0.05)
    assert p == pytest.approx(1.5e-9, rel=0.05)


def test_one_value_is_a_t_test():
    rng = np.random.default_rng(1)
    x = rng.normal(0.4, 1.0, (11, 1))
    found = hotelling_one_sample(x, rng=rng)
    known: Any = stats.ttest_1samp(x[:, 0], 0.0)
    assert found.t2 == pytest.approx(known.statistic**2)
    assert found.p_value == pytest.approx(known.pvalue)
    low, high = known.confidence_interval(0.95)
    np.testing.assert_allclose(found.intervals, [[low, high]])
    assert found.effect == pytest.approx(abs(x.mean()) / x.std(ddof=1))
    assert found.exact and found.n_flips == 2**10


def test_does_not_depend_on_reference_or_scale():
    rng = np.random.default_rng(2)
    natural, viscous = people(rng)
    base = compare_weights(natural, viscous, rng=np.random.default_rng(3), n_flips=999)
    scaled = natural / natural.max(axis=1, keepdims=True)
    for reference in range(3):
        other = hotelling_paired(
            log_ratios(scaled, reference=reference),
            log_ratios(7.0 * viscous, reference=reference),
            rng=np.random.default_rng(3),
            n_flips=999,
        )
        assert other.t2 == pytest.approx(base.t2, rel=1e-9)
        assert other.p_permutation == base.p_permutation
    assert str(base).startswith("T² = ") and base.df == (2, 15)


def test_sign_flips_agree_with_brute_force():
    rng = np.random.default_rng(4)
    d = rng.normal(0.5, 1.0, (7, 2))

    def t2(x):
        mean = x.mean(axis=0)
        return len(x) * mean @ np.linalg.solve(np.cov(x.T), mean)

    flips = np.array(np.meshgrid(*[[1, -1]] * 7)).reshape(7, -1).T
    values = np.array([t2(flip[:, None] * d) for flip in flips])
    found = hotelling_one_sample(d, rng=rng)
    assert found.t2 == pytest.approx(t2(d))
    assert found.p_permutation == pytest.approx(np.mean(values >= t2(d) * (1 - 1e-9)))


def test_permutation_and_f_agree_and_hold_their_level():
    rng = np.random.default_rng(5)
    both = [
        hotelling_one_sample(rng.standard_normal((18, 2)), rng=rng, n_flips=499) for _ in range(300)
    ]
    for rate in (
        np.mean([test.p_value < 0.1 for test in both]),
        np.mean([test.p_permutation <= 0.1 for test in both]),
    ):
        assert 0.05 < rate < 0.16  # 300 tests: 3 standard errors
    assert np.max(np.abs([t.p_value - t.p_permutation for t in both])) < 0.15


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda rng: hotelling_one_sample(np.zeros((2, 2)), rng=rng), "2 people for 2 values"),
        (lambda rng: hotelling_one_sample(np.ones((5, 2)), rng=rng), "singular"),
        (lambda rng: log_ratios([[1.0, np.nan]]), "not finite"),
        (lambda rng: log_ratios([[1.0, 0.0]]), "positive"),
        (lambda rng: log_ratios([[1.0, 2.0]], reference=2), "allowed is 0 to 1"),
    ],
)
def test_bad_values_are_refused(call, words):
    with pytest.raises(SelfmotionError, match=words):
        call(np.random.default_rng(0))
