"""Donders surfaces of recorded people: thickness of shoulder, forearm and wrist, task by task."""

from typing import TYPE_CHECKING

import numpy as np

from selfmotion.errors import SelfmotionError
from selfmotion.methods.elasticity.orientation_surface import (
    OrientationSurface,
    fit_orientation_surface,
)
from selfmotion.studies.donders_postures import SEGMENTS, PersonPostures

if TYPE_CHECKING:
    import pandas as pd

ALL_TASKS = "all tasks"
MEASURES = ("thickness_deg", "held_out_deg", "torsion_deg")


def surface_table(postures: PersonPostures) -> "pd.DataFrame":
    """Fit surfaces to each segment, in each task and in all of them.

    Returns:
        A table, one row a segment and task: `thickness_deg` (standard deviation beside the
        surface), `held_out_deg` (the same for repeats left out of the fit, in turn), `torsion_deg`
        (standard deviation of the torsion without a surface), `status`.
    """
    import pandas as pd

    rows = []
    for segment in SEGMENTS:
        for task in (*dict.fromkeys(postures.condition.tolist()), ALL_TASKS):
            some = postures.on_path & ((postures.condition == task) | (task == ALL_TASKS))
            label = {"subject": postures.subject, "side": postures.side, "segment": segment}
            rows.append(
                label | {"task": task, "postures": int(some.sum())} | _row(postures, segment, some)
            )
    return pd.DataFrame(rows)


def surface_of(postures: PersonPostures, segment: str, some: np.ndarray) -> OrientationSurface:
    """Fit the surface of one segment to some of a person's postures."""
    return fit_orientation_surface(postures.rotations[segment][some], axis=postures.axes[segment])


def _row(postures: PersonPostures, segment: str, some: np.ndarray) -> dict[str, object]:
    try:
        found = surface_of(postures, segment, some)
        torsion = found.components(postures.rotations[segment][some])[:, 0]
        row: dict[str, object] = {
            "thickness_deg": found.thickness_deg,
            "held_out_deg": _held_out(postures, segment, some),
            "torsion_deg": float(np.degrees(torsion.std())),
        }
        return row | {"status": "fitted"}
    except SelfmotionError as error:
        empty: dict[str, object] = dict.fromkeys(
            ("thickness_deg", "held_out_deg", "torsion_deg"), np.nan
        )
        return empty | {"status": str(error)}


def _held_out(postures: PersonPostures, segment: str, some: np.ndarray) -> float:
    """Give the standard deviation beside the surfaces of the other repeats (degrees)."""
    residuals = []
    for repeat in dict.fromkeys(postures.trial[some].tolist()):
        left = some & (postures.trial == repeat)
        rest = some & ~left
        if not rest.any():
            return float("nan")
        surface = surface_of(postures, segment, rest)
        residuals.append(surface.residual(postures.rotations[segment][left]))
    return float(np.degrees(np.sqrt((np.concatenate(residuals) ** 2).mean())))
