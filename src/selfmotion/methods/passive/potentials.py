"""Joint-space potentials: what draws the arm to some postures, whatever the task.

[Tommasino2017] uses an elastic potential and says that others "can be simply added in parallel";
λ0 then keeps all of them out of the task. Here are the elastic one, gravity, joint limits, and any
scalar function of posture, such as muscle effort. A potential offers energy (J), its gradient
(N m, the torque that it would take to hold the posture against it) and its second derivative.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import JointSamples, as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.dynamics import gravity_torque, potential_energy

Energies = Float[np.ndarray, " samples"]
Hessians = Float[np.ndarray, "samples joints joints"]
# Step of central differences (rad or m): their error is of the order of its square.
STEP = 1e-4


class Potential(Protocol):
    """A function of posture that pulls the joints towards where it is small."""

    def energy(self, q: JointSamples) -> Energies:
        """Give the energy (J) of postures (K, n)."""
        ...

    def gradient(self, q: JointSamples) -> JointSamples:
        """Give its gradient (N m per joint; N for slides)."""
        ...

    def hessian(self, q: JointSamples) -> Hessians:
        """Give its second derivative; an approximation costs steps, not accuracy."""
        ...


@dataclass(frozen=True, eq=False)
class ElasticPotential:
    """A spring at every joint, and between joints: ½ (q - q*)ᵀ K^J (q - q*).

    Attributes:
        stiffness: (n, n) symmetric, positive definite (N m/rad).
        rest: (n,) posture without torque (rad).

    Raises:
        ShapeError: the arrays do not fit.
        RangeError: the stiffness is not symmetric or not positive definite.
    """

    stiffness: Float[np.ndarray, "joints joints"]
    rest: Float[np.ndarray, " joints"]

    def __post_init__(self) -> None:
        """Check both."""
        rest = as_float_array("rest", self.rest, ndim=1)
        require_finite("rest", rest)
        stiffness = positive_definite("stiffness", self.stiffness, len(rest))
        object.__setattr__(self, "stiffness", freeze(stiffness))
        object.__setattr__(self, "rest", freeze(rest.copy()))

    def energy(self, q: JointSamples) -> Energies:
        """Give the energy (J)."""
        away = q - self.rest
        return 0.5 * np.einsum("ki,ij,kj->k", away, self.stiffness, away)

    def gradient(self, q: JointSamples) -> JointSamples:
        """Give K^J (q - q*) (N m)."""
        return (q - self.rest) @ self.stiffness

    def hessian(self, q: JointSamples) -> Hessians:
        """Give K^J."""
        return np.broadcast_to(self.stiffness, (len(q), *self.stiffness.shape))


@dataclass(frozen=True, eq=False)
class GravityPotential:
    """The weight of the arm, or of the share of it that is not supported.

    Attributes:
        arm: with masses and centres of mass.
        share: factor on the weight, 1 for an arm without support.
    """

    arm: Arm
    share: float = 1.0

    def energy(self, q: JointSamples) -> Energies:
        """Give the energy (J)."""
        return self.share * potential_energy(self.arm, q)

    def gradient(self, q: JointSamples) -> JointSamples:
        """Give the torque that holds the arm (N m)."""
        return self.share * gravity_torque(self.arm, q)

    def hessian(self, q: JointSamples) -> Hessians:
        """Give its second derivative, by differences of the torque."""
        return differentiate_gradient(self.gradient, q)


@dataclass(frozen=True, eq=False)
class JointLimitPotential:
    """A wall inside each joint limit: ½ strength · (how far q is into the margin)².

    Attributes:
        lower: (n,) lower limits (rad or m).
        upper: (n,) upper limits.
        margin: width of the strip inside the limit in which the wall is felt (rad or m).
        strength: stiffness of the wall (N m/rad).

    Example:
        >>> wall = JointLimitPotential(np.array([-1.0]), np.array([1.0]), margin=0.1, strength=50.0)
        >>> wall.gradient(np.array([[0.0], [0.95], [-1.0]])).round(6).ravel().tolist()
        [0.0, 2.5, -5.0]
    """

    lower: Float[np.ndarray, " joints"]
    upper: Float[np.ndarray, " joints"]
    margin: float = 0.1
    strength: float = 10.0

    def __post_init__(self) -> None:
        """Check the range and the wall."""
        for name in ("margin", "strength"):
            if not getattr(self, name) >= 0.0:
                raise RangeError(f"{name} = {getattr(self, name):g}: allowed is 0 and above")
        room = np.asarray(self.upper) - np.asarray(self.lower)
        if not (room > 2.0 * self.margin).all():
            i = int(np.argmin(room))
            raise RangeError(
                f"margin = {self.margin:g}: joint {i} has a range of {room[i]:g}, which must be "
                "more than twice the margin"
            )

    def energy(self, q: JointSamples) -> Energies:
        """Give the energy (J)."""
        return 0.5 * self.strength * (self._depth(q) ** 2).sum(axis=1)

    def gradient(self, q: JointSamples) -> JointSamples:
        """Give the torque of the walls (N m)."""
        return self.strength * self._depth(q)

    def hessian(self, q: JointSamples) -> Hessians:
        """Give the stiffness of the walls that are felt."""
        return self.strength * (self._depth(q) != 0.0)[:, :, None] * np.eye(q.shape[1])

    def _depth(self, q: np.ndarray) -> np.ndarray:
        above = np.maximum(q - (self.upper - self.margin), 0.0)
        below = np.maximum((self.lower + self.margin) - q, 0.0)
        return above - below


@dataclass(frozen=True, eq=False)
class EffortPotential:
    """Any scalar function of posture, such as the muscle effort E(q), times a scale.

    Attributes:
        effort: postures (K, n) to values (K,).
        scale: joules that the value 1 counts as.
        step: step of the central differences that give the gradient (rad or m).
    """

    effort: Callable[[np.ndarray], np.ndarray]
    scale: float = 1.0
    step: float = field(default=STEP)

    def energy(self, q: JointSamples) -> Energies:
        """Give scale times effort."""
        return self.scale * np.asarray(self.effort(q), dtype=np.float64)

    def gradient(self, q: JointSamples) -> JointSamples:
        """Give the gradient by central differences."""
        n = q.shape[1]
        moved = np.concatenate([q + s * self.step * e for e in np.eye(n) for s in (1.0, -1.0)])
        values = self.energy(moved).reshape(n, 2, len(q))
        return ((values[:, 0] - values[:, 1]) / (2.0 * self.step)).T

    def hessian(self, q: JointSamples) -> Hessians:
        """Give the second derivative by differences, of all postures in one call."""
        n, h = q.shape[1], max(self.step, 1e-3)
        rows, columns = np.triu_indices(n)
        one = h * np.eye(n)
        two = one[rows] + one[columns]
        # f(+i+j) - f(+i) - f(+j) + f, and the same with all signs turned: second order in h.
        moves = np.concatenate([np.zeros((1, n)), one, -one, two, -two])
        values = self.energy((q[:, None] + moves).reshape(-1, n)).reshape(len(q), -1)
        middle, ahead, back = values[:, :1], values[:, 1 : n + 1], values[:, n + 1 : 2 * n + 1]
        both, neither = np.split(values[:, 2 * n + 1 :], 2, axis=1)
        single = ahead[:, rows] + ahead[:, columns] + back[:, rows] + back[:, columns]
        H = np.empty((len(q), n, n))
        H[:, rows, columns] = (both + neither - single + 2.0 * middle) / (2.0 * h * h)
        H[:, columns, rows] = H[:, rows, columns]
        return H


def differentiate_gradient(
    gradient: Callable[[np.ndarray], np.ndarray], q: JointSamples, *, step: float = STEP
) -> Hessians:
    """Give the symmetric second derivative of a potential from its gradient."""
    n = q.shape[1]
    columns = [(gradient(q + step * e) - gradient(q - step * e)) / (2.0 * step) for e in np.eye(n)]
    H = np.stack(columns, axis=2)
    return 0.5 * (H + np.swapaxes(H, 1, 2))


def positive_definite(name: str, value: object, n: int) -> Float[np.ndarray, "joints joints"]:
    """Check and give a symmetric positive definite matrix (n, n).

    Raises:
        ShapeError: the shape is wrong.
        NotFiniteError: an entry is not finite.
        RangeError: it is not symmetric, or an eigenvalue is not above 0.
    """
    matrix = as_float_array(name, value, ndim=2)  # pyright: ignore[reportArgumentType]
    require_shape(name, matrix, (n, n))
    require_finite(name, matrix)
    apart = np.abs(matrix - matrix.T)
    if apart.max() > 1e-9 * np.abs(matrix).max():
        i, j = (int(k) for k in np.unravel_index(int(apart.argmax()), apart.shape))
        raise RangeError(
            f"{name}[{i}, {j}] = {matrix[i, j]:g} but [{j}, {i}] = {matrix[j, i]:g}: "
            "the matrix must be symmetric"
        )
    matrix = 0.5 * (matrix + matrix.T)
    smallest = float(np.linalg.eigvalsh(matrix)[0])
    if not smallest > 1e-12 * np.abs(matrix).max():
        raise RangeError(
            f"{name}: its smallest eigenvalue is {smallest:g}; it must be positive definite"
        )
    return matrix
