"""Regression of the swivel angle on the hand pose (after Zanchettin et al. 2013).

Zanchettin, Bascetta & Rocco 2013, doi 10.1109/MRA.2013.2283650, named in [Li2022] Table IV, give
the swivel angle as a nonlinear function of hand position and orientation, identified on people.
Their function and its numbers are not at hand; here it is a quadratic in the wrist's place (a
share of the arm's length) and linear in the hand's axes, fitted on other people by ridge
regression.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.methods.predictors.observation import (
    Observation,
    Prediction,
    angle_between,
    mean_angle,
)
from selfmotion.methods.predictors.ridge import Ridge, fit_ridge


@dataclass(frozen=True, eq=False)
class PoseRegression:
    """A law of the hand pose, fitted on other people.

    Attributes:
        name: name it goes by.
        origin: angle from which the law counts (rad), so that no turn is cut.
        law: None before it is fitted.
    """

    name: str = "regression on hand pose"
    origin: float = 0.0
    law: Ridge | None = None

    def fit(self, training: Sequence[Observation]) -> "PoseRegression":
        """Fit the law; people count alike."""
        origin = mean_angle([o.natural for o in training])
        values = angle_between(np.array([o.natural for o in training]), origin)
        law = fit_ridge(pose_features(training), values, [o.subject for o in training])
        return PoseRegression(self.name, origin, law)

    def swivel(self, observation: Observation) -> Prediction:
        """Evaluate the law."""
        assert self.law is not None, "fit comes first"
        return Prediction(self.origin + float(self.law.at(pose_features([observation]))[0]))


def pose_features(observations: Sequence[Observation]) -> Float[np.ndarray, "samples 15"]:
    """Give the wrist's place, its squares and products, and two axes of the hand."""
    p = np.stack([o.wrist for o in observations])
    i, j = np.triu_indices(3)
    axes = np.stack([o.hand[:, :2].T.ravel() for o in observations])
    return np.hstack([p, p[:, i] * p[:, j], axes])
