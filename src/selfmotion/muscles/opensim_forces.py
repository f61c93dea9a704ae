"""Forces of OpenSim muscles and coordinate limits, from the parameters that a bridge has read.

With the convention ``opensim``, active force is what OpenSim's static optimisation uses
(`calcInextensibleTendonActiveFiberForce`), with the cosine of pennation that it takes for this
kind of muscle (`opensim_curves`). With ``plain`` the angle is the true one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from selfmotion.muscles.hill import MuscleSet, fibre_length
from selfmotion.muscles.opensim_curves import NONE, NORMALISED, Curves


@dataclass(frozen=True, eq=False)
class OpensimForces:
    """Forces along the tendon with OpenSim's own curves, tendons stiff.

    Attributes:
        muscles: constants of the M muscles.
        curves: of each muscle.
        fastest: (M,) greatest shortening velocity (fibre lengths per second).
        convention: opensim or plain.
    """

    muscles: MuscleSet
    curves: tuple[Curves, ...]
    fastest: Float[np.ndarray, " muscles"]
    convention: str

    def full_activation(
        self,
        lengths: Float[np.ndarray, "samples muscles"],
        velocities: Float[np.ndarray, "samples muscles"] | None = None,
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the active force (N) at activation 1 along the tendon."""
        fibre, true_cosine = fibre_length(self.muscles, lengths)
        share = _each([c.active for c in self.curves], fibre)
        force = self.muscles.max_force * share * self._cosine(fibre, true_cosine)
        if velocities is not None:
            speed = velocities * true_cosine / (self.muscles.fibre * self.fastest)
            force = force * _each([c.velocity for c in self.curves], speed)
        return np.where(fibre * self.muscles.fibre > self._shortest, force, 0.0)

    def passive(
        self, lengths: Float[np.ndarray, "samples muscles"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the passive force (N) along the tendon of stretched muscles."""
        fibre, cosine = fibre_length(self.muscles, lengths)
        return self.muscles.max_force * _each([c.passive for c in self.curves], fibre) * cosine

    @cached_property
    def _shortest(self) -> Float[np.ndarray, " muscles"]:
        return np.array([c.shortest for c in self.curves])

    @cached_property
    def _kinds(self) -> tuple[np.ndarray, np.ndarray]:
        """Tell which muscles take the angle at the normalised length, and which take none."""
        kinds = np.array([c.cosine for c in self.curves])
        return kinds == NORMALISED, kinds == NONE

    def _cosine(self, fibre: np.ndarray, true_cosine: np.ndarray) -> np.ndarray:
        if self.convention == "plain":
            return true_cosine
        normalised, none = self._kinds
        near_one = np.sqrt(
            np.maximum(1.0 - (self.muscles.height / np.maximum(fibre, 1e-9)) ** 2, 0)
        )
        return np.where(none, 1.0, np.where(normalised, near_one, true_cosine))


def _each(curves: list[Callable[[float], float]], x: np.ndarray) -> np.ndarray:
    """Evaluate the curve of each muscle at (K, M) places."""
    columns = [
        [curve(v) for v in column] for curve, column in zip(curves, x.T.tolist(), strict=True)
    ]
    return np.array(columns).T


@dataclass(frozen=True, eq=False)
class LimitForces:
    """Torque of coordinate limits: ``K s(x / transition) x`` beyond a limit, and damping there.

    s is the smooth step ``10 t^3 - 15 t^4 + 6 t^5``. All in rad (or m), N m per rad, s.

    Attributes:
        coordinate: (L,) index of the free coordinate of each limit force.
        upper: (L,) where it begins above; `lower` (L,) below.
        lower: see `upper`.
        upper_stiffness: (L,) K above; `lower_stiffness` (L,) below.
        lower_stiffness: see `upper_stiffness`.
        transition: (L,) width over which the step rises.
        damping: (L,) N m s per rad, times the step, beyond either limit.
    """

    coordinate: np.ndarray
    upper: Float[np.ndarray, " limits"]
    lower: Float[np.ndarray, " limits"]
    upper_stiffness: Float[np.ndarray, " limits"]
    lower_stiffness: Float[np.ndarray, " limits"]
    transition: Float[np.ndarray, " limits"]
    damping: Float[np.ndarray, " limits"]

    def __call__(
        self,
        q: Float[np.ndarray, "samples coords"],
        velocity: Float[np.ndarray, "samples coords"] | None = None,
    ) -> Float[np.ndarray, "samples coords"]:
        """Give the torque (N m) that limits exert on the free coordinates."""
        x = q[:, self.coordinate]
        above, below = np.maximum(x - self.upper, 0.0), np.maximum(self.lower - x, 0.0)
        under, over = _step(below / self.transition), _step(above / self.transition)
        force = self.lower_stiffness * under * below - self.upper_stiffness * over * above
        if velocity is not None:
            force = force - self.damping * (under + over) * velocity[:, self.coordinate]
        out = np.zeros_like(q)
        for i, j in enumerate(self.coordinate):  # a coordinate may have several
            out[:, j] += force[:, i]
        return out


def _step(t: np.ndarray) -> np.ndarray:
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 + t * (-15.0 + 6.0 * t))
