"""From many estimates to tables: weights of each person, and how true they are."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.methods.identification import (
    DEFAULT_OPTIONS,
    Method,
    MotionArrays,
    identify_weights_from_arrays,
)
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.uncertainty import interval_factor
from selfmotion.motion.recording import Study
from selfmotion.studies.results import Recovery

Key = tuple[str, str]  # subject, condition

COVERAGE_LEVEL = 0.95
# Algorithm 1 at γ = 0.9 creeps: on movements it has not settled after 5000 iterations. The paper
# stops at a threshold that it does not give. Generated people: stopped early, to save time;
# recorded people: the estimator's own limit.
SHORT_RUN, LONG_RUN = 200, 5000


def identify_each(
    study: Study,
    *,
    method: Method = "ml",
    null_ratio: float = 0.9,
    paper_iterations: int = LONG_RUN,
) -> dict[Key, WeightEstimate]:
    """Identify weights for each person in each condition, all targets and trials pooled.

    Args:
        study: recordings labelled by subject and condition.
        method: the estimator.
        null_ratio: γ of Algorithm 1.
        paper_iterations: where Algorithm 1 is stopped at the latest.
    """
    limit = paper_iterations if method == "paper" else None
    options = replace(DEFAULT_OPTIONS, hash_inputs=False, max_iterations=limit)
    return {
        (str(subject), str(condition)): identify_weights_from_arrays(
            _side_by_side(part), method=method, null_ratio=null_ratio, options=options
        )
        for (subject, condition), part in study.group("subject", "condition").items()
    }


def _side_by_side(study: Study) -> MotionArrays:
    """Put the trials of a person into one array each: many short trials run faster so."""
    postures = [r.q for r in study if r.q is not None]
    return MotionArrays(
        qd=np.concatenate([r.array("qd") for r in study]),
        jacobian=np.concatenate([r.array("jacobian") for r in study]),
        trial=np.repeat(np.arange(len(study)), [r.n_samples for r in study]),
        q=np.concatenate(postures) if len(postures) == len(study) else None,
        joints=study.joints,
        name=study[0].name,
    )


def weight_table(estimates: Mapping[Key, WeightEstimate]) -> pd.DataFrame:
    """Make one table of many estimates: one row for each person, condition and joint.

    Returns:
        Columns subject, condition, method, joint, weight (NaN where not identified),
        full_weight, stderr_log, contribution (eq. 26), identified, reason.
    """
    rows = []
    for (subject, condition), estimate in estimates.items():
        for i, joint in enumerate(estimate.joints):
            rows.append(
                {
                    "subject": subject,
                    "condition": condition,
                    "method": estimate.method,
                    "joint": joint,
                    "weight": float(estimate.weights[i]),
                    "full_weight": float(estimate.full_weights[i]),
                    "stderr_log": float(estimate.stderr_log[i]),
                    "contribution": float(estimate.contribution_eq26[i]),
                    "identified": bool(np.isfinite(estimate.weights[i])),
                    "reason": estimate.unidentifiable.get(joint, ""),
                }
            )
    return pd.DataFrame(rows)


def mean_contribution(
    table: pd.DataFrame, joints: Sequence[str]
) -> dict[str, Float[np.ndarray, " joints"]]:
    """Give the mean over people of β in each condition, in joint order; NaN is left out."""
    means = {}
    for condition in dict.fromkeys(table["condition"]):
        rows = table[table["condition"] == condition]
        of_joint = [rows.loc[rows["joint"] == joint, "contribution"] for joint in joints]
        means[str(condition)] = np.array([float(one.mean()) for one in of_joint])
    return means


def recovery(
    estimates: Sequence[Mapping[Key, WeightEstimate]],
    truth: Mapping[Key, Float[np.ndarray, " joints"]],
    ratios: Sequence[tuple[int, int]],
) -> Recovery:
    """Hold identified log-ratios against the true ones of generated people.

    Args:
        estimates: one mapping for each estimator.
        truth: (subject, condition) to true weights; other keys of the estimates are passed over.
        ratios: pairs of joints (indices) whose log-ratio is compared.
    """
    rows = []
    for one in estimates:
        conditions = dict.fromkeys(condition for _, condition in one)
        for condition in conditions:
            for i, j in ratios:
                keys = [key for key in one if key[1] == condition and key in truth]
                if keys:
                    rows.append(_recovered(one, truth, keys, (i, j)))
    return Recovery(pd.DataFrame(rows))


def _recovered(
    estimates: Mapping[Key, WeightEstimate],
    truth: Mapping[Key, np.ndarray],
    keys: Sequence[Key],
    ratio: tuple[int, int],
) -> dict[str, object]:
    i, j = ratio
    errors, stderrs, covered = [], [], []
    first = estimates[keys[0]]
    for key in keys:
        estimate = estimates[key]
        found, stderr = estimate.log_ratio(estimate.joints[i], estimate.joints[j])
        if not np.isfinite(found):
            continue
        error = found - float(np.log(truth[key][i] / truth[key][j]))
        errors.append(error)
        stderrs.append(stderr)
        covered.append(abs(error) <= _half_width(estimate, stderr))
    known = len(errors) > 0
    return {
        "method": first.method,
        "condition": keys[0][1],
        "ratio": f"{first.joints[i]} / {first.joints[j]}",
        "bias": float(np.mean(errors)) if known else float("nan"),
        "rmse": float(np.sqrt(np.mean(np.square(errors)))) if known else float("nan"),
        "stderr": float(np.mean(stderrs)) if known else float("nan"),
        "coverage": float(np.mean(covered)) if known else float("nan"),
        "people": len(errors),
        "of": len(keys),
    }


def _half_width(estimate: WeightEstimate, stderr: float) -> float:
    return interval_factor(COVERAGE_LEVEL, estimate.n_clusters) * stderr
