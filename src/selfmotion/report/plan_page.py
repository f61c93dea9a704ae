"""The report of `selfmotion plan`: paths, joints and speed of planned movements."""

from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.planner_figures import planned_movements_figure
from selfmotion.studies.center_out import NAMES

MODELS = {
    "lambda0": "λ0-PMP: the joints' elasticity acts on the self-motion alone, so that it shapes "
    "the posture and leaves the task to the spring.",
    "pmp1": "PMP1: no joint elasticity; the posture depends on the way that the hand took.",
    "pmp2": "PMP2: the joints' elasticity also pulls at the hand, which misses its target.",
}


def write_plan_report(path: str | Path, motion: PlannedMotion, table: pd.DataFrame) -> Path:
    """Write the report on planned movements; give its path.

    Args:
        path: the HTML file.
        motion: the movements, labelled.
        table: one row a movement, with its areas and status.
    """
    model = str(motion.provenance.choices["model"])
    largest = 1e3 * float(np.nanmax(motion.end_error))
    summary = (
        f"{len(motion)} movements planned; the one that ends farthest from its target ends "
        f"{largest:.1f} mm from it ({motion.status.sentence})."
    )
    section = Section(
        "Movements",
        words=(MODELS[model],),
        pictures=_pictures(motion),
        tables=(
            Table(
                table,
                "Where each movement ends (m from its target), and the areas between its path "
                "and the straight line over the squared length of that line; net areas are "
                "positive to the right.",
            ),
        ),
    )
    footer = Footer((motion.provenance,), ("Tommasino2017",))
    return write_report(path, "Planned movements", [section], summary=summary, footer=footer)


def _pictures(motion: PlannedMotion) -> tuple[Picture, ...]:
    """Draw the center-out experiment; other movements are given by their table."""
    outward = tuple(f"{name} outbound" for name in NAMES)
    if motion.names != outward + tuple(f"{name} inbound" for name in NAMES):
        return ()
    return (
        Picture(
            planned_movements_figure(motion),
            "Paths on the screen, joint angles and speed of the movements out and back.",
            "Paths, joint angles and speed of sixteen planned movements",
        ),
    )
