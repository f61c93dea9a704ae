"""Sections of the workspace's report: maps, recordings, the hand held, a mapping to another."""

from collections.abc import Mapping, Sequence

import pandas as pd

from selfmotion.methods.hand_circle import CircleReach
from selfmotion.methods.hand_constraints import HeldReach
from selfmotion.methods.reach_clouds import USED, CloudReach, clouds_frame
from selfmotion.methods.reaching.map_result import WorkspaceMaps
from selfmotion.methods.workspace import Workspace
from selfmotion.methods.workspace_mapping import WorkspaceMapping
from selfmotion.report.html import Picture, Section, Table
from selfmotion.report.interactive import Interactive
from selfmotion.report.workspace_circle_figures import circle_figure
from selfmotion.report.workspace_clouds_figures import clouds_figure
from selfmotion.report.workspace_maps_figures import map_figure, map_slices_figure

MEANINGS = {
    "margin": "Room to the limits: the largest share of its half range that every joint can keep "
    "from its limits while the hand is there. 1: all joints in the middle; 0: reached at a limit.",
    "manipulability": "Manipulability: the largest sqrt(det(J Jᵀ)) of the hand's position over all "
    "postures found there. Near 0 the hand cannot move in some direction.",
    "effort": "Least effort: the smallest sum of squared muscle activations found that holds the "
    "arm's own weight there, whatever the hand's orientation.",
}
# Rows of a table of mapped points that the page shows.
SHOWN = 20


def maps_section(maps: WorkspaceMaps, limits: str) -> Section:
    """Show maps: one interactive figure, and slices of each; `limits` is free or limited."""
    whose = "with the limits" if limits == "limited" else "without limits"
    return Section(
        f"Maps over the space that is reached {whose}",
        words=(maps.summary(),),
        points=tuple(MEANINGS[name] for name in maps.values),
        charts=(
            Interactive(
                map_figure(maps),
                "Points of the grid that are reached. Drag to turn; the slider takes sheets away "
                "from the left, the menu chooses the map.",
                f"Points in space coloured by {', '.join(maps.values)}",
            ),
        ),
        pictures=tuple(
            Picture(
                map_slices_figure(maps, name),
                f"{name}: horizontal slices seen from above; the cross is the ground's origin. "
                "White: not reached, or nothing holds the arm there.",
                f"Horizontal slices of the map {name}",
            )
            for name in maps.values
        ),
    )


def clouds_section(space: Workspace, clouds: Sequence[CloudReach]) -> Section:
    """Show recorded positions over the workspace."""
    table = clouds_frame(tuple(clouds)).drop(columns="workspace")
    limits = "with the limits" if clouds[0].region == "limited" else "of the free arm"
    if clouds[0].region == "free" and space.limited_arm is None:
        limits = "looked at"
    return Section(
        f"Recorded positions in the workspace {limits}",
        words=(
            "Outside: how far the arm stays short of a recorded position. Inside: how deep below "
            f"the boundary, over by at most about {1e3 * clouds[0].spacing:.0f} mm, the spacing of "
            f"its known points. Used: the part of the workspace within {1e3 * USED:.0f} mm of a "
            "recorded position.",
        ),
        pictures=(
            Picture(
                clouds_figure(space, clouds),
                "Recorded positions over the outline of the workspace (its hull: hollows do not "
                "show), and how many lie how deep.",
                "Recorded hand positions in three views of the workspace",
            ),
        ),
        tables=(Table(table, "One row a recording: shares in %, distances in mm."),),
    )


def held_section(held: Mapping[str, HeldReach]) -> Section:
    """Say what is reached with rows of the hand held."""
    rows = [
        {
            "arm": name,
            f"reached ({found.unit})": found.region.volume,
            "standard error": found.region.standard_error,
            "orientation free": found.by_position.volume,
        }
        for name, found in held.items()
    ]
    return Section(
        "Reach with the hand held",
        points=tuple(f"{name}: {found.summary()}" for name, found in held.items()),
        tables=(Table(pd.DataFrame(rows), "What is left."),),
    )


def circle_section(circles: Mapping[str, CircleReach]) -> Section:
    """Show feasible arcs of a device's circle and the joints along them."""
    frames = [found.to_frame().assign(arm=name) for name, found in circles.items()]
    return Section(
        "A device's circle",
        points=tuple(f"{name}: {found.summary()}" for name, found in circles.items()),
        pictures=tuple(
            Picture(
                circle_figure(found),
                f"{name}: left, the arcs that the hand can follow (dotted: the circle); right, the "
                "joints along them.",
                "Feasible arcs of a circle and joint angles along them",
            )
            for name, found in circles.items()
        ),
        tables=(Table(pd.concat(frames), "One row an arc: degrees and metres."),),
    )


def mapping_section(mapping: WorkspaceMapping, points: pd.DataFrame) -> Section:
    """Show the map from one workspace onto another."""
    shown = f"The first {SHOWN} of {len(points)} points" if len(points) > SHOWN else "All points"
    return Section(
        "Map onto another workspace",
        words=(
            mapping.summary(),
            "A position keeps its direction from the centre and its share of the way to the "
            "envelope; the map is continuous and can be turned round.",
        ),
        tables=(
            Table(
                points.head(SHOWN),
                f"{shown}: position and image (m), share of the way to the envelope, and how far "
                "the other person stays short of the image (mm).",
            ),
        ),
    )
