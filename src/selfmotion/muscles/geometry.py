"""What a musculoskeletal arm is made of: an arm, its muscles, their paths and their forces."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Float

from selfmotion.errors import unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.muscles.hill import MuscleSet

# How muscle effort is computed: see `static_optimization`.
CONVENTIONS = ("plain", "opensim")


class MuscleGeometry(Protocol):
    """Paths of muscles over the free coordinates of an arm."""

    def length(self, q: Float[np.ndarray, " coords"], muscle: int) -> float:
        """Give the length of one path (m), tendon included, in one posture (rad)."""
        ...

    def lengths(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the lengths of all paths (m), tendon included."""
        ...

    def moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles coords"]:
        """Give the torque of a unit tension on each free coordinate (m), coupling applied."""
        ...

    def lengths_and_moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> tuple[
        Float[np.ndarray, "samples muscles"],
        Float[np.ndarray, "samples muscles coords"],
    ]:
        """Give both, in one pass."""
        ...

    def rates(
        self,
        q: Float[np.ndarray, "samples coords"],
        velocity: Float[np.ndarray, "samples coords"],
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the rate of change of all lengths (m/s) for velocities (rad/s)."""
        ...

    def paths(self, q: Float[np.ndarray, " coords"]) -> list[Float[np.ndarray, "points 3"]]:
        """Give the points of each path in the ground (m), for drawing one posture."""
        ...


class MuscleForces(Protocol):
    """Forces of the muscles along their tendons."""

    def full_activation(
        self,
        lengths: Float[np.ndarray, "samples muscles"],
        velocities: Float[np.ndarray, "samples muscles"] | None = None,
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the active force (N) at activation 1 for path lengths (m) and their rates."""
        ...

    def passive(
        self, lengths: Float[np.ndarray, "samples muscles"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the passive force (N) of stretched muscles."""
        ...


class LimitTorque(Protocol):
    """Torque of ligaments and coordinate limits."""

    def __call__(
        self,
        q: Float[np.ndarray, "samples coords"],
        velocity: Float[np.ndarray, "samples coords"] | None = None,
    ) -> Float[np.ndarray, "samples coords"]:
        """Give the torque (N m) that they exert on the free coordinates, damping included."""
        ...


@dataclass(frozen=True, eq=False)
class MusculoskeletalArm:
    """An arm with muscles.

    Attributes:
        arm: chain, masses and landmarks.
        muscles: names and constants of the M muscles.
        geometry: lengths and moment arms.
        forces: force over length and velocity.
        convention: how effort is computed where nothing else is asked for.
        limits: torque of coordinate limits, if the model has them.
    """

    arm: Arm
    muscles: MuscleSet
    geometry: MuscleGeometry
    forces: MuscleForces
    convention: str = "plain"
    limits: LimitTorque | None = None

    def __post_init__(self) -> None:
        """Check the convention's name."""
        if self.convention not in CONVENTIONS:
            raise unknown_name("convention", self.convention, CONVENTIONS)
