"""Force curves of OpenSim's kinds of muscle.

What OpenSim's static optimisation takes for the cosine of pennation differs by kind: that of the
true angle (`Thelen2003Muscle`), that of the angle at the *normalised* fibre length, which is
nearly 1 (`Millard2012EquilibriumMuscle`), or none (`DeGrooteFregly2016Muscle`).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from selfmotion.errors import ModelError

TRUE, NORMALISED, NONE = "true", "normalised", "none"


class Curves(NamedTuple):
    """Curves of one muscle, as shares of its greatest isometric force.

    Attributes:
        active: of normalised fibre length.
        passive: of normalised fibre length.
        velocity: factor of active force, of speed (greatest shortening velocities; lengthening
            is positive).
        cosine: which cosine of pennation OpenSim takes: true, normalised, none.
        shortest: fibre length (m) at and below which there is no active force.
    """

    active: Callable[[float], float]
    passive: Callable[[float], float]
    velocity: Callable[[float], float]
    cosine: str
    shortest: float


def read_curves(osim: Any, muscle: Any) -> Curves:
    """Read the force curves of a muscle.

    Raises:
        ModelError: the muscle is of a kind that is not represented.
    """
    millard = osim.Millard2012EquilibriumMuscle.safeDownCast(muscle)
    if millard is not None:
        return Curves(
            millard.getActiveForceLengthCurve().calcValue,
            millard.getFiberForceLengthCurve().calcValue,
            millard.getForceVelocityCurve().calcValue,
            NORMALISED,
            millard.getMinimumFiberLength(),
        )
    degroote = osim.DeGrooteFregly2016Muscle.safeDownCast(muscle)
    if degroote is not None:
        return Curves(
            degroote.calcActiveForceLengthMultiplier,
            degroote.calcPassiveForceMultiplier,
            degroote.calcForceVelocityMultiplier,
            NONE,
            0.0,
        )
    thelen = osim.Thelen2003Muscle.safeDownCast(muscle)
    if thelen is not None:
        return _thelen(thelen)
    raise ModelError(
        f"muscle {muscle.getName()!r} is a {muscle.getConcreteClassName()}, which is not "
        "represented: Millard2012EquilibriumMuscle, DeGrooteFregly2016Muscle and "
        "Thelen2003Muscle are"
    )


def _thelen(muscle: Any) -> Curves:
    """Write out the curves of Thelen (2003), which OpenSim does not hand out."""
    width, stiff = muscle.get_KshapeActive(), muscle.get_KshapePassive()
    strain, bend, greatest = muscle.get_FmaxMuscleStrain(), muscle.get_Af(), muscle.get_Flen()
    line = muscle.get_fv_linear_extrap_threshold()

    def active(x: float) -> float:
        return float(np.exp(-((x - 1.0) ** 2) / width))

    def passive(x: float) -> float:
        return float(np.expm1(stiff * max(x - 1.0, 0.0) / strain) / np.expm1(stiff))

    # At full activation. Lengthening: speed = (f - 1) / (rise (greatest - f)).
    rise = (2.0 + 2.0 / bend) / (greatest - 1.0)
    last = line * greatest  # from here on OpenSim goes straight on
    begin = (last - 1.0) / (rise * (greatest - last))
    slope = rise * (greatest - last) ** 2 / (greatest - 1.0)

    def velocity(speed: float) -> float:
        if speed <= 0.0:
            return max(1.0 + speed, 0.0) / (1.0 - speed / bend)
        if speed > begin:
            return last + slope * (speed - begin)
        return (1.0 + speed * rise * greatest) / (1.0 + speed * rise)

    return Curves(active, passive, velocity, TRUE, 0.0)
