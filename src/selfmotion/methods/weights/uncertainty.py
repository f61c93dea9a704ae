"""Standard errors of log-weights, clustered by trial.

Samples of one movement are not independent, so the unit of observation is the cluster: a trial,
or, where there are too few trials, a stretch of time of one. For an estimate that solves
Σ_g s_g(θ) = 0 with derivative A = Σ_g A_g, cluster g moves it by about δ_g = -A⁺ s_g:

- sandwich: cov θ = G/(G-1) Σ_g δ_g δ_gᵀ (Liang-Zeger, with the usual factor for few clusters);
  where trials had to be cut, its sum is over pairs of stretches, weighted by `dependence`;
- jackknife: δ_g = (A - A_g)⁺ s_g, cov θ = (G-1)/G Σ_g (δ_g - δ̄)(δ_g - δ̄)ᵀ, one Newton step of
  leaving a trial out; it errs on the wide side where the sandwich errs on the narrow one.

A is the whole Hessian (the second derivatives of the residual included), or the Gauss-Newton
matrix where the Hessian is not positive definite. With posture feedback its gains are eliminated
first (s_θ - A_θb A_bb⁺ s_b and the Schur complement).
"""

import numpy as np
from scipy.special import stdtrit  # scipy.stats takes a second to import

from selfmotion.methods.weights.identifiability import Excitation
from selfmotion.methods.weights.passes import NormalEquations

WHOLE_TRIAL_CRITICAL = 4.771
"""95 % critical value of an estimate over its error by Bartlett's weights of the whole length."""
PIVOT_TOLERANCE = 1e-12
"""Relative eigenvalue below which a direction of the feedback gains counts as not excited."""


def scaled_pseudo_inverse(matrix: np.ndarray, tolerance: float = PIVOT_TOLERANCE) -> np.ndarray:
    """Invert a symmetric positive semidefinite matrix on its range, scaled to a unit diagonal."""
    diagonal = np.diag(matrix)
    scale = np.zeros(len(diagonal))
    scale[diagonal > 0.0] = 1.0 / np.sqrt(diagonal[diagonal > 0.0])
    values, vectors = np.linalg.eigh(scale[:, None] * matrix * scale[None, :])
    kept = values > tolerance * max(float(values[-1]), np.finfo(float).tiny)
    half = (scale[:, None] * vectors[:, kept]) / np.sqrt(values[kept])
    return half @ half.T


def eliminate_feedback(
    matrix: np.ndarray, vectors: np.ndarray, n: int
) -> tuple[np.ndarray, np.ndarray]:
    """Take the feedback gains out of a matrix (U, U) and of gradients (..., U).

    Returns:
        The Schur complement (n, n) and the profiled gradients (..., n).
    """
    if len(matrix) == n:
        return matrix, vectors
    gain = matrix[:n, n:] @ scaled_pseudo_inverse(matrix[n:, n:])
    return matrix[:n, :n] - gain @ matrix[n:, :n], vectors[..., :n] - vectors[..., n:] @ gain.T


def dependence(n_clusters: int, stretches: int) -> np.ndarray:
    """Weigh the products of clusters (G, G) in a sandwich.

    Trials are independent: the unit matrix. Stretches of one trial are not, and how far they
    depend on each other cannot be told from one movement. Then Bartlett's weights over the whole
    trial, with the critical value that goes with them (4.771 at 95 %: Kiefer, Vogelsang and
    Bunzel 2000, doi 10.1111/1468-0262.00128) in place of that of t.

    Example:
        >>> dependence(3, 1).tolist()
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    number = np.arange(n_clusters)
    same_trial = number[:, None] // stretches == number[None, :] // stretches
    apart = np.abs(number[:, None] - number[None, :])
    weights = np.where(same_trial, 1.0 - apart / stretches, 0.0)
    if stretches == 1:
        return weights
    return weights * (WHOLE_TRIAL_CRITICAL / interval_factor(0.95, n_clusters)) ** 2


def sandwich(excitation: Excitation, sums: NormalEquations, weights: np.ndarray) -> np.ndarray:
    """Give the cluster-robust covariance (n, n) of log-weights, `weights` from `dependence`."""
    n = len(excitation.scale)
    bread, scores = eliminate_feedback(sums.exact, sums.gradient_by_cluster, n)
    if not excitation.definite(bread):
        bread, scores = eliminate_feedback(sums.curvature, sums.gradient_by_cluster, n)
    shifts = scores @ excitation.inverse(bread)
    G = len(shifts)
    return G / (G - 1) * shifts.T @ weights @ shifts


def jackknife(excitation: Excitation, sums: NormalEquations, weights: np.ndarray) -> np.ndarray:
    """Give the covariance (n, n) by leaving one cluster out at a time, one Newton step each."""
    n = len(excitation.scale)
    bread, _ = eliminate_feedback(sums.exact, sums.gradient, n)
    whole = sums.exact if excitation.definite(bread) else sums.curvature
    share = sums.exact_by_cluster
    shifts = np.zeros((len(share), n))
    for g, score in enumerate(sums.gradient_by_cluster):
        rest, profiled = eliminate_feedback(whole - share[g], score, n)
        if not excitation.definite(rest):
            return np.full((n, n), np.inf)  # one trial carries a ratio alone
        shifts[g] = excitation.inverse(rest) @ profiled
    G = len(shifts)
    centred = shifts - shifts.mean(axis=0)
    return (G - 1) / G * centred.T @ weights @ centred


def interval_factor(level: float, n_clusters: int) -> float:
    """Give the half-width of a confidence interval in standard errors: t with G - 1 degrees."""
    return float(stdtrit(n_clusters - 1, 0.5 + 0.5 * level))
