"""The report of `selfmotion reproduce deboon`: its table and figures, what they mean."""

import pandas as pd

from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Page, Picture, Section, Table
from selfmotion.report.workspace_figures import (
    arc_joints_figure,
    arcs_figure,
    hulls_figure,
    slices_figure,
)
from selfmotion.studies.deboon import DeBoonStudy, DeviceResult

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
            tables=(Table(numbers, "`kind` says what may be compared."),),
        ),
        workspace_section(made),
        *(device_section(device) for device in made.devices),
        missing_section(),
    ]
    footer = Footer((provenance, made.workspace.provenance), ("DeBoon",))
    title = "DeBoon et al., computed again"
    return Page(title, tuple(sections), made.summary(), footer)


def workspace_section(made: DeBoonStudy) -> Section:
    """Show scenario 1: the workspace with the elbow free and splinted."""
    space = made.workspace
    return Section(
        "Scenario 1: the workspace",
        pictures=(
            Picture(
                hulls_figure(space),
                "Outlines of the convex hulls (Fig. 6). A hull bridges hollows: compare volumes.",
                "Hulls of the workspace with and without the splint, from three sides",
            ),
            Picture(
                slices_figure(space),
                "Horizontal slices, seen from above: what the splint leaves and what it takes.",
                "Points reached in horizontal slices, with and without the splint",
            ),
        ),
        tables=(
            Table(space.to_frame(), "Volumes in cm³; shares of the free volume.", digits=4),
            Table(space.slices_frame(), "Areas of the slices (m, m²)."),
        ),
    )


def missing_section() -> Section:
    """Say what of the paper cannot be compared, and why."""
    return Section(
        "What cannot be compared",
        points=(
            "Fig. 5 and every measured curve of figs 6 to 13: the recordings are not public. Of "
            "the four cases that the paper lays over each other (measured and computed, free and "
            "splinted) the two computed ones are shown here, in one picture each.",
            "The paper prints no volume and no area; figs 6 to 9 are pictures only. The hulls of "
            "fig. 6 are drawn by their outlines; the slices of figs 7 to 9 are drawn here as the "
            "sets that are reached, since hulls overstate a hollow slice.",
            "The cut-outs of head, torso and legs have no printed sizes: `selfmotion workspace "
            "--body standing` cuts them out with shapes of our own.",
            "Figs 11 and 13: the self-motion on the circles is so wide that a joint's curve "
            "depends on the cost chosen; only the elbow's, which the distance to the device fixes "
            "most, says more than that.",
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
