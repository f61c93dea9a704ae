"""Recorded hand positions against a workspace: how deep inside, how far outside, what was used.

[DeBoon] figs 6 to 9 lay measured points over the simulated workspace by eye; here each point has a
signed distance to the workspace: outside, how far inverse kinematics stays short of it; inside,
minus the distance to the nearest known point of the boundary, so that depths are over by about the
spacing of those points at most (`CloudReach.spacing`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import freeze
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.envelope import checked_points
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.workspace import Workspace

if TYPE_CHECKING:
    import pandas as pd
    from scipy.spatial import KDTree

# A point is reached when the hand comes as near as this (m).
REACHED = 1e-5
# Space counts as used where a recorded point is as near as this (m).
USED = 0.05


@dataclass(frozen=True, eq=False)
class CloudReach:
    """One cloud of recorded points against a workspace.

    Attributes:
        name: of the recording.
        region: "free" or "limited".
        points: (K, 3) m.
        distance: (K,) signed distance to the workspace (m): above 0 outside, below 0 inside.
        in_body: (K,) which points lie inside the body's shapes, where the workspace has a body.
        used: share of the workspace within 50 mm of a point, and its standard error.
        spacing: median distance between neighbours of the boundary's known points (m).
        sides: share of the points in front of the shoulder, above it, and outwards of it.
    """

    name: str
    region: str
    points: Float[np.ndarray, "points 3"]
    distance: Float[np.ndarray, " points"]
    in_body: Bool[np.ndarray, " points"]
    used: tuple[float, float]
    spacing: float
    sides: Mapping[str, float]

    @property
    def inside(self) -> Bool[np.ndarray, " points"]:
        """Which points are reached."""
        return self.distance <= 0

    def row(self) -> dict[str, object]:
        """Give the numbers of a table's row: shares in %, distances in mm."""
        d, inside = 1e3 * self.distance, self.inside
        outside = d[~inside]
        return {
            "recording": self.name,
            "workspace": self.region,
            "points": len(d),
            "inside_percent": 100.0 * float(inside.mean()),
            "outside_median_mm": float(np.median(outside)) if len(outside) else 0.0,
            "outside_most_mm": float(outside.max()) if len(outside) else 0.0,
            "depth_median_mm": float(np.median(-d[inside])) if inside.any() else np.nan,
            "in_body_percent": 100.0 * float(self.in_body.mean()),
            "used_percent": 100.0 * self.used[0],
            "used_error_percent": 100.0 * self.used[1],
            **{f"{side}_percent": 100.0 * share for side, share in self.sides.items()},
        }


def compare_clouds(
    space: Workspace, clouds: Mapping[str, ArrayLike], *, region: str = "free", threads: int = 1
) -> tuple[CloudReach, ...]:
    """Hold recorded positions against a workspace.

    Args:
        space: of `workspace`.
        clouds: name of a recording to its hand positions (K, 3) in the arm's ground (m).
        region: "free" or "limited".
        threads: how many threads share the points.

    Returns:
        One comparison a recording.

    Raises:
        UnknownNameError: the workspace has no such region.
        RangeError: a recording has no point.
        NotFiniteError: a point is not finite.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.workspace import WorkspaceOptions, workspace
        >>> few = WorkspaceOptions(n_points=128, shifts=2)
        >>> space = workspace(load_arm("upper_limb"), options=few)
        >>> found = compare_clouds(space, {"a": [[0.2, 0.4, 0.0], [0.2, 0.4, 0.9]]})
        >>> found[0].inside.tolist()
        [True, False]
    """
    names = [name for name in ("free", "limited") if name in space.regions]
    if region not in names:
        raise unknown_name("region", region, names)
    arm = space.limited_arm if region == "limited" and space.limited_arm else space.arm
    return tuple(
        _compared(space, arm, region, (name, checked_points(points)), threads)
        for name, points in clouds.items()
    )


def clouds_frame(clouds: tuple[CloudReach, ...]) -> "pd.DataFrame":
    """Give a table, one row a recording: shares in %, distances in mm."""
    import pandas as pd

    return pd.DataFrame([cloud.row() for cloud in clouds])


def out_of_reach(
    arm: Arm, points: Float[np.ndarray, "points 3"], *, threads: int = 1
) -> Float[np.ndarray, " points"]:
    """Give how far the hand stays short of points (m); 0 where it reaches them."""
    options = IkOptions(position_tolerance=REACHED, threads=threads)
    found = solve_ik(HandRows(arm, ("x", "y", "z")), points, options=options)
    return np.where(found.solved, 0.0, found.position_error)


def _compared(
    space: Workspace, arm: Arm, region: str, cloud: tuple[str, np.ndarray], threads: int
) -> CloudReach:
    from scipy.spatial import KDTree

    name, points = cloud
    if not len(points):
        raise RangeError(f"recording {name!r}: 0 points; at least one is needed")
    distance = out_of_reach(arm, points, threads=threads)
    edge = space.boundary[region]
    spacing = np.nan
    inside = distance <= 0
    if len(edge) > 1:
        tree = KDTree(edge)
        distance[inside] = -tree.query(points[inside])[0]
        spacing = float(np.median(tree.query(edge, k=2)[0][:, 1]))
    body = np.zeros(len(points), dtype=np.bool_)
    if space.blocked is not None:
        body = np.asarray(space.blocked(points))
    return CloudReach(
        name,
        region,
        points,
        freeze(distance),
        freeze(body),
        _used(space, region, KDTree(points)),
        spacing,
        _sides(arm, points),
    )


def _used(space: Workspace, region: str, tree: "KDTree") -> tuple[float, float]:
    """Give the share of a region within `USED` of the cloud, and its standard error."""
    known = space.regions[region]
    rows = np.flatnonzero(known.inside)
    near = np.isfinite(tree.query(known.points[rows], distance_upper_bound=USED)[0])
    n_shifts = int(known.shift.max()) + 1
    counts = np.bincount(known.shift[rows], minlength=n_shifts)
    shares = np.bincount(known.shift[rows], near, minlength=n_shifts) / np.maximum(counts, 1)
    return float(near.mean()), float(shares.std(ddof=1) / np.sqrt(n_shifts))


def _sides(arm: Arm, points: np.ndarray) -> dict[str, float]:
    """Give the shares of points in front of, above and outwards of the shoulder."""
    frame = BodyFrame.of(arm)
    away = (points - frame.shoulder) @ frame.axes
    return {
        "in_front": float((away[:, 1] > 0).mean()),
        "above": float((away[:, 2] > 0).mean()),
        "outwards": float((frame.side * away[:, 0] > 0).mean()),
    }
