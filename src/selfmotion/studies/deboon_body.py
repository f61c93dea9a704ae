"""Head, torso and legs in the workspace of [DeBoon], and the way over the shoulder.

The paper cuts head, torso and legs out of the slices of figs 7 to 9, without sizes; here they are
the shapes of `BodyShapes`, those of someone who stands. Fig. 7 puts an island of points behind the
person into a dashed box: places that are reached over the shoulder only. Here such places are
those that no posture with the elbow below the shoulder was found for.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from jaxtyping import Bool

from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.reaching.regions import REGIONS, RegionReach, decide_way, region_reach
from selfmotion.methods.workspace import Slice, Workspace

# The region of fig. 7's dashed box, and that figure's height (m).
OVER, ISLAND_HEIGHT = "over_shoulder", 0.0


@dataclass(frozen=True, eq=False)
class Island:
    """The slice of fig. 7: which of its places only the way over the shoulder leads to.

    Attributes:
        part: the slice.
        over: "free" and "limited" to a mask of the slice's points: reached over the shoulder.
        under: the same for the elbow below the shoulder.
        box: outwards and forward ends of the named region (m), as (2, 2).
    """

    part: Slice
    over: dict[str, Bool[np.ndarray, " points"]]
    under: dict[str, Bool[np.ndarray, " points"]]
    box: np.ndarray

    def only(self, name: str) -> Bool[np.ndarray, " points"]:
        """Tell which points no posture with the elbow below the shoulder was found for."""
        return self.over[name] & ~self.under[name]

    def area(self, name: str) -> float:
        """Give the area (m²) of the slice that is reached over the shoulder only."""
        region = self.part.regions["free"].where("island", self.only(name))
        return region.volume / self.part.thickness


@dataclass(frozen=True, eq=False)
class BodyPlaces:
    """The person's body in the workspace.

    Attributes:
        body: shapes of someone who stands.
        volumes: a row a region: volume, what of it lies inside the body (cm³).
        over: what is reached of the region over the shoulder, the body cut out.
        island: of the slice at the height of the sternoclavicular joint, if there is one.
    """

    body: BodyShapes
    volumes: pd.DataFrame
    over: RegionReach
    island: Island | None


def body_places(space: Workspace, *, rng: np.random.Generator) -> BodyPlaces:
    """Put a standing person's body into a workspace that was computed without one.

    Args:
        space: free and limited, of `workspace`.
        rng: draws the points of the region over the shoulder.
    """
    body = BodyShapes.of(space.arm, "standing")
    rows = []
    for name, region in space.regions.items():
        within = region.where(name, body.inside(region.points))
        left = region.where(name, ~body.inside(region.points))
        rows.append(
            {
                "region": name,
                "volume_cm3": 1e6 * region.volume,
                "inside_the_body_cm3": 1e6 * within.volume,
                "without_the_body_cm3": 1e6 * left.volume,
                "standard_error_cm3": 1e6 * left.standard_error,
            }
        )
    over = [region for region in REGIONS if region.name == OVER]
    at = [part for part in space.slices if abs(part.height - ISLAND_HEIGHT) < 1e-9]
    return BodyPlaces(
        body,
        pd.DataFrame(rows),
        region_reach(replace(space, blocked=body.inside), over, rng=rng)[0],
        _island(space, at[0], body) if at else None,
    )


def _island(space: Workspace, part: Slice, body: BodyShapes) -> Island:
    frame = BodyFrame.of(space.arm)
    ways: dict[str, dict[str, np.ndarray]] = {"over": {}, "under": {}}
    for name, screen in zip(("limited", "free"), space.screens, strict=True):
        region = part.regions[name]
        rows = np.flatnonzero(region.inside & ~body.inside(region.points))
        for way in ("over", "under"):
            found = np.zeros(len(region.points), dtype=np.bool_)
            places = region.points[rows]
            found[rows] = decide_way(screen, places, way, frame, space.options.threads)
            ways[way][name] = found
    region = next(region for region in REGIONS if region.name == OVER)
    box = frame.stature * np.array([region.outwards, region.forward])
    return Island(part, ways["over"], ways["under"], box)
