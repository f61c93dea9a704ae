"""The choices that shape a plan, and where they differ from the paper's."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from jaxtyping import Float

from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.dynamics import inertia_matrix
from selfmotion.methods.passive.potentials import Potential
from selfmotion.methods.passive.task_planners import Planner, TargetSpring

Model = Literal["lambda0", "pmp1", "pmp2"]
DampingLaw: TypeAlias = Callable[[np.ndarray], np.ndarray]
FROM_DAMPING = "from-damping"
# Intervals of the output of one movement, at most: 0.4 s at 1 MHz is enough for anybody.
MOST_STEPS = 400_000


@dataclass(frozen=True, eq=False)
class PlanSettings:
    """How to plan; the defaults are the paper's.

    Attributes:
        model: "lambda0", "pmp1" (no joint potential) or "pmp2" (no λ0).
        spring: k (N m/rad or N/m), a matrix (m, m), or "from-damping" for eq. 10.
        duration: length of a movement (s).
        n_steps: intervals of the output; the integration takes as many steps as it needs.
        damping: None: W = τ₀K^J (eq. 7); (n,) or (n, n): W itself (N m s/rad), as from
            `identify_weights`; a function q (K, n) to (K, n, n): W(q), as `inertia_damping`.
        potentials: further joint-space potentials beside the elastic one.
        planner: what pulls the hand.
        locked: joints that do not move, by name.
        tolerance: error allowed in a step of the implicit integration (rad or m).
    """

    model: Model = "lambda0"
    spring: float | Float[np.ndarray, "rows rows"] | Literal["from-damping"] = FROM_DAMPING
    duration: float = 0.4
    n_steps: int = 100
    damping: Float[np.ndarray, "..."] | DampingLaw | None = None
    potentials: tuple[Potential, ...] = ()
    planner: Planner = field(default_factory=TargetSpring)
    locked: tuple[str, ...] = ()
    tolerance: float = 1e-8

    def __post_init__(self) -> None:
        """Check what needs no arm."""
        if self.model not in ("lambda0", "pmp1", "pmp2"):
            raise RangeError(f"model = {self.model!r}: allowed are lambda0, pmp1, pmp2")
        if not (np.isfinite(self.duration) and self.duration > 0.0):
            raise RangeError(f"duration = {self.duration:g} s: must be above 0")
        if not 1 <= self.n_steps <= MOST_STEPS:
            raise RangeError(f"n_steps = {self.n_steps}: allowed are 1 to {MOST_STEPS}")
        if not self.tolerance > 0.0:
            raise RangeError(f"tolerance = {self.tolerance:g}: must be above 0")
        if self.model == "pmp1" and self.potentials:
            raise RangeError("model = 'pmp1': it has no joint potential; use lambda0 or pmp2")
        if isinstance(self.spring, str) and self.spring != FROM_DAMPING:
            raise RangeError(f"spring = {self.spring!r}: a number, a matrix or 'from-damping'")


def inertia_damping(arm: Arm, rate: float) -> DampingLaw:
    """Give W(q) = rate · A(q): damping shaped like the inertia matrix of the arm.

    Args:
        arm: with masses.
        rate: damping over inertia (1/s).

    Returns:
        A function of postures (K, n) that gives (K, n, n) N m s/rad.

    Raises:
        RangeError: the rate is not above 0.
    """
    if not rate > 0.0:
        raise RangeError(f"rate = {rate:g} /s: must be above 0")
    return lambda q: rate * inertia_matrix(arm, q)
