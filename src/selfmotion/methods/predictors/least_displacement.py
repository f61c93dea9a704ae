"""Least displacement of the joints from a posture: hanging, or where the movement started.

Coordinates of a shoulder count the same movement differently near a hanging arm (the plane of
elevation is free there), so displacement is measured by rotation: the angle by which the upper arm
turns, and the changes of the elbow, forearm and wrist, squared and added. The plain norm over the
coordinates is at hand too, since the two do not agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.capture.marker_guides import upper_arm_body
from selfmotion.errors import unknown_name
from selfmotion.kinematics.forward import body_frames
from selfmotion.methods.predictors.least_cost import least_cost
from selfmotion.methods.predictors.observation import (
    Observation,
    Prediction,
    Scene,
)

MEASURES = ("rotation", "coordinates")


@dataclass(frozen=True)
class LeastDisplacement:
    """The posture nearest to a hanging arm, or to the start of the movement.

    Attributes:
        name: name it goes by.
        from_start: whether from the start; else from hanging.
        measure: rotation, or coordinates: the norm over the model's coordinates.
    """

    name: str = "nearest to hanging"
    from_start: bool = False
    measure: str = "rotation"

    def __post_init__(self) -> None:
        """Check the measure."""
        if self.measure not in MEASURES:
            raise unknown_name("measure", self.measure, MEASURES)

    def fit(self, training: Sequence[Observation]) -> "LeastDisplacement":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Search the sampled postures."""
        scene = observation.the_scene()
        arm = scene.model.arm
        hanging = np.clip(np.zeros(7), arm.lower, arm.upper)
        origin = scene.start if self.from_start else hanging
        if self.measure == "coordinates":
            return least_cost(scene, lambda q: ((q - origin) ** 2).sum(axis=1))
        return least_cost(scene, lambda q: displacement(scene, q, origin))


def displacement(
    scene: Scene, q: Float[np.ndarray, "samples 7"], origin: Float[np.ndarray, "7"]
) -> Float[np.ndarray, " samples"]:
    """Give the squared displacement (rad²) of postures from another."""
    arm = scene.model.arm
    frames = body_frames(arm.chain, np.vstack([origin, q]))[:, upper_arm_body(arm), :3, :3]
    R = frames[1:] @ frames[0].T
    cosine = 0.5 * (np.trace(R, axis1=1, axis2=2) - 1.0)
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    return turn**2 + ((q[:, 3:] - origin[3:]) ** 2).sum(axis=1)
