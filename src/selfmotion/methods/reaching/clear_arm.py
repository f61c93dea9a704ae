"""What is left of a workspace if upper arm and forearm, too, keep out of the body.

`workspace(..., blocked=body.inside)` keeps the hand out of the body; the arm behind it may still
pass through chest or head. Here a place counts only if a posture was found whose segments are
clear of the body (`BodyShapes.clearance`, by which natural postures are judged). That is a search
(`with_posture`), so what is left is a lower bound, and what the hand reaches an upper one.

What bounds the workspace, its hull, and what recordings are held against stay those of the hand.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import freeze
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.ik_seeds import evenly, finite_limits
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import ReachScreen, reach_options
from selfmotion.methods.reaching.volumes import Region
from selfmotion.methods.reaching.ways import Wanted, with_posture
from selfmotion.methods.workspace import Slice, Workspace

# Postures tried at a place, and how many of them are changed along the self-motion.
TRIES, CLIMBS = 12, 4
# Points that are looked at together.
CHUNK = 4096
# Places (K, 3), reached by an arm, to whether its segments can keep out of the body there.
Clear = Callable[[HandRows, np.ndarray], np.ndarray]


def clear_places(
    task: HandRows,
    points: Float[np.ndarray, "points 3"],
    body: BodyShapes,
    *,
    threads: int = 1,
) -> Bool[np.ndarray, " points"]:
    """Tell at which places that the hand reaches a posture was found whose arm is clear.

    Args:
        task: position of the hand.
        points: places (m); those out of reach are not clear.
        body: shapes; thorax, neck and head count (see `BodyShapes.clearance`).
        threads: how many threads share the points.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> arm = load_arm("upper_limb_anatomical")
        >>> task = HandRows(arm, ("x", "y", "z"))
        >>> clear_places(task, np.array([[0.2, 0.4, -0.2]]), BodyShapes.of(arm))
        array([ True])
    """
    starts = evenly(TRIES, *finite_limits(task.arm))
    clear = body.clearance(task.arm)
    wanted = Wanted(clear, lambda x, k: np.repeat(starts[k : k + 1], len(x), axis=0), TRIES, CLIMBS)
    out = np.zeros(len(points), dtype=np.bool_)
    for rows in np.array_split(np.arange(len(points)), max(1, -(-len(points) // CHUNK))):
        found = solve_ik(task, points[rows], options=reach_options(threads=threads))
        met = rows[found.solved]
        q = found.q[found.solved]
        out[met] = with_posture(task, points[met], q, wanted, threads=threads)
    return out


def clear_of_body(space: Workspace, body: BodyShapes) -> Workspace:
    """Give the workspace of a hand whose arm keeps out of the body, too.

    The limited arm's postures are the free one's, too: what it reaches so, the free arm does.

    Args:
        space: of `workspace`, the inside of the body blocked.
        body: the same body.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.workspace import WorkspaceOptions, workspace
        >>> arm = load_arm("upper_limb")
        >>> body, few = BodyShapes.of(arm), WorkspaceOptions(n_points=64, shifts=2)
        >>> whole = workspace(arm, blocked=body.inside, options=few)
        >>> clear = clear_of_body(whole, body)
        >>> 0 < clear.regions["free"].volume <= whole.regions["free"].volume
        True
    """
    threads = space.options.threads
    regions = clear_regions(space.screens, space.regions, body, threads=threads)
    slices = tuple(
        Slice(
            part.height,
            clear_regions(space.screens, part.regions, body, threads=threads),
            part.thickness,
        )
        for part in space.slices
    )
    q = np.where(regions["free"].inside[:, None], space.q, np.nan)
    provenance = replace(
        space.provenance, choices={**space.provenance.choices, "arm_outside": True}
    )
    return replace(space, regions=regions, slices=slices, q=freeze(q), provenance=provenance)


def clear_regions(
    screens: tuple[ReachScreen, ...],
    regions: dict[str, Region],
    body: BodyShapes,
    *,
    threads: int = 1,
) -> dict[str, Region]:
    """Give regions ("free", or "free", "limited" and "lost") without places that are not clear.

    Args:
        screens: of the limited arm and of the free arm, or of the free arm alone.
        regions: sets of the same points.
        body: shapes.
        threads: how many threads share the points.
    """
    names = ("limited", "free")[-len(screens) :]
    inside = np.zeros(len(regions["free"].points), dtype=np.bool_)
    out = {}
    for name, screen in zip(names, screens, strict=True):
        region = regions[name]
        rows = np.flatnonzero(region.inside & ~inside)
        inside[rows] = clear_places(screen.task, region.points[rows], body, threads=threads)
        out[name] = region.where(name, inside)
    if len(screens) == 1:
        return out
    lost = regions["free"].where("lost", out["free"].inside & ~out["limited"].inside)
    return {"free": out["free"], "limited": out["limited"], "lost": lost}
