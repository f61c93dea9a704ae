"""Maximum likelihood for IK weights, with or without posture feedback, by Gauss-Newton.

Of the model of [Khoramshahi2022] eq. 15, q̇ = J#ẋ + v, this takes the weights that leave the least
null-space velocity: min over θ = log w of ½Σ‖N(θ)q̇‖², maximum likelihood if v is normal, white and
independent of ẋ. With feedback, min over θ and b of ½Σ‖N(θ)(q̇ - Φ(q)b)‖², Φ = [diag(q), I]: the
null-space motion may be driven by posture. b is linear and is eliminated (variable projection).

Deviation: the paper solves a box QP in w by fixed-point iteration (see `algorithm_one`); that
estimate is biased as soon as there is null-space motion, at every γ.
"""

from dataclasses import dataclass

import numpy as np

from selfmotion.errors import Status
from selfmotion.methods.weights.passes import (
    NO_FEEDBACK,
    Feedback,
    NormalEquations,
    normal_equations,
)
from selfmotion.methods.weights.samples import Samples
from selfmotion.methods.weights.uncertainty import eliminate_feedback, scaled_pseudo_inverse

STEP_CAP = 2.0
"""Largest change of a log-weight in one iteration."""
LOG_RANGE = float(np.log(1e9))
"""Log-weights are held within this of each other in a group: a contribution of 1e-9 is zero."""
DECREASE_TOLERANCE = 1e-14
"""Converged if the model promises a smaller relative decrease of the cost."""
ZERO_RESIDUAL = 1e-28
"""A cost below this times ½Σ‖q̇‖² is rounding."""
UNIQUE_TOLERANCE = 1e-10
"""Second smallest eigenvalue of the linear problem, relative to the largest, taken for zero."""
HALVINGS = 30


@dataclass(frozen=True, eq=False)
class Fit:
    """Where an iteration ended.

    Attributes:
        log_weights: θ (n), largest zero in each scale group.
        feedback: kinds and gains of the feedback, if any.
        history: log-weights of each iteration, the start first (iterations + 1, n).
        errors: one number an iterate (iterations + 1).
        at_bound: which joints ran to the end of the allowed range (n).
        status: whether it converged.
        ratio: null-space projection ratio of the last iteration (Algorithm 1 only).
    """

    log_weights: np.ndarray
    feedback: Feedback
    history: np.ndarray
    errors: np.ndarray
    at_bound: np.ndarray
    status: Status
    ratio: float = float("nan")


@dataclass(frozen=True, eq=False)
class Problem:
    """What is fitted.

    Attributes:
        samples: the data.
        groups: scale groups (indices).
        moving: joints that move (n).
        in_chain: joints that take part (n); with ``paper`` those that never move do, too.
        kinds: codes of the feedback terms; empty for plain maximum likelihood.
        energy: Σ‖q̇‖².
        n_used: usable samples.
    """

    samples: Samples
    groups: tuple[tuple[int, ...], ...]
    moving: np.ndarray
    in_chain: np.ndarray
    kinds: np.ndarray
    energy: float
    n_used: int


@dataclass(frozen=True, eq=False)
class _Point:
    theta: np.ndarray
    feedback: Feedback
    cost: float
    gradient: np.ndarray
    curvature: np.ndarray


def normalise(theta: np.ndarray, groups: tuple[tuple[int, ...], ...]) -> np.ndarray:
    """Shift log-weights so that the largest is zero in each group; others become zero."""
    shifted = np.zeros_like(theta)
    for group in groups:
        at = list(group)
        shifted[at] = theta[at] - theta[at].max()
    return shifted


def half_powers(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """Give h = w^(-1/2), zero for joints out of the chain."""
    return np.where(problem.in_chain, np.exp(-0.5 * theta), 0.0)


def first_guess(linear: np.ndarray, groups: tuple[tuple[int, ...], ...]) -> np.ndarray:
    """Guess log-weights (n): the smallest eigenvector of Σ diag(q̇)ZZᵀdiag(q̇), group by group.

    Zᵀdiag(q̇)w = 0 holds without null-space motion. Where the eigenvector has mixed signs (noise)
    the guess is ones.
    """
    theta = np.zeros(len(linear))
    for group in groups:
        at = np.array(group)
        values, vectors = np.linalg.eigh(linear[np.ix_(at, at)])
        w = vectors[:, 0] * np.sign(vectors[:, 0].sum())
        if values[1] <= UNIQUE_TOLERANCE * values[-1]:
            continue  # more than one vector fits: the movement leaves the weights open
        if w.min() > w.max() * np.exp(-0.5 * LOG_RANGE):
            theta[at] = np.log(w)
    return normalise(theta, groups)


def gauss_newton(
    problem: Problem, start: np.ndarray, *, tolerance: float, max_iterations: int
) -> Fit:
    """Minimise from one start; `tolerance` is the largest last step of a log-weight."""
    point = _evaluate(problem, normalise(start, problem.groups))
    history, costs = [point.theta], [point.cost]
    status = Status(False, f"not converged in {max_iterations} iterations")
    for iteration in range(max_iterations + 1):
        step, promised = _step(problem, point)
        size = float(np.abs(step).max())
        if size <= tolerance or promised <= DECREASE_TOLERANCE * point.cost:
            status = Status(True, f"converged in {iteration} iterations")
            break
        if point.cost <= ZERO_RESIDUAL * problem.energy:
            status = Status(True, f"converged in {iteration} iterations (no null-space motion)")
            break
        if iteration == max_iterations:
            break
        new = _search(problem, point, step)
        if new is None:
            status = Status(True, f"converged in {iteration} iterations (to rounding)")
            break
        point = new
        history.append(point.theta)
        costs.append(point.cost)
    return Fit(
        log_weights=point.theta,
        feedback=point.feedback,
        history=np.array(history),
        errors=np.sqrt(2.0 * np.array(costs) / problem.n_used),
        at_bound=point.theta <= -LOG_RANGE * (1.0 - 1e-12),
        status=status,
    )


def _evaluate(problem: Problem, theta: np.ndarray) -> _Point:
    n = len(theta)
    h = half_powers(problem, theta)
    feedback = NO_FEEDBACK
    if len(problem.kinds):
        zero = Feedback(problem.kinds, np.zeros((len(problem.kinds), n)))
        sums = normal_equations(problem.samples, h, zero)
        inverse = scaled_pseudo_inverse(sums.curvature[n:, n:])
        gains = -(inverse @ sums.gradient[n:]).reshape(-1, n)
        feedback = Feedback(problem.kinds, gains)
    sums = normal_equations(problem.samples, h, feedback)
    curvature, gradient = eliminate_feedback(sums.curvature, sums.gradient, n)
    return _Point(theta, feedback, sums.cost, gradient, curvature)


def _step(problem: Problem, point: _Point) -> tuple[np.ndarray, float]:
    step = np.zeros(len(point.theta))
    for group in problem.groups:
        at = np.array(group)
        block = point.curvature[np.ix_(at, at)]
        step[at] = -scaled_pseudo_inverse(block) @ point.gradient[at]
        step[at] -= step[at].mean()
    promised = -0.5 * float(step @ point.gradient)
    largest = float(np.abs(step).max())
    return (step * STEP_CAP / largest if largest > STEP_CAP else step), promised


def _search(problem: Problem, point: _Point, step: np.ndarray) -> _Point | None:
    for halving in range(HALVINGS):
        theta = point.theta + 0.5**halving * step
        theta = np.maximum(normalise(theta, problem.groups), -LOG_RANGE)
        if np.abs(theta - point.theta).max() <= 1e-15:
            return None
        new = _evaluate(problem, theta)
        if new.cost < point.cost:
            return new
    return None


def final_sums(problem: Problem, fit: Fit) -> NormalEquations:
    """Sum the normal equations at the estimate, with Hessian and clusters."""
    h = half_powers(problem, fit.log_weights)
    return normal_equations(problem.samples, h, fit.feedback, exact=True)
