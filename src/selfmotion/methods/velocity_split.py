"""Split joint velocities into the part that moves the hand and the part that does not.

[Khoramshahi2022], doi 10.1371/journal.pone.0278228, eqs 2-12 and Fig 7: q̇ = J#Jq̇ + Nq̇ with
identified weights, or with W = I as a baseline. The two parts are orthogonal in the metric of W,
not in the plain one, so two shares are given:

- `task_share` = Σ‖task‖²/(Σ‖task‖² + Σ‖null‖²), in plain joint velocities. It does not depend on
  the free scale of a group of weights, so it can be compared between people and against W = I.
- `task_share_weighted` = Σ‖task‖²_W/Σ‖q̇‖²_W, a true partition, for one W.

`null_share` is what is left of the first to 1. `unexplained` = Σ‖null‖²/Σ‖q̇‖², what the
maximum-likelihood weights make smallest, may exceed 1 - task_share, since the parts may oppose.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import JointSamples, JointVector, require_shape
from selfmotion.errors import RangeError, ShapeError
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.motion.filters import normalise_time
from selfmotion.motion.recording import Recording, Study
from selfmotion.redundancy.projection import split_velocity

if TYPE_CHECKING:
    import pandas as pd

CHUNK = 20_000
"""Samples split at a time: projectors of one chunk are all that is held."""


@dataclass(frozen=True, eq=False)
class VelocitySplit:
    """One recording's velocities, split.

    Attributes:
        name: of the recording.
        joints: joint names (n).
        time: instants (K), s.
        task: J#Jq̇ (K, n), rad/s; NaN in gaps.
        null: Nq̇ (K, n), rad/s.
        weights: W's diagonal (n); ones for W = I.
        task_share: Σ‖task‖²/(Σ‖task‖² + Σ‖null‖²); NaN without motion.
        task_share_weighted: the same in the metric of W, in which the parts are orthogonal.
        unexplained: Σ‖null‖²/Σ‖q̇‖².
        null_rms: rms null-space velocity of each joint (n), rad/s.
    """

    name: str
    joints: tuple[str, ...]
    time: Float[np.ndarray, " samples"]
    task: JointSamples
    null: JointSamples
    weights: JointVector
    task_share: float
    task_share_weighted: float
    unexplained: float
    null_rms: JointVector

    @property
    def null_share(self) -> float:
        """1 - task_share."""
        return 1.0 - self.task_share

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a sample: time, NAME_task and NAME_null of each joint (rad/s)."""
        import pandas as pd

        columns: dict[str, np.ndarray] = {"time": self.time}
        for i, joint in enumerate(self.joints):
            columns |= {f"{joint}_task": self.task[:, i], f"{joint}_null": self.null[:, i]}
        return pd.DataFrame(columns)


def split(
    recording: Recording, *, weights: WeightEstimate | Sequence[float] | np.ndarray | None = None
) -> VelocitySplit:
    """Split the joint velocities of a recording into task and null-space part.

    Args:
        recording: with `qd` (K, n) and `jacobian` (K, m, n).
        weights: an estimate (its `full_weights` are taken), numbers (n), or None for W = I.

    Raises:
        ShapeError: `qd` or `jacobian` is missing, or the weights do not fit the joints.
        RangeError: a weight is not a positive number.

    Example:
        >>> qd, J = np.array([[0, 1.0]] * 2), np.ones((2, 1, 2))
        >>> one = Recording(np.arange(2.0), qd=qd, jacobian=J)
        >>> split(one, weights=[1, 1 / 9]).task[0].round(6).tolist()       # eq. 14
        [0.1, 0.9]
        >>> split(one).null[0].round(6).tolist()                          # eq. 13
        [-0.5, 0.5]
    """
    qd, jacobian = recording.array("qd"), recording.array("jacobian")
    W = weight_vector(weights, recording.joints)
    task, null = np.full_like(qd, np.nan), np.full_like(qd, np.nan)
    for at in range(0, len(qd), CHUNK):
        some = slice(at, at + CHUNK)
        whole = ~(np.isnan(qd[some]).any(axis=1) | np.isnan(jacobian[some]).any(axis=(1, 2)))
        if whole.any():
            parts = split_velocity(jacobian[some][whole], qd[some][whole], W)
            task[some][whole], null[some][whole] = parts
    kept = ~np.isnan(task).any(axis=1)
    t, v = task[kept], null[kept]
    size, rest = float((t**2).sum()), float((v**2).sum())
    return VelocitySplit(
        name=recording.name,
        joints=recording.joints,
        time=recording.time,
        task=task,
        null=null,
        weights=W,
        task_share=_ratio(size, size + rest),
        task_share_weighted=_ratio(float((W * t**2).sum()), float((W * (t + v) ** 2).sum())),
        unexplained=_ratio(rest, float(((t + v) ** 2).sum())),
        null_rms=np.sqrt((v**2).mean(axis=0)) if len(v) else np.full(qd.shape[1], np.nan),
    )


def weight_vector(
    weights: WeightEstimate | Sequence[float] | np.ndarray | None, joints: tuple[str, ...]
) -> np.ndarray:
    """Turn an estimate, numbers or None into the diagonal of W (n).

    Raises:
        ShapeError: the number of weights or the joints' names differ.
        RangeError: a weight is not a positive number.
    """
    if weights is None:
        return np.ones(len(joints))
    if isinstance(weights, WeightEstimate):
        if weights.joints != joints:
            raise ShapeError(
                f"weights are of {', '.join(weights.joints)}; the recording has {', '.join(joints)}"
            )
        return weights.full_weights
    W = np.asarray(weights, dtype=np.float64)
    require_shape("weights", W, (len(joints),))
    bad = ~(np.isfinite(W) & (W > 0.0))
    if bad.any():
        i = int(np.argmax(bad))
        raise RangeError(f"weights: {joints[i]} has {W[i]:g}; allowed are positive numbers")
    return W


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else float("nan")


@dataclass(frozen=True, eq=False)
class VelocityBands:
    """Mean and spread over trials of total, task and null-space velocity, as Fig 7 shows them.

    Attributes:
        joints: joint names (n).
        phase: fractions of the movement's duration (T), 0 to 1.
        mean: keys ``total``, ``task``, ``null``: mean velocity (T, n), rad/s.
        spread: the same keys: standard deviation over trials (T, n); NaN for one trial.
        n_trials: recordings that went in.
    """

    joints: tuple[str, ...]
    phase: Float[np.ndarray, " phases"]
    mean: dict[str, Float[np.ndarray, "phases joints"]]
    spread: dict[str, Float[np.ndarray, "phases joints"]]
    n_trials: int


def velocity_bands(
    recordings: Recording | Study | Iterable[Recording],
    *,
    weights: WeightEstimate | Sequence[float] | np.ndarray | None = None,
    n_points: int = 101,
) -> VelocityBands:
    """Average split velocities over trials on a common, normalised time.

    Velocities are split at the recorded samples first and interpolated then.

    Raises:
        ShapeError: recordings differ in their joints, or there are none.

    Example:
        >>> t, J = np.arange(5.0), np.ones((5, 1, 2))
        >>> trials = [Recording(t, qd=np.full((5, 2), s), jacobian=J) for s in (1.0, 3.0)]
        >>> bands = velocity_bands(trials, n_points=3)
        >>> bands.mean["task"][0].round(9).tolist(), bands.spread["null"][0].round(9).tolist()
        ([2.0, 2.0], [0.0, 0.0])
    """
    given = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    trials = Study(tuple(trial for trial in given if trial.n_samples > 1))  # one has no course
    profiles: dict[str, list[np.ndarray]] = {"total": [], "task": [], "null": []}
    joints = trials.joints
    for trial in trials:
        parts = split(trial, weights=weights)
        both = np.concatenate([parts.task, parts.null], axis=1)
        carrier = Recording(trial.time, q=both, timed=trial.timed, source=trial.source)
        task, null = np.split(normalise_time(carrier, n_points).array("q"), 2, axis=1)
        for key, profile in (("total", task + null), ("task", task), ("null", null)):
            profiles[key].append(profile)
    stacks = {key: np.stack(profile) for key, profile in profiles.items()}
    one = len(trials) == 1
    return VelocityBands(
        joints=joints,
        phase=np.linspace(0.0, 1.0, n_points),
        mean={key: stack.mean(axis=0) for key, stack in stacks.items()},
        spread={
            key: np.full(stack.shape[1:], np.nan) if one else stack.std(axis=0, ddof=1)
            for key, stack in stacks.items()
        },
        n_trials=len(trials),
    )
