"""Identify IK weights from recorded motion: which joints does this person prefer?

[Khoramshahi2022], doi 10.1371/journal.pone.0278228. Model: q̇ = J#ẋ + v with the weighted
pseudo-inverse J# = W⁻¹Jᵀ(JW⁻¹Jᵀ)⁻¹, W diagonal (eqs 4, 15). Three estimators:

- ``ml`` (default): least null-space velocity; right when null-space motion does not depend on the
  task motion (`gauss_newton`).
- ``feedback``: the same with null-space motion that may be driven by posture.
- ``paper``: Algorithm 1 exactly (`algorithm_one`); biased as soon as there is null-space motion.

No estimator wins everywhere: if null-space motion correlates with ẋ, `ml` is inconsistent too.
Deviations from the paper: scale groups, over-specified joints and standard errors are found
automatically (`weights.identifiability`, `weights.uncertainty`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from selfmotion.errors import ShapeError
from selfmotion.methods.weights.algorithm_one import NullSchedule
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.options import (
    DEFAULT_OPTIONS,
    IdentificationOptions,
    Method,
)
from selfmotion.methods.weights.run import clusters_needed, identify_samples
from selfmotion.methods.weights.samples import (
    part_from_arrays,
    plan_chunks,
    samples_from_recordings,
)
from selfmotion.motion.recording import Recording, Study

__all__ = [
    "IdentificationOptions",
    "MotionArrays",
    "NullSchedule",
    "WeightEstimate",
    "identify_weights",
    "identify_weights_from_arrays",
]


def identify_weights(
    data: Recording | Study | Sequence[Recording],
    *,
    method: Method = "ml",
    null_ratio: float | Sequence[float] = 0.9,
    null_schedule: Literal["constant", "printed"] = "constant",
    options: IdentificationOptions = DEFAULT_OPTIONS,
) -> WeightEstimate:
    """Identify the IK weights of one person from their movements, pooled.

    Args:
        data: recordings with `qd` (rad/s) and `jacobian`, and `q` for ``feedback``; each recording
            is one trial, and trials are the unit of the standard errors. No array is copied.
        method: ``ml``, ``paper`` or ``feedback`` (see the module).
        null_ratio: γ of Algorithm 1, 0 to 1, one value or one an iteration (``paper`` only).
        null_schedule: ``constant``, or ``printed`` (γ ← γ + 0.6(1 - γ) from `null_ratio` on).
        options: see :class:`IdentificationOptions`.

    Returns:
        The estimate. What the data cannot tell is NaN with a reason; not converging is a status.

    Raises:
        SelfmotionError: the data cannot carry an estimate at all (one line that says why).

    Example:
        >>> rng = np.random.default_rng(1)
        >>> J, w = rng.standard_normal((200, 3, 5)), np.array([1, 0.8, 0.6, 0.4, 0.2])
        >>> Ji = J / w @ J.mT                     # J W⁻¹ Jᵀ
        >>> xd = rng.standard_normal((200, 3, 1))
        >>> qd = (J.mT / w[:, None] @ np.linalg.solve(Ji, xd))[..., 0]
        >>> one = Recording(np.arange(200) / 100, qd=qd, jacobian=J)
        >>> identify_weights(one).weights.round(6).tolist()
        [1.0, 0.8, 0.6, 0.4, 0.2]
    """
    recordings = (data,) if isinstance(data, Recording) else tuple(data)
    terms = options.feedback_terms if method == "feedback" else ()
    samples = samples_from_recordings(
        recordings,
        with_posture="posture" in terms,
        min_clusters=lambda n: clusters_needed(n, terms),
    )
    return identify_samples(samples, method, NullSchedule(null_ratio, null_schedule), options)


@dataclass(frozen=True, eq=False)
class MotionArrays:
    """Plain arrays in place of recordings.

    Attributes:
        qd: joint velocities (K, n), rad/s (m/s for prismatic joints).
        jacobian: task Jacobian (K, m, n).
        trial: label of the trial of each sample (K); None: one trial.
        q: posture (K, n), for ``feedback``.
        xd: task velocity (K, m), to check the Jacobian against.
        joints: joint names; None: ``joint_1`` ...
        name: what to call the data in a message.
    """

    qd: np.ndarray
    jacobian: np.ndarray
    trial: np.ndarray | None = None
    q: np.ndarray | None = None
    xd: np.ndarray | None = None
    joints: tuple[str, ...] | None = None
    name: str = "arrays"


def identify_weights_from_arrays(
    arrays: MotionArrays,
    *,
    method: Method = "ml",
    null_ratio: float | Sequence[float] = 0.9,
    null_schedule: Literal["constant", "printed"] = "constant",
    options: IdentificationOptions = DEFAULT_OPTIONS,
) -> WeightEstimate:
    """Identify IK weights from plain arrays; as :func:`identify_weights` in all else.

    Example:
        >>> qd, J = np.array([[0.1, 0.9]] * 40), np.ones((40, 1, 2))     # eq. 14
        >>> qd *= np.cos(np.arange(40.0))[:, None]
        >>> identify_weights_from_arrays(MotionArrays(qd, J)).contribution.round(6).tolist()
        [0.1, 0.9]
    """
    terms = options.feedback_terms if method == "feedback" else ()
    if "posture" in terms and arrays.q is None:
        raise ShapeError(f"{arrays.name}: q needed to identify weights with posture feedback")
    q = arrays.q if "posture" in terms else None
    part = part_from_arrays(
        arrays.name, arrays.qd, arrays.jacobian, q=q, xd=arrays.xd, trial=arrays.trial
    )
    n = part.qd.shape[1]
    joints = arrays.joints or tuple(f"joint_{i + 1}" for i in range(n))
    if len(joints) != n:
        raise ShapeError(f"{arrays.name}: {len(joints)} joint names for {n} joints")
    samples = plan_chunks(joints, (part,), min_clusters=clusters_needed(n, terms))
    return identify_samples(samples, method, NullSchedule(null_ratio, null_schedule), options)
