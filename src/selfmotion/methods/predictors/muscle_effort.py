"""Least muscle effort: the law of [Li2022] eq. 3.1 (doi 10.1109/TNSRE.2022.3198400)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.methods.predictors.observation import Observation, Prediction
from selfmotion.methods.predictors.scenes import swivel_about
from selfmotion.muscles.static_optimization import EffortOptions


@dataclass(frozen=True)
class MuscleEffort:
    """The posture of least muscle effort.

    Attributes:
        name: name it goes by.
        options: how effort is computed.
    """

    name: str = "muscle effort"
    options: EffortOptions = field(default_factory=EffortOptions)

    def fit(self, training: Sequence[Observation]) -> "MuscleEffort":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Search all postures of the person's arm that hold the hand pose."""
        scene = observation.the_scene()
        finder = PostureFinder.of(scene.model, effort=self.options)
        known = scene.manifold
        found = finder.find(scene.T_hand) if known is None else finder.find_on(known)
        if not found.minima:
            return Prediction(float("nan"), found.status)
        return Prediction(float(swivel_about(scene, found.q[None])[0]), found.status)
