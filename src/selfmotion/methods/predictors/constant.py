"""The mean angle of other people: the baseline that a law must beat."""

from collections.abc import Sequence
from dataclasses import dataclass

from selfmotion.errors import Status
from selfmotion.methods.predictors.observation import Observation, Prediction, mean_angle


@dataclass(frozen=True)
class Constant:
    """Other people's mean, for each task and moment or for all together.

    Attributes:
        name: name it goes by.
        by_kind: whether each task and moment has its own.
        means: kind ("" for all together) to angle (rad).
    """

    name: str = "constant per task"
    by_kind: bool = True
    means: tuple[tuple[str, float], ...] = ()

    def fit(self, training: Sequence[Observation]) -> "Constant":
        """Take each person's mean first, so that each counts once."""
        people: dict[tuple[str, str], list[float]] = {}
        for o in training:
            people.setdefault((o.kind if self.by_kind else "", o.subject), []).append(o.natural)
        kinds: dict[str, list[float]] = {}
        for (kind, _), values in people.items():
            kinds.setdefault(kind, []).append(mean_angle(values))
        return Constant(
            self.name, self.by_kind, tuple((k, mean_angle(v)) for k, v in kinds.items())
        )

    def swivel(self, observation: Observation) -> Prediction:
        """Give the mean of the kind."""
        kind = observation.kind if self.by_kind else ""
        known = dict(self.means)
        if kind not in known:
            return Prediction(float("nan"), Status(False, f"nobody else did {kind}"))
        return Prediction(known[kind])
