"""The tables of a prediction study, made once for the document, the files and the report."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from selfmotion.provenance import Provenance
from selfmotion.studies.prediction import PredictionRun
from selfmotion.studies.prediction_summary import (
    by_kind,
    by_person_and_kind,
    compare_variants,
    counted,
    of_variant,
    spread,
    summarise,
)

KEYS = ["subject", "side", "task", "moment", "trial"]


@dataclass(frozen=True, eq=False)
class PredictionTables:
    """What is shown of a run.

    Attributes:
        summary: one row a predictor, the best first.
        kinds: error by predictor and kind of moment.
        persons: natural and predicted angle by predictor, person, side and kind.
        spread: natural angles within and between people, by kind.
        sensitivity: errors by variant; empty where none was asked for.
        observations: one row a moment, `predicted` holding every predictor's angle (rad).
        fits: how the arm was fitted to each person.
        provenance: with the seed of the intervals.
    """

    summary: pd.DataFrame
    kinds: pd.DataFrame
    persons: pd.DataFrame
    spread: pd.DataFrame
    sensitivity: pd.DataFrame
    observations: pd.DataFrame
    fits: pd.DataFrame
    provenance: Provenance

    def named(self) -> dict[str, pd.DataFrame]:
        """Give the tables by the name of their file; predictions get a column each."""
        wide = pd.DataFrame(self.observations["predicted"].tolist())
        flat = pd.concat(
            [self.observations.drop(columns=["predicted", "coordinate_error"]), wide], axis=1
        )
        found = {
            "predictors": self.summary,
            "errors_by_kind": self.kinds,
            "errors_by_person": self.persons,
            "spread": self.spread,
            "observations": flat,
            "fits": self.fits,
        }
        return found | ({"sensitivity": self.sensitivity} if len(self.sensitivity) else {})


def tables_of(run: PredictionRun, *, seed: int = 0) -> PredictionTables:
    """Make all tables; intervals are drawn with the seed."""
    predictions = of_variant(run.predictions)
    observations = of_variant(run.observations)
    several = len(set(run.observations["variant"])) > 1

    def rng() -> np.random.Generator:
        return np.random.default_rng(seed)

    return PredictionTables(
        summary=summarise(predictions, rng=rng()),
        kinds=by_kind(predictions),
        persons=by_person_and_kind(predictions),
        spread=spread(counted(observations), rng=rng()),
        sensitivity=compare_variants(run.observations, run.predictions, rng=rng())
        if several
        else pd.DataFrame(),
        observations=_with_predictions(observations, predictions),
        fits=of_variant(run.fits),
        provenance=replace(run.provenance, seed=seed),
    )


def _with_predictions(observations: pd.DataFrame, predictions: pd.DataFrame) -> pd.DataFrame:
    said: dict[tuple[str, ...], dict[str, float | None]] = {}
    labels = predictions[KEYS].to_numpy().tolist()
    angles = predictions["predicted"].to_numpy(dtype=float)
    for key, name, angle in zip(labels, predictions["predictor"], angles, strict=True):
        where = said.setdefault(tuple(map(str, key)), {})
        where[str(name)] = float(angle) if np.isfinite(angle) else None
    keys = [tuple(map(str, key)) for key in observations[KEYS].to_numpy().tolist()]
    return observations.assign(predicted=[said.get(key, {}) for key in keys])
