"""Fit a person's joint elasticity to postures alone: Donders' law as [Tommasino2017] reads it.

doi 10.3389/fnbot.2017.00065; the inverse optimisation is that of Tommasino & Campolo 2016 in
purpose, not in detail. For each target a person takes the posture of least elastic energy
½(q - q*)ᵀK^J(q - q*); K^J (up to a scale: its trace is set to 4 N m/rad) and q* follow from where
postures lie on the self-motion. The distance of a posture from the law's surface is minimised, not
the torque that remains: the latter is linear and exact without noise, but with half a degree of it
the stiffness of pronation collapses to nothing.

Deviations: fits all postures, not a quadratic surface through them, since such a surface has six
parameters and the law eight; gives standard errors, and says which entries the data cannot tell.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.methods.donders_fit import (
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
from selfmotion.methods.donders_result import ElasticityPrior, JointElasticity, findings
from selfmotion.methods.joint_law import TRACE
from selfmotion.methods.orientations import Form, wrist_angles
from selfmotion.methods.passive_motion_tasks import arm_of
from selfmotion.provenance import Provenance, hash_arrays
from selfmotion.redundancy.task import Pointing, Task

__all__ = ["ElasticityPrior", "JointElasticity", "fit_elasticity"]

# Where the surface folds, the fit begins with the postures nearest to the middle and goes on
# outwards: shares of them all.
OUTWARD = (0.4, 0.6, 0.8)
# Postures on which first guesses are tried, and the softness of one joint in some of them.
TRIAL_SIZE = 150
SOFT = 0.25
# Share of the postures that may lie past a fold, where noise alone can carry the outermost.
FOLDED = 0.02
# Noise widths beyond which a posture is put down to a gross error.
GROSS = 4.0
# Second spread of the task values over the first, below which they lie on one line.
LINE = 1e-3
# Postures beyond the number of parameters.
SPARE = 4
# Singular values of the scaled problem below this share of the largest count as zero.
RANK_TOLERANCE = 1e-9
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
class _Problem:
    """What stays fixed while the law is searched."""

    geometry: PostureGeometry
    prior: ElasticityPrior | None
    trace: float

    @property
    def n(self) -> int:
        return self.geometry.q.shape[1]


@dataclass(frozen=True, eq=False)
class _Fit:
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


def fit_elasticity(
    postures: ArrayLike,
    *,
    task: Task | None = None,
    form: Form = "angles",
    prior: ElasticityPrior | None = None,
    trials: ArrayLike | None = None,
    trace: float = TRACE,
) -> JointElasticity:
    """Fit stiffness and rest posture of the joints to postures ([Tommasino2017]).

    Args:
        postures: (K, n) joint angles (rad); for the wrist also rotation vectors (K, 3) (rad),
            quaternions (K, 4) as x, y, z, w, or matrices (K, 3, 3) of the hand, as `form` says.
        task: what the postures were taken for; left out: pointing with the wrist.
        form: "angles", "rotation vectors", "quaternions" or "matrices".
        prior: what is known about the law beforehand; stated in the result.
        trials: (K,) labels; postures with the same label are not independent of each other.
        trace: sum of the joint stiffnesses (N m/rad): postures say nothing about it.

    Returns:
        The law with standard errors and sentences on what the data can and cannot tell.

    Raises:
        ShapeError: shapes do not fit, or there are too few postures.
        NotFiniteError: a posture is not finite.
        RangeError: the postures lie on one line of the task, or at a singular posture.

    Example:
        >>> from selfmotion.arms import wrist
        >>> from selfmotion.methods.donders_posture import donders_postures
        >>> from selfmotion.methods.joint_law import JointLaw
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> angles = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
        >>> targets = np.concatenate([r * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        ...                           for r in (0.2, 0.4)])
        >>> q = donders_postures(Pointing(wrist()), law, targets).q
        >>> fit_elasticity(q).stiffness.diagonal().round(6).tolist()
        [0.5, 1.5, 2.0]
    """
    if task is None:
        from selfmotion.arms import wrist

        task = Pointing(wrist())
    q = _angles(task, postures, form)
    groups = _groups(trials, len(q))
    _refuse_poor_postures(task, q)
    if prior is not None:
        prior.refuse_misfit(q.shape[1])
    if not trace > 0.0:
        raise RangeError(f"trace = {trace:g} N m/rad: must be above 0")
    problem = _Problem(PostureGeometry.of(task, q), prior, trace)
    fit = _from_all_starts(problem, _from_the_middle(task, q))
    covariance, known = _covariance(problem, fit, groups)
    choices = {"arm": arm_of(task).name, "form": form, "trace": trace, "loss": "Huber"}
    inputs = {"postures": hash_arrays(q)}
    if prior is not None:
        choices["prior"] = prior.source
    return findings(
        (fit.K, fit.rest),
        (covariance, known),
        distance=fit.found.delta,
        used=(fit.weights, _status(fit)),
        joints=arm_of(task).joints,
        prior=prior,
        provenance=Provenance("fit_elasticity", inputs=inputs, choices=choices),
    )


def _angles(task: Task, postures: ArrayLike, form: Form) -> np.ndarray:
    """Give checked joint angles (K, n)."""
    if form == "angles":
        array = as_float_array("postures", postures, ndim=2)
        return arm_of(task).chain.as_samples(array)
    if arm_of(task).joints != ("pronation", "flexion", "deviation"):
        raise RangeError(f"form = {form!r}: orientations are understood for the arm 'wrist' only")
    return wrist_angles(postures, form)


def _groups(trials: ArrayLike | None, n_samples: int) -> np.ndarray:
    """Number the groups of dependent postures."""
    if trials is None:
        return np.arange(n_samples)
    labels = np.asarray(trials)
    require_shape("trials", labels, (n_samples,))
    return np.unique(labels, return_inverse=True)[1]


def _refuse_poor_postures(task: Task, q: np.ndarray) -> None:
    n = q.shape[1]
    n_parameters = n * (n + 1) // 2 + n - 1
    if n <= len(task.units):
        raise ShapeError(f"task has {len(task.units)} rows for {n} joints: no self-motion is left")
    if len(q) < n_parameters + SPARE:
        raise ShapeError(
            f"postures: {len(q)} are too few for {n_parameters} parameters; "
            f"at least {n_parameters + SPARE} are needed"
        )
    x = task.value(q)
    spread = np.linalg.svd(x - x.mean(axis=0), compute_uv=False)
    if len(task.units) > 1 and not spread[1] > LINE * max(spread[0], 1e-12):
        raise RangeError(
            "postures: they point at one place, or along one line; a law needs targets in two "
            f"directions (spread {spread[1]:.2g} against {spread[0]:.2g})"
        )
    sizes = np.linalg.svd(task.jacobian(q), compute_uv=False)
    if not (sizes[:, -1] > 1e-6 * sizes[:, 0]).all():
        i = int(np.argmin(sizes[:, -1] / sizes[:, 0]))
        raise RangeError(f"postures[{i}]: the task's Jacobian has lost rank there")


def _from_the_middle(task: Task, q: np.ndarray) -> np.ndarray:
    """Order the postures by the distance of what they point at from the middle."""
    x = task.value(q)
    return np.argsort(np.linalg.norm(x - np.median(x, axis=0), axis=1), kind="stable")


def _part(problem: _Problem, which: np.ndarray) -> _Problem:
    g = problem.geometry
    some = PostureGeometry(g.q[which], g.Z[which], g.P[which], g.Q[which], g.C[which])
    return _Problem(some, problem.prior, problem.trace)


def _from_all_starts(problem: _Problem, order: np.ndarray) -> _Fit:
    """Try several starts on a few postures; from the best, go outwards if the surface folds."""
    n, n_all = problem.n, len(order)
    least = n * (n + 1) // 2 + n + SPARE
    few = order[:: max(1, n_all // max(TRIAL_SIZE, least))]
    trial = _part(problem, few)
    tried = [_search(trial, K, rest, TRIAL) for K, rest in _starts(problem, trial)]
    # The distance of all postures tells false minima from the true one.
    fit = min((_at(problem, fit.K, fit.rest) for fit in tried), key=_order)
    if fit.folded > FOLDED * n_all:
        K, rest = np.eye(n), np.median(problem.geometry.q, axis=0)
        for share in OUTWARD:
            part = _part(problem, order[: max(least, int(np.ceil(share * n_all)))])
            inner = _search(part, K, rest, STAGE)
            K, rest = inner.K, inner.rest
        fit = min(fit, _at(problem, K, rest), key=_order)
    return _search(problem, fit.K, fit.rest, LAST)


def _starts(problem: _Problem, trial: _Problem) -> list[tuple[np.ndarray, np.ndarray]]:
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


def _order(fit: _Fit) -> tuple[bool, float]:
    """Rank laws: not folded, then near to half of the postures or more."""
    return fit.folded > FOLDED * len(fit.weights), fit.scale


def _at(problem: _Problem, K: np.ndarray, rest: np.ndarray, converged: bool = False) -> _Fit:
    """Look at the data from one law: distances, their noise and their weights."""
    K = K * (problem.trace / np.trace(K))
    found = residuals(problem.geometry, K, rest)
    white = whitening(found.spread)
    w = np.einsum("krs,ks->kr", white, found.delta)
    weights, scale = huber_weights(w)
    weights = np.where(past_fold(found), 0.0, weights)  # there the distance means nothing
    return _Fit(K, rest, found, white, weights, scale, converged)


def _system(problem: _Problem, fit: _Fit) -> tuple[np.ndarray, np.ndarray]:
    """Give rows and right-hand side by (entries of K, q*), one sample after the other."""
    J = np.concatenate([fit.found.by_stiffness, fit.found.by_rest], axis=2)
    root = np.sqrt(fit.weights)[:, None, None]
    A = (root * (fit.white @ J)).reshape(-1, J.shape[2])
    b = -(root * (fit.white @ fit.found.delta[..., None])).ravel()
    if problem.prior is not None:
        P, p = problem.prior.rows(fit.K, fit.rest, problem.trace)
        A = np.concatenate([A, fit.scale * P])
        b = np.concatenate([b, fit.scale * p])
    return A, b


def _search(problem: _Problem, K: np.ndarray, rest: np.ndarray, stop: _Stop) -> _Fit:
    """Iterate: weights and noise shape from the last law, a damped step in K = LLᵀ and q*."""
    fit = _at(problem, K, rest)
    damping = 1e-6
    for _ in range(stop.max_iterations):
        A, b = _system(problem, fit)
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
                _, left = _system(problem, tried)
                # Judged with the weights of the point left, so that they do not hide a rise.
                after = _weighted(problem, fit, tried, left)
                if after <= before * (1.0 + 1e-12) or after < 1e-30:
                    break
            damping *= 10.0
            if damping > LARGEST_DAMPING:
                return fit
        damping = max(0.1 * damping, 1e-12)
        size = max(np.abs(tried.K - fit.K).max(), np.abs(tried.rest - fit.rest).max())
        fit = tried
        if size < TOLERANCE:
            return _at(problem, fit.K, fit.rest, converged=True)
    return fit


def _moved(problem: _Problem, fit: _Fit, L: np.ndarray, step: np.ndarray) -> _Fit | None:
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


def _weighted(problem: _Problem, old: _Fit, new: _Fit, left: np.ndarray) -> float:
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


def _covariance(
    problem: _Problem, fit: _Fit, groups: np.ndarray
) -> tuple[Float[np.ndarray, "parameters parameters"], Bool[np.ndarray, " parameters"]]:
    """Give the covariance of (entries of K, q*), and which of them the data determine at all.

    The sandwich: the spread of each group's pull on the law, so that neither unequal noise nor
    postures that depend on each other make the errors look small.
    """
    n = problem.n
    rows, columns = entries(n)
    basis = np.zeros((len(rows) + n, len(rows) + n - 1))
    on_diagonal = (rows == columns).astype(float)[None]
    basis[: len(rows), : len(rows) - 1] = np.linalg.svd(on_diagonal)[2][1:].T
    basis[len(rows) :, len(rows) - 1 :] = np.eye(n)
    A, b = _system(problem, fit)
    A = A @ basis
    n_data = fit.found.delta.size
    scale = np.linalg.norm(A, axis=0)
    _, s, Vt = np.linalg.svd(A / scale, full_matrices=False)
    kept = s > RANK_TOLERANCE * s[0]
    half = basis / scale @ Vt.T
    bread = (half[:, kept] / s[kept] ** 2) @ Vt[kept] / scale  # to all parameters from scores
    scores = (A[:n_data] * b[:n_data, None]).reshape(len(groups), -1, A.shape[1]).sum(axis=1)
    n_groups = int(groups.max()) + 1
    pulls = np.zeros((n_groups, A.shape[1]))
    np.add.at(pulls, groups, scores)
    spare = max(n_groups - A.shape[1], 1)
    meat = pulls.T @ pulls * (n_groups / spare)
    meat = meat + fit.scale**2 * A[n_data:].T @ A[n_data:]
    lost = np.abs(half[:, ~kept]).max(axis=1, initial=0.0)
    return bread @ meat @ bread.T, lost < 1e-6 * np.abs(half).max()


def _status(fit: _Fit) -> Status:
    if fit.folded > FOLDED * len(fit.weights):
        return Status(
            False,
            f"{fit.folded} of {len(fit.weights)} postures lie past a fold of the law's surface; "
            "leave out the farthest targets",
        )
    if not fit.converged:
        return Status(False, "the fit did not settle: the postures do not determine the law")
    return Status(True, "fitted")
