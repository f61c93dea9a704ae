"""Plane cuts through a workspace, as a clinician looks at a person: from the side, from the front.

Axes are the person's right, forward and up (`BodyFrame`), from the ground's origin.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.reaching.boundary import BoundaryLimits, boundary_limits
from selfmotion.methods.reaching.clear_arm import clear_regions
from selfmotion.methods.reaching.volumes import Draw, PlacedBox, Region, decide_box, extent
from selfmotion.methods.workspace import Slice, Workspace

RIGHT, FORWARD, UP = 0, 1, 2
# How far before the shoulders the person is cut from side to side (shares of the stature).
FRONT = 0.15
# Points of one shift of a cut, and points of a cut whose boundary is asked for.
N_POINTS, N_BOUNDARY = 768, 6144


@dataclass(frozen=True, eq=False)
class PlaneCut:
    """A thin cut across one of the person's axes.

    Attributes:
        title: where it is.
        across: the axis that it cuts across: 0 right, 1 forward, 2 up.
        at: place along that axis (m).
        axes: (3, 3) columns are right, forward and up in the ground.
        regions: "free", and with a limited arm "limited" and "lost".
        boundary: which limits bound the limited arm there, or the free one where it is alone;
            None where it was not asked for.
    """

    title: str
    across: int
    at: float
    axes: Float[np.ndarray, "3 3"]
    regions: dict[str, Region]
    boundary: BoundaryLimits | None


def body_cuts(
    space: Workspace,
    *,
    clear_of: BodyShapes | None = None,
    rng: np.random.Generator | None = None,
) -> tuple[PlaneCut, ...]:
    """Cut a workspace through the shoulder from front to back, and before the body.

    Args:
        space: of `workspace`.
        clear_of: body that the arm has to keep out of, too; left out: it need not.
        rng: moves the points; left out: ``np.random.default_rng(0)``.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.workspace import WorkspaceOptions, workspace
        >>> options = WorkspaceOptions(n_points=64, shifts=2)
        >>> [cut.across for cut in body_cuts(workspace(load_arm("upper_limb"), options=options))]
        [0, 1]
    """
    frame = BodyFrame.of(space.arm)
    beside, ahead, _ = (frame.shoulder @ frame.axes).tolist()
    front = ahead + FRONT * frame.stature
    draw = np.random.default_rng(0) if rng is None else rng
    cuts = (
        _cut(space, "through the shoulder, from the side", RIGHT, beside, draw),
        _cut(
            space,
            f"{1e2 * FRONT * frame.stature:.0f} cm before the shoulders",
            FORWARD,
            front,
            draw,
        ),
    )
    if clear_of is None:
        return cuts
    return tuple(
        replace(cut, regions=clear_regions(space.screens, cut.regions, clear_of)) for cut in cuts
    )


def bounded_slices(
    space: Workspace, *, rng: np.random.Generator | None = None
) -> tuple[PlaneCut, ...]:
    """Give the slices of a workspace with the limits that bound them.

    Args:
        space: of `workspace`, with slices.
        rng: moves the points; left out: ``np.random.default_rng(0)``.
    """
    draw = np.random.default_rng(0) if rng is None else rng
    axes = BodyFrame.of(space.arm).axes
    return tuple(_of_slice(space, part, axes, draw) for part in space.slices)


def _of_slice(
    space: Workspace, part: Slice, axes: np.ndarray, rng: np.random.Generator
) -> PlaneCut:
    low, high = extent(space.screens[-1], axes, np.zeros(3))
    low[UP], high[UP] = part.height - 0.5 * part.thickness, part.height + 0.5 * part.thickness
    box = PlacedBox.between(low - [0.02, 0.02, 0.0], high + [0.02, 0.02, 0.0], axes)
    edge = boundary_limits(space.screens[0], box=box, n_points=N_BOUNDARY, rng=rng)
    # A point of the layer outside may have its nearest place on the boundary beside the slice.
    edge = edge.among(np.abs(edge.points @ axes[:, UP] - part.height) <= 0.5 * part.thickness)
    above = 1e2 * (part.height - float(BodyFrame.of(space.arm).shoulder @ axes[:, UP]))
    side = "above" if above > 0 else "below"
    title = f"{abs(above):.0f} cm {side} the shoulder" if abs(above) >= 0.5 else "shoulder height"
    return PlaneCut(title, UP, part.height, axes, part.regions, edge)


def _cut(
    space: Workspace, title: str, across: int, at: float, rng: np.random.Generator
) -> PlaneCut:
    options = space.options
    axes = BodyFrame.of(space.arm).axes
    low, high = extent(space.screens[-1], axes, np.zeros(3))
    low[across], high[across] = at - options.half_thickness, at + options.half_thickness
    draw = Draw(N_POINTS, options.shifts, options.threads, space.blocked, rng)
    found = decide_box(space.screens, PlacedBox.between(low, high, axes), draw)
    return PlaneCut(title, across, at, axes, found.regions, None)
