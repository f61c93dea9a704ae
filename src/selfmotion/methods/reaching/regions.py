"""Places that a clinician knows: the table, overhead, the mouth, the back, over the shoulder.

Each is a box in body coordinates (`BodyFrame`), as shares of the stature, so that it fits a small
and a tall person; sides may be open. The sizes are estimates of round numbers for an adult of
1.75 m, meant to be edited (`NamedRegion`, or the table ``regions`` of a person's TOML file).

Over the shoulder is a place and a way: behind the shoulders, with the elbow above the shoulder.
In [DeBoon] fig. 7 it is the island of points behind the person that only this way leads to.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import freeze
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.kinematics.forward import tip_positions
from selfmotion.methods.reaching.clear_arm import clear_places
from selfmotion.methods.reaching.ik_seeds import evenly, finite_limits
from selfmotion.methods.reaching.screen import ReachScreen, reach_options
from selfmotion.methods.reaching.volumes import (
    Draw,
    PlacedBox,
    Region,
    extent,
    shifted_points,
)
from selfmotion.methods.reaching.ways import Wanted, with_posture
from selfmotion.methods.workspace import Workspace

Way = Literal["any", "over", "under"]
WAYS: tuple[Way, ...] = ("any", "over", "under")
# Postures that lead to a region its way: so many are tried from, chosen among so many.
STARTS, CLIMBS, POSTURES = 10, 2, 4000
OPEN = np.inf


@dataclass(frozen=True)
class NamedRegion:
    """A place by its box, and the way in which the hand gets there.

    Attributes:
        name: a word, as in the document.
        title: what a clinician reads.
        outwards: from and to, outwards of the middle of the body (shares of the stature).
        forward: from and to, before the shoulders.
        up: from and to, above the shoulders.
        way: over: with the elbow above the shoulder; under: below it; any: it does not matter.

    Raises:
        RangeError: an end is not above its start, or a number is unknown.
        UnknownNameError: there is no such way.
    """

    name: str
    title: str
    outwards: tuple[float, float] = (-OPEN, OPEN)
    forward: tuple[float, float] = (-OPEN, OPEN)
    up: tuple[float, float] = (-OPEN, OPEN)
    way: Way = "any"

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.way not in WAYS:
            raise unknown_name(f"way of region {self.name!r}:", self.way, WAYS)
        for side in ("outwards", "forward", "up"):
            low, high = getattr(self, side)
            if not low < high:
                raise RangeError(
                    f"region {self.name!r}, {side} = {low:g} to {high:g}: the second number must "
                    "be above the first"
                )

    @property
    def bounded(self) -> bool:
        """Whether the box has no open side."""
        return bool(np.isfinite([self.outwards, self.forward, self.up]).all())


# Shares of the stature; for 1.75 m: 0.1 is 17.5 cm. The table stands 0.12 to 0.24 below the
# shoulders of someone who sits (elbow rest height; a table at 0.41 H over a seat at 0.25 H).
REGIONS = (
    NamedRegion("table", "In front, at table height", (-0.12, 0.28), (0.12, 0.40), (-0.24, -0.10)),
    NamedRegion("eye_level", "In front, at eye level", (-0.12, 0.28), (0.12, 0.40), (0.06, 0.16)),
    NamedRegion("overhead", "Above the head", up=(0.182, OPEN)),
    NamedRegion("face", "Mouth and face", (-0.06, 0.06), (0.075, 0.14), (0.05, 0.15)),
    NamedRegion("back_of_head", "Back of the head", (-0.07, 0.07), (-0.12, -0.03), (0.06, 0.18)),
    NamedRegion(
        "opposite_shoulder", "Opposite shoulder", (-0.17, -0.07), (0.00, 0.13), (-0.07, 0.06)
    ),
    NamedRegion(
        "over_shoulder",
        "Over the shoulder, behind the neck and between the shoulder blades",
        (-0.12, 0.16),
        (-0.25, -0.05),
        (-0.15, 0.06),
        "over",
    ),
    NamedRegion(
        "lower_back", "Small of the back", (-0.12, 0.12), (-0.20, -0.06), (-0.33, -0.20), "under"
    ),
    NamedRegion("side", "Out to the side", (0.22, OPEN), (-0.10, 0.12), (-0.15, 0.10)),
)


@dataclass(frozen=True, eq=False)
class RegionReach:
    """How much of a named region is reached.

    Attributes:
        region: which.
        space: volume of the box without the body (m³); of an open box, what lies within the reach
            of the free arm's box.
        sets: "free", and with a limited arm "limited" and "lost".
    """

    region: NamedRegion
    space: float
    sets: dict[str, Region]


def region_reach(
    space: Workspace,
    regions: Sequence[NamedRegion] = REGIONS,
    *,
    n_points: int = 256,
    stature: float | None = None,
    clear_of: BodyShapes | None = None,
    rng: np.random.Generator | None = None,
) -> tuple[RegionReach, ...]:
    """Find how much of each named region a workspace holds, by points of its own.

    Args:
        space: of `workspace`; its body, limits and number of shifts count.
        regions: which.
        n_points: points of one shift in a region.
        stature: of the person (m); left out: from the arm's lengths.
        clear_of: body that the arm has to keep out of, too; left out: it need not.
        rng: draws the shifts; left out: ``np.random.default_rng(0)``.

    Raises:
        RangeError: stature outside 0.5 to 2.5 m.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.workspace import WorkspaceOptions, workspace
        >>> options = WorkspaceOptions(n_points=64, shifts=2)
        >>> space = workspace(load_arm("upper_limb_anatomical"), options=options)
        >>> table = region_reach(space, REGIONS[:1], n_points=64)[0]
        >>> table.sets["free"].volume > 0.5 * table.space
        True
    """
    draw = Draw(
        n_points,
        space.options.shifts,
        space.options.threads,
        space.blocked,
        np.random.default_rng(0) if rng is None else rng,
    )
    frame = BodyFrame.of(space.arm, stature)
    return tuple(_reach(space.screens, region, frame, draw, clear_of) for region in regions)


def _reach(
    screens: tuple[ReachScreen, ...],
    region: NamedRegion,
    frame: BodyFrame,
    draw: Draw,
    clear_of: BodyShapes | None,
) -> RegionReach:
    """Decide points of one region, for the limited arm first."""
    box = _box(screens[-1], region, frame)
    if box is None:  # the box lies beyond all that can be reached
        return _beyond(screens, region, frame, draw)
    shares, shift = shifted_points(draw.n_points, draw.shifts, draw.rng)
    points = box.at(shares)
    counts = np.ones(len(points), dtype=np.bool_) if draw.blocked is None else ~draw.blocked(points)
    inside = np.zeros(len(points), dtype=np.bool_)
    sets: dict[str, Region] = {}
    for name, screen in zip(("limited", "free")[-len(screens) :], screens, strict=True):
        rows = np.flatnonzero(counts & ~inside)
        inside[rows] = decide_way(screen, points[rows], region.way, frame, draw.threads, clear_of)
        sets[name] = Region(name, points, freeze(inside.copy()), shift, box.volume)
    if "limited" in sets:
        lost = freeze(sets["free"].inside & ~sets["limited"].inside)
        sets = {"free": sets["free"], "limited": sets["limited"]}
        sets["lost"] = Region("lost", points, lost, shift, box.volume)
    return RegionReach(region, box.volume * float(counts.mean()), sets)


def decide_way(
    screen: ReachScreen,
    points: Float[np.ndarray, "points 3"],
    way: Way,
    frame: BodyFrame,
    threads: int,
    clear_of: BodyShapes | None = None,
) -> Bool[np.ndarray, " points"]:
    """Tell which points (K, 3) are reached, and if the way matters, that way.

    A point that was first reached the other way is tried again: the elbow is raised, or lowered,
    along the self-motion of the hand's place, from that posture and from others that go this way
    and have the hand near.
    """
    from scipy.spatial import KDTree

    reach = screen.decide(points, options=reach_options(threads=threads))
    if not reach.reachable.any() or (way == "any" and clear_of is None):
        return reach.reachable.copy()
    if way == "any" and clear_of is not None:
        return clear_places(screen.task, points, clear_of, threads=threads)
    arm = screen.task.arm
    clear = None if clear_of is None else clear_of.clearance(arm)
    sign = 1.0 if way == "over" else -1.0

    def height(q: Float[np.ndarray, "samples coords"]) -> np.ndarray:
        """Give how far the elbow is on the right side of the shoulder, and the arm clear (m)."""
        places = tip_positions(arm.chain, q, [arm.tip("shoulder"), arm.tip("elbow")])
        up = sign * ((places[:, 1] - places[:, 0]) @ frame.axes[:, 2])
        return up if clear is None else np.minimum(up, clear(q))

    postures = evenly(POSTURES, *finite_limits(arm))
    postures = postures[height(postures) > 0]
    hands = tip_positions(arm.chain, postures, [arm.tip(screen.task.landmark)])[:, 0]

    tree, count = KDTree(hands), len(postures)

    def near(x: np.ndarray, k: int) -> np.ndarray:
        return postures[np.reshape(tree.query(x, k=k + 1)[1], (len(x), -1))[:, k]]

    wanted = Wanted(height, near, min(STARTS, count), min(CLIMBS, count))
    out, rows = np.zeros(len(points), dtype=np.bool_), np.flatnonzero(reach.reachable)
    out[rows] = with_posture(screen.task, points[rows], reach.q[rows], wanted, threads=threads)
    return out


def _box(screen: ReachScreen, region: NamedRegion, frame: BodyFrame) -> PlacedBox | None:
    """Give the part of a region's box in which anything can be reached; a bounded one whole."""
    ends = frame.stature * np.array([region.outwards, region.forward, region.up])
    low, high = extent(screen, frame.outward_axes, frame.middle)
    if region.bounded:
        low, high = ends[:, 0], ends[:, 1]
    else:
        low, high = np.maximum(low, ends[:, 0]), np.minimum(high, ends[:, 1])
    if (low >= high).any():
        return None
    return PlacedBox.between(low, high, frame.outward_axes, frame.middle)


def _beyond(
    screens: tuple[ReachScreen, ...], region: NamedRegion, frame: BodyFrame, draw: Draw
) -> RegionReach:
    """Give a region of which nothing is reached, and which has no end."""
    whole = replace(region, outwards=(-1, 1), forward=(-1, 1), up=(-1, 1))
    box = _box(screens[-1], whole, frame)
    assert box is not None
    shares, shift = shifted_points(draw.n_points, draw.shifts, draw.rng)
    points, none = box.at(shares), freeze(np.zeros(len(shift), dtype=np.bool_))
    names = ["free"] if len(screens) == 1 else ["free", "limited", "lost"]
    return RegionReach(region, 0.0, {n: Region(n, points, none, shift, 0.0) for n in names})
