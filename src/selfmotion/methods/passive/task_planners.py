"""Task-space planners: what pulls the hand towards its target.

"Any stable task-space force field can be used as a movement planner" ([Tommasino2017]). A planner
either moves the point that the spring K(t) is tied to, and may ask that its velocity be followed
exactly (the force B ẋ_d is then added, eq. 5), or it gives the force itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError

Points = Float[np.ndarray, "movements samples rows"]
Targets = Float[np.ndarray, "movements rows"]


@dataclass(frozen=True)
class TargetSpring:
    """Tie the spring to the target itself: the planner of the paper."""


@dataclass(frozen=True)
class MinimumJerk:
    """Move the point on a straight line with minimum jerk (Flash 1987), then rest.

    Attributes:
        duration: time that the point takes (s); None for the whole movement.
        follow: True: the hand keeps to the point exactly (force B ẋ_d added); False: the spring
            alone pulls, as in the equilibrium-point hypothesis, and the hand lags.
    """

    duration: float | None = None
    follow: bool = True

    def __post_init__(self) -> None:
        """Check the duration."""
        if self.duration is not None and not self.duration > 0.0:
            raise RangeError(f"duration = {self.duration:g} s: must be above 0")

    def reference(
        self, time: np.ndarray, start: Targets, targets: Targets
    ) -> tuple[Points, Points]:
        """Give points (B, S, m) and their velocities (per s) at times (S,)."""
        total = float(time[-1]) if self.duration is None else self.duration
        s = np.clip(time / total, 0.0, 1.0)
        share = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        rate = 30.0 * s**2 * (1.0 - s) ** 2 / total
        way = (targets - start)[:, None, :]
        return start[:, None, :] + share[:, None] * way, rate[:, None] * way


@dataclass(frozen=True, eq=False)
class ForceField:
    """Pull with any force field; stability is the field's own matter.

    Attributes:
        force: time (s), hand (B, m), targets (B, m) to forces (B, m) (N, or N m for angles).
    """

    force: Callable[[float, np.ndarray, np.ndarray], np.ndarray]

    def stiffness(self, t: float, x: Targets, targets: Targets) -> np.ndarray:
        """Give minus the derivative of the force by the hand's place, (B, m, m)."""
        step = 1e-6
        base = self.force(t, x, targets)
        columns = [(base - self.force(t, x + step * e, targets)) / step for e in np.eye(x.shape[1])]
        return np.stack(columns, axis=2)


@dataclass(frozen=True, eq=False)
class MovementPrimitive:
    """Reproduce the shape of a recorded path between any two points: a dynamic primitive.

    A critically damped spring to the goal with a learned forcing term (Ijspeert et al., Neural
    Computation 25:328, 2013), one for each row:
    ``T² ẍ = α(β(g - x) - T ẋ) + s (g - x₀) f(s)``, ``T ṡ = -a s``, here with the forcing scaled
    by the length of the way instead of row by row, so that a row that starts and ends at the
    same value keeps its shape; the shape turns with the way where the task is planar.

    Attributes:
        forcing: (basis, m) weights learned, for a way of unit length along the first axis.
        follow: as for :class:`MinimumJerk`.
        gain: α.
        decay: a.
    """

    forcing: Float[np.ndarray, "basis rows"]
    follow: bool = True
    gain: float = 25.0
    decay: float = 4.0
    n_substeps: int = field(default=8, repr=False)

    @classmethod
    def from_path(
        cls, time: ArrayLike, path: ArrayLike, *, n_basis: int = 30
    ) -> "MovementPrimitive":
        """Learn the forcing of a recorded path.

        Args:
            time: (K,) increasing (s).
            path: (K, m) positions; it should start and end at rest.
            n_basis: number of Gaussian basis functions.

        Raises:
            ShapeError: too few samples, or the arrays do not fit.
            RangeError: time does not increase, or the path ends where it starts.
        """
        t = as_float_array("time", time, ndim=1)
        x = as_float_array("path", path, ndim=2)
        require_shape("path", x, (len(t), None))
        require_finite("time", t)
        require_finite("path", x)
        if len(t) < n_basis:
            raise ShapeError(f"path: {len(t)} samples; at least {n_basis} (n_basis) are needed")
        if not (np.diff(t) > 0.0).all():
            raise RangeError("time: must increase strictly")
        way = x[-1] - x[0]
        if not np.linalg.norm(way) > 1e-9:
            raise RangeError("path: it ends where it starts, so that it has no way to scale")
        u = (t - t[0]) / (t[-1] - t[0])
        from scipy.interpolate import CubicSpline

        turned = (x - x[0]) @ _turn(way).T / np.linalg.norm(way)
        curve = CubicSpline(u, turned, bc_type="clamped")
        empty = cls(np.zeros((n_basis, x.shape[1])))
        s = np.exp(-empty.decay * u)
        goal = turned[-1]
        wanted = curve(u, 2) - empty.gain * (0.25 * empty.gain * (goal - turned) - curve(u, 1))
        basis = empty._basis(s)
        weights = np.linalg.lstsq(basis * s[:, None], wanted, rcond=None)[0]
        return cls(freeze(weights))

    def reference(
        self, time: np.ndarray, start: Targets, targets: Targets
    ) -> tuple[Points, Points]:
        """Give points (B, S, m) and their velocities (per s) at times (S,)."""
        m = self.forcing.shape[1]
        if targets.shape[1] != m:
            raise ShapeError(f"targets have {targets.shape[1]} rows, the primitive {m}")
        unit_way = np.zeros(m)
        unit_way[0] = 1.0
        u, n = time / time[-1], self.n_substeps
        state = np.zeros((2, m))
        shape = np.empty((len(u), 2, m))
        shape[0] = state
        for i in range(1, len(u)):
            h = (u[i] - u[i - 1]) / n
            for k in range(n):
                state = self._runge_kutta(u[i - 1] + k * h, state, h, unit_way)
            shape[i] = state
        way = targets - start
        length = np.linalg.norm(way, axis=1)
        points, speeds = np.empty((len(way), len(u), m)), np.empty((len(way), len(u), m))
        for b in range(len(way)):
            back = length[b] * (_turn(way[b]) if length[b] > 0.0 else np.eye(m))
            points[b] = start[b] + shape[:, 0] @ back
            speeds[b] = shape[:, 1] @ back / time[-1]
        return points, speeds

    def _runge_kutta(self, u: float, state: np.ndarray, h: float, goal: np.ndarray) -> np.ndarray:
        k1 = self._slope(u, state, goal)
        k2 = self._slope(u + 0.5 * h, state + 0.5 * h * k1, goal)
        k3 = self._slope(u + 0.5 * h, state + 0.5 * h * k2, goal)
        k4 = self._slope(u + h, state + h * k3, goal)
        return state + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)

    def _slope(self, u: float, state: np.ndarray, goal: np.ndarray) -> np.ndarray:
        s = np.exp(-self.decay * np.array([u]))
        push = (self._basis(s) * s[:, None] @ self.forcing)[0]
        x, v = state
        return np.stack([v, self.gain * (0.25 * self.gain * (goal - x) - v) + push])

    def _basis(self, s: np.ndarray) -> np.ndarray:
        centres = np.exp(-self.decay * np.linspace(0.0, 1.0, len(self.forcing)))
        widths = 1.0 / np.gradient(centres) ** 2
        psi = np.exp(-0.5 * widths * (s[:, None] - centres) ** 2)
        return psi / (psi.sum(axis=1, keepdims=True) + 1e-300)


Planner: TypeAlias = TargetSpring | MinimumJerk | MovementPrimitive | ForceField


def _turn(way: np.ndarray) -> np.ndarray:
    """Give the rotation that takes the direction of `way` to the first axis (identity past 3)."""
    m = len(way)
    a = way / np.linalg.norm(way)
    e = np.zeros(m)
    e[0] = 1.0
    total = a + e
    if np.dot(total, total) < 1e-16:  # opposite: half a turn in the plane of the first two axes
        R = np.eye(m)
        R[: min(m, 2), : min(m, 2)] *= -1.0
        return R
    # Rotation in the plane of a and e that leaves all else in place.
    return np.eye(m) - np.outer(total, total) / (1.0 + a[0]) + 2.0 * np.outer(e, a)
