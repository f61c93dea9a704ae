"""Figs 8 and 9 and Table IV of [Li2022] on recorded people, from a run of `prediction`.

DOI 10.1109/TNSRE.2022.3198400. The paper's people held an imaginary vertical cup at 114 places;
these people did what they were recorded doing, so that errors are shown at the places of their
hands. Its law is least muscle effort with gravity alone (eqs 1 to 3).
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from selfmotion.methods.predictors.catalogue import BASELINE, EFFORT, EFFORT_PASSIVE
from selfmotion.studies.li2022 import TABLE_IV
from selfmotion.studies.prediction_tables import PredictionTables
from selfmotion.studies.published import Ours, Published, beside

# Coordinates of the arm, in the order of Fig 9 C.
COORDINATES = (
    "elv_angle",
    "shoulder_elv",
    "shoulder_rot",
    "elbow_flexion",
    "pro_sup",
    "deviation",
    "flexion",
)
# Table IV beside ours: what the table names, and the predictor that stands for it here.
ROWS = (
    ("This work", EFFORT, "gravity alone, activations from 0 to 1"),
    ("This work", "muscle effort, opensim bound", "activations from 0.01"),
    ("This work", EFFORT_PASSIVE, "with passive forces of the muscles"),
    ("Li et al. 2015", "", "not computed: its criteria are not at hand"),
    ("Kim et al. 2012", "manipulability", "towards the mouth, inside the joint limits"),
    ("Wu et al. 2016", "coplanar with the mouth", "closed form, without limits"),
    ("Zanchettin et al. 2013", "regression on hand pose", "fitted anew, on other people"),
    ("", BASELINE, "mean of the other people: the baseline here"),
)
LAW_ON_PEOPLE = Published(
    "people", "Table IV", "replication error of least muscle effort: mean, SD", (3.73, 3.27), "deg"
)


@dataclass(frozen=True, eq=False)
class LiOnPeople:
    """The paper's figures on recorded people.

    Attributes:
        numbers: the published error beside ours.
        table_iv: Table IV with ours, a row a predictor.
        places: hand place from the shoulder (right, forward, up; m) and the law's mean absolute
            error (deg), one row a person, side and kind (Fig 8).
        trials: natural and predicted angle and error (deg), one row a moment (Fig 9 A and B).
        coordinates: mean and standard deviation of the coordinates' absolute error (deg) (Fig 9 C).
    """

    numbers: pd.DataFrame
    table_iv: pd.DataFrame
    places: pd.DataFrame
    trials: pd.DataFrame
    coordinates: pd.DataFrame


def li2022_on_people(tables: PredictionTables) -> LiOnPeople:
    """Take the paper's figures and table out of a prediction study."""
    kept = tables.observations.loc[tables.observations["counts"].to_numpy(dtype=bool)]
    said = [row.get(EFFORT) for row in kept["predicted"]]
    predicted = np.rad2deg(np.array([np.nan if v is None else v for v in said], dtype=float))
    natural = np.rad2deg(kept["natural"].to_numpy(dtype=float))
    error = (predicted - natural + 180.0) % 360.0 - 180.0
    labels = ["subject", "side", "kind", "trial"]
    trials = kept.loc[:, labels].assign(
        natural_deg=natural, predicted_deg=predicted, error_deg=error
    )
    wrist = [f"wrist_{axis}_m" for axis in "xyz"]
    grouped = kept.assign(error_deg=np.abs(error)).groupby(labels[:3], sort=False)
    places = pd.DataFrame(grouped[[*wrist, "error_deg"]].mean()).reset_index()
    size = np.abs(error[np.isfinite(error)])
    spread = float(size.std(ddof=1)) if len(size) > 1 else float("nan")
    ours = Ours(
        LAW_ON_PEOPLE.key,
        (float(size.mean()) if len(size) else float("nan"), spread),
        "other people, tasks and arm",
        f"{len(set(kept['subject']))} recorded people, {len(size)} moments; the paper: 5 people "
        "holding an imaginary cup at 114 places",
    )
    return LiOnPeople(
        beside((LAW_ON_PEOPLE,), (ours,)),
        _table_iv(tables.summary),
        places,
        trials.reset_index(drop=True),
        _coordinates(kept),
    )


def with_people(numbers: pd.DataFrame, found: LiOnPeople) -> pd.DataFrame:
    """Put the error on people in the place of the published number without counterpart."""
    same = numbers["where"] == LAW_ON_PEOPLE.where
    return pd.concat([numbers.loc[~same], found.numbers], ignore_index=True)


def _table_iv(summary: pd.DataFrame) -> pd.DataFrame:
    printed = {study: (error, law) for study, error, law in TABLE_IV}
    rows = []
    found = summary.set_index("predictor")
    for study, predictor, note in ROWS:
        error, law = printed.get(study, ("–", ""))
        ours, interval = "–", "–"
        if predictor in found.index:
            row = found.loc[predictor]
            ours = f"{row['trials_deg']:.1f} ± {row['trials_sd_deg']:.1f}"
            interval = f"{row['mean_deg']:.1f} ({row['lower_deg']:.1f} to {row['upper_deg']:.1f})"
        rows.append(
            {
                "study": study or "–",
                "assumption": law or "–",
                "published_deg": error,
                "predictor": predictor or "–",
                "ours_deg": ours,
                "people_deg": interval,
                "note": note,
            }
        )
    return pd.DataFrame(rows)


def _coordinates(kept: pd.DataFrame) -> pd.DataFrame:
    known = [row for row in kept["coordinate_error"] if isinstance(row, list)]
    values = np.abs(np.rad2deg(np.array(known, dtype=float).reshape(-1, len(COORDINATES))))
    several = len(values) > 1
    return pd.DataFrame(
        {
            "coordinate": list(COORDINATES),
            "mean_deg": values.mean(axis=0) if len(values) else np.nan,
            "sd_deg": values.std(axis=0, ddof=1) if several else np.nan,
        }
    )
