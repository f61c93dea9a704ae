"""What identification returns: weights, what they rest on, and what the data cannot tell."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import JointVector, require_between
from selfmotion.errors import Status
from selfmotion.methods.weights.uncertainty import interval_factor
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

STILL_WEIGHT = 1e6
"""Stands for ∞ in `full_weights`: a joint that never moved, beside the largest weight 1."""


@dataclass(frozen=True, eq=False)
class WeightEstimate:
    """IK weights identified from recorded motion [Khoramshahi2022].

    Only ratios within a scale group mean anything. Weights have maximum 1 in each group; a joint
    that is in no group has NaN and a reason.

    Attributes:
        joints: joint names (n).
        weights: w (n): relative cost of each joint; NaN where not identified.
        contribution: β = w⁻¹/Σw⁻¹ within each group (n), sum 1 a group; NaN likewise.
        contribution_eq26: β over all joints (eq. 26), which sums to 1, with over-specified joints
            counted as 1 (the paper's elbow); compare with the paper, not between people. NaN if a
            joint whose weight matters is not identified (for ``paper``: of the weights as found).
        full_weights: a number for every joint (n), for use in a projector: the point estimate,
            identified or not, maximum 1 in each structural group; 1 for over-specified joints;
            `STILL_WEIGHT` for joints that never moved (ml, feedback).
        groups: the groups within which ratios are reported (joint names).
        structural_groups: scale groups that the null space allows, before the data are asked.
        unidentifiable: joint to the reason why it has no weight.
        stderr_log: standard error of log(w / largest w of its group) (n); 0 for the largest.
        stderr_kind: how the standard errors were made.
        log_covariance: covariance of log w (n, n), exact for contrasts within a group; NaN outside.
        method: ``ml``, ``paper`` or ``feedback``.
        iterations: number of updates.
        history: weights of each iteration, the start first (iterations + 1, n).
        error_history: rms of what the weights leave unexplained, rad/s (ml, feedback), or the mean
            ‖e‖ of Algorithm 1's line 12 (paper), of each row of `history`.
        unexplained: Σ‖r‖²/Σ‖q̇‖², r what these weights (and the feedback) leave to the null space.
        unexplained_identity: the same with W = I and no feedback: what the weights improve on.
        feedback_terms: the terms of Φ (feedback only): ``posture`` (1/s), ``constant`` (rad/s).
        feedback_gains: b (terms, n); only what N b φ shows in the null space is determined.
        n_samples: samples used.
        n_trials: trials.
        n_clusters: clusters behind the standard errors.
        n_dropped: samples left out because they hold NaN.
        n_rank_deficient: samples left out because rows of J depend on each other.
        status: whether it converged and found at least one group.
        provenance: where it comes from.
    """

    joints: tuple[str, ...]
    weights: JointVector
    contribution: JointVector
    contribution_eq26: JointVector
    full_weights: JointVector
    groups: tuple[tuple[str, ...], ...]
    structural_groups: tuple[tuple[str, ...], ...]
    unidentifiable: Mapping[str, str]
    stderr_log: JointVector
    stderr_kind: str
    log_covariance: Float[np.ndarray, "joints joints"]
    method: str
    iterations: int
    history: Float[np.ndarray, "iterates joints"]
    error_history: Float[np.ndarray, " iterates"]
    unexplained: float
    unexplained_identity: float
    feedback_terms: tuple[str, ...]
    feedback_gains: Float[np.ndarray, "terms joints"]
    n_samples: int
    n_trials: int
    n_clusters: int
    n_dropped: int
    n_rank_deficient: int
    status: Status
    provenance: Provenance

    def interval(self, level: float = 0.95) -> Float[np.ndarray, "joints 2"]:
        """Give confidence intervals of w relative to the largest of its group.

        Normal in log w, t with clusters - 1 degrees of freedom. The largest is its own reference
        and has [1, 1].
        """
        require_between("level", level, 0.0, 1.0)
        if self.n_clusters < 2:
            return np.full((len(self.joints), 2), np.nan)
        half = interval_factor(level, self.n_clusters) * self.stderr_log
        return self.weights[:, None] * np.exp(np.stack([-half, half], axis=1))

    def log_ratio(self, joint: str, reference: str) -> tuple[float, float]:
        """Give log(w_joint / w_reference) and its standard error; NaN outside one group."""
        i, j = self.joints.index(joint), self.joints.index(reference)
        if not any(joint in group and reference in group for group in self.groups):
            return float("nan"), float("nan")
        V = self.log_covariance
        variance = max(float(V[i, i] + V[j, j] - 2.0 * V[i, j]), 0.0)
        return float(np.log(self.weights[i] / self.weights[j])), float(np.sqrt(variance))

    def to_frame(self, level: float = 0.95) -> "pd.DataFrame":
        """Give a table, one row a joint: weight, interval, contribution, group, reason."""
        import pandas as pd

        interval = self.interval(level)
        number = {joint: k + 1 for k, group in enumerate(self.groups) for joint in group}
        return pd.DataFrame(
            {
                "joint": self.joints,
                "weight": self.weights,
                "lower": interval[:, 0],
                "upper": interval[:, 1],
                "stderr_log": self.stderr_log,
                "contribution": self.contribution,
                "contribution_eq26": self.contribution_eq26,
                "group": [number.get(joint) for joint in self.joints],
                "reason": [self.unidentifiable.get(joint, "") for joint in self.joints],
            }
        )


def contributions(weights: np.ndarray) -> np.ndarray:
    """Turn weights into contribution coefficients β = w⁻¹/Σw⁻¹ ([Khoramshahi2022] eq. 26).

    Example:
        >>> contributions(np.array([1.0, 1 / 9])).round(3).tolist()
        [0.1, 0.9]
    """
    share = 1.0 / weights
    return share / share.sum()


def nothing_identified(
    joints: tuple[str, ...], method: str, sentence: str, provenance: Provenance
) -> WeightEstimate:
    """Build the estimate of an item that failed: NaN everywhere, and why."""
    n = len(joints)
    nan = np.full(n, np.nan)
    return WeightEstimate(
        joints=joints,
        weights=nan,
        contribution=nan,
        contribution_eq26=nan,
        full_weights=nan,
        groups=(),
        structural_groups=(),
        unidentifiable=dict.fromkeys(joints, sentence),
        stderr_log=nan,
        stderr_kind="none",
        log_covariance=np.full((n, n), np.nan),
        method=method,
        iterations=0,
        history=np.empty((0, n)),
        error_history=np.empty(0),
        unexplained=float("nan"),
        unexplained_identity=float("nan"),
        feedback_terms=(),
        feedback_gains=np.empty((0, n)),
        n_samples=0,
        n_trials=0,
        n_clusters=0,
        n_dropped=0,
        n_rank_deficient=0,
        status=Status(False, sentence),
        provenance=provenance,
    )
