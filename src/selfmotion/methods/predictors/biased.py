"""A criterion and the constant by which people differ from it, fitted on other people."""

from collections.abc import Sequence
from dataclasses import dataclass

from selfmotion.methods.predictors.observation import (
    Observation,
    Prediction,
    angle_between,
    mean_angle,
)


@dataclass(frozen=True)
class Biased:
    """What another predictor says, and the mean by which people differ from it.

    Attributes:
        name: name it goes by.
        of: the criterion that is corrected.
        by_kind: whether each task and moment has its own correction.
        bias: kind ("" for all together) to correction (rad).
    """

    name: str
    of: str
    by_kind: bool = False
    bias: tuple[tuple[str, float], ...] = ()

    def fit(self, training: Sequence[Observation]) -> "Biased":
        """Take the mean difference between people and the criterion."""
        differences: dict[str, list[float]] = {}
        for o in training:
            gap = float(angle_between(o.natural, o.criteria[self.of].angle))
            for key in ("", o.kind) if self.by_kind else ("",):
                differences.setdefault(key, []).append(gap)
        bias = tuple((key, mean_angle(values)) for key, values in differences.items())
        return Biased(self.name, self.of, self.by_kind, bias)

    def swivel(self, observation: Observation) -> Prediction:
        """Add the correction."""
        base = observation.criteria[self.of]
        known = dict(self.bias)
        shift = known.get(observation.kind, known[""])
        return Prediction(base.angle + shift, base.status)
