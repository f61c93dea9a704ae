"""The force of a muscle with a stiff tendon: force over length and over velocity.

The curves are those of MuJoCo's muscle model, written out so that a whole arm is one call and so
that they can be checked against MuJoCo itself. Lengths and velocities are normalised by the
optimal fibre length, and velocities by the greatest shortening velocity too; a positive velocity
lengthens.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numba import njit

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

    @cached_property
    def height(self) -> Float[np.ndarray, " muscles"]:
        """Give what the fibres keep square to the tendon as they shorten (m)."""
        return freeze(self.fibre * np.sin(self.pennation))

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
        m, c = self.muscles, self.curves
        if velocities is None:
            held = np.empty(lengths.shape)
            _forces_at_rest(
                lengths, m.max_force, m.fibre, m.tendon, m.height, c.shortest, c.longest, held
            )
            return held
        fibre, cosine = fibre_length(m, lengths)
        force = m.max_force * active_force_length(fibre, c) * cosine
        return force * force_velocity(velocities * cosine / (m.fibre * c.fastest), c)

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
    fibre = np.hypot(along, muscles.height)
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


@njit(cache=True)
def _forces_at_rest(lengths, max_force, fibre, tendon, height, shortest, longest, out):
    """Fill out (K,M): the product of `active_force_length` and pennation, in one pass."""
    for k in range(lengths.shape[0]):
        for i in range(lengths.shape[1]):
            along = max(lengths[k, i] - tendon[i], 0.0)
            whole = np.sqrt(along * along + height[i] * height[i])
            if not whole > 0.0:
                out[k, i] = 0.0
                continue
            x = whole / fibre[i]
            if x <= 1.0:
                x = (x - shortest[i]) / (0.5 * (1.0 - shortest[i]))
            else:
                x = (longest[i] - x) / (0.5 * (longest[i] - 1.0))
            x = min(max(x, 0.0), 2.0)
            share = 0.5 * x * x if x <= 1.0 else 1.0 - 0.5 * (2.0 - x) ** 2
            out[k, i] = max_force[i] * share * along / whole
