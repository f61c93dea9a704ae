"""The search for the law that fits postures: starts, damped steps, weights, and where it stops."""

from dataclasses import dataclass, replace

import numpy as np

from selfmotion.methods.elasticity.fit import (
    EXACT,
    TOLERANCE,
    PostureGeometry,
    Residuals,
    entries,
    huber_weights,
    linear_start,
    past_fold,
    residuals,
    whitening,
)
from selfmotion.methods.elasticity.result import ElasticityPrior
from selfmotion.redundancy.task import Task

# Where the surface folds, the fit begins with the postures nearest to the middle and goes on
# outwards: shares of them all.
OUTWARD = (0.4, 0.6, 0.8)
# Noise of most postures beyond which the law found is taken for a false minimum (rad).
ROUGH = np.radians(4.0)
# Postures on which first guesses are tried, and the softness of one joint in some of them.
TRIAL_SIZE = 150
SOFT = 0.25
# Share of the postures that may lie past a fold, where noise alone can carry the outermost.
FOLDED = 0.02
# Noise widths beyond which a posture is put down to a gross error.
GROSS = 4.0
# Postures beyond the number of parameters.
SPARE = 4
LARGEST_DAMPING = 1e12
# Change of the rest posture in one step beyond which the step is shortened (rad).
LARGEST_TURN = 0.3


@dataclass(frozen=True)
class _Stop:
    """When a search ends: squared distance to the minimum in squared standard errors, or steps."""

    settled: float
    max_iterations: int


TRIAL, STAGE, LAST = _Stop(0.1, 15), _Stop(0.01, 40), _Stop(1e-6, 200)


@dataclass(frozen=True, eq=False)
class Problem:
    """What stays fixed while the law is searched."""

    geometry: PostureGeometry
    prior: ElasticityPrior | None
    trace: float

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.geometry.q.shape[1]


@dataclass(frozen=True, eq=False)
class Fit:
    """One law with what the data say at it."""

    K: np.ndarray
    rest: np.ndarray
    found: Residuals
    white: np.ndarray  # (K, r, r)
    weights: np.ndarray  # (K,)
    scale: float
    converged: bool

    @property
    def folded(self) -> int:
        """Number of postures past a fold of the surface, gross errors left out."""
        near = np.linalg.norm(self.distance, axis=1) < GROSS * max(self.scale, EXACT)
        return int((past_fold(self.found) & near).sum())

    @property
    def distance(self) -> np.ndarray:
        """Distances (K, r) in units that all have the same noise (rad)."""
        return np.einsum("krs,ks->kr", self.white, self.found.delta)


def _part(problem: Problem, which: np.ndarray) -> Problem:
    g = problem.geometry
    some = PostureGeometry(g.q[which], g.Z[which], g.P[which], g.Q[which], g.C[which])
    return Problem(some, problem.prior, problem.trace)


def best_fit(problem: Problem, order: np.ndarray) -> Fit:
    """Try several starts on a few postures; from the best, go outwards if the surface folds."""
    n, n_all = problem.n, len(order)
    least = n * (n + 1) // 2 + n + SPARE
    fit = _best_start(problem, order, least)
    if fit.folded > FOLDED * n_all or fit.scale > ROUGH:
        inner = _part(problem, order[: max(least, int(np.ceil(OUTWARD[0] * n_all)))])
        stage = _best_start(inner, np.arange(len(inner.geometry.q)), least)
        for share in OUTWARD:
            part = _part(problem, order[: max(least, int(np.ceil(share * n_all)))])
            stage = _search(part, stage.K, stage.rest, STAGE)
        fit = min(fit, _at(problem, stage.K, stage.rest), key=_order)
    return _search(problem, fit.K, fit.rest, LAST)


def _best_start(problem: Problem, order: np.ndarray, least: int) -> Fit:
    """Try several starts on a few postures; the distance of all tells which minimum is true."""
    trial = _part(problem, order[:: max(1, len(order) // max(TRIAL_SIZE, least))])
    tried = [_search(trial, K, rest, TRIAL) for K, rest in _starts(problem, trial)]
    return min((_at(problem, fit.K, fit.rest) for fit in tried), key=_order)


def _starts(problem: Problem, trial: Problem) -> list[tuple[np.ndarray, np.ndarray]]:
    """Give first guesses: the linear solution, equal stiffness, each joint soft, the prior."""
    n, rest = problem.n, np.median(problem.geometry.q, axis=0)
    starts = [(np.eye(n), rest)]
    starts += [(np.diag(np.where(np.arange(n) == i, SOFT, 1.0)), rest) for i in range(n)]
    exact = linear_start(problem.geometry)
    if exact is not None:
        starts.append(exact)
    if problem.prior is not None:
        starts.append((problem.prior.stiffness, problem.prior.rest))
    return [start for start in starts if not past_fold(_at(trial, *start).found).any()] or starts[
        :1
    ]


def _order(fit: Fit) -> tuple[bool, float]:
    """Rank laws: not folded, then near to half of the postures or more."""
    return fit.folded > FOLDED * len(fit.weights), fit.scale


def _at(problem: Problem, K: np.ndarray, rest: np.ndarray, converged: bool = False) -> Fit:
    """Look at the data from one law: distances, their noise and their weights."""
    K = K * (problem.trace / np.trace(K))
    found = residuals(problem.geometry, K, rest)
    white = whitening(found.spread)
    w = np.einsum("krs,ks->kr", white, found.delta)
    weights, scale = huber_weights(w)
    weights = np.where(past_fold(found), 0.0, weights)  # there the distance means nothing
    return Fit(K, rest, found, white, weights, scale, converged)


def system(problem: Problem, fit: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Give rows and right-hand side by (entries of K, q*), one sample after the other."""
    J = np.concatenate([fit.found.by_stiffness, fit.found.by_rest], axis=2)
    root = np.sqrt(fit.weights)[:, None, None]
    A = (root * (fit.white @ J)).reshape(-1, J.shape[2])
    b = -(root * (fit.white @ fit.found.delta[..., None])).ravel()
    if problem.prior is not None:
        P, p = problem.prior.rows(fit.K, fit.rest, problem.trace)
        P = P @ _at_trace(fit.K, problem.trace)
        A = np.concatenate([A, fit.scale * P])
        b = np.concatenate([b, fit.scale * p])
    return A, b


def _at_trace(K: np.ndarray, trace: float) -> np.ndarray:
    """Give the derivative of (entries of K, q*) after K was brought to its trace."""
    n = len(K)
    rows, columns = entries(n)
    out = np.eye(len(rows) + n)
    out[: len(rows), : len(rows)] -= np.outer(K[rows, columns], rows == columns) / trace
    return out


def _search(problem: Problem, K: np.ndarray, rest: np.ndarray, stop: _Stop) -> Fit:
    """Iterate: weights and noise shape from the last law, a damped step in K = LLᵀ and q*."""
    fit = _at(problem, K, rest)
    damping = 1e-6
    for _ in range(stop.max_iterations):
        A, b = system(problem, fit)
        n_entries = A.shape[1] - problem.n
        L = np.linalg.cholesky(fit.K)
        T = _by_factor(L)
        A = np.concatenate([A[:, :n_entries] @ T, A[:, n_entries:]], axis=1)
        AtA, Atb = A.T @ A, A.T @ b
        before = float(b @ b)
        # Twice what a full step would gain, in squared standard errors.
        full = np.linalg.solve(AtA + np.diag(1e-12 * AtA.diagonal() + 1e-30), Atb)
        if float(Atb @ full) < stop.settled * fit.scale**2 and fit.scale > EXACT:
            return replace(fit, converged=True)
        while True:
            scaled = AtA + np.diag(damping * AtA.diagonal() + 1e-14 * np.trace(AtA))
            step = np.linalg.solve(scaled, Atb)
            tried = _moved(problem, fit, L, step)
            if tried is not None:
                # Judged with the weights of the point left, so that they do not hide a rise.
                after = _weighted(problem, fit, tried)
                if after <= before * (1.0 + 1e-12) or after < 1e-30:
                    break
            damping *= 10.0
            if damping > LARGEST_DAMPING:
                return _at_rest(fit)
        damping = max(0.1 * damping, 1e-12)
        size = max(np.abs(tried.K - fit.K).max(), np.abs(tried.rest - fit.rest).max())
        fit = tried
        if size < TOLERANCE:
            return _at(problem, fit.K, fit.rest, converged=True)
    return _at_rest(fit)


def _at_rest(fit: Fit) -> Fit:
    """Give a fit that no step improves: it has settled where only rounding is left of distances."""
    return replace(fit, converged=fit.scale < EXACT)


def _moved(problem: Problem, fit: Fit, L: np.ndarray, step: np.ndarray) -> Fit | None:
    """Give the law after a step; None where it has left the numbers."""
    n = problem.n
    dL = np.zeros((n, n))
    dL[entries(n)] = step[:-n]
    K = (L + dL) @ (L + dL).T
    if not np.isfinite(step).all() or np.linalg.eigvalsh(K)[0] <= 1e-9 * np.trace(K):
        return None
    if np.abs(step[-n:]).max() > LARGEST_TURN:
        return None
    try:
        tried = _at(problem, K, fit.rest + step[-n:])
    except np.linalg.LinAlgError:
        return None
    allowed = max(fit.folded, FOLDED * len(fit.weights))
    return None if tried.folded > allowed else tried


def _weighted(problem: Problem, old: Fit, new: Fit) -> float:
    """Sum the squares of new distances with the old weights, plus the prior's."""
    white = np.einsum("krs,ks->kr", old.white, new.found.delta)
    total = float((old.weights[:, None] * white**2).sum())
    if problem.prior is not None:
        p = problem.prior.rows(new.K, new.rest, problem.trace)[1]
        total += float(old.scale**2 * (p @ p))
    return total


def _by_factor(L: np.ndarray) -> np.ndarray:
    """Give the derivative of the entries of LLᵀ by those of L."""
    n = len(L)
    rows, columns = entries(n)
    T = np.zeros((len(rows), len(rows)))
    for j, (a, c) in enumerate(zip(rows, columns, strict=True)):
        dK = np.zeros((n, n))
        dK[a] += L[:, c]
        dK[:, a] += L[:, c]
        T[:, j] = dK[rows, columns]
    return T


def from_the_middle(task: Task, q: np.ndarray) -> np.ndarray:
    """Order the postures by the distance of what they point at from the middle."""
    x = task.value(q)
    return np.argsort(np.linalg.norm(x - np.median(x, axis=0), axis=1), kind="stable")
