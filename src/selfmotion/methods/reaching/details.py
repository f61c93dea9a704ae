"""All that is said of a workspace beside its volume: regions, boundary, joints, the arm's path."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.reaching.boundary import BoundaryLimits, boundary_limits
from selfmotion.methods.reaching.regained import Share, regained_by_joint, share_without_body
from selfmotion.methods.reaching.regions import REGIONS, NamedRegion, RegionReach, region_reach
from selfmotion.methods.reaching.sections import PlaneCut, body_cuts, bounded_slices
from selfmotion.methods.workspace import Workspace


@dataclass(frozen=True, eq=False)
class WorkspaceDetails:
    """What bounds a workspace and where it serves.

    Attributes:
        regions: named regions and what is reached of them.
        boundary: "free", and with a limited arm "limited": which limits bound it.
        regained: joint to what it alone would give back; empty without a limited arm.
        enters_body: "free" and "limited": the part for which no posture was found that keeps the
            arm out of the body; empty without a body, or where such places were left out.
        cuts: through the shoulder from front to back, and before the body.
        slices: those of the workspace, with the limits that bound them.
    """

    regions: tuple[RegionReach, ...]
    boundary: Mapping[str, BoundaryLimits]
    regained: Mapping[str, Share]
    enters_body: Mapping[str, Share]
    cuts: tuple[PlaneCut, ...]
    slices: tuple[PlaneCut, ...]


def workspace_details(
    space: Workspace,
    regions: Sequence[NamedRegion] = REGIONS,
    body: BodyShapes | None = None,
    stature: float | None = None,
    *,
    arm_outside: bool = False,
    rng: np.random.Generator | None = None,
) -> WorkspaceDetails:
    """Find what bounds a workspace, how named regions fare, and what each joint takes away.

    Args:
        space: of `workspace`.
        regions: named places.
        body: the shapes whose inside was `blocked`.
        stature: of the person (m); left out: from the arm's lengths.
        arm_outside: whether the workspace is one of `clear_of_body`: then places count here, too,
            only where the arm keeps out of the body. What bounds is told of the hand all the same.
        rng: moves the points; left out: ``np.random.default_rng(0)``.

    Raises:
        RangeError: stature outside 0.5 to 2.5 m.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.workspace import WorkspaceOptions, workspace
        >>> options = WorkspaceOptions(n_points=64, shifts=2)
        >>> space = workspace(load_arm("upper_limb_anatomical"), options=options)
        >>> list(workspace_details(space, REGIONS[:1]).boundary)
        ['free']
    """
    draw = np.random.default_rng(0) if rng is None else rng
    names = ("limited", "free")[-len(space.screens) :]
    screens = dict(sorted(zip(names, space.screens, strict=True)))
    clear_of = body if arm_outside else None
    regained = {}
    if space.limited_arm is not None:
        lost = space.regions["lost"]
        same = np.array_equal(space.arm.lower, space.limited_arm.lower) and np.array_equal(
            space.arm.upper, space.limited_arm.upper
        )
        if not same:
            regained = regained_by_joint(space.arm, space.limited_arm, lost, clear_of=clear_of)
    entering = {}
    if body is not None and not arm_outside:
        entering = {
            name: share_without_body(screen, space.regions[name], body)
            for name, screen in screens.items()
        }
    return WorkspaceDetails(
        region_reach(space, regions, stature=stature, clear_of=clear_of, rng=draw),
        {name: boundary_limits(s, body=body, rng=draw) for name, s in screens.items()},
        regained,
        entering,
        body_cuts(space, clear_of=clear_of, rng=draw),
        bounded_slices(space, rng=draw),
    )
