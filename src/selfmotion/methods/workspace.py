"""The space that the hand can reach: volume, hull, slices, and what limits take away.

Points spread evenly over a box are each decided by inverse kinematics (`reach_screen`); the volume
is the share of the box that was reached. This converges, which neither the hull of random
postures nor an alpha shape does: the hull, drawn in [DeBoon] figs 6 to 9, is given beside it. The
standard error comes from the scatter over independent shifts of the points.

The limited arm is decided first, and what it reaches counts as reached by the free arm, whose
limits hold the limited ones: so the limited workspace lies inside the free one by construction,
and the lost region is a set of points of its own.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_between, require_finite
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_seeds import golden_steps
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import ReachScreen, reach_options, reach_screen
from selfmotion.provenance import Provenance, hash_arrays

if TYPE_CHECKING:
    import pandas as pd

# How far beyond the hull of the points its true place is looked for (m).
OUTWARDS = 0.03
# Points of space that do not count, as the inside of the body: (K, 3) to (K,).
Blocked = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class WorkspaceOptions:
    """How finely space is looked at.

    Attributes:
        n_points: points of one shift.
        shifts: independent shifts; their scatter is the standard error.
        slice_points: points of one shift of a slice.
        half_thickness: of a slice (m); the paper's is 10 mm.
        threads: how many threads share the points.

    Raises:
        RangeError: a number is too small to mean anything.
    """

    n_points: int = 8192
    shifts: int = 8
    slice_points: int = 256
    half_thickness: float = 0.01
    threads: int = 1

    def __post_init__(self) -> None:
        """Check the numbers."""
        require_between("n_points", self.n_points, 64, 10**8)
        require_between("shifts", self.shifts, 2, 10**4)
        require_between("slice_points", self.slice_points, 16, 10**8)
        require_between("half_thickness", self.half_thickness, 1e-6, 1.0)
        require_between("threads", self.threads, 1, 1024)


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


@dataclass(frozen=True, eq=False)
class Slice:
    """A thin horizontal slice: areas by the same rule as the volume.

    Attributes:
        height: middle of the slice (m).
        regions: free, limited and lost (the last two only where a limited arm was given); their
            `volume` divided by the thickness is the area.
        thickness: m.
    """

    height: float
    regions: dict[str, Region]
    thickness: float

    def area(self, name: str = "free") -> tuple[float, float]:
        """Give area and its standard error (m²)."""
        region = self.regions[name]
        return region.volume / self.thickness, region.standard_error / self.thickness


@dataclass(frozen=True, eq=False)
class Workspace:
    """What an arm reaches, and what a limited arm of the same person reaches.

    Attributes:
        arm: the free arm.
        limited_arm: the arm with its limits, or None.
        regions: "free", and with a limited arm "limited" and "lost".
        q: (K, n) a posture for each point reached by the free arm; NaN elsewhere.
        boundary: region name to (B, 3) points on the boundary (m), where postures stopped on the
            way to points out of reach.
        slices: by height.
        provenance: version, hashes, choices.
    """

    arm: Arm
    limited_arm: Arm | None
    regions: dict[str, Region]
    q: Float[np.ndarray, "points coords"]
    boundary: dict[str, Float[np.ndarray, "boundary 3"]]
    slices: tuple[Slice, ...]
    provenance: Provenance

    def hull_volume(self, name: str = "free") -> float:
        """Give the volume of the convex hull (m³): above the volume wherever there are hollows."""
        from scipy.spatial import ConvexHull

        region = self.regions[name]
        points = np.concatenate([region.points[region.inside], self.boundary.get(name, _NONE)])
        if len(points) < 4:
            return 0.0
        hull = ConvexHull(points)
        if name in self.boundary:  # reach outwards from the middle of each facet
            arm = self.limited_arm if name == "limited" and self.limited_arm else self.arm
            middles = hull.points[hull.simplices].mean(axis=1)
            beyond = solve_ik(
                HandRows(arm, ("x", "y", "z")),
                middles + OUTWARDS * hull.equations[:, :3],
                options=IkOptions(restarts=4),
            )
            ends = forward_kinematics(arm.chain, beyond.q, arm.tip("hand"))[:, :3, 3]
            hull = ConvexHull(np.concatenate([hull.points[hull.vertices], ends]))
        return float(hull.volume)

    def to_frame(self) -> "pd.DataFrame":
        """Give a table: volume, standard error, share and hull of each region (cm³, %)."""
        import pandas as pd

        free = self.regions["free"].volume
        rows = [
            {
                "region": name,
                "volume_cm3": 1e6 * r.volume,
                "standard_error_cm3": 1e6 * r.standard_error,
                "share_percent": 100.0 * r.volume / free if free else np.nan,
                "hull_volume_cm3": 1e6 * self.hull_volume(name) if name != "lost" else np.nan,
            }
            for name, r in self.regions.items()
        ]
        return pd.DataFrame(rows)

    def slices_frame(self) -> "pd.DataFrame":
        """Give a table: area and standard error of each region at each height (m, m²)."""
        import pandas as pd

        rows = []
        for s in self.slices:
            for name in s.regions:
                area, error = s.area(name)
                rows.append({"z": s.height, "region": name, "area_m2": area, "error_m2": error})
        return pd.DataFrame(rows, columns=["z", "region", "area_m2", "error_m2"])

    def summary(self) -> str:
        """Say in words how much is reached, kept and lost."""
        free = self.regions["free"]
        text = f"The free arm reaches {_litres(free)}."
        if self.limited_arm is None:
            return text
        limited, lost = self.regions["limited"], self.regions["lost"]
        kept = 100.0 * limited.volume / free.volume
        return (
            f"{text} With its limits it reaches {_litres(limited)}: {kept:.1f} % is kept and "
            f"{_litres(lost)} ({100.0 - kept:.1f} %) is lost, where help is needed."
        )


_NONE = np.zeros((0, 3))


def workspace(
    arm: Arm,
    *,
    limited: Arm | None = None,
    heights: ArrayLike = (),
    blocked: Blocked | None = None,
    options: WorkspaceOptions | None = None,
    rng: np.random.Generator | None = None,
) -> Workspace:
    """Find the space that the hand of an arm reaches, and what limits take from it.

    Args:
        arm: the arm with the limits of a free person.
        limited: the same arm with narrower limits (``arm.with_limits``).
        heights: heights of slices above the ground's origin (m).
        blocked: which points do not count, as the body's ``inside``; left out: none.
        options: how finely to look.
        rng: draws the shifts; left out: ``np.random.default_rng(0)``.

    Returns:
        The regions, with volumes and standard errors.

    Raises:
        RangeError: the limited arm may go where the free one may not; or nothing can be reached.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> arm = load_arm("upper_limb")
        >>> brace = arm.with_limits({"elbow_flexion": (1.12, 1.99)})
        >>> found = workspace(arm, limited=brace, options=WorkspaceOptions(n_points=64, shifts=2))
        >>> found.regions["limited"].volume < found.regions["free"].volume
        True
    """
    opts = options or WorkspaceOptions()
    draw = rng if rng is not None else np.random.default_rng(0)
    if limited is not None:
        _check_nested(arm, limited)
    screens = [
        reach_screen(HandRows(a, ("x", "y", "z")), n_points=256)
        for a in (limited, arm)
        if a is not None
    ]
    box = screens[-1].low, screens[-1].high
    regions, q, boundary, screens = _decide(screens, box, opts.n_points, opts, blocked, draw)
    if not regions["free"].inside.any():
        reason = "the body blocks all of it" if blocked else "the joint limits leave no volume"
        raise RangeError(f"empty workspace of {arm.name}: {reason}")
    slices = []
    for height in as_float_array("heights", heights, ndim=1):
        require_finite("heights", np.atleast_1d(height))
        low, high = box[0].copy(), box[1].copy()
        low[2], high[2] = height - opts.half_thickness, height + opts.half_thickness
        part = _decide(screens, (low, high), opts.slice_points, opts, blocked, draw)[0]
        slices.append(Slice(float(height), part, 2 * opts.half_thickness))
    limits = [a for s in screens for a in (s.task.arm.lower, s.task.arm.upper)]
    return Workspace(
        arm,
        limited,
        regions,
        q,
        boundary,
        tuple(slices),
        Provenance(
            "workspace",
            inputs={"limits": hash_arrays(*limits)},
            choices={"arm": arm.name, "n_points": opts.n_points, "shifts": opts.shifts},
        ),
    )


def _decide(
    screens: list[ReachScreen],
    box: tuple[np.ndarray, np.ndarray],
    n_points: int,
    options: WorkspaceOptions,
    blocked: Blocked | None,
    rng: np.random.Generator,
) -> tuple[dict[str, Region], np.ndarray, dict[str, np.ndarray], list[ReachScreen]]:
    """Decide all shifts of the points for the limited arm, if any, and then for the free one."""
    low, high = box
    points, shift = _shifted_points(n_points, options.shifts, rng)
    points = low + (high - low) * points
    counts = np.ones(len(points), dtype=np.bool_) if blocked is None else ~blocked(points)
    names = ["free"] if len(screens) == 1 else ["limited", "free"]
    inside = np.zeros(len(points), dtype=np.bool_)
    q = np.full((len(points), screens[-1].task.arm.n_joints), np.nan)
    regions, boundary, learned = {}, {}, []
    size = float(np.prod(high - low))
    for name, screen in zip(names, screens, strict=True):
        todo = np.flatnonzero(counts & ~inside)
        ends = []
        for rows in np.array_split(todo, options.shifts):
            reach = screen.decide(points[rows], options=reach_options(threads=options.threads))
            screen = screen.learn(reach)
            inside[rows], q[rows] = reach.reachable, reach.q
            ends.append(reach.q[~reach.reachable & np.isfinite(reach.distance)])
        q[~inside] = np.nan
        task = screen.task
        stopped = np.concatenate(ends)
        edge = forward_kinematics(task.arm.chain, stopped, task.arm.tip("hand"))[:, :3, 3]
        boundary[name] = edge if blocked is None else edge[~blocked(edge)]
        regions[name] = Region(name, points, freeze(inside.copy()), shift, size)
        learned.append(screen)
    if "limited" in regions:
        lost = regions["free"].inside & ~regions["limited"].inside
        ordered = {name: regions[name] for name in ("free", "limited")}
        regions = {**ordered, "lost": Region("lost", points, freeze(lost), shift, size)}
    return regions, freeze(q), boundary, learned


def _shifted_points(
    n_points: int, shifts: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Give points (shifts * n, 3) spread evenly over the unit cube.

    Each shift is moved, turned and mirrored at random, so that no pattern shows in pictures.
    """
    base = golden_steps(3) * np.arange(n_points)[:, None]
    parts = []
    for _ in range(shifts):
        steps = base[:, rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
        parts.append((steps + rng.random(3)) % 1.0)
    return np.concatenate(parts), freeze(np.repeat(np.arange(shifts), n_points))


def _check_nested(arm: Arm, limited: Arm) -> None:
    """Check that the limited arm goes nowhere where the free one does not."""
    if limited.joints != arm.joints:
        raise RangeError("limited: it must be the same arm with narrower limits")
    for j, joint in enumerate(arm.joints):
        if limited.lower[j] < arm.lower[j] or limited.upper[j] > arm.upper[j]:
            have = np.rad2deg([limited.lower[j], limited.upper[j]])
            allowed = np.rad2deg([arm.lower[j], arm.upper[j]])
            raise RangeError(
                f"limited range of {joint} {have[0]:.4g} to {have[1]:.4g} degrees: allowed is "
                f"within the free range {allowed[0]:.4g} to {allowed[1]:.4g}"
            )


def _litres(region: Region) -> str:
    return f"{1e3 * region.volume:.1f} ± {1e3 * region.standard_error:.1f} litres"
