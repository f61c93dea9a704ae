"""The report of `selfmotion workspace`: what is reached, kept and lost, for a clinician."""

from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion.kinematics.arm import Arm
from selfmotion.methods.workspace import Workspace
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.workspace_figures import slices_figure


def write_workspace_report(path: str | Path, space: Workspace, person: str = "") -> Path:
    """Write the report on a workspace; give its path.

    Args:
        path: the HTML file.
        space: what is reached.
        person: whose workspace it is.
    """
    title = f"Workspace of {person}" if person else "Workspace"
    sections = [volume_section(space), ranges_section(space)]
    if space.slices:
        sections.append(slices_section(space))
    footer = Footer((space.provenance,), ("DeBoon",))
    return write_report(path, title, sections, summary=space.summary(), footer=footer)


def volume_section(space: Workspace) -> Section:
    """Show volumes and their errors."""
    return Section(
        "Volume",
        words=(
            "The volume that the palm can reach, by deciding points spread evenly over space; the "
            "standard error comes from repeating this with the points moved. The hull is the "
            "smallest shape without dents around it: it also counts hollows that are not reached.",
        ),
        tables=(Table(space.to_frame(), "Volumes in cm³; shares of the free volume.", digits=4),),
    )


def ranges_section(space: Workspace) -> Section:
    """Show the joint limits."""
    return Section(
        "Ranges of the joints",
        tables=(Table(ranges_frame(space.arm, space.limited_arm), "Degrees."),),
    )


def ranges_frame(arm: Arm, limited: Arm | None) -> pd.DataFrame:
    """Give a table, one row a joint: lower and upper limits (degrees)."""
    columns: dict[str, object] = {"joint": [name.replace("_", " ") for name in arm.joints]}
    for name, a in (("", arm), ("limited ", limited)):
        if a is not None:
            columns[f"{name}lower"] = np.degrees(a.lower)
            columns[f"{name}upper"] = np.degrees(a.upper)
    return pd.DataFrame(columns)


def slices_section(space: Workspace) -> Section:
    """Show horizontal slices."""
    return Section(
        "Slices",
        pictures=(
            Picture(
                slices_figure(space),
                "Horizontal slices 20 mm thick, seen from above.",
                "Points reached in horizontal slices, with and without the limits",
            ),
        ),
        tables=(Table(space.slices_frame(), "Areas of the slices (m, m²)."),),
    )
