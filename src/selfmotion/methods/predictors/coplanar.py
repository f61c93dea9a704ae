"""Shoulder, elbow, wrist and mouth in one plane (Wu et al.), named in [Li2022] Table IV.

The elbow is on the side of the line from shoulder to wrist that the mouth is not on: a closed
form, without joint limits. Of the paper this one assumption is taken; its own arm model is not.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from selfmotion.errors import Status
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.methods.predictors.observation import Observation, Prediction
from selfmotion.methods.predictors.scenes import wrist_of_hand


@dataclass(frozen=True)
class Coplanar:
    """The elbow opposite to the mouth, in one plane with it."""

    name: str = "coplanar with the mouth"

    def fit(self, training: Sequence[Observation]) -> "Coplanar":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Turn the plane through shoulder and wrist until it meets the mouth."""
        scene = observation.the_scene()
        W = wrist_of_hand(scene)[None]
        opposite = 2.0 * scene.shoulder - scene.mouth
        angle = swivel_angle(scene.shoulder, opposite[None], W, down=-scene.model.arm.up)[0]
        if not np.isfinite(angle):
            return Prediction(float("nan"), Status(False, "the mouth is on the line to the wrist"))
        return Prediction(float(angle))
