"""The report of `selfmotion reproduce deboon`: its table and figures, what they mean."""

import pandas as pd

from selfmotion.kinematics.arm import Arm
from selfmotion.methods.workspace import Workspace
from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Page, Picture, Section, Table
from selfmotion.report.ik_figures import saturation_figure
from selfmotion.report.reproductions_page import BY_FIGURE
from selfmotion.report.workspace_figures import (
    arc_joints_figure,
    arcs_figure,
    hulls_figure,
    island_figure,
    slices_figure,
)
from selfmotion.studies.deboon import DeBoonStudy, DeviceResult
from selfmotion.studies.deboon_figures import counterparts

FIGURES = {2: 11, 3: 13}
PLANES = {"yz": "sagittal", "xz": "coronal"}


def deboon_page(made: DeBoonStudy, numbers: pd.DataFrame, provenance: Provenance) -> Page:
    """Give the report on a reproduction.

    Args:
        made: the three scenarios, computed again.
        numbers: each published number beside ours.
        provenance: how it was made.
    """
    sections = [
        Section(
            "Published numbers beside ours",
            words=(
                "Lengths and limits are those that the arm is built from: that they agree shows "
                "that they were taken over without error, and no more.",
            ),
            tables=(Table(numbers, "“Kind” says what may be compared."),),
        ),
        saturation_section(made.workspace.arm),
        workspace_section(made),
        island_section(made),
        *(device_section(device) for device in made.devices),
        counterparts_section(made),
        missing_section(),
    ]
    footer = Footer((provenance, made.workspace.provenance), ("DeBoon",))
    title = "DeBoon et al., computed again"
    return Page(title, tuple(sections), made.summary(), footer)


def saturation_section(arm: Arm) -> Section:
    """Show the functions that keep joints inside their limits in the paper's scheme."""
    return Section(
        "Joint limits as saturation",
        words=(
            "The paper's inverse kinematics steps in a variable v without bounds, and the joint "
            "angle follows by an arctangent (eq. 11): it never passes a limit. The price is seen "
            "on the right: near a limit a step of v hardly moves the joint, back from the limit as "
            "little as towards it. What follows was therefore computed by steps inside the limits "
            "(selfmotion ik, default), which have no such brake.",
        ),
        pictures=(
            Picture(
                saturation_figure(arm),
                "Left: Fig. 2(a), by eq. 11 with the ranges of the model (Table 3; the last three "
                "upper limits are assumed). Right: its slope, the diagonal of eq. 13.",
                "Joint angles over the unbounded variable, and their slopes",
            ),
        ),
    )


def workspace_section(made: DeBoonStudy) -> Section:
    """Show scenario 1: the workspace with the elbow free and splinted."""
    space, places = made.workspace, made.places
    return Section(
        "Scenario 1: the workspace",
        pictures=(
            Picture(
                hulls_figure(space, places.body),
                "The convex hulls in space (Fig. 6). A hull bridges hollows: compare volumes.",
                "Hulls of the workspace with and without the splint, in space from two sides",
            ),
            Picture(
                slices_figure(space, places.body),
                "Horizontal slices, seen from above (Figs 7 to 9): what the splint leaves, what it "
                "takes, and the body of someone who stands, cut out.",
                "Points reached in horizontal slices, with and without the splint",
            ),
        ),
        tables=(
            Table(space.to_frame(), "Volumes in cm³, body included; shares of the free volume.", 4),
            Table(places.volumes, "What of the volumes lies inside the body.", 4),
            Table(
                slices_table(space),
                "Areas of the slices (m², ± standard error) by height (m), body included.",
            ),
        ),
    )


def slices_table(space: Workspace) -> pd.DataFrame:
    """Give a row a height: the areas of what is free, kept and lost."""
    rows = []
    for part in space.slices:
        areas = {name: "{:.3f} ± {:.3f}".format(*part.area(name)) for name in part.regions}
        rows.append({"z": f"{part.height:+.1f}", **areas})
    return pd.DataFrame(rows)


def island_section(made: DeBoonStudy) -> Section:
    """Show the island of fig. 7: what only the way over the shoulder leads to."""
    places, pictures, words = made.places, (), []
    if places.island is not None:
        pictures = (
            Picture(
                island_figure(places.island, places.body),
                "The slice at the height of the sternoclavicular joint, seen from above. Dashed: "
                "the named region, a box of our own; the paper draws its box without numbers.",
                "Places of one slice that only the way over the shoulder leads to",
            ),
        )
        free, limited = (1e4 * places.island.area(name) for name in ("free", "limited"))
        words.append(
            f"In this slice {free:.0f} cm² (elbow free) and {limited:.0f} cm² (splinted) are "
            "reached over the shoulder only: no posture with the elbow below it was found."
        )
    reach = {name: region.volume for name, region in places.over.sets.items()}
    words.append(
        "In the whole region over the shoulder (behind it, elbow above it; body cut out) the free "
        f"arm reaches {1e3 * reach['free']:.1f} litres, the splinted one "
        f"{1e3 * reach['limited']:.1f}: help would be needed in {1e3 * reach['lost']:.1f}."
    )
    return Section("Scenario 1: over the shoulder", words=tuple(words), pictures=pictures)


def counterparts_section(made: DeBoonStudy) -> Section:
    """Put each figure and table of the paper beside ours, with a word on the difference."""
    return Section(BY_FIGURE, tables=(Table(counterparts(made), "In the paper's order."),))


def missing_section() -> Section:
    """Say what of the paper cannot be compared, and why."""
    return Section(
        "What cannot be compared",
        points=(
            "Fig. 5 and every measured curve of figs 6 to 13: the recordings are not public. Of "
            "the four cases that the paper lays over each other (measured and computed, free and "
            "splinted) the two computed ones are shown here, in one picture each.",
            "The paper prints no volume, no area and no arc; figs 6 to 13 are pictures only.",
            "The cut-outs of head, torso and legs have no printed sizes, and the dashed box of "
            "fig. 7 none either: both are ours, sized by the arm's lengths. The body's middle is "
            "put at the model's origin, the right sternoclavicular joint, about 2 cm beside it.",
            "The upper limits of the three wrist joints are lost in the text at hand, and so is "
            "where the sternal notch lies in the model's axes; the first are assumed, the second "
            "is a parameter of the study, taken as zero.",
        ),
    )


def device_section(result: DeviceResult) -> Section:
    """Show a scenario in which a device leads the palm round circles."""
    scenario = result.scenario
    return Section(
        f"Scenario {scenario.number}: circles in the {PLANES[scenario.plane]} plane",
        pictures=(
            Picture(
                arcs_figure(result),
                "Above: the arcs of each circle that the palm can follow; dotted: the circles. "
                "Below: the elbow along them.",
                f"Feasible arcs of scenario {scenario.number} with the elbow free and splinted",
            ),
            Picture(
                arc_joints_figure(result),
                f"The joints of fig. {FIGURES[scenario.number]}, by our computation: least motion "
                "from sample to sample. The wrist's angles are those of the printed model, whose "
                "deviation turns about the forearm and whose pronation about the hand.",
                f"Elbow and wrist along the arcs of scenario {scenario.number}",
            ),
        ),
        tables=(Table(result.to_frame(), "One row an arc."),),
    )
