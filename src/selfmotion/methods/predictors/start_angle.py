"""The swivel angle with which the movement started."""

from collections.abc import Sequence
from dataclasses import dataclass

from selfmotion.methods.predictors.observation import Observation, Prediction


@dataclass(frozen=True)
class StartAngle:
    """The angle that the person had at the start, kept."""

    name: str = "angle at the start"

    def fit(self, training: Sequence[Observation]) -> "StartAngle":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Keep the angle."""
        return Prediction(observation.start)
