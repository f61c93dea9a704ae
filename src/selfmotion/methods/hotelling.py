"""Hotelling's T² on log-ratios of weights: do people change their joint preferences?

[Khoramshahi2022] section 4.2 tests the weights themselves (T² = 225.3, F(2, 15) = 105.6). Weights
scaled to a maximum of 1 are compositional: only ratios mean anything, and a test of the scaled
values depends on which joint happens to be the largest. Here log-ratios to a reference joint are
tested; T² is the same for every reference, since the log-ratios of one reference are an invertible
linear map of those of another. The sign-flip permutation check needs symmetry, not normality.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike
from scipy.special import fdtrc, fdtri  # scipy.stats takes a second to import

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError

ALL_FLIPS = 14
"""Up to so many people all 2^(n-1) sign flips are tried, so that the check is exact."""
BLOCK = 4096


@dataclass(frozen=True, eq=False)
class HotellingTest:
    """The outcome of a test that a mean vector is zero.

    Attributes:
        t2: Hotelling's T² = n d̄ᵀS⁻¹d̄.
        f: (n - p)/(p(n - 1)) T².
        df: degrees of freedom of F: (p, n - p).
        p_value: of F, under normality.
        p_permutation: share of sign flips with a T² at least as large.
        n_flips: sign flips tried.
        exact: whether these were all there are.
        effect: Mahalanobis distance of the mean from zero, √(T²/n): the multivariate d_z.
        mean: mean vector d̄ (p).
        intervals: simultaneous 95 % confidence intervals of each component (p, 2), from T².
        n_people: n.
    """

    t2: float
    f: float
    df: tuple[int, int]
    p_value: float
    p_permutation: float
    n_flips: int
    exact: bool
    effect: float
    mean: Float[np.ndarray, " ratios"]
    intervals: Float[np.ndarray, "ratios 2"]
    n_people: int

    def __str__(self) -> str:
        """Give the sentence for a paper."""
        return (
            f"T² = {self.t2:.1f}, F({self.df[0]}, {self.df[1]}) = {self.f:.1f}, "
            f"p = {self.p_value:.2g} (sign flips: {self.p_permutation:.2g}), d = {self.effect:.2f}"
        )


def f_from_t2(t2: float, n_people: int, n_ratios: int) -> tuple[float, tuple[int, int], float]:
    """Turn T² into F, its degrees of freedom and p.

    Example:
        >>> f, df, p = f_from_t2(225.3, 17, 2)            # the paper's experiment 1
        >>> round(f, 1), df, f"{p:.1e}"
        (105.6, (2, 15), '1.5e-09')
    """
    n, p = n_people, n_ratios
    f = (n - p) / (p * (n - 1)) * t2
    return f, (p, n - p), float(fdtrc(p, n - p, f))


def log_ratios(weights: ArrayLike, *, reference: int = 0) -> Float[np.ndarray, "people ratios"]:
    """Turn weights (people, joints) of one scale group into log-ratios to a reference joint.

    Raises:
        NotFiniteError: a weight is missing (not identified); leave that person or joint out.
        RangeError: a weight is not positive, or the reference is not a joint.
    """
    w = as_float_array("weights", weights, ndim=2)
    require_finite("weights", w)
    if not (w > 0.0).all():
        raise RangeError(f"weights: smallest is {w.min():g}; allowed are positive numbers")
    if not 0 <= reference < w.shape[1]:
        raise RangeError(f"reference = {reference}: allowed is 0 to {w.shape[1] - 1}")
    log = np.log(w)
    return np.delete(log - log[:, [reference]], reference, axis=1)


def hotelling_one_sample(
    values: ArrayLike, *, rng: np.random.Generator, n_flips: int = 9999, null: ArrayLike = 0.0
) -> HotellingTest:
    """Test whether the mean of vectors (people, p), log-ratios say, is `null`.

    Args:
        values: one row a person.
        rng: for the sign flips; not used where all flips can be tried (14 people or fewer).
        n_flips: random sign flips otherwise.
        null: mean under the null hypothesis, a number or (p).

    Raises:
        ShapeError: not more people than values each.
        RangeError: the values of the people lie in a plane (S is singular).

    Example:
        >>> values = np.array([[1.0], [2.0], [3.0]])       # one value: T² is t²
        >>> test = hotelling_one_sample(values, rng=np.random.default_rng(0))
        >>> round(test.t2, 6), test.df, test.p_permutation
        (12.0, (1, 2), 0.25)
    """
    d = as_float_array("values", values, ndim=2) - np.asarray(null, dtype=np.float64)
    require_finite("values", d)
    n, p = d.shape
    if n <= p:
        raise ShapeError(f"values: {n} people for {p} values each; more people than values needed")
    mean, S = d.mean(axis=0), np.atleast_2d(np.cov(d, rowvar=False))
    if np.linalg.matrix_rank(d - mean, tol=1e-12 * np.abs(d).max(initial=1e-300)) < p:
        raise RangeError(f"values: the covariance of {n} people is singular; leave a value out")
    t2 = float(n * mean @ np.linalg.solve(S, mean))
    f, df, p_value = f_from_t2(t2, n, p)
    signs, exact = _signs(n, n_flips, rng)
    larger = sum(
        int(np.count_nonzero(_t2_of_flips(d, signs[at : at + BLOCK]) >= t2 * (1.0 - 1e-12)))
        for at in range(0, len(signs), BLOCK)
    )
    half = np.sqrt(p * (n - 1) / (n - p) * fdtri(p, n - p, 0.95) * np.diag(S) / n)
    share = larger / len(signs) if exact else (larger + 1) / (len(signs) + 1)
    return HotellingTest(
        t2, f, df, p_value, share, len(signs), exact, float(np.sqrt(t2 / n)),
        mean, np.stack([mean - half, mean + half], axis=1), n,
    )  # fmt: skip


def hotelling_paired(
    first: ArrayLike, second: ArrayLike, *, rng: np.random.Generator, n_flips: int = 9999
) -> HotellingTest:
    """Test whether people differ between two conditions: one-sample test of second - first.

    Args:
        first: vectors in the first condition (people, p), log-ratios say.
        second: the same people in the second.
        rng: for the sign flips.
        n_flips: random sign flips where not all can be tried.

    Example:
        >>> before, after = np.zeros((3, 1)), np.array([[1.0], [2.0], [3.0]])
        >>> round(hotelling_paired(before, after, rng=np.random.default_rng(0)).effect, 6)
        2.0
    """
    before, after = as_float_array("first", first, ndim=2), as_float_array("second", second, ndim=2)
    require_shape("second", after, before.shape)
    return hotelling_one_sample(after - before, rng=rng, n_flips=n_flips)


def compare_weights(
    first: ArrayLike, second: ArrayLike, *, rng: np.random.Generator, n_flips: int = 9999
) -> HotellingTest:
    """Test whether weights (people, joints) of one scale group differ between two conditions.

    The result does not depend on the scale of anybody's weights nor on a reference joint.

    Example:
        >>> rng = np.random.default_rng(2)
        >>> natural = np.exp(rng.normal([0, -2, -3], 0.3, (12, 3)))
        >>> viscous = natural * np.exp(rng.normal([0, 0, 1], 0.2, (12, 3)))
        >>> test = compare_weights(natural, viscous, rng=rng)
        >>> test.df, test.p_value < 0.001, test.exact
        ((2, 10), True, True)
    """
    return hotelling_paired(log_ratios(first), log_ratios(second), rng=rng, n_flips=n_flips)


def _signs(n: int, n_flips: int, rng: np.random.Generator) -> tuple[np.ndarray, bool]:
    """List sign flips (flips, n); flipping everybody changes nothing, so the first stays."""
    if n <= ALL_FLIPS:
        return np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=n - 1)]), True
    return rng.choice(np.array([-1.0, 1.0]), size=(n_flips, n)), False


def _t2_of_flips(d: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """T² for each row of signs; flips change the mean but not Σddᵀ."""
    n = len(d)
    means = signs @ d / n
    form = np.einsum("fi,if->f", means, np.linalg.solve(d.T @ d, means.T))
    # S = (Σddᵀ - n m mᵀ)/(n-1); Sherman-Morrison turns mᵀS⁻¹m into this
    return n * (n - 1) * form / np.maximum(1.0 - n * form, np.finfo(float).tiny)
