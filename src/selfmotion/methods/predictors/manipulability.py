"""Greatest manipulability of the wrist towards the mouth (Kim et al. 2012).

Kim, Miller, Byl, Abrams & Rosen 2012, doi 10.1109/TBME.2012.2194489, named in [Li2022] Table IV:
of all swivel angles a person takes the one at which the longest axis of the wrist's
manipulability ellipsoid, of an arm with a spherical shoulder and a hinged elbow, points most
towards the mouth. Deviations: angles outside the joint limits are left out, and elbow and wrist
are those of the person's arm and not of a simplified one. Turning the arm about the line from
shoulder to wrist turns the ellipsoid along; its longest axis lies in the plane of the arm, so
that without limits the plane of the arm meets the mouth, as in `coplanar`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.methods.predictors.least_cost import least_cost
from selfmotion.methods.predictors.observation import Observation, Prediction
from selfmotion.methods.predictors.scenes import elbow_and_wrist


@dataclass(frozen=True)
class Manipulability:
    """The posture from which the wrist moves most easily towards the mouth."""

    name: str = "manipulability"

    def fit(self, training: Sequence[Observation]) -> "Manipulability":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Search the sampled postures."""
        scene = observation.the_scene()

        def cost(q: Float[np.ndarray, "samples 7"]) -> Float[np.ndarray, " samples"]:
            E, W = elbow_and_wrist(scene, q)
            towards = scene.mouth - W
            towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
            return -np.abs(np.einsum("ki,ki->k", longest_axis(scene.shoulder, E, W), towards))

        return least_cost(scene, cost)


def longest_axis(
    shoulder: Float[np.ndarray, "3"],
    elbow: Float[np.ndarray, "samples 3"],
    wrist: Float[np.ndarray, "samples 3"],
) -> Float[np.ndarray, "samples 3"]:
    """Give the unit direction in which unit joint speeds move the wrist fastest.

    Three shoulder axes through the centre, square to each other, move the wrist square to the
    line from it (``|r|² I - r rᵀ``); the elbow moves it square to the forearm, in the arm's plane.

    Example:
        >>> S, E, W = np.zeros(3), np.array([[0, 0, -0.3]]), np.array([[0, 0.25, -0.3]])
        >>> float(longest_axis(S, E, W)[0, 0])  # nothing out of the plane of the arm
        0.0
    """
    r = wrist - shoulder
    normal = np.cross(elbow - shoulder, wrist - elbow)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    c = np.cross(normal, wrist - elbow)
    M = (r * r).sum(axis=1)[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :]
    M = M + c[:, :, None] * c[:, None, :]
    return np.linalg.eigh(M)[1][:, :, -1]
