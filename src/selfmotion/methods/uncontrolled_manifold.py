"""Uncontrolled-manifold analysis: is variance over trials kept where it does no harm?

At each phase of the movement the deviations of the trials from their mean posture are split by the
mean Jacobian into a part along its null space (the uncontrolled manifold: the hand stays) and a
part across it (Scholz & Schöner 1999, doi 10.1007/s002210050738). Per degree of freedom,

    V_UCM = Σ_trials ‖along‖²/((n - m) R),   V_ORT = Σ_trials ‖across‖²/(m R),
    ΔV = (V_UCM - V_ORT)/V_TOT,   V_TOT = ((n - m) V_UCM + m V_ORT)/n,

ΔV > 0 is called a synergy that stabilises the hand. ΔV is bounded by -n/m and n/(n - m); its
z-transform ½ ln((n/m + ΔV)/(n/(n - m) - ΔV)) is what goes into tests.

A joint that never moves the task variable (its column of the Jacobian is zero in all trials, as
the wrist's joints where the wrist is the task) is left out: its variance would always count as
kept, whatever the person does.

Stands beside the weights because the paper does: UCM measures how variance is shared out and
takes the plain metric for granted, weights measure who does the work ([Khoramshahi2022] 2.2).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from selfmotion.errors import RangeError, ShapeError
from selfmotion.motion.filters import normalise_time
from selfmotion.motion.recording import Recording, Study

if TYPE_CHECKING:
    import pandas as pd

RANK_TOLERANCE = 1e-9
"""Singular value of the mean Jacobian, relative to the largest, that counts as zero."""


@dataclass(frozen=True, eq=False)
class ManifoldVariance:
    """Variance along and across the uncontrolled manifold.

    Attributes:
        variable: ``q`` (posture, rad) or ``qd`` (velocity, rad/s): of what the variance is.
        phase: fractions of the movement (T).
        along: V_UCM per degree of freedom (T), rad² or (rad/s)².
        across: V_ORT per degree of freedom (T).
        synergy: ΔV (T); NaN where there is no variance.
        synergy_z: z-transform of ΔV (T).
        dof: degrees of freedom along and across at each phase (T, 2).
        n_trials: R.
        joints: those that can move the task variable, n of them.
    """

    variable: Literal["q", "qd"]
    phase: Float[np.ndarray, " phases"]
    along: Float[np.ndarray, " phases"]
    across: Float[np.ndarray, " phases"]
    synergy: Float[np.ndarray, " phases"]
    synergy_z: Float[np.ndarray, " phases"]
    dof: Int[np.ndarray, "phases 2"]
    n_trials: int
    joints: tuple[str, ...] = ()

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a phase."""
        import pandas as pd

        return pd.DataFrame(
            {
                "phase": self.phase,
                "variance_along": self.along,
                "variance_across": self.across,
                "synergy": self.synergy,
                "synergy_z": self.synergy_z,
            }
        )


def manifold_variance(
    recordings: Study | Iterable[Recording], *, n_points: int = 101
) -> ManifoldVariance:
    """Part the variance over trials into that along and that across the manifold.

    Trials are brought to a common, normalised time. Postures are used where every recording has
    them, else velocities; the result says which. The manifold is linearised by the mean over
    trials of the Jacobians at the same phase.

    Args:
        recordings: trials of one person, one condition and one target (mixing targets turns the
            difference between targets into variance).
        n_points: phases.

    Raises:
        RangeError: fewer than two trials.
        ShapeError: a recording has no Jacobian, or joints differ, or none moves the task.

    Example:
        >>> t, J = np.arange(3.0), np.ones((3, 1, 2))     # hand = q1 + q2
        >>> trials = [Recording(t, q=np.tile([a, -a + b], (3, 1)), jacobian=J)
        ...           for a, b in ((1, 0.0), (-1, 0.0), (0, 0.1), (0, -0.1))]
        >>> variance = manifold_variance(trials, n_points=3)
        >>> bool(variance.synergy[0] > 1.9), variance.variable
        (True, 'q')
    """
    trials = Study(tuple(recordings))
    if len(trials) < 2:
        raise RangeError(f"manifold variance of {len(trials)} trial; at least 2 are needed")
    n = len(trials.joints)
    variable: Literal["q", "qd"] = "q" if all(r.q is not None for r in trials) else "qd"
    brought = [normalise_time(trial, n_points) for trial in trials]
    jacobian = np.mean([r.array("jacobian") for r in brought], axis=0)
    if jacobian.shape[2] != n:
        raise ShapeError(f"jacobian has {jacobian.shape[2]} joints, the recording {n}")
    used = _moving_joints(trials)
    if not used.any():
        raise ShapeError("jacobian: 0 everywhere; no joint moves the task")
    values = np.stack([r.array(variable)[:, used] for r in brought])
    joints = tuple(np.array(trials.joints)[used].tolist())
    return _variances(variable, values - values.mean(axis=0), jacobian[:, :, used], joints)


def _moving_joints(trials: Study) -> Bool[np.ndarray, " joints"]:
    """Tell which joints move the task in any sample of any trial."""
    sizes = [np.abs(np.nan_to_num(r.array("jacobian"))).max(axis=(0, 1)) for r in trials]
    largest = np.max(sizes, axis=0)
    return largest > RANK_TOLERANCE * largest.max()


def _variances(
    variable: Literal["q", "qd"],
    deviation: np.ndarray,
    jacobian: np.ndarray,
    joints: tuple[str, ...],
) -> ManifoldVariance:
    R, T, n = deviation.shape
    along, across = np.full(T, np.nan), np.full(T, np.nan)
    dof = np.zeros((T, 2), dtype=np.int64)
    for t in range(T):
        if np.isnan(jacobian[t]).any() or np.isnan(deviation[:, t]).any():
            continue  # a gap in some trial
        _, size, rows = np.linalg.svd(jacobian[t])
        rank = int(np.count_nonzero(size > RANK_TOLERANCE * size[0]))
        dof[t] = n - rank, rank
        parts = deviation[:, t] @ rows.T
        if rank < n:
            along[t] = (parts[:, rank:] ** 2).sum() / ((n - rank) * R)
        if rank > 0:
            across[t] = (parts[:, :rank] ** 2).sum() / (rank * R)
    total = (dof[:, 0] * along + dof[:, 1] * across) / n
    synergy = np.divide(along - across, total, out=np.full(T, np.nan), where=total > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):  # the ends of the range map to ±∞
        low, high = n / dof[:, 1], n / dof[:, 0]
        z = 0.5 * (np.log(low + synergy) - np.log(high - synergy))
    phase = np.linspace(0.0, 1.0, T)
    return ManifoldVariance(variable, phase, along, across, synergy, z, dof, R, joints)
