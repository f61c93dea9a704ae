"""The usual measures of inter-joint coordination, which do not ask what the joints work for.

[Khoramshahi2022] sections 1 and 2.2 argue against them: correlation of joint velocities, principal
components, continuous relative phase. They stand here as comparators, to be shown beside weights.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import JointVector
from selfmotion.errors import RangeError
from selfmotion.motion.filters import normalise_time
from selfmotion.motion.recording import Recording, Study

if TYPE_CHECKING:
    import pandas as pd

Recordings = Recording | Study | Iterable[Recording]


def _trials(recordings: Recordings) -> Study:
    return Study((recordings,) if isinstance(recordings, Recording) else tuple(recordings))


def _moments(trials: Sequence[Recording]) -> tuple[np.ndarray, np.ndarray, int]:
    """Sum velocities over whole samples: mean (n), covariance (n, n), count."""
    count, total, square = 0, np.zeros(0), np.zeros((0, 0))
    for trial in trials:
        qd = trial.array("qd")
        qd = qd[~np.isnan(qd).any(axis=1)]
        count += len(qd)
        total = total + qd.sum(axis=0) if total.size else qd.sum(axis=0)
        square = square + qd.T @ qd if square.size else qd.T @ qd
    if count < 2:
        raise RangeError(f"coordination: {count} whole sample(s) of qd; at least 2 are needed")
    mean = total / count
    return mean, (square - count * np.outer(mean, mean)) / (count - 1), count


def velocity_correlation(recordings: Recordings) -> Float[np.ndarray, "joints joints"]:
    """Correlate joint velocities over all samples (n, n); NaN for a joint that never moves.

    Example:
        >>> qd = np.array([[0.0, 1.0], [1.0, -1.0], [2.0, -3.0]])
        >>> velocity_correlation(Recording(np.arange(3.0), q=qd, qd=qd)).round(6).tolist()
        [[1.0, -1.0], [-1.0, 1.0]]
    """
    _, covariance, _ = _moments(_trials(recordings).recordings)
    deviation = np.sqrt(np.diag(covariance))
    deviation[deviation <= 1e-12 * deviation.max(initial=0.0)] = np.nan
    return np.clip(covariance / np.outer(deviation, deviation), -1.0, 1.0)


@dataclass(frozen=True, eq=False)
class PrincipalComponents:
    """Principal components of joint velocities, largest first.

    Attributes:
        joints: joint names (n).
        share: share of the variance of each component (n), sum 1.
        loadings: unit vectors, one a row (n, n); the largest entry of each is positive.
        mean: mean velocity (n), rad/s.
    """

    joints: tuple[str, ...]
    share: JointVector
    loadings: Float[np.ndarray, "joints joints"]
    mean: JointVector

    def needed(self, share: float = 0.95) -> int:
        """Count the components that together hold this share of the variance."""
        return int(np.searchsorted(np.cumsum(self.share), share - 1e-12)) + 1

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a component."""
        import pandas as pd

        frame = pd.DataFrame(self.loadings, columns=list(self.joints))
        frame.insert(0, "share", self.share)
        return frame


def principal_components(recordings: Recordings) -> PrincipalComponents:
    """Find the principal components of joint velocities, pooled over samples and centred.

    Raises:
        RangeError: nothing moves, or fewer than two samples.

    Example:
        >>> qd = np.array([[0.0, 0.0], [3.0, 4.0], [6.0, 8.0]])
        >>> found = principal_components(Recording(np.arange(3.0), q=qd, qd=qd))
        >>> found.share.round(6).tolist(), found.loadings[0].round(6).tolist()
        ([1.0, 0.0], [0.6, 0.8])
    """
    trials = _trials(recordings)
    mean, covariance, _ = _moments(trials.recordings)
    values, vectors = np.linalg.eigh(covariance)
    values, loadings = np.maximum(values[::-1], 0.0), vectors.T[::-1]
    if values.sum() == 0.0:
        raise RangeError("coordination: joint velocities do not vary; motion is needed")
    largest = np.abs(loadings).argmax(axis=1)
    signs = np.sign(loadings[np.arange(len(loadings)), largest])
    return PrincipalComponents(
        trials.joints, values / values.sum(), loadings * signs[:, None], mean
    )


@dataclass(frozen=True, eq=False)
class RelativePhase:
    """Continuous relative phase of each pair of joints, over trials on normalised time.

    Attributes:
        joints: joint names (n).
        phase: fractions of the movement (T).
        curve: mean relative phase of joint i to joint j (T, n, n), rad, -π to π (circular mean).
        mean_absolute: mean absolute relative phase (n, n), rad: 0 in phase, π in antiphase.
        variability: deviation phase (n, n), rad: circular standard deviation over trials, averaged
            over the movement; NaN for one trial.
    """

    joints: tuple[str, ...]
    phase: Float[np.ndarray, " phases"]
    curve: Float[np.ndarray, "phases joints joints"]
    mean_absolute: Float[np.ndarray, "joints joints"]
    variability: Float[np.ndarray, "joints joints"]


def relative_phase(recordings: Recordings, *, n_points: int = 101) -> RelativePhase:
    """Compute continuous relative phase from joint angles, with the Hilbert transform.

    Each angle is centred on the middle of its range and its phase is that of the analytic signal
    (Lamb & Stöckl 2014, doi 10.1016/j.clinbiomech.2014.03.008), which suits signals that are not
    sinusoidal; the signal is mirrored at its ends first, since reaching is not periodic.

    Args:
        recordings: with `q`, and no gaps.
        n_points: phases.

    Raises:
        RangeError: a recording has gaps.
        ShapeError: a recording has no `q`.

    Example:
        >>> t = np.linspace(0, 1, 50)
        >>> q = np.stack([np.cos(np.pi * t), -np.cos(np.pi * t)], axis=1)
        >>> round(float(relative_phase(Recording(t, q=q)).mean_absolute[0, 1] / np.pi), 6)
        1.0
    """
    trials = _trials(recordings)
    angles = []
    for trial in trials:
        q = normalise_time(trial, n_points).array("q")
        if np.isnan(q).any():
            raise RangeError(f"{trial.name}: q has gaps; relative phase needs whole recordings")
        angles.append(_signal_phase(q))
    stack = np.stack(angles)
    turning = np.exp(1j * (stack[:, :, :, None] - stack[:, :, None, :]))
    mean = turning.mean(axis=0)
    length = np.clip(np.abs(mean), 1e-300, 1.0)
    one = len(angles) == 1
    spread = np.sqrt(np.maximum(-2.0 * np.log(length), 0.0)).mean(axis=0)
    return RelativePhase(
        joints=trials.joints,
        phase=np.linspace(0.0, 1.0, n_points),
        curve=np.angle(mean),
        mean_absolute=np.abs(np.angle(turning)).mean(axis=(0, 1)),
        variability=np.full_like(spread, np.nan) if one else spread,
    )


def _signal_phase(q: np.ndarray) -> np.ndarray:
    from scipy.signal import hilbert  # slow to import, and not always needed

    centred = q - 0.5 * (q.max(axis=0) + q.min(axis=0))
    mirrored = np.concatenate([centred[::-1], centred, centred[::-1]])
    return np.angle(np.asarray(hilbert(mirrored, axis=0)))[len(q) : 2 * len(q)]
