"""Algorithm 1 of the paper: IK weights by a fixed-point iteration of box QPs.

[Khoramshahi2022], doi 10.1371/journal.pone.0278228, eqs 16-24 and Algorithm 1. With S = Σq̇q̇ᵀ and
C = ΣN q̇q̇ᵀ its matrices are Ψ = S - γC and Ω = W(S - C), row i of eq. 22 holds w_i alone, and the
box QP of eq. 24 is exactly w_i ← clip(Σ_j Ψ_ij Ω_ij / Σ_j Ψ_ij², 1e-9, 1).

How v̄ is treated: as printed. Line 7 uses v̄ of the iteration before (zero in the first), so that
the error e = Nq̇ - γ_before N_before q̇ is lagged; line 14 uses v̄ of this iteration. ẋ is Jq̇.

Deviations: iteration stops on max|Δ log w| ≤ tolerance·(1 - γ) or at a cap, since e > ε may never
end (e has the floor (1-γ)·mean‖Nq̇‖). Weights are normalised within each scale group, and the
weight of an over-specified joint is set to 1: the paper's convention in section 4.2, found
automatically. A weight whose row of Ψ is zero (0/0) stays as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from selfmotion.errors import RangeError, Status
from selfmotion.methods.weights.gauss_newton import Fit, Problem
from selfmotion.methods.weights.passes import NO_FEEDBACK, Survey, algorithm_sums
from selfmotion.methods.weights.samples import Samples
from selfmotion.methods.weights.uncertainty import dependence

LOWER = 1e-9
"""Lower bound of the box QP; the upper is 1."""
PRINTED_GAIN = 0.6
"""γ_{t+1} = γ_t + 0.6 (1 - γ_t), section 4.1."""
FROZEN = 1e-12
"""1 - γ below which an update changes nothing."""
LAST_RATIO = 1.0 - 1e-4
"""γ at which the fixed point is examined when a schedule ends at 1, where every W is one."""
DIFFERENCE = 1e-5
"""Step in log w for the derivative of the fixed point."""


@dataclass(frozen=True)
class NullSchedule:
    """The null-space projection ratio γ of each iteration.

    Attributes:
        ratio: one value for all iterations, or one an iteration (the last one stays).
        kind: ``"constant"``: as given; ``"printed"``: from `ratio` on, γ ← γ + 0.6(1 - γ), as
            section 4.1 prints it. Its steps sum to 2/3 of one iteration at γ = 0.6 and then freeze.

    Raises:
        RangeError: a ratio outside 0 to 1.
    """

    ratio: float | Sequence[float] = 0.9
    kind: Literal["constant", "printed"] = "constant"

    def __post_init__(self) -> None:
        """Refuse ratios outside 0 to 1 and unknown kinds."""
        values = np.atleast_1d(np.asarray(self.ratio, dtype=np.float64))
        if values.ndim != 1 or len(values) == 0:
            raise RangeError("null_ratio: expected a number or a sequence of numbers")
        for value in values:
            if not 0.0 <= value <= 1.0:
                raise RangeError(f"null_ratio = {value:g}: allowed is 0 to 1")
        if self.kind not in ("constant", "printed"):
            raise RangeError(f"null_schedule = {self.kind!r}: allowed are constant, printed")

    def at(self, iteration: int) -> float:
        """Give γ of an iteration (0 is the first).

        Example:
            >>> [round(NullSchedule(0.6, "printed").at(t), 3) for t in range(3)]
            [0.6, 0.84, 0.936]
        """
        values = np.atleast_1d(np.asarray(self.ratio, dtype=np.float64))
        if self.kind == "printed":
            return float(1.0 - (1.0 - values[0]) * (1.0 - PRINTED_GAIN) ** iteration)
        return float(values[min(iteration, len(values) - 1)])

    def settled(self, iteration: int) -> bool:
        """Tell whether γ stays as it is from this iteration on."""
        return self.kind == "printed" or iteration >= len(np.atleast_1d(self.ratio)) - 1


def algorithm_one(
    problem: Problem,
    moment: np.ndarray,
    schedule: NullSchedule,
    *,
    tolerance: float,
    max_iterations: int,
) -> Fit:
    """Run Algorithm 1 from W = I.

    Args:
        problem: the data, all joints in the chain.
        moment: S = Σq̇q̇ᵀ (n, n).
        schedule: γ of each iteration.
        tolerance: largest last change of a log-weight, in units of 1 - γ.
        max_iterations: cap.

    Returns:
        The fit; `errors[t]` is the mean ‖e‖ (line 12, lagged) at the weights `history[t]`.
    """
    w = np.ones(len(moment))
    before, ratio_before, ratio = w, 0.0, schedule.at(0)
    history, errors = [w], []
    status = Status(False, f"not converged in {max_iterations} iterations of Algorithm 1")
    for iteration in range(max_iterations + 1):
        sums = algorithm_sums(problem.samples, w, w_before=before, ratio_before=ratio_before)
        errors.append(sums.error / problem.n_used)
        if status.ok or iteration == max_iterations:
            break
        ratio = schedule.at(iteration)
        if 1.0 - ratio < FROZEN and schedule.settled(iteration):
            status = _frozen(schedule, iteration)
            break
        new = _update(w, moment, sums.cross, ratio, problem.groups)
        change = _change(np.log(new / w), problem)
        before, ratio_before, w = w, ratio, new
        history.append(w)
        if schedule.settled(iteration) and change <= tolerance * (1.0 - ratio):
            status = Status(True, f"converged in {iteration + 1} iterations of Algorithm 1")
    return Fit(
        log_weights=np.log(w),
        feedback=NO_FEEDBACK,
        history=np.log(np.array(history)),
        errors=np.array(errors),
        at_bound=w <= LOWER * (1.0 + 1e-12),
        status=status,
        ratio=ratio,
    )


def _change(step: np.ndarray, problem: Problem) -> float:
    """Find the largest step of a log-weight; joints that never move drift and are passed over."""
    largest = 0.0
    for group in problem.groups:
        live = [i for i in group if problem.moving[i]]
        if live:
            drift = 0.0 if len(live) == len(group) else step[live].mean()
            largest = max(largest, float(np.abs(step[live] - drift).max()))
    return largest


def _frozen(schedule: NullSchedule, iteration: int) -> Status:
    if schedule.kind == "printed":
        return Status(False, f"the printed schedule froze: γ reached 1 at iteration {iteration}")
    return Status(False, "γ = 1 changes nothing: every W explains the data (eq. 17)")


def _update(
    w: np.ndarray,
    moment: np.ndarray,
    cross: np.ndarray,
    ratio: float,
    groups: tuple[tuple[int, ...], ...],
) -> np.ndarray:
    """Solve the diagonal box QP (lines 14-20), then normalise within groups (line 21)."""
    psi = moment - ratio * cross
    omega = w[:, None] * (moment - cross)
    square = (psi**2).sum(axis=1)
    solvable = square > 0.0
    best = np.divide((psi * omega).sum(axis=1), square, out=w.copy(), where=solvable)
    best = np.clip(best, LOWER, 1.0)
    new = np.ones_like(w)
    for group in groups:
        at = list(group)
        new[at] = np.maximum(best[at] / best[at].max(), LOWER)
    return new


def fixed_point_covariance(problem: Problem, found: Survey, fit: Fit) -> np.ndarray:
    """Give the covariance (n, n) of log-weights at a fixed point, clustered by trial.

    Delta method: at a fixed point ρ_i = Σ_j Ψ_ij (S-C)_ij / Σ_j Ψ_ij² is one number in each scale
    group. Its derivative by θ is a central difference of passes; its derivative by a cluster's
    share of S and C is exact.
    """
    n = len(found.moment)
    if len(fit.history) == 1:  # γ = 1 from the start: any W is a fixed point
        return np.full((n, n), np.inf)
    ratio = min(fit.ratio, LAST_RATIO)
    free = problem.moving & ~fit.at_bound  # at a bound of the box there is no fixed point
    groups = tuple(tuple(i for i in group if free[i]) for group in problem.groups)
    centre = _centring(n, tuple(group for group in groups if len(group) > 1))
    here = _sums(problem.samples, fit.log_weights)
    slope = np.zeros((n, n))
    for i in np.flatnonzero(centre.diagonal()):
        shift = np.zeros(n)
        shift[i] = DIFFERENCE
        ends = [
            _log_ratio(found.moment, _sums(problem.samples, theta)[0], ratio)
            for theta in (fit.log_weights + shift, fit.log_weights - shift)
        ]
        slope[:, i] = (ends[0] - ends[1]) / (2.0 * DIFFERENCE)
    influence = _influence(found, here, ratio)
    shifts = -(influence @ centre) @ np.linalg.pinv(centre @ slope @ centre, rcond=1e-9).T
    G = len(shifts)
    weights = dependence(G, problem.samples.stretches)
    return G / (G - 1) * shifts.T @ weights @ shifts


def _centring(n: int, groups: tuple[tuple[int, ...], ...]) -> np.ndarray:
    centre = np.zeros((n, n))
    for group in groups:
        at = np.ix_(group, group)
        centre[at] = np.eye(len(group)) - 1.0 / len(group)
    return centre


def _sums(samples: Samples, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    w = np.exp(theta)
    sums = algorithm_sums(samples, w, w_before=w, ratio_before=0.0, clusters=True)
    return sums.cross, sums.cross_by_cluster


def _log_ratio(moment: np.ndarray, cross: np.ndarray, ratio: float) -> np.ndarray:
    psi = moment - ratio * cross
    top, bottom = (psi * (moment - cross)).sum(axis=1), (psi**2).sum(axis=1)
    tiny = np.finfo(float).tiny
    return np.log(np.maximum(top, tiny)) - np.log(np.maximum(bottom, tiny))


def _influence(found: Survey, here: tuple[np.ndarray, np.ndarray], ratio: float) -> np.ndarray:
    """Differentiate log ρ by each cluster's share (G, n)."""
    moment, (cross, shares) = found.moment, here
    psi, task = moment - ratio * cross, moment - cross
    d_psi = found.moment_by_cluster - ratio * shares
    d_task = found.moment_by_cluster - shares
    top, bottom = (psi * task).sum(axis=1), (psi**2).sum(axis=1)
    d_top = (d_psi * task + psi * d_task).sum(axis=2)
    d_bottom = 2.0 * (psi * d_psi).sum(axis=2)
    live = (top > 0.0) & (bottom > 0.0)
    first = np.divide(d_top, top, out=np.zeros_like(d_top), where=live)
    return first - np.divide(d_bottom, bottom, out=np.zeros_like(d_bottom), where=live)
