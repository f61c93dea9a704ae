"""A combination of criteria and hand pose, fitted on other people only."""

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
from selfmotion.methods.predictors.pose_regression import pose_features
from selfmotion.methods.predictors.ridge import Ridge, fit_ridge


@dataclass(frozen=True, eq=False)
class Combination:
    """Ridge regression on what the criteria say, the start, the hand pose and the kind of task.

    Attributes:
        name: name it goes by.
        criteria: the criteria that enter; one that failed counts as the mean angle.
        kinds: tasks and moments, each with its own constant.
        origin: angle from which everything counts (rad).
        law: None before it is fitted.
    """

    name: str = "combination"
    criteria: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    origin: float = 0.0
    law: Ridge | None = None

    def fit(self, training: Sequence[Observation]) -> "Combination":
        """Fit the law; people count alike."""
        kinds = tuple(sorted({o.kind for o in training}))
        origin = mean_angle([o.natural for o in training])
        bare = Combination(self.name, self.criteria, kinds, origin)
        values = angle_between(np.array([o.natural for o in training]), origin)
        law = fit_ridge(bare.features(training), values, [o.subject for o in training])
        return Combination(self.name, self.criteria, kinds, origin, law)

    def swivel(self, observation: Observation) -> Prediction:
        """Evaluate the law."""
        assert self.law is not None, "fit comes first"
        return Prediction(self.origin + float(self.law.at(self.features([observation]))[0]))

    def features(
        self, observations: Sequence[Observation]
    ) -> Float[np.ndarray, "samples features"]:
        """Give what the law is of."""
        said = [
            [o.criteria[name].angle for name in self.criteria] + [o.start] for o in observations
        ]
        angles = np.nan_to_num(angle_between(np.array(said), self.origin))
        kinds = [[float(o.kind == kind) for kind in self.kinds] for o in observations]
        return np.hstack([angles, np.array(kinds), pose_features(observations)])
