"""Muscle effort of a posture: the least activation that holds the arm.

Implements [Li2022] eqs 1 to 3 (doi 10.1109/TNSRE.2022.3198400): gravity torque, projected on the
free coordinates, is shared among the muscles so that the sum of squared activations is least.
Deviations: the balance is asked of the free coordinates only (eq. 2 writes 20 rows, of which the
coupled ones are carried by the couplings and not by muscles); velocity and acceleration may be
added, which the paper leaves out.

Two conventions name what else goes in:

- ``plain``: activations from 0 to 1, gravity only, fibres at their true pennation.
- ``opensim``: as OpenSim's static optimisation computes it: activations from 0.01 to 1, gravity
  and the torque of coordinate limits, and the muscle model's own pennation.
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_between, require_finite, require_shape
from selfmotion.errors import ModelError, RangeError, Status, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.dynamics import gravity_torque, inertia_matrix
from selfmotion.kinematics.inertia import RigidBody, merge_bodies
from selfmotion.muscles import qp_kernels
from selfmotion.muscles.geometry import CONVENTIONS, MusculoskeletalArm

if TYPE_CHECKING:
    import pandas as pd

LOADS = ("gravity", "passive", "limits")

# Missing torque (N m) above which no activation is said to hold the posture.
TORQUE_TOLERANCE = 1e-6
# How far a posture is beyond a joint limit (rad) before its status says so.
LIMIT_TOLERANCE = 1e-6
# What the status of a posture begins with that some activation holds.
HELD = "held"
# Beyond these no arm moves (rad/s, rad/s²).
FASTEST, GREATEST_ACCELERATION = 1e3, 1e6
# Step (rad) of the central differences that give centrifugal and Coriolis torque.
_STEP = 1e-5


@dataclass(frozen=True)
class EffortOptions:
    """How effort is computed.

    Attributes:
        lower: least activation of every muscle.
        upper: greatest activation.
        loads: what loads the joints: gravity; passive (the force of stretched muscles, which may
            also relieve); limits (ligaments and coordinate limits, if the model has them).
        hand_load: mass held in the hand (kg), at the origin of the hand's frame.
        exponent: p in the sum of a**p that is least, 2 or more.
        solver: newton (compiled, on the dual) or daqp (active set; exponent 2 only).
    """

    lower: float = 0.0
    upper: float = 1.0
    loads: tuple[str, ...] = ("gravity",)
    hand_load: float = 0.0
    exponent: float = 2.0
    solver: str = "newton"

    def __post_init__(self) -> None:
        """Check the ranges."""
        require_between("lower", self.lower, 0.0, self.upper)
        require_between("upper", self.upper, self.lower, 1.0)
        require_between("hand_load", self.hand_load, 0.0, 200.0)
        require_between("exponent", self.exponent, 2.0, 10.0)
        for load in self.loads:
            if load not in LOADS:
                raise unknown_name("load", load, LOADS)
        if self.solver not in ("newton", "daqp"):
            raise unknown_name("solver", self.solver, ("newton", "daqp"))
        if self.solver == "daqp" and self.exponent != 2.0:
            raise RangeError(f"exponent = {self.exponent:g}: daqp solves exponent 2 only")

    @classmethod
    def of(cls, convention: str) -> "EffortOptions":
        """Give the options of a convention.

        Raises:
            UnknownNameError: there is no such convention.
        """
        if convention not in _CONVENTIONS:
            raise unknown_name("convention", convention, CONVENTIONS)
        return _CONVENTIONS[convention]


_CONVENTIONS: Mapping[str, EffortOptions] = MappingProxyType(
    {
        "plain": EffortOptions(),
        "opensim": EffortOptions(lower=0.01, loads=("gravity", "limits")),
    }
)


@dataclass(frozen=True, eq=False)
class MuscleEffort:
    """Muscle effort of K postures.

    Attributes:
        effort: (K,) sum over muscles of a**p (p = 2: [Li2022] eq. 3); where nothing holds the
            posture, that of the answer with the least missing torque.
        activations: (K, M).
        torque: (K, n) that the muscles' activations must give (N m).
        missing: (K, n) torque that they do not give (N m).
        coordinates: names of the n coordinates.
        muscles: names of the M muscles.
        status: whether the posture is held, for each; if not, what is missing where; and which
            coordinates are beyond their joint limits.
    """

    effort: Float[np.ndarray, " samples"]
    activations: Float[np.ndarray, "samples muscles"]
    torque: Float[np.ndarray, "samples coords"]
    missing: Float[np.ndarray, "samples coords"]
    coordinates: tuple[str, ...]
    muscles: tuple[str, ...]
    status: tuple[Status, ...]

    def to_frame(self) -> "pd.DataFrame":
        """Give a table: effort, whether held, then activations by muscle."""
        import pandas as pd

        table = pd.DataFrame(self.activations, columns=list(self.muscles))
        table.insert(0, "effort", self.effort)
        table.insert(1, "held", [bool(s) for s in self.status])
        return table


def muscle_effort(
    model: MusculoskeletalArm,
    q: ArrayLike,
    *,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    options: EffortOptions | None = None,
) -> MuscleEffort:
    """Give the least muscle effort that holds postures, or that makes a movement.

    Args:
        model: arm with muscles.
        q: (n,) or (K, n) free coordinates (rad).
        velocity: (K, n) of the coordinates (rad/s); left out: at rest.
        acceleration: (K, n) of the coordinates (rad/s²); left out: none.
        options: left out: those of the model's convention.

    Returns:
        Effort and activations. Where no activation gives the torque, the answer with the least
        missing torque, and a status that says which coordinate lacks how much. Postures outside
        the joint limits are computed as well; their status says so.

    Raises:
        ShapeError: the arrays do not fit the arm.
        NotFiniteError: an array holds NaN or infinite values.
        RangeError: a velocity or acceleration is beyond what any arm does.
        ModelError: limits are asked for as a load, but the model has none.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms.with_muscles import load_musculoskeletal_arm
        >>> model = load_musculoskeletal_arm()
        >>> hanging, raised = np.zeros((2, 7))
        >>> raised[1] = np.pi / 2
        >>> e = muscle_effort(model, [hanging, raised]).effort
        >>> bool(e[0] < e[1])
        True
    """
    chosen = EffortOptions.of(model.convention) if options is None else options
    samples = model.arm.chain.as_samples(q)
    rates = None if velocity is None else _like("velocity", velocity, samples, FASTEST)
    second = (
        None
        if acceleration is None
        else _like("acceleration", acceleration, samples, GREATEST_ACCELERATION)
    )
    problem = muscle_problem(model, samples, chosen, rates, second)
    activations, missing, converged = problem.solve(chosen)
    names = model.arm.joints
    beyond = _beyond_limits(model.arm, samples)
    status = tuple(
        _status(missing[k], names, beyond[k], bool(converged[k])) for k in range(len(samples))
    )
    effort = (activations**chosen.exponent).sum(axis=1)
    return MuscleEffort(
        effort, activations, problem.torque, missing, names, model.muscles.names, status
    )


@dataclass(frozen=True, eq=False)
class MuscleProblem:
    """What K postures ask of the muscles: ``strength.T @ activation = torque`` for each.

    Attributes:
        lengths: (K, M) of the paths (m).
        arms: (K, M, n) moment arms (m).
        strength: (K, M, n) torque of each muscle at activation 1 (N m).
        torque: (K, n) that activations must give (N m).
    """

    lengths: Float[np.ndarray, "samples muscles"]
    arms: Float[np.ndarray, "samples muscles coords"]
    strength: Float[np.ndarray, "samples muscles coords"]
    torque: Float[np.ndarray, "samples coords"]

    def slopes(
        self, tangents: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the rate of change of lengths along directions of the coordinates (m/rad)."""
        return -np.einsum("kmn,kn->km", self.arms, tangents)

    def solve(
        self, options: EffortOptions
    ) -> tuple[
        Float[np.ndarray, "samples muscles"], Float[np.ndarray, "samples coords"], np.ndarray
    ]:
        """Give activations, missing torque (N m), and whether the solver converged (K,)."""
        n_samples, n_muscles, n = self.strength.shape
        lower = np.full(n_muscles, options.lower)
        upper = np.full(n_muscles, options.upper)
        activations = np.empty((n_samples, n_muscles))
        iterations = qp_kernels.solve_many(
            self.strength,
            self.torque,
            lower,
            upper,
            float(options.exponent),
            activations,
            np.empty((n_samples, n)),
        )
        missing = self._missing(activations)
        if options.solver == "daqp":
            held = np.abs(missing).max(axis=1) <= TORQUE_TOLERANCE
            for k in np.flatnonzero(held):  # daqp gives no least residual where nothing holds
                activations[k] = _daqp(self.strength[k], self.torque[k], options)
            missing = self._missing(activations)
        return activations, missing, iterations >= 0

    def _missing(self, activations: np.ndarray) -> np.ndarray:
        return self.torque - np.einsum("kmn,km->kn", self.strength, activations)


def muscle_problem(
    model: MusculoskeletalArm,
    q: Float[np.ndarray, "samples coords"],
    options: EffortOptions,
    velocity: Float[np.ndarray, "samples coords"] | None = None,
    acceleration: Float[np.ndarray, "samples coords"] | None = None,
) -> MuscleProblem:
    """Set up what postures ask of the muscles ([Li2022] eq. 2).

    Raises:
        ModelError: limits are asked for as a load, but the model has none.
    """
    lengths, arms = model.geometry.lengths_and_moment_arms(q)
    rates = None if velocity is None else model.geometry.rates(q, velocity)
    strength = arms * model.forces.full_activation(lengths, rates)[:, :, None]
    torque = required_torque(model.arm, q, options, velocity, acceleration)
    if "passive" in options.loads:
        torque = torque - np.einsum("kmn,km->kn", arms, model.forces.passive(lengths))
    if "limits" in options.loads:
        if model.limits is None:
            raise ModelError(f"{model.arm.name}: the model has no coordinate-limit forces")
        torque = torque - model.limits(q, velocity)
    return MuscleProblem(lengths, arms, strength, torque)


def required_torque(
    arm: Arm,
    q: Float[np.ndarray, "samples coords"],
    options: EffortOptions,
    velocity: Float[np.ndarray, "samples coords"] | None = None,
    acceleration: Float[np.ndarray, "samples coords"] | None = None,
) -> Float[np.ndarray, "samples coords"]:
    """Give the torque of gravity and inertia on the free coordinates, ([Li2022] eq. 1)."""
    loaded = with_hand_load(arm, options.hand_load) if options.hand_load > 0 else arm
    torque = np.zeros_like(q)
    if "gravity" in options.loads:
        torque = gravity_torque(loaded, q)
    if velocity is not None:
        torque = torque + _centrifugal(loaded, q, velocity)
    if acceleration is not None:
        torque = torque + np.einsum("kij,kj->ki", inertia_matrix(loaded, q), acceleration)
    return torque


@functools.lru_cache(maxsize=16)
def with_hand_load(arm: Arm, mass: float) -> Arm:
    """Give the same arm with a point mass (kg) at the origin of the hand's frame."""
    tip = arm.tip("hand")
    i = tip.joint
    hand = RigidBody(float(arm.mass[i]), arm.com[i], arm.inertia[i])
    load = RigidBody(mass, tip.transform[:3, 3], np.zeros((3, 3)))
    both = merge_bodies([hand, load])
    masses, com, inertia = arm.mass.copy(), arm.com.copy(), arm.inertia.copy()
    masses[i], com[i], inertia[i] = both.mass, both.com, both.inertia
    return replace(arm, mass=masses, com=com, inertia=inertia)


def _centrifugal(arm: Arm, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Give b(q, qd), centrifugal and Coriolis torque, from the slope of the inertia matrix.

    ``b = (dA/dt) qd - d(qd' A qd)/dq / 2``. Central differences keep one inertia matrix the
    source of both terms, so that power balances exactly; their error is 1e-9 of b.
    """
    along = 0.0
    gradient = np.empty_like(q)
    for i in range(q.shape[1]):
        step = np.zeros(q.shape[1])
        step[i] = _STEP
        slope = (inertia_matrix(arm, q + step) - inertia_matrix(arm, q - step)) / (2 * _STEP)
        slope_qd = np.einsum("kij,kj->ki", slope, qd)
        gradient[:, i] = np.einsum("ki,ki->k", slope_qd, qd)
        along = along + slope_qd * qd[:, i : i + 1]
    return along - 0.5 * gradient


def _daqp(strength: np.ndarray, torque: np.ndarray, options: EffortOptions) -> np.ndarray:
    """Solve one quadratic programme by daqp's active set."""
    import daqp

    n_muscles, n = strength.shape
    above = np.concatenate([np.full(n_muscles, options.upper), torque])
    below = np.concatenate([np.full(n_muscles, options.lower), torque])
    equality = 5
    sense = np.concatenate([np.zeros(n_muscles), np.full(n, equality)]).astype(np.int32)
    rows = np.ascontiguousarray(strength.T)
    return daqp.solve(np.eye(n_muscles), np.zeros(n_muscles), rows, above, below, sense)[0]


def _beyond_limits(arm: Arm, q: np.ndarray) -> list[str]:
    """Say, for each posture, which coordinates are beyond their limits, if any are."""
    over = np.maximum(arm.lower - q, q - arm.upper)
    out = [""] * len(q)
    for k in np.flatnonzero((over > LIMIT_TOLERANCE).any(axis=1)):
        parts = [
            f"{arm.joints[i]} by {np.degrees(over[k, i]):.1f} deg"
            for i in np.flatnonzero(over[k] > LIMIT_TOLERANCE)
        ]
        out[k] = f"; outside the joint limits: {', '.join(parts)}"
    return out


def _status(missing: np.ndarray, names: tuple[str, ...], beyond: str, converged: bool) -> Status:
    if not converged:
        return Status(False, "the solver did not converge" + beyond)
    short = np.flatnonzero(np.abs(missing) > TORQUE_TOLERANCE)
    if len(short) == 0:
        return Status(True, HELD + beyond)
    worst = short[np.argsort(-np.abs(missing[short]))][:3]
    parts = ", ".join(f"{names[i]} lacks {missing[i]:.3g} N m" for i in worst)
    return Status(False, f"no activation holds the posture: {parts}{beyond}")


def _like(name: str, value: ArrayLike, samples: np.ndarray, bound: float) -> np.ndarray:
    array = np.atleast_2d(as_float_array(name, value))
    require_shape(name, array, samples.shape)
    require_finite(name, array)
    if np.abs(array).max(initial=0.0) > bound:
        raise RangeError(f"{name}: {np.abs(array).max():g}; allowed is up to {bound:g} either way")
    return array
