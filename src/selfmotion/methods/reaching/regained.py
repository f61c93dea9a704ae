"""What each limit alone takes away, and how much of a workspace needs the arm inside the body."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import freeze
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.clear_arm import clear_places
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import ReachScreen, reach_options
from selfmotion.methods.reaching.volumes import Region

# Points that are looked at again at most.
MOST = 4096


@dataclass(frozen=True, eq=False)
class Share:
    """A part of a set, estimated from some of its points.

    Attributes:
        part: 0 to 1.
        standard_error: of the part, from the number of points.
        volume: of the part (m³).
        points: how many points it was estimated from.
    """

    part: float
    standard_error: float
    volume: float
    points: int


def regained_by_joint(
    free: Arm, limited: Arm, lost: Region, *, clear_of: BodyShapes | None = None
) -> dict[str, Share]:
    """Give how much of the lost region comes back if one joint alone had its free range.

    The parts need not add up to the whole: a point may need two joints at once, or either.

    Args:
        free: the arm with its free ranges.
        limited: the same arm with narrower ranges.
        lost: what the limits take away, of `workspace`.
        clear_of: body that the arm has to keep out of, too; left out: it need not.

    Returns:
        Joint name to the part that comes back, for each joint whose range is narrower.

    Raises:
        RangeError: there is no such joint.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.workspace import WorkspaceOptions, workspace
        >>> arm = load_arm("upper_limb")
        >>> brace = arm.with_limits({"elbow_flexion": (1.12, 1.99)})
        >>> space = workspace(arm, limited=brace, options=WorkspaceOptions(n_points=64, shifts=2))
        >>> regained_by_joint(arm, brace, space.regions["lost"])["elbow_flexion"].part
        1.0
    """
    narrower = np.flatnonzero((limited.lower > free.lower) | (limited.upper < free.upper))
    if not len(narrower):
        raise RangeError("limited: no joint has a narrower range than the free arm")
    points = some(lost.points[lost.inside])
    out = {}
    for j in narrower:
        joint = free.joints[j]
        arm = limited.with_limits({joint: (float(free.lower[j]), float(free.upper[j]))})
        back = np.zeros(len(points), dtype=np.bool_)
        task = HandRows(arm, ("x", "y", "z"))
        if len(points) and clear_of is not None:
            back = clear_places(task, points, clear_of)
        elif len(points):
            back = solve_ik(task, points, options=reach_options()).solved
        out[joint] = share_of(back, lost.volume)
    return out


def share_without_body(screen: ReachScreen, region: Region, body: BodyShapes) -> Share:
    """Give the part of a set for which no posture was found that keeps the arm out of the body.

    The volume counts the places of the hand. Upper arm and forearm may have to pass through
    thorax or head to get it there: such a place is looked at from several postures, and counts
    here if each of them enters the body. More postures could only make the part smaller.

    Args:
        screen: of the arm.
        region: what it reaches.
        body: shapes; thorax, neck and head count (see `BodyShapes.clearance`).
    """
    points = some(region.points[region.inside], MOST // 4)
    return share_of(~clear_places(screen.task, points, body), region.volume)


def some(points: Float[np.ndarray, "points 3"], most: int = MOST) -> Float[np.ndarray, "chosen 3"]:
    """Give at most so many of the points, evenly chosen."""
    return freeze(points[:: max(1, -(-len(points) // most))])


def share_of(chosen: Bool[np.ndarray, " points"], volume: float) -> Share:
    """Give the share of the points that were chosen; NaN where there are no points."""
    n = len(chosen)
    if not n:
        return Share(np.nan, np.nan, 0.0, 0)
    part = float(chosen.mean())
    return Share(part, float(np.sqrt(part * (1.0 - part) / n)), part * volume, n)
