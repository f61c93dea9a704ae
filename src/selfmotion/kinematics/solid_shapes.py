"""Capsule, ellipsoid and box with the exact signed distance of points to their surface.

Distances (m) are Euclidean: positive outside, negative inside. All three bodies are convex, so
their signed distance is a convex function of the point and changes by at most the way that the
point moves.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import freeze, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.kinematics.ellipsoid_kernel import ellipsoid_distance

# How far axes may be from orthonormal.
ORTHONORMAL = 1e-9


@dataclass(frozen=True, eq=False)
class Capsule:
    """All points within a radius of a segment.

    Attributes:
        start: (3,) one end of the segment (m).
        end: (3,) the other end; the same point makes a ball.
        radius: m.

    Raises:
        RangeError: the radius is not positive, or an end is not finite.
    """

    start: Float[np.ndarray, "3"]
    end: Float[np.ndarray, "3"]
    radius: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        _store(self, "start", self.start, (3,))
        _store(self, "end", self.end, (3,))
        _require_positive("radius", self.radius)

    def distance(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give the signed distance (m) of points (K, 3) to the surface.

        Example:
            >>> Capsule(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.1).distance([[0.3, 0.0, 0.5]])
            array([0.2])
        """
        p = _points(points) - self.start
        along = self.end - self.start
        square = along @ along
        share = np.clip(p @ along / square, 0.0, 1.0) if square > 0 else np.zeros(len(p))
        return np.linalg.norm(p - share[:, None] * along, axis=1) - self.radius


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid.

    Attributes:
        centre: (3,) m.
        half: (3,) semi-axes (m).
        axes: (3, 3) columns are the directions of the semi-axes in the ground.

    Raises:
        RangeError: a semi-axis is not positive, or the axes are not orthonormal.
    """

    centre: Float[np.ndarray, "3"]
    half: Float[np.ndarray, "3"]
    axes: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        """Check the numbers."""
        _store_placed(self, self.centre, self.half, self.axes)

    def distance(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give the signed distance (m) of points (K, 3) to the surface, exact to rounding.

        The nearest surface point is x_i = h_i² y_i / (t + h_i²), where t is the largest root of
        Σ (h_i y_i / (t + h_i²))² = 1. With s = t + min h² no difference cancels where t is near
        its lower end, and Newton's steps on 1 / sqrt(Σ) - 1, concave and rising in s, come up to
        the root from below without ever passing it.

        Example:
            >>> egg = Ellipsoid(np.zeros(3), np.array([2.0, 1.0, 1.0]))
            >>> egg.distance([[5.0, 0.0, 0.0]]).round(12)
            array([3.])
        """
        return ellipsoid_distance((_points(points) - self.centre) @ self.axes, self.half)


@dataclass(frozen=True, eq=False)
class Box:
    """A box with sharp edges.

    Attributes:
        centre: (3,) m.
        half: (3,) half its edges (m).
        axes: (3, 3) columns are the directions of the edges in the ground.

    Raises:
        RangeError: an edge is not positive, or the axes are not orthonormal.
    """

    centre: Float[np.ndarray, "3"]
    half: Float[np.ndarray, "3"]
    axes: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        """Check the numbers."""
        _store_placed(self, self.centre, self.half, self.axes)

    def distance(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give the signed distance (m) of points (K, 3) to the surface.

        Example:
            >>> Box(np.zeros(3), np.ones(3)).distance([[4.0, 5.0, 0.0], [0.5, 0.0, 0.0]])
            array([ 5. , -0.5])
        """
        beyond = np.abs((_points(points) - self.centre) @ self.axes) - self.half
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        return outside + np.minimum(beyond.max(axis=1), 0.0)


Shape = Capsule | Ellipsoid | Box


def _points(points: ArrayLike) -> np.ndarray:
    array = np.asarray(points, dtype=np.float64)
    require_shape("points", array, (None, 3))
    return array


def _store(shape: object, name: str, value: ArrayLike, size: tuple[int, ...]) -> np.ndarray:
    array = np.array(value, dtype=np.float64)
    require_shape(name, array, size)
    require_finite(name, array)
    object.__setattr__(shape, name, freeze(array))
    return array


def _store_placed(shape: object, centre: ArrayLike, half: ArrayLike, axes: ArrayLike) -> None:
    _store(shape, "centre", centre, (3,))
    for value in _store(shape, "half", half, (3,)):
        _require_positive("half", value)
    A = _store(shape, "axes", axes, (3, 3))
    worst = float(np.abs(A.T @ A - np.eye(3)).max())
    if worst > ORTHONORMAL:
        raise RangeError(f"axes: {worst:.3g} from orthonormal; allowed is {ORTHONORMAL:g}")


def _require_positive(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise RangeError(f"{name} = {value:g} m: must be a positive number")
