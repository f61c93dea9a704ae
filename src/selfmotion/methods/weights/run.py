"""The steps of an identification, in order: survey, structure, fit, errors, verdict, report."""

import warnings
from dataclasses import asdict, dataclass

import numpy as np

from selfmotion.errors import RangeError, Status, unknown_name
from selfmotion.methods.weights.algorithm_one import (
    NullSchedule,
    algorithm_one,
    fixed_point_covariance,
)
from selfmotion.methods.weights.estimate import STILL_WEIGHT, WeightEstimate, contributions
from selfmotion.methods.weights.gauss_newton import (
    Fit,
    Problem,
    final_sums,
    first_guess,
    gauss_newton,
)
from selfmotion.methods.weights.identifiability import (
    Excitation,
    Structure,
    find_excitation,
    find_structure,
)
from selfmotion.methods.weights.options import (
    METHODS,
    TERMS,
    IdentificationOptions,
    Method,
)
from selfmotion.methods.weights.passes import (
    NO_FEEDBACK,
    NormalEquations,
    Survey,
    check_survey,
    survey,
)
from selfmotion.methods.weights.samples import Samples
from selfmotion.methods.weights.uncertainty import (
    dependence,
    eliminate_feedback,
    jackknife,
    sandwich,
)
from selfmotion.methods.weights.verdict import Evidence, Verdict, reach_verdict
from selfmotion.motion.recording import GapWarning
from selfmotion.provenance import Provenance, hash_arrays

MANY_CLUSTERS = 15
"""Clusters from which on the sandwich is no longer clearly too narrow."""
STILL_TOLERANCE = 1e-8
"""A joint whose rms velocity is below this part of the largest one never moves."""
MIN_CLUSTERS = 5


@dataclass(frozen=True, eq=False)
class _Plan:
    method: Method
    schedule: NullSchedule
    options: IdentificationOptions


def clusters_needed(n: int, terms: tuple[str, ...]) -> int:
    """Count the clusters without which the sandwich cannot have full rank."""
    return max(MIN_CLUSTERS, n * (1 + len(terms)) + 1)


def identify_samples(
    samples: Samples, method: Method, schedule: NullSchedule, options: IdentificationOptions
) -> WeightEstimate:
    """Run all steps on samples that are ready to stream."""
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    found = survey(samples)
    check_survey(samples, found)
    if found.n_gaps:
        message = f"{found.n_gaps} of {samples.n_all} samples hold NaN and are left out"
        warnings.warn(message, GapWarning, stacklevel=3)
    if found.n_rank_deficient:
        message = (
            f"{found.n_rank_deficient} of {samples.n_all} samples are left out: "
            "the rows of their jacobian depend on each other"
        )
        warnings.warn(message, UserWarning, stacklevel=3)
    plan = _Plan(method, schedule, options)
    problem, structure, linear = _set_up(samples, found, plan)
    fit = _fit(problem, found, linear, plan)
    sums = final_sums(problem, fit)
    fisher, _ = eliminate_feedback(sums.curvature, sums.gradient, len(samples.joints))
    excitation = find_excitation(fisher, structure)
    evidence = _evidence(problem, found, fit, sums, (structure, excitation, plan))
    return _report(problem, found, fit, (sums, evidence, plan))


def _set_up(samples: Samples, found: Survey, plan: _Plan) -> tuple[Problem, Structure, np.ndarray]:
    """Take joints that never move out of the chain (w = ∞) and find the scale groups."""
    speed = np.sqrt(np.diag(found.moment))
    moving = speed > STILL_TOLERANCE * speed.max()
    terms = plan.options.feedback_terms if plan.method == "feedback" else ()
    kinds = np.array([TERMS[term] for term in terms], dtype=np.int64)
    in_chain = np.ones_like(moving) if plan.method == "paper" else moving
    chain = found if in_chain.all() else survey(samples, in_chain.astype(np.float64))
    structure = find_structure(chain.coupling, in_chain)
    energy = float(np.trace(found.moment))
    problem = Problem(samples, structure.groups, moving, in_chain, kinds, energy, found.n_used)
    return problem, structure, chain.linear


def _fit(problem: Problem, found: Survey, linear: np.ndarray, plan: _Plan) -> Fit:
    options, n = plan.options, len(found.moment)
    if not problem.groups:
        zero = np.zeros(n)
        status = Status(False, "no two joints can stand in for each other: there are no ratios")
        none = np.zeros(n, dtype=bool)
        return Fit(zero, NO_FEEDBACK, zero[None, :], np.full(1, np.nan), none, status)
    if plan.method == "paper":
        return algorithm_one(
            problem,
            found.moment,
            plan.schedule,
            tolerance=1e-8 if options.tolerance is None else options.tolerance,
            max_iterations=options.max_iterations or 5000,
        )
    tolerance = 1e-10 if options.tolerance is None else options.tolerance
    fits = [
        gauss_newton(
            problem, start, tolerance=tolerance, max_iterations=options.max_iterations or 100
        )
        for start in _starts(linear, problem, plan)
    ]
    return min(fits, key=lambda fit: float(fit.errors[-1]))


def _starts(linear: np.ndarray, problem: Problem, plan: _Plan) -> list[np.ndarray]:
    n, start = len(linear), plan.options.start
    if start == "eigenvector":
        guess = first_guess(linear, problem.groups)
        # with feedback the cost has several valleys; the linear guess knows of no feedback
        return [guess, np.zeros(n)] if len(problem.kinds) and guess.any() else [guess]
    if start == "ones":
        return [np.zeros(n)]
    if len(start) != n:
        raise RangeError(f"start has {len(start)} weights; allowed is one for each of {n} joints")
    return [np.log(np.array(start))]


def _evidence(
    problem: Problem,
    found: Survey,
    fit: Fit,
    sums: NormalEquations,
    basis: tuple[Structure, Excitation, _Plan],
) -> Evidence:
    structure, excitation, plan = basis
    n_clusters = int(np.count_nonzero(found.used_by_cluster))
    needed = 2 + excitation.rank
    covariance, how = np.full_like(found.moment, np.inf), ""
    if n_clusters >= needed and structure.groups:
        weights = dependence(len(sums.gradient_by_cluster), problem.samples.stretches)
        if plan.method == "paper":
            covariance, how = fixed_point_covariance(problem, found, fit), "delta method"
        else:
            covariance, how = _covariance(excitation, sums, weights, plan.options)
    limit = plan.options.max_stderr
    tentative = plan.method == "paper"
    return Evidence(structure, excitation, covariance, limit, needed, n_clusters, how, tentative)


def _covariance(
    excitation: Excitation,
    sums: NormalEquations,
    weights: np.ndarray,
    options: IdentificationOptions,
) -> tuple[np.ndarray, str]:
    """Give the covariance and how it was made: with few trials, the jackknife where it exists."""
    G = len(weights)
    independent = np.array_equal(weights, np.eye(G))
    if options.stderr == "jackknife" or (
        options.stderr == "auto" and independent and G < MANY_CLUSTERS
    ):
        covariance = jackknife(excitation, sums, weights)
        if options.stderr == "jackknife" or np.isfinite(covariance).all():
            return covariance, "jackknife"
    return sandwich(excitation, sums, weights), "sandwich"


def _report(
    problem: Problem, found: Survey, fit: Fit, rest: tuple[NormalEquations, Evidence, _Plan]
) -> WeightEstimate:
    sums, evidence, plan = rest
    verdict = reach_verdict(problem, fit, evidence)
    samples, joints = problem.samples, problem.samples.joints
    weights, contribution, stderr = _by_group(fit, verdict)
    full = np.where(problem.in_chain, np.exp(fit.log_weights), STILL_WEIGHT)
    inside = np.isfinite(weights)
    if not fit.status.ok:  # Algorithm 1, stopped on its way: a weight, but no error
        stderr = np.full_like(stderr, np.nan)
    shown = inside[:, None] & inside[None, :] & fit.status.ok
    covariance = np.where(shown, evidence.covariance, np.nan)
    terms = plan.options.feedback_terms if plan.method == "feedback" else ()
    return WeightEstimate(
        joints=joints,
        weights=weights,
        contribution=contribution,
        contribution_eq26=_over_all_joints(problem, fit, inside, plan),
        full_weights=full,
        groups=_names(joints, verdict.groups),
        structural_groups=_names(joints, problem.groups),
        unidentifiable={joints[i]: reason for i, reason in verdict.reasons.items()},
        stderr_log=stderr,
        stderr_kind=_stderr_kind(problem, evidence, converged=fit.status.ok),
        log_covariance=covariance,
        method=plan.method,
        iterations=len(fit.history) - 1,
        history=np.exp(fit.history),
        error_history=fit.errors,
        unexplained=2.0 * sums.cost / problem.energy,
        unexplained_identity=float(found.linear.sum()) / problem.energy,
        feedback_terms=terms,
        feedback_gains=fit.feedback.gains.reshape(-1, len(joints)),
        n_samples=found.n_used,
        n_trials=samples.n_trials,
        n_clusters=evidence.n_clusters,
        n_dropped=found.n_gaps,
        n_rank_deficient=found.n_rank_deficient,
        status=_status(fit, verdict),
        provenance=_provenance(samples, plan),
    )


def _names(
    joints: tuple[str, ...], groups: tuple[tuple[int, ...], ...]
) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(joints[i] for i in group) for group in groups)


def _by_group(fit: Fit, verdict: Verdict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    weights, share, stderr = (np.full(len(fit.log_weights), np.nan) for _ in range(3))
    for group in verdict.groups:
        at = list(group)
        theta = fit.log_weights[at]
        weights[at] = np.exp(theta - theta.max())
        share[at] = contributions(weights[at])
        stderr[at] = verdict.errors[at, at[int(theta.argmax())]]
    return weights, share, stderr


def _over_all_joints(problem: Problem, fit: Fit, inside: np.ndarray, plan: _Plan) -> np.ndarray:
    """Give β of eq. 26: over-specified joints count as 1, as in the paper's experiment 1.

    Of Algorithm 1 it is that of the weights as they are, like the paper's. Otherwise a joint
    whose weight matters and could not be identified leaves no sum to divide by: NaN.
    """
    weights = np.exp(fit.log_weights)
    matters = np.zeros(len(weights), dtype=bool)
    for group in problem.groups:
        matters[list(group)] = True
    if plan.method != "paper" and not inside[matters].all():
        return np.full(len(weights), np.nan)
    return contributions(np.where(matters, weights, 1.0))


def _stderr_kind(problem: Problem, evidence: Evidence, *, converged: bool) -> str:
    samples, G = problem.samples, evidence.n_clusters
    if G < evidence.clusters_needed:
        return f"none: {G} clusters, at least {evidence.clusters_needed} are needed"
    if not converged:
        return "none: the fit did not converge"
    how = evidence.how
    if samples.n_clusters == samples.n_trials:
        return f"clustered by trial ({how})"
    if samples.n_trials == 1:
        return (
            f"single trial: {G} stretches of it in place of repetitions ({how}); "
            "holds for this trial, not for the person"
        )
    return (
        f"{samples.n_trials} trials, too few: {G} stretches of them in place of repetitions "
        f"({how}); holds for these trials, not for the person"
    )


def _status(fit: Fit, verdict: Verdict) -> Status:
    if not problem_has_ratios(fit) or verdict.groups:
        return fit.status
    return Status(False, f"{fit.status.sentence}; no ratio of weights is identified")


def problem_has_ratios(fit: Fit) -> bool:
    """Tell whether anything was fitted (there is a structural group)."""
    return bool(np.isfinite(fit.errors).all())


def _provenance(samples: Samples, plan: _Plan) -> Provenance:
    choices: dict[str, object] = {"method": plan.method}
    if plan.method == "paper":
        choices |= asdict(plan.schedule)
    choices |= asdict(plan.options)
    inputs = {}
    if plan.options.hash_inputs:
        arrays = [a for part in samples.parts for a in (part.qd, part.jacobian, part.q)]
        inputs["recordings"] = hash_arrays(*arrays)
    return Provenance("identify_weights", inputs=inputs, choices=choices)
