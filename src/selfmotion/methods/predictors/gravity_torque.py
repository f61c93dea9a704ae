"""Least gravity torque: the sum of its squares over the free coordinates."""

from collections.abc import Sequence
from dataclasses import dataclass

from selfmotion.kinematics.dynamics import gravity_torque
from selfmotion.methods.predictors.least_cost import least_cost
from selfmotion.methods.predictors.observation import Observation, Prediction


@dataclass(frozen=True)
class GravityTorque:
    """The posture in which the joints carry the least torque, squared."""

    name: str = "gravity torque"

    def fit(self, training: Sequence[Observation]) -> "GravityTorque":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Search the sampled postures."""
        scene = observation.the_scene()
        return least_cost(scene, lambda q: (gravity_torque(scene.model.arm, q) ** 2).sum(axis=1))
