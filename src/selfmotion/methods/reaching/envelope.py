"""The envelope of a workspace seen from a centre: how far out the hand gets in each direction.

Two kinds: ``outermost``, the farthest point reached along a ray, so that the envelope holds all
that is reached, and hollows besides; ``unbroken``, as far as all is reached along the ray, so that
it holds no hollow, but not what lies behind one. Between the directions looked at, the envelope is
a closed surface of flat triangles: its gauge (0 at the centre, 1 on the surface) is linear over
the cone of each triangle, and so continuous everywhere.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import (
    as_float_array,
    freeze,
    require_between,
    require_finite,
    require_shape,
)
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.joint_limited_ik import IkOptions
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import ReachScreen, reach_options, reach_screen

if TYPE_CHECKING:
    from scipy.spatial import KDTree

Kind = Literal["outermost", "unbroken"]
KINDS = ("outermost", "unbroken")
# Radii tried along a ray, halvings of the last step (down to 0.1 mm), and triangles looked at for
# a direction.
RADII, HALVINGS, NEAR = 24, 10, 8
# A radius below this (m) makes the centre useless.
LEAST_RADIUS = 0.01


@dataclass(frozen=True, eq=False)
class Envelope:
    """A star-shaped surface of triangles around a centre.

    Attributes:
        centre: (3,) m.
        directions: (V, 3) unit vectors.
        faces: (F, 3) which of them span a triangle.
        radius: (V,) distance of the surface in these directions (m).
    """

    centre: Float[np.ndarray, "3"]
    directions: Float[np.ndarray, "vertices 3"]
    faces: Int[np.ndarray, "faces 3"]
    radius: Float[np.ndarray, " vertices"]

    @property
    def vertices(self) -> Float[np.ndarray, "vertices 3"]:
        """Corners of the surface (m)."""
        return self.centre + self.radius[:, None] * self.directions

    @property
    def volume(self) -> float:
        """Volume inside (m³)."""
        corners = (self.radius[:, None] * self.directions)[self.faces]
        return float(np.linalg.det(corners).sum() / 6.0)

    @cached_property
    def _inverse(self) -> np.ndarray:
        """Matrices (F, 3, 3) that give the shares of a vector in the corners of each cone."""
        return np.linalg.inv((self.radius[:, None] * self.directions)[self.faces].mT)

    @cached_property
    def _tree(self) -> "KDTree":
        from scipy.spatial import KDTree

        middle = self.directions[self.faces].mean(axis=1)
        return KDTree(middle / np.linalg.norm(middle, axis=1, keepdims=True))

    def gauge(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give the share (K,) of the way to the surface at which points (K, 3) lie.

        0 at the centre, 1 on the surface, above 1 outside.

        Raises:
            ShapeError: the points are not (K, 3).
            NotFiniteError: a point is not finite.
        """
        v = checked_points(points) - self.centre
        length = np.linalg.norm(v, axis=1)
        out = np.zeros(len(v))
        rows = np.flatnonzero(length > 0)
        if not len(rows):
            return out
        near = np.reshape(self._tree.query(v[rows] / length[rows, None], k=NEAR)[1], (-1, NEAR))
        shares = np.einsum("kfij,kj->kfi", self._inverse[near], v[rows])
        # The cone that holds the vector: none of its shares is negative.
        best = np.argmax(shares.min(axis=2), axis=1)
        out[rows] = shares[np.arange(len(rows)), best].sum(axis=1)
        return out


def reach_envelope(
    arm: Arm,
    centre: ArrayLike,
    *,
    kind: Kind = "outermost",
    subdivisions: int = 3,
    threads: int = 1,
) -> Envelope:
    """Find how far out the hand gets in all directions from a centre.

    Args:
        arm: with the limits that hold.
        centre: (3,) m.
        kind: outermost or unbroken.
        subdivisions: of the icosahedron whose corners are the directions: 3 gives 642, 8 degrees
            apart; 4 gives 2562.
        threads: how many threads share the points.

    Raises:
        RangeError: nothing is reached in some direction: choose another centre.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> envelope = reach_envelope(load_arm("upper_limb"), [0.2, 0.3, 0.0], subdivisions=1)
        >>> bool(abs(envelope.gauge(envelope.vertices) - 1).max() < 1e-12)
        True
    """
    require_between("subdivisions", subdivisions, 0, 6)
    if kind not in KINDS:
        raise unknown_name("kind of envelope", kind, KINDS)
    middle = as_float_array("centre", centre, ndim=1)
    require_shape("centre", middle, (3,))
    require_finite("centre", middle)
    screen = reach_screen(HandRows(arm, ("x", "y", "z")), n_points=1024)
    directions, faces = icosphere(subdivisions)
    radius = _radii(screen, middle, directions, kind, reach_options(threads=threads))
    if radius.min() < LEAST_RADIUS:
        worst = " ".join(f"{c:.2f}" for c in directions[int(np.argmin(radius))])
        where = " ".join(f"{1e3 * c:.0f}" for c in middle)
        raise RangeError(
            f"centre {where} mm: {arm.name} reaches nothing in the direction {worst}; allowed is a "
            "centre inside the workspace"
        )
    return Envelope(freeze(middle), freeze(directions), freeze(faces), freeze(radius))


def _radii(
    screen: ReachScreen, middle: np.ndarray, directions: np.ndarray, kind: Kind, options: IkOptions
) -> Float[np.ndarray, " vertices"]:
    """Give the distance of the envelope in each direction; 0 where nothing is reached."""
    corners = np.stack([screen.low - middle, screen.high - middle])
    farthest = np.linalg.norm(np.abs(corners).max(axis=0))
    radii = farthest * np.arange(RADII + 1) / RADII
    points = middle + radii[1:, None, None] * directions
    reached = screen.decide(points.reshape(-1, 3), options=options).reachable.reshape(RADII, -1)
    if kind == "outermost":
        last = np.where(reached.any(axis=0), RADII - np.argmax(reached[::-1], axis=0), 0)
    else:
        last = np.where(reached.all(axis=0), RADII, np.argmin(reached, axis=0))
    low = radii[last]
    high = low + farthest / RADII
    for _ in range(HALVINGS):
        tried = 0.5 * (low + high)
        found = screen.decide(middle + tried[:, None] * directions, options=options).reachable
        low, high = np.where(found, tried, low), np.where(found, high, tried)
    return low


def icosphere(subdivisions: int) -> tuple[Float[np.ndarray, "vertices 3"], Int[np.ndarray, "f 3"]]:
    """Give corners on the unit sphere and triangles, outwards, of a divided icosahedron."""
    from scipy.spatial import ConvexHull

    g = 0.5 * (1 + 5**0.5)
    signs = [(a, b) for a in (-1.0, 1.0) for b in (-g, g)]
    corners = np.array([row for a, b in signs for row in ((0, a, b), (a, b, 0), (b, 0, a))])
    vertices = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    for _ in range(subdivisions):
        faces = ConvexHull(vertices).simplices
        edges = np.unique(
            np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0
        )
        middle = vertices[edges].mean(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        vertices = np.concatenate([vertices, middle])
    faces = ConvexHull(vertices).simplices.astype(np.int64)
    inwards = np.linalg.det(vertices[faces]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return vertices, faces


def checked_points(points: ArrayLike) -> Float[np.ndarray, "points 3"]:
    """Give points as (K, 3) finite numbers."""
    x = np.atleast_2d(as_float_array("points", points))
    require_shape("points", x, (None, 3))
    require_finite("points", x)
    return x
