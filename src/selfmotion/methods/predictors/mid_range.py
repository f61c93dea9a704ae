"""The middle of the feasible interval of swivel angle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from selfmotion.methods.predictors.least_cost import NOTHING_FEASIBLE
from selfmotion.methods.predictors.observation import Observation, Prediction


@dataclass(frozen=True)
class MidRange:
    """The middle of the widest feasible interval: as far from the joint limits as can be."""

    name: str = "mid-range"

    def fit(self, training: Sequence[Observation]) -> "MidRange":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Take the middle between the ends of the widest interval."""
        scene = observation.the_scene()
        if not scene.stretches:
            return NOTHING_FEASIBLE
        widest = max(scene.stretches, key=lambda stretch: float(np.ptp(stretch.swivel)))
        return Prediction(float(0.5 * (widest.swivel.min() + widest.swivel.max())))
