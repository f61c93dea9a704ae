"""What the studies return: tables and arrays for figures and reports. Nothing here draws."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.methods.velocity_split import VelocityBands


@dataclass(frozen=True, eq=False)
class Convergence:
    """Weights from iteration to iteration, over repeats.

    Attributes:
        label: what was varied, as in ``γ = 0.6``.
        weights: (repeats, iterations, n); the first iteration is the start, and a run that has
            stopped keeps its last value.
        truth: (n,) weights that generated the data.
    """

    label: str
    weights: Float[np.ndarray, "repeats iterations joints"]
    truth: Float[np.ndarray, " joints"]

    @property
    def error(self) -> Float[np.ndarray, "repeats iterations"]:
        """Norm of the difference to the truth."""
        return np.linalg.norm(self.weights - self.truth, axis=2)

    @property
    def final_error(self) -> float:
        """Mean over repeats of the last error."""
        return float(self.error[:, -1].mean())

    def iterations_to(self, distance: float) -> Float[np.ndarray, " repeats"]:
        """Count iterations until the weights stay within a distance of their last value."""
        away = np.linalg.norm(self.weights - self.weights[:, -1:], axis=2) > distance
        last = away.shape[1] - np.argmax(away[:, ::-1], axis=1)
        return np.where(away.any(axis=1), last, 0).astype(float)


@dataclass(frozen=True, eq=False)
class Sweep:
    """One convergence for each null-space projection ratio γ.

    Attributes:
        gammas: the ratios; NaN stands for a schedule.
        runs: their convergences.
    """

    gammas: tuple[float, ...]
    runs: tuple[Convergence, ...]

    def run(self, gamma: float) -> Convergence:
        """Give the convergence at a ratio."""
        return self.runs[self.gammas.index(gamma)]


@dataclass(frozen=True, eq=False)
class NoiseSweep:
    """Error of the estimators against null-space noise.

    Attributes:
        table: columns sigma, noise (``projected`` or ``not projected``), method, error, sd.
    """

    table: pd.DataFrame


@dataclass(frozen=True, eq=False)
class SplitBands:
    """Task and null-space velocity of the same movements with two kinds of weights.

    Attributes:
        identity: split with W = I.
        identified: split with given weights; None where there are none.
    """

    identity: VelocityBands
    identified: VelocityBands | None


@dataclass(frozen=True, eq=False)
class NullSpeeds:
    """Null-space velocities of an experiment, with identified weights and with W = I.

    Attributes:
        panels: (condition, ``identified`` or ``identity``) to bands over people.
        table: columns subject, condition, weights (``identified`` or ``identity``), rms
            (root mean square of the null-space velocity, rad/s), share (of the squared speed).
    """

    panels: dict[tuple[str, str], VelocityBands]
    table: pd.DataFrame


@dataclass(frozen=True, eq=False)
class Recovery:
    """Identified weights of generated people against the weights that they have.

    Attributes:
        table: columns method, condition, ratio (``joint / joint``), bias (mean error of the
            log-ratio), rmse, stderr (mean standard error), coverage (share of people whose 95 %
            interval holds the truth), people.
    """

    table: pd.DataFrame
