"""Sets in space known at evenly spread points, and how such points are decided."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int

from selfmotion.arrays import freeze
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.reaching.ik_seeds import golden_steps
from selfmotion.methods.reaching.screen import ReachScreen

# Points of space that do not count, as the inside of the body: (K, 3) to (K,).
Blocked = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Region:
    """A set in space, known at points that are spread evenly over a box.

    Attributes:
        name: as in "free", "limited", "lost".
        points: (K, 3) all points looked at (m).
        inside: (K,) which of them belong to the set.
        shift: (K,) to which of the independent shifts a point belongs.
        box_volume: volume of the box (m³).
    """

    name: str
    points: Float[np.ndarray, "points 3"]
    inside: Bool[np.ndarray, " points"]
    shift: Int[np.ndarray, " points"]
    box_volume: float

    @property
    def volumes(self) -> Float[np.ndarray, " shifts"]:
        """Volume by each shift (m³)."""
        counts = np.bincount(self.shift)
        return self.box_volume * np.bincount(self.shift, self.inside) / counts

    @property
    def volume(self) -> float:
        """Volume (m³)."""
        return float(self.volumes.mean())

    @property
    def standard_error(self) -> float:
        """Standard error of the volume (m³)."""
        v = self.volumes
        return float(v.std(ddof=1) / np.sqrt(len(v)))

    @property
    def centroid(self) -> Float[np.ndarray, "3"]:
        """Mean of the points inside (m); NaN where there are none."""
        if not self.inside.any():
            return np.full(3, np.nan)
        return self.points[self.inside].mean(axis=0)

    def where(self, name: str, chosen: Bool[np.ndarray, " points"]) -> "Region":
        """Give the part of the set that is among some of its points."""
        inside = freeze(self.inside & chosen)
        return Region(name, self.points, inside, self.shift, self.box_volume)


@dataclass(frozen=True, eq=False)
class PlacedBox:
    """A box in the ground, in any direction.

    Attributes:
        corner: (3,) m.
        edges: (3, 3) columns lead from the corner along the edges (m).
    """

    corner: Float[np.ndarray, "3"]
    edges: Float[np.ndarray, "3 3"]

    @classmethod
    def between(
        cls,
        low: Float[np.ndarray, "3"],
        high: Float[np.ndarray, "3"],
        axes: Float[np.ndarray, "3 3"] | None = None,
        origin: Float[np.ndarray, "3"] | None = None,
    ) -> "PlacedBox":
        """Give the box from `low` to `high` along axes (columns); left out: the ground's."""
        A = np.eye(3) if axes is None else axes
        start = np.zeros(3) if origin is None else origin
        return cls(start + A @ low, A * (high - low))

    @property
    def volume(self) -> float:
        """Volume (m³)."""
        return float(abs(np.linalg.det(self.edges)))

    def at(self, shares: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
        """Give points by their shares (0 to 1) of the edges."""
        return self.corner + shares @ self.edges.T


@dataclass(frozen=True, eq=False)
class Draw:
    """How many points are drawn, and what is no space.

    Attributes:
        n_points: of one shift.
        shifts: independent shifts.
        threads: that share the points.
        blocked: which points do not count.
        rng: draws the shifts.
    """

    n_points: int
    shifts: int
    threads: int
    blocked: Blocked | None
    rng: np.random.Generator


@dataclass(frozen=True, eq=False)
class Decided:
    """What was decided about the points of a box.

    Attributes:
        regions: "free", or "free", "limited" and "lost".
        q: (K, n) a posture for each point reached by the free arm; NaN elsewhere.
        boundary: name to (B, 3) where postures stopped on the way to points out of reach.
        screens: those that decided, with what they learned; the free arm's last.
    """

    regions: dict[str, Region]
    q: Float[np.ndarray, "points coords"]
    boundary: dict[str, Float[np.ndarray, "boundary 3"]]
    screens: tuple[ReachScreen, ...]


def decide_box(screens: tuple[ReachScreen, ...], box: PlacedBox, draw: Draw) -> Decided:
    """Decide points spread over a box, for the limited arm, if any, and then for the free one.

    Args:
        screens: of the limited arm and of the free arm, or of the free arm alone.
        box: where.
        draw: how many points.
    """
    shares, shift = shifted_points(draw.n_points, draw.shifts, draw.rng)
    points = box.at(shares)
    counts = np.ones(len(points), dtype=np.bool_) if draw.blocked is None else ~draw.blocked(points)
    names = ["free"] if len(screens) == 1 else ["limited", "free"]
    inside = np.zeros(len(points), dtype=np.bool_)
    q = np.full((len(points), screens[-1].task.arm.n_joints), np.nan)
    regions, boundary, learned = {}, {}, []
    for name, screen in zip(names, screens, strict=True):
        todo = np.flatnonzero(counts & ~inside)
        reach, screen = screen.explore(points[todo], threads=draw.threads)
        inside[todo], q[todo] = reach.reachable, reach.q
        q[~inside] = np.nan
        task, stopped = screen.task, reach.q[~reach.reachable & np.isfinite(reach.distance)]
        edge = forward_kinematics(task.arm.chain, stopped, task.arm.tip("hand"))[:, :3, 3]
        boundary[name] = edge if draw.blocked is None else edge[~draw.blocked(edge)]
        regions[name] = Region(name, points, freeze(inside.copy()), shift, box.volume)
        learned.append(screen)
    if "limited" in regions:
        lost = regions["free"].inside & ~regions["limited"].inside
        ordered = {name: regions[name] for name in ("free", "limited")}
        regions = {**ordered, "lost": Region("lost", points, freeze(lost), shift, box.volume)}
    return Decided(regions, freeze(q), boundary, tuple(learned))


def extent(
    screen: ReachScreen, axes: Float[np.ndarray, "3 3"], origin: Float[np.ndarray, "3"]
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Give how far what is reached extends along axes (columns), from an origin (m)."""
    corners = np.array(list(product(*np.stack([screen.low, screen.high], axis=1))))
    along = (corners - origin) @ axes
    return along.min(axis=0), along.max(axis=0)


def shifted_points(
    n_points: int, shifts: int, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "points 3"], Int[np.ndarray, " points"]]:
    """Give points (shifts * n, 3) spread evenly over the unit cube, and their shifts.

    Each shift is moved, turned and mirrored at random, so that no pattern shows in pictures.
    """
    base = golden_steps(3) * np.arange(n_points)[:, None]
    parts = []
    for _ in range(shifts):
        steps = base[:, rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
        parts.append((steps + rng.random(3)) % 1.0)
    return np.concatenate(parts), freeze(np.repeat(np.arange(shifts), n_points))
