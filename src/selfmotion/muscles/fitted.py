"""The same arm with muscles for another person: larger or smaller, stronger, or left-handed.

Rules of scaling, each a stated choice:

- lengths: chain, muscle paths, fibres and tendons grow by one factor, so that every muscle works
  at the same normalised lengths in the same posture;
- mass: segments weigh a given share of the model's; left out, the cube of the length factor;
- strength: greatest forces stay (`constant`), follow the muscles' cross-section, the square of
  the length factor (`area`), or follow mass to the power 2/3 (`mass`).
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import require_between
from selfmotion.errors import unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import Tip
from selfmotion.kinematics.mirror import mirror
from selfmotion.muscles.geometry import MuscleForces, MuscleGeometry, MusculoskeletalArm
from selfmotion.spatial import unit

STRENGTHS = ("constant", "area", "mass")


@dataclass(frozen=True, eq=False)
class FittedGeometry:
    """Paths of another geometry, reflected or scaled.

    Attributes:
        inner: the geometry of the model.
        matrix: (3, 3) from the model's ground to this one's: a reflection, or a factor.
        factor: of all lengths.
    """

    inner: MuscleGeometry
    matrix: Float[np.ndarray, "3 3"]
    factor: float

    def length(self, q: Float[np.ndarray, " coords"], muscle: int) -> float:
        """Give the length of one path (m)."""
        return self.factor * self.inner.length(q, muscle)

    def lengths(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the lengths of all paths (m)."""
        return self.factor * self.inner.lengths(q)

    def moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles coords"]:
        """Give the moment arms (m)."""
        return self.factor * self.inner.moment_arms(q)

    def lengths_and_moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> tuple[
        Float[np.ndarray, "samples muscles"],
        Float[np.ndarray, "samples muscles coords"],
    ]:
        """Give both, in one pass."""
        lengths, arms = self.inner.lengths_and_moment_arms(q)
        return self.factor * lengths, self.factor * arms

    def rates(
        self,
        q: Float[np.ndarray, "samples coords"],
        velocity: Float[np.ndarray, "samples coords"],
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the rate of change of all lengths (m/s)."""
        return self.factor * self.inner.rates(q, velocity)

    def paths(self, q: Float[np.ndarray, " coords"]) -> list[Float[np.ndarray, "points 3"]]:
        """Give the points of each path in the ground (m)."""
        return [points @ self.matrix.T for points in self.inner.paths(q)]


@dataclass(frozen=True, eq=False)
class FittedForces:
    """Forces of other muscles, at scaled lengths and with scaled strength.

    Attributes:
        inner: the forces of the model.
        length: factor of all lengths.
        strength: factor of all forces.
    """

    inner: MuscleForces
    length: float
    strength: float

    def full_activation(
        self,
        lengths: Float[np.ndarray, "samples muscles"],
        velocities: Float[np.ndarray, "samples muscles"] | None = None,
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the active force (N) at activation 1."""
        rates = None if velocities is None else velocities / self.length
        return self.strength * self.inner.full_activation(lengths / self.length, rates)

    def passive(
        self, lengths: Float[np.ndarray, "samples muscles"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the passive force (N)."""
        return self.strength * self.inner.passive(lengths / self.length)


def scale_to_person(
    model: MusculoskeletalArm,
    *,
    length: float,
    mass: float | None = None,
    strength: str = "area",
) -> MusculoskeletalArm:
    """Scale an arm with muscles to a person.

    The ground's origin is the centre of the scaling. Joint limits and the torque of coordinate
    limits stay as they are.

    Args:
        model: the arm.
        length: factor of all lengths, as the person's arm length over the model's.
        mass: factor of all masses; left out: the cube of `length`.
        strength: constant, area or mass (see the module).

    Raises:
        RangeError: a factor is not between 0.2 and 5 (mass: 0.01 and 100).
        UnknownNameError: there is no such rule of strength.

    Example:
        >>> from selfmotion.arms.with_muscles import load_musculoskeletal_arm
        >>> small = scale_to_person(load_musculoskeletal_arm(), length=0.9)
        >>> round(small.arm.lengths["upper_arm"], 3)
        0.262
    """
    require_between("length", length, 0.2, 5.0)
    heavier = length**3 if mass is None else mass
    require_between("mass", heavier, 0.01, 100.0)
    if strength not in STRENGTHS:
        raise unknown_name("strength", strength, STRENGTHS)
    stronger = {"constant": 1.0, "area": length**2, "mass": heavier ** (2 / 3)}[strength]
    m = model.muscles
    muscles = replace(
        m, max_force=stronger * m.max_force, fibre=length * m.fibre, tendon=length * m.tendon
    )
    return replace(
        model,
        arm=_scaled_arm(model.arm, length, heavier),
        muscles=muscles,
        geometry=FittedGeometry(model.geometry, length * np.eye(3), length),
        forces=FittedForces(model.forces, length, stronger),
    )


def mirror_muscles(model: MusculoskeletalArm) -> MusculoskeletalArm:
    """Give the left arm with muscles for a right one; coordinates keep their meaning.

    Example:
        >>> from selfmotion.arms.with_muscles import load_musculoskeletal_arm
        >>> mirror_muscles(load_musculoskeletal_arm()).arm.name
        'myoarm (mirrored)'
    """
    across = unit("up x forward", np.cross(model.arm.up, model.arm.forward))
    reflection = np.eye(3) - 2.0 * np.outer(across, across)
    return replace(
        model,
        arm=mirror(model.arm),
        geometry=FittedGeometry(model.geometry, reflection, 1.0),
    )


def _scaled_arm(arm: Arm, length: float, mass: float) -> Arm:
    offsets = arm.chain.offsets.copy()
    offsets[:, :3, 3] *= length

    def longer(tip: Tip) -> Tip:
        T = tip.transform.copy()
        T[:3, 3] *= length
        return Tip(tip.joint, T)

    return replace(
        arm,
        chain=replace(arm.chain, offsets=offsets),
        landmarks={name: longer(tip) for name, tip in arm.landmarks.items()},
        lengths={name: length * value for name, value in arm.lengths.items()},
        mass=mass * arm.mass,
        com=length * arm.com,
        inertia=mass * length**2 * arm.inertia,
        source=f"{arm.source}; lengths times {length:g}, masses times {mass:g}",
    )
