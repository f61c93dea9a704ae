"""From a fit and its covariance to the groups that are reported, and reasons for the rest."""

from dataclasses import dataclass

import numpy as np

from selfmotion.methods.weights.gauss_newton import Fit, Problem
from selfmotion.methods.weights.identifiability import (
    Excitation,
    Structure,
    contrast_errors,
    group_by_precision,
)


@dataclass(frozen=True, eq=False)
class Verdict:
    """Groups (indices) that are reported, a reason for each other joint, all standard errors."""

    groups: tuple[tuple[int, ...], ...]
    reasons: dict[int, str]
    errors: np.ndarray


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that the verdict rests on.

    Attributes:
        structure: what the null spaces allow.
        excitation: what the movement excites.
        covariance: of log-weights (n, n).
        limit: largest standard error of a log-ratio that is reported.
        clusters_needed: clusters without which no standard error is trusted.
        n_clusters: clusters there are.
        how: how the covariance was made.
        tentative: whether weights are reported, without standard errors, where the fit did not
            converge: Algorithm 1 creeps, and the paper stops it at a threshold of its own.
    """

    structure: Structure
    excitation: Excitation
    covariance: np.ndarray
    limit: float
    clusters_needed: int
    n_clusters: int
    how: str
    tentative: bool = False


def reach_verdict(problem: Problem, fit: Fit, evidence: Evidence) -> Verdict:
    """Decide which ratios are reported."""
    structure = evidence.structure
    errors = contrast_errors(evidence.excitation, evidence.covariance)
    if evidence.n_clusters < evidence.clusters_needed:
        errors = np.where(np.eye(len(errors), dtype=bool), 0.0, np.inf)
    if not (fit.status.ok or evidence.tentative):  # away from a minimum a sandwich says nothing
        errors = np.where(np.eye(len(errors), dtype=bool), 0.0, np.inf)
    out = fit.at_bound | ~problem.moving
    errors[out] = errors[:, out] = np.inf
    groups = group_by_precision(structure.groups, errors, evidence.limit)
    reported = {i for group in groups for i in group}
    reasons = {
        i: _reason(i, problem, fit, evidence, errors)
        for i in range(len(errors))
        if i not in reported
    }
    return Verdict(groups, reasons, errors)


def _reason(i: int, problem: Problem, fit: Fit, evidence: Evidence, errors: np.ndarray) -> str:
    names, structure = problem.samples.joints, evidence.structure
    if not problem.moving[i]:
        return "never moves: its weight is beyond measure"
    others = [j for group in structure.groups if i in group for j in group if j != i]
    if i in structure.over_specified:
        still = "" if problem.in_chain.all() else " among those that move"
        return (
            f"over-specified: no other joint{still} can stand in for it; its weight has no effect"
        )
    if i in structure.idle:
        return "moves without moving the hand: it shares the null space with no other joint"
    if not (fit.status.ok or evidence.tentative):
        return fit.status.sentence
    if evidence.n_clusters < evidence.clusters_needed:
        return (
            f"too few samples for a standard error: {evidence.n_clusters} clusters, "
            f"at least {evidence.clusters_needed} are needed"
        )
    if fit.at_bound[i]:
        return "its weight ran to zero: the bound of the range was reached"
    estimable = [j for j in others if evidence.excitation.estimable(i, j)]
    if not estimable:
        return "not excited by this movement: the recorded motion cannot tell it from the others"
    best = min(estimable, key=lambda j: errors[i, j])
    if not np.isfinite(errors[i, best]):
        return "its ratio to every other joint rests on a weight at the bound, or on one trial"
    return (
        f"standard error too large: {errors[i, best]:.2g} for its log-ratio to {names[best]} "
        f"(at most {evidence.limit:g} is reported)"
    )
