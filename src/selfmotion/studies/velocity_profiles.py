"""Velocities over the course of a movement, 0 to 100 %: conditions side by side, people averaged.

The splitting itself is `methods.velocity_split`; here its bands are made for the panels of
[Khoramshahi2022] Figs 5 and 7.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.methods.velocity_split import VelocityBands, velocity_bands
from selfmotion.motion.recording import Study
from selfmotion.redundancy.projection import split_velocity
from selfmotion.studies.results import NullSpeeds, SplitBands

IDENTIFIED, IDENTITY = "identified", "identity"


def bands_by(study: Study, *labels: str) -> dict[tuple[str, ...], VelocityBands]:
    """Average velocities over trials for each combination of labels (Fig 5)."""
    return {
        tuple(str(value) for value in key): velocity_bands(part)
        for key, part in study.group(*labels).items()
    }


def split_bands(study: Study, weights: Float[np.ndarray, " joints"] | None = None) -> SplitBands:
    """Split velocities with given weights and with W = I, averaged over trials."""
    identified = None if weights is None else velocity_bands(study, weights=weights)
    return SplitBands(velocity_bands(study), identified)


def null_speeds(
    study: Study, weights: Mapping[tuple[str, str], Float[np.ndarray, " joints"]]
) -> NullSpeeds:
    """Compare null-space velocities with each person's own weights and with W = I (Fig 7).

    Args:
        study: recordings of people in conditions, commonly of one target.
        weights: (subject, condition) to weights.
    """
    rows: list[dict[str, object]] = []
    people: dict[tuple[str, str], list[VelocityBands]] = {}
    for (subject, condition), part in study.group("subject", "condition").items():
        for kind, w in ((IDENTIFIED, weights[str(subject), str(condition)]), (IDENTITY, None)):
            people.setdefault((str(condition), kind), []).append(velocity_bands(part, weights=w))
            row: dict[str, object] = {
                "subject": subject,
                "condition": condition,
                "weights": kind,
            }
            rows.append(row | _sizes(part, w))
    panels = {key: average_people(bands) for key, bands in people.items()}
    return NullSpeeds(panels, pd.DataFrame(rows))


def average_people(bands: list[VelocityBands]) -> VelocityBands:
    """Average people; the spread is over all their movements, within and between people."""
    mean, spread = {}, {}
    for part in bands[0].mean:
        stack = np.stack([one.mean[part] for one in bands])
        mean[part] = stack.mean(axis=0)
        within = np.mean([np.nan_to_num(one.spread[part]) ** 2 for one in bands], axis=0)
        spread[part] = np.sqrt(within + stack.var(axis=0))
    n_trials = sum(one.n_trials for one in bands)
    return VelocityBands(bands[0].joints, bands[0].phase, mean, spread, n_trials)


def _sizes(study: Study, weights: np.ndarray | None) -> dict[str, object]:
    """Give the rms null-space speed (rad/s) and its share of the squared joint speed."""
    squared = whole = 0.0
    n_samples = 0
    for recording in study:
        qd = recording.array("qd")
        null = split_velocity(recording.array("jacobian"), qd, weights)[1]
        squared, whole = squared + float(np.sum(null**2)), whole + float(np.sum(qd**2))
        n_samples += len(qd)
    return {
        "rms": float(np.sqrt(squared / n_samples)),
        "share": squared / whole if whole > 0.0 else float("nan"),
    }
