"""One pass over all samples: the survey, the normal equations, and Algorithm 1's sums.

[Khoramshahi2022] eqs 16-22; the formulas stand in `kernels`.
"""

from dataclasses import dataclass

import numpy as np

from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.methods.weights import kernels
from selfmotion.methods.weights.samples import Samples, by_cluster, sweep
from selfmotion.motion.checks import CONSISTENCY

STILL_SPEED = 1e-9
"""Root mean square joint speed (rad/s) below which nothing moves: it is rounding."""


@dataclass(frozen=True, eq=False)
class Survey:
    """Sums that do not depend on the weights.

    Attributes:
        moment: Σ q̇q̇ᵀ (n, n).
        moment_by_cluster: the same by cluster (G, n, n).
        linear: Σ diag(q̇) ZZᵀ diag(q̇) (n, n); its smallest eigenvector is the first guess of w.
        coupling: max over samples of |ZZᵀ| (n, n).
        used_by_cluster: usable samples of each cluster (G).
        n_used: usable samples.
        n_gaps: samples left out because they hold NaN.
        n_rank_deficient: samples left out because rows of J depend on each other.
        mismatch: relative ‖ẋ - Jq̇‖, NaN where ẋ is not known.
    """

    moment: np.ndarray
    moment_by_cluster: np.ndarray
    linear: np.ndarray
    coupling: np.ndarray
    used_by_cluster: np.ndarray
    n_used: int
    n_gaps: int
    n_rank_deficient: int
    mismatch: float


def survey(samples: Samples, h: np.ndarray | None = None) -> Survey:
    """Mark usable samples and sum what does not depend on the weights.

    Args:
        samples: the samples; their `keep` is filled unless `h` takes joints out.
        h: one for each joint (n), zero for joints to be taken out of the chain.

    Raises:
        NotFiniteError: a value is infinite.
    """
    n, chunks = len(samples.joints), len(samples.cluster)
    scale = np.ones(n) if h is None else h
    moment, linear, coupling = (np.zeros((chunks, n, n)) for _ in range(3))
    mismatch = np.zeros((chunks, 2))

    def work(number: int, some: slice, all_: slice) -> None:
        part = samples.parts[number]
        kernels.survey_samples(
            part.qd, part.jacobian, part.q, part.xd, samples.keep[number],
            samples.bounds[number][some], scale,
            moment[all_], linear[all_], coupling[all_], mismatch[all_],
        )  # fmt: skip

    sweep(samples, work)
    codes = sum(np.bincount(keep, minlength=4) for keep in samples.keep)
    assert isinstance(codes, np.ndarray)
    if codes[kernels.HAS_INF]:
        raise _infinite(samples)
    wrong, size = mismatch.sum(axis=0)
    if not np.isfinite(wrong):
        raise _infinite(samples)
    counts = [
        np.add.reduceat(keep == kernels.KEPT, bounds[:, 0], dtype=np.int64)
        for keep, bounds in zip(samples.keep, samples.bounds, strict=True)
    ]
    return Survey(
        moment=moment.sum(axis=0),
        moment_by_cluster=by_cluster(samples, moment),
        linear=linear.sum(axis=0),
        coupling=coupling.max(axis=0),
        used_by_cluster=by_cluster(samples, np.concatenate(counts).astype(np.float64)),
        n_used=int(codes[kernels.KEPT]),
        n_gaps=int(codes[kernels.HAS_NAN]),
        n_rank_deficient=int(codes[kernels.RANK_DEFICIENT]),
        mismatch=float(np.sqrt(wrong / size)) if size > 0.0 else float("nan"),
    )


def _infinite(samples: Samples) -> NotFiniteError:
    for part in samples.parts:
        for field in ("qd", "jacobian", "q", "xd"):
            array = getattr(part, field)
            bad = np.argwhere(np.isinf(array))
            if len(bad):
                where = ", ".join(str(int(i)) for i in bad[0])
                return NotFiniteError(
                    f"{part.name}: {field}[{where}] = {array[tuple(bad[0])]}; "
                    f"allowed are finite values, and NaN for a gap"
                )
    return NotFiniteError("velocities or Jacobian overflow; allowed are finite values")


def check_survey(samples: Samples, found: Survey) -> None:
    """Refuse data from which no weight can come.

    Raises:
        ShapeError: the arm is not redundant for the task (m >= n).
        RangeError: fewer than two usable samples, no motion, or J does not fit ẋ.
    """
    m, n = samples.n_rows, len(samples.joints)
    name = samples.parts[0].name
    if len(samples.parts) > 1:
        name += f" and {len(samples.parts) - 1} more recordings"
    if m >= n:
        raise ShapeError(
            f"{name}: jacobian has {m} task rows for {n} joints; allowed are fewer rows than joints"
        )
    if found.n_used == 0 and found.n_rank_deficient:
        raise RangeError(
            f"{name}: jacobian is rank-deficient in all {found.n_rank_deficient} samples "
            f"(rows within {kernels.RANK_TOLERANCE:g} rad of each other); allowed is full row rank"
        )
    if found.n_used < 2:
        raise RangeError(
            f"{name}: {found.n_used} usable sample(s) of {samples.n_all} "
            f"({found.n_gaps} hold NaN); at least 2 are needed"
        )
    speed = float(np.sqrt(np.trace(found.moment) / found.n_used))
    if speed < STILL_SPEED:
        raise RangeError(
            f"{name}: qd is zero in all {found.n_used} samples (rms {speed:.2g} rad/s; "
            f"at least {STILL_SPEED:g} is motion)"
        )
    if found.mismatch > CONSISTENCY:
        raise RangeError(
            f"{name}: xd differs from jacobian @ qd by {100 * found.mismatch:.3g} % (over all "
            f"samples); allowed is {100 * CONSISTENCY:g} %: check arm, frame and units"
        )


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """½Σ‖r‖² and its derivatives with respect to θ = log w and the feedback (U = n·terms).

    Attributes:
        cost: ½Σ‖r‖².
        gradient: (U).
        curvature: Gauss-Newton matrix (U, U).
        gradient_by_cluster: (G, U); empty unless asked for.
        exact: the Hessian (U, U); empty unless asked for.
        exact_by_cluster: (G, U, U); empty unless asked for.
    """

    cost: float
    gradient: np.ndarray
    curvature: np.ndarray
    gradient_by_cluster: np.ndarray
    exact: np.ndarray
    exact_by_cluster: np.ndarray


@dataclass(frozen=True, eq=False)
class Feedback:
    """Null-space motion driven by posture: Σ_t φ_t b_t with φ the posture or ones.

    Attributes:
        kinds: one code a term (see `kernels`).
        gains: b (terms, n): 1/s for the posture, rad/s for the constant.
    """

    kinds: np.ndarray
    gains: np.ndarray


NO_FEEDBACK = Feedback(np.empty(0, dtype=np.int64), np.empty((0, 0)))


def normal_equations(
    samples: Samples, h: np.ndarray, feedback: Feedback = NO_FEEDBACK, *, exact: bool = False
) -> NormalEquations:
    """Sum cost, gradient and curvature at weights w = h⁻² (h = 0: the joint is taken out).

    With `exact` the Hessian and the sums by cluster are kept, too.
    """
    n, chunks = len(samples.joints), len(samples.cluster)
    U = n * (1 + len(feedback.kinds))
    gains = feedback.gains.reshape(-1, n)
    cost, gradient = np.zeros(chunks), np.zeros((chunks, U))
    curvature = np.zeros((chunks, U, U))
    hessian = np.zeros((chunks if exact else 0, U, U))

    def work(number: int, some: slice, all_: slice) -> None:
        part = samples.parts[number]
        kernels.sum_normal_equations(
            part.qd, part.jacobian, part.q, samples.keep[number], samples.bounds[number][some],
            h, feedback.kinds, gains, cost[all_], gradient[all_], curvature[all_], hessian[all_],
        )  # fmt: skip

    sweep(samples, work)
    return NormalEquations(
        cost=float(cost.sum()),
        gradient=gradient.sum(axis=0),
        curvature=curvature.sum(axis=0),
        gradient_by_cluster=by_cluster(samples, gradient) if exact else np.empty((0, U)),
        exact=hessian.sum(axis=0),
        exact_by_cluster=by_cluster(samples, hessian) if exact else np.empty((0, U, U)),
    )


@dataclass(frozen=True, eq=False)
class AlgorithmSums:
    """Algorithm 1's sums: C = Σ N q̇q̇ᵀ, by cluster if asked for, and Σ‖e‖."""

    cross: np.ndarray
    cross_by_cluster: np.ndarray
    error: float


def algorithm_sums(
    samples: Samples,
    w: np.ndarray,
    *,
    w_before: np.ndarray,
    ratio_before: float,
    clusters: bool = False,
) -> AlgorithmSums:
    """Sum C at weights w, and the error with v̄ = γ_before N(w_before) q̇ (zero at first)."""
    n, chunks = len(samples.joints), len(samples.cluster)
    cross, error = np.zeros((chunks, n, n)), np.zeros(chunks)
    h, h_before = 1.0 / np.sqrt(w), 1.0 / np.sqrt(w_before)

    def work(number: int, some: slice, all_: slice) -> None:
        part = samples.parts[number]
        kernels.sum_algorithm_one(
            part.qd, part.jacobian, samples.keep[number], samples.bounds[number][some],
            h, h_before, float(ratio_before), cross[all_], error[all_],
        )  # fmt: skip

    sweep(samples, work)
    shares = by_cluster(samples, cross) if clusters else np.empty((0, n, n))
    return AlgorithmSums(cross.sum(axis=0), shares, float(error.sum()))
