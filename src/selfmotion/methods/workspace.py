"""The space that the hand can reach: volume, hull, slices, and what limits take away.

Points spread evenly over a box are each decided by inverse kinematics (`reach_screen`); the volume
is the share of the box that was reached. This converges, which neither the hull of random
postures nor an alpha shape does: the hull, drawn in [DeBoon] figs 6 to 9, is given beside it. The
standard error comes from the scatter over independent shifts of the points.

The limited arm is decided first, and what it reaches counts as reached by the free arm, whose
limits hold the limited ones: so the limited workspace lies inside the free one by construction,
and the lost region is a set of points of its own.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_between, require_finite
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.kinematics.forward import forward_kinematics, frames_and_jacobian
from selfmotion.kinematics.threads import share
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_seeds import evenly, finite_limits
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import ReachScreen, reach_screen
from selfmotion.methods.reaching.volumes import Blocked, Draw, PlacedBox, Region, decide_box, extent
from selfmotion.provenance import Provenance, hash_arrays

if TYPE_CHECKING:
    import pandas as pd

# A joint with a narrower range cannot move (rad or m).
NO_RANGE = 1e-9
# Postures at which the directions of the hand are counted, and the least stretch (m/rad).
RANK_POSTURES, NO_STRETCH = 64, 1e-9
# A hull of a smaller share of the volume than this is one of too few points.
HULL_SHARE = 0.9
# How far beyond the hull of the points its true place is looked for (m).
OUTWARDS = 0.03


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
class Slice:
    """A thin horizontal slice: areas by the same rule as the volume.

    Attributes:
        height: middle of the slice above the ground's origin, along the arm's up (m).
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
        screens: that decided the points; the limited arm's, if there is one, stands first.
        blocked: which points did not count.
        options: how finely space was looked at.
    """

    arm: Arm
    limited_arm: Arm | None
    regions: dict[str, Region]
    q: Float[np.ndarray, "points coords"]
    boundary: dict[str, Float[np.ndarray, "boundary 3"]]
    slices: tuple[Slice, ...]
    provenance: Provenance
    screens: tuple[ReachScreen, ...]
    blocked: Blocked | None
    options: WorkspaceOptions

    def hull_volume(self, name: str = "free") -> float:
        """Give the volume of the convex hull (m³).

        It lies above the volume wherever there are hollows, and it does not respect the body: what
        `blocked` takes out of the volume lies within the hull and counts there. NaN where the
        points are so few that it comes out clearly below the volume.
        """
        from scipy.spatial import ConvexHull

        region, corners = self.regions[name], self.hull(name)
        if not len(corners):
            return 0.0
        volume = float(ConvexHull(corners).volume)
        return np.nan if volume < HULL_SHARE * region.volume else volume

    def hull(self, name: str = "free") -> Float[np.ndarray, "corners 3"]:
        """Give the corners of the convex hull (m); none where fewer than four points are known."""
        if name not in self._hulls:
            self._hulls[name] = self._hull(name)
        return self._hulls[name]

    @cached_property
    def _hulls(self) -> dict[str, np.ndarray]:
        return {}

    def _hull(self, name: str) -> np.ndarray:
        from scipy.spatial import ConvexHull

        region = self.regions[name]
        points = np.concatenate([region.points[region.inside], self.boundary.get(name, _NONE)])
        if len(points) < 4:
            return _NONE
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
        return hull.points[hull.vertices]

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
        if not self.regions["limited"].inside.any():
            return f"{text} With its limits it reaches no volume ({held_joints(self.limited_arm)})."
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
    screens = _screens([a for a in (limited, arm) if a is not None], opts.threads)
    _require_volume(arm)
    box = screens[-1].low, screens[-1].high
    points = Draw(opts.n_points, opts.shifts, opts.threads, blocked, draw)
    found = decide_box(screens, PlacedBox.between(*box), points)
    if not found.regions["free"].inside.any():
        raise RangeError(f"empty workspace of {arm.name}: {_why_empty(screens[-1], points)}")
    limits = [a for s in screens for a in (s.task.arm.lower, s.task.arm.upper)]
    return Workspace(
        arm,
        limited,
        found.regions,
        found.q,
        found.boundary,
        _slices(found.screens, as_float_array("heights", heights, ndim=1), opts, points),
        Provenance(
            "workspace",
            inputs={"limits": hash_arrays(*limits)},
            choices={"arm": arm.name, "n_points": opts.n_points, "shifts": opts.shifts},
        ),
        found.screens,
        blocked,
        opts,
    )


def _screens(arms: list[Arm], threads: int) -> tuple[ReachScreen, ...]:
    """Build the screens of arms, at the same time if there are threads."""
    made: dict[int, ReachScreen] = {}

    def work(first: int, last: int) -> None:
        for i in range(first, last):
            made[i] = reach_screen(HandRows(arms[i], ("x", "y", "z")), n_points=256)

    share(work, len(arms), threads, least=1)
    return tuple(made[i] for i in range(len(arms)))


def _slices(
    screens: tuple[ReachScreen, ...],
    heights: Float[np.ndarray, " heights"],
    options: WorkspaceOptions,
    draw: Draw,
) -> tuple[Slice, ...]:
    """Decide points of thin boxes across the arm's upward direction."""
    require_finite("heights", heights)
    axes = BodyFrame.of(screens[-1].task.arm).axes
    low, high = extent(screens[-1], axes, np.zeros(3))
    points = replace(draw, n_points=options.slice_points)
    slices = []
    for height in heights:
        low[2], high[2] = height - options.half_thickness, height + options.half_thickness
        part = decide_box(screens, PlacedBox.between(low, high, axes), points)
        slices.append(Slice(float(height), part.regions, 2 * options.half_thickness))
    return tuple(slices)


def _require_volume(arm: Arm) -> None:
    """Refuse an arm whose hand stays on a point, line or surface: it has no volume to count.

    Raises:
        RangeError: names the joints without a range, or says that the arm has too few.
    """
    q = evenly(RANK_POSTURES, *finite_limits(arm))
    J = frames_and_jacobian(arm.chain, q, arm.tip("hand"))[1][:, :3]
    J = J * (arm.upper - arm.lower >= NO_RANGE)
    stretch = np.linalg.svd(J, compute_uv=False)
    rank = int((stretch > NO_STRETCH).sum(axis=1).max())
    if rank == 3:
        return
    where = ("does not move", "moves on a line", "moves on a surface")[rank]
    held = held_joints(arm)
    reason = held if held.startswith("no range") else "its joints allow no more"
    raise RangeError(f"empty workspace of {arm.name}: no volume, the hand {where}; {reason}")


def _why_empty(screen: ReachScreen, draw: Draw) -> str:
    """Say which constraint leaves nothing: the body, or the limits of which joints."""
    arm = screen.task.arm
    box = PlacedBox.between(screen.low, screen.high)
    if draw.blocked is not None:
        bare = decide_box((screen,), box, replace(draw, blocked=None))
        if bare.regions["free"].inside.any():
            return "the body blocks all of it"
    return f"the joint limits leave no volume; {held_joints(arm)}"


def held_joints(arm: Arm) -> str:
    """Say which joints have no range, or how narrow the widest is.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> arm = load_arm("planar")
        >>> held_joints(arm.with_limits({"joint_1": (0.0, 0.0)}))
        'no range: joint_1'
    """
    width = arm.upper - arm.lower
    held = [j for j, w in zip(arm.joints, width, strict=True) if w < NO_RANGE]
    if held:
        return f"no range: {', '.join(held)}"
    widest = int(np.argmax(width))
    return f"the widest range, of {arm.joints[widest]}, is {np.rad2deg(width[widest]):.3g} degrees"


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
