"""Ridge regression whose penalty is chosen by leaving out one person at a time.

Each person counts alike. Columns are scaled to unit spread; the mean is not penalised.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

# Penalties tried, beside a spread of one in each column and the mean over samples.
PENALTIES = (1e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0)


@dataclass(frozen=True, eq=False)
class Ridge:
    """A linear law of features.

    Attributes:
        centre: mean of each feature.
        scale: spread of each feature; infinite where it does not vary.
        slopes: per unit spread.
        mean: of what is predicted.
        penalty: the one chosen.
    """

    centre: Float[np.ndarray, " features"]
    scale: Float[np.ndarray, " features"]
    slopes: Float[np.ndarray, " features"]
    mean: float
    penalty: float

    def at(self, features: Float[np.ndarray, "samples features"]) -> Float[np.ndarray, " samples"]:
        """Evaluate the law."""
        return ((features - self.centre) / self.scale) @ self.slopes + self.mean


def fit_ridge(
    features: Float[np.ndarray, "samples features"],
    values: Float[np.ndarray, " samples"],
    people: Sequence[str],
) -> Ridge:
    """Fit a law; the penalty is that of the least mean absolute error on people left out.

    Args:
        features: (K, F).
        values: (K,) what is predicted.
        people: who each sample is of; with one person alone the greatest penalty is taken.
    """
    names = np.asarray(people)
    everyone = np.unique(names)
    if len(everyone) < 2:
        return _solve(features, values, names, PENALTIES[-1])
    error = np.zeros(len(PENALTIES))
    for person in everyone:
        out = names == person
        for i, penalty in enumerate(PENALTIES):
            law = _solve(features[~out], values[~out], names[~out], penalty)
            error[i] += float(np.abs(law.at(features[out]) - values[out]).mean())
    return _solve(features, values, names, PENALTIES[int(np.argmin(error))])


def _solve(X: np.ndarray, y: np.ndarray, names: np.ndarray, penalty: float) -> Ridge:
    _, index, count = np.unique(names, return_inverse=True, return_counts=True)
    w = 1.0 / count[index]
    w = w / w.sum()
    centre, mean = w @ X, float(w @ y)
    spread = np.sqrt(w @ (X - centre) ** 2)
    scale = np.where(spread > 1e-9, spread, np.inf)
    Z = (X - centre) / scale
    A = (Z * w[:, None]).T @ Z + penalty * np.eye(Z.shape[1])
    slopes = np.linalg.solve(A, (Z * w[:, None]).T @ (y - mean))
    return Ridge(centre, scale, slopes, mean, penalty)
