"""Putting rigid bodies together: mass, centre of mass and inertia of several as one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import Transform


@dataclass(frozen=True, eq=False)
class RigidBody:
    """What a rigid body weighs and how it resists turning.

    Attributes:
        mass: kg.
        com: (3,) centre of mass in the body's frame (m).
        inertia: (3, 3) about the centre of mass, in the frame's axes (kg m²).
    """

    mass: float
    com: Float[np.ndarray, "3"]
    inertia: Float[np.ndarray, "3 3"]

    def moved(self, T: Transform) -> "RigidBody":
        """Give the same body in another frame: T takes this frame's coordinates to that one."""
        R = T[:3, :3]
        return RigidBody(self.mass, R @ self.com + T[:3, 3], R @ self.inertia @ R.T)


def merge_bodies(bodies: Sequence[RigidBody]) -> RigidBody:
    """Give several bodies in one frame as one (nothing, or no mass: a body without mass)."""
    mass = float(sum(body.mass for body in bodies))
    if mass == 0.0:
        inertia = sum((body.inertia for body in bodies), np.zeros((3, 3)))
        return RigidBody(0.0, np.zeros(3), inertia)
    com = sum((body.mass * body.com for body in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        d = body.com - com
        inertia += body.inertia + body.mass * ((d @ d) * np.eye(3) - np.outer(d, d))
    return RigidBody(mass, com, inertia)
