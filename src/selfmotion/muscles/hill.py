"""The force of a muscle with a stiff tendon: force over length and over velocity.

The curves are those of MuJoCo's muscle model, written out so that a whole arm is one call and so
that they can be checked against MuJoCo itself. Lengths and velocities are normalised by the
optimal fibre length, and velocities by the greatest shortening velocity too; a positive velocity
lengthens.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import freeze, require_finite, require_shape
from selfmotion.errors import RangeError, unknown_name


@dataclass(frozen=True, eq=False)
class ForceCurves:
    """Where each muscle's curves begin and end; all arrays (M,), in units of fibre length.

    Attributes:
        shortest: normalised length below which there is no active force.
        longest: normalised length above which there is no active force.
        fastest: greatest shortening velocity (fibre lengths per second).
        passive: passive force at the middle between 1 and `longest`, twice over, as a share of
            the greatest force (MuJoCo's fpmax).
        eccentric: force at fast lengthening as a share of the greatest force.
    """

    shortest: Float[np.ndarray, " muscles"]
    longest: Float[np.ndarray, " muscles"]
    fastest: Float[np.ndarray, " muscles"]
    passive: Float[np.ndarray, " muscles"]
    eccentric: Float[np.ndarray, " muscles"]


@dataclass(frozen=True, eq=False)
class MuscleSet:
    """The muscles of an arm and what is constant about them.

    Attributes:
        names: the M muscles.
        max_force: (M,) greatest isometric force (N).
        fibre: (M,) optimal fibre length (m).
        tendon: (M,) slack length of the tendon (m).
        pennation: (M,) angle between fibres and tendon at the optimal fibre length (rad).
    """

    names: tuple[str, ...]
    max_force: Float[np.ndarray, " muscles"]
    fibre: Float[np.ndarray, " muscles"]
    tendon: Float[np.ndarray, " muscles"]
    pennation: Float[np.ndarray, " muscles"]

    def __post_init__(self) -> None:
        """Check the arrays and make them read-only."""
        for field in ("max_force", "fibre", "tendon", "pennation"):
            array = np.array(getattr(self, field), dtype=np.float64)
            require_shape(field, array, (len(self.names),))
            require_finite(field, array)
            if field in ("max_force", "fibre") and not (array > 0).all():
                i = int(np.argmin(array))
                raise RangeError(
                    f"{field} of {self.names[i]!r} is {array[i]:g}; it must be above 0"
                )
            object.__setattr__(self, field, freeze(array))

    def index(self, name: str) -> int:
        """Give the position of a muscle.

        Raises:
            UnknownNameError: no muscle has this name.
        """
        if name not in self.names:
            raise unknown_name("muscle", name, self.names)
        return self.names.index(name)


@dataclass(frozen=True, eq=False)
class StiffTendonForces:
    """Forces along the tendon for a `MuscleSet` and its curves.

    Attributes:
        muscles: the muscles.
        curves: their curves.
        passive_muscles: constants that hold for passive force; MuJoCo states them apart, and in
            myo-sim they differ for one muscle. Left out: `muscles`.
    """

    muscles: MuscleSet
    curves: ForceCurves
    passive_muscles: MuscleSet | None = None

    def full_activation(
        self,
        lengths: Float[np.ndarray, "samples muscles"],
        velocities: Float[np.ndarray, "samples muscles"] | None = None,
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the active force (N) at activation 1 along the tendon, ([Li2022] eq. 2).

        Args:
            lengths: (K, M) of the whole path, tendon included (m).
            velocities: (K, M) rate of change of `lengths` (m/s); left out: at rest.
        """
        fibre, cosine = fibre_length(self.muscles, lengths)
        force = self.muscles.max_force * active_force_length(fibre, self.curves) * cosine
        if velocities is not None:
            rate = velocities * cosine / (self.muscles.fibre * self.curves.fastest)
            force = force * force_velocity(rate, self.curves)
        return force

    def passive(
        self, lengths: Float[np.ndarray, "samples muscles"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the passive force (N) along the tendon of stretched muscles."""
        muscles = self.muscles if self.passive_muscles is None else self.passive_muscles
        fibre, cosine = fibre_length(muscles, lengths)
        return muscles.max_force * passive_force_length(fibre, self.curves) * cosine


def fibre_length(
    muscles: MuscleSet, lengths: Float[np.ndarray, "samples muscles"]
) -> tuple[Float[np.ndarray, "samples muscles"], Float[np.ndarray, "samples muscles"]]:
    """Give normalised fibre length and cosine of pennation, for a tendon that does not stretch.

    The fibres keep the height ``fibre * sin(pennation)`` of a parallelogram of constant volume.
    A path shorter than its tendon gives fibres of no length along it.
    """
    along = np.maximum(lengths - muscles.tendon, 0.0)
    height = muscles.fibre * np.sin(muscles.pennation)
    fibre = np.hypot(along, height)
    cosine = np.divide(along, fibre, out=np.zeros_like(along), where=fibre > 0)
    return fibre / muscles.fibre, cosine


def active_force_length(
    fibre: Float[np.ndarray, "samples muscles"], curves: ForceCurves
) -> Float[np.ndarray, "samples muscles"]:
    """Give active force over normalised length: four parabolas, 1 at length 1, 0 at the ends.

    Example:
        >>> import numpy as np
        >>> one = np.ones(1)
        >>> curves = ForceCurves(0.5 * one, 1.6 * one, 10 * one, one, 1.2 * one)
        >>> active_force_length(np.array([[0.5], [0.75], [1.0], [1.3]]), curves)[:, 0].tolist()
        [0.0, 0.5, 1.0, 0.5]
    """
    low, high = curves.shortest, curves.longest
    rising = (fibre - low) / (0.5 * (1.0 - low))  # 0 to 2 from `low` to 1
    falling = (high - fibre) / (0.5 * (high - 1.0))
    x = np.clip(np.where(fibre <= 1.0, rising, falling), 0.0, 2.0)
    return np.where(x <= 1.0, 0.5 * x * x, 1.0 - 0.5 * (2.0 - x) ** 2)


def passive_force_length(
    fibre: Float[np.ndarray, "samples muscles"], curves: ForceCurves
) -> Float[np.ndarray, "samples muscles"]:
    """Give passive force over normalised length: a parabola beyond 1, then a straight line."""
    x = np.maximum(fibre - 1.0, 0.0) / (0.5 * (curves.longest - 1.0))
    return curves.passive * np.where(x <= 1.0, 0.5 * x * x, x - 0.5)


def force_velocity(
    rate: Float[np.ndarray, "samples muscles"], curves: ForceCurves
) -> Float[np.ndarray, "samples muscles"]:
    """Give the factor of active force over normalised velocity: 0 at -1, 1 at rest."""
    excess = curves.eccentric - 1.0
    shortening = np.clip(rate + 1.0, 0.0, 1.0) ** 2
    gap = np.clip(excess - rate, 0.0, None)
    lengthening = curves.eccentric - np.divide(
        gap * gap, excess, out=np.zeros_like(gap), where=excess > 0
    )
    return np.where(rate <= 0.0, shortening, lengthening)
