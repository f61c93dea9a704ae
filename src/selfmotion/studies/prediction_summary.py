"""How well each predictor does: errors by person and task, with intervals over people.

People, not movements, are the sample: a person's errors are averaged over kinds of moment first,
each kind alike, and intervals come from drawing people anew ([Li2022] eq. 14 averages over trials;
that number stands beside).
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.methods.predictors.catalogue import BASELINE
from selfmotion.methods.predictors.observation import angle_between, mean_angle
from selfmotion.studies.prediction_observe import BASE

DRAWS = 10_000
LEVEL = (2.5, 97.5)


def summarise(
    predictions: pd.DataFrame, *, rng: np.random.Generator, draws: int = DRAWS
) -> pd.DataFrame:
    """Give one row a predictor, the best first; all angles in degrees.

    Args:
        predictions: of one variant, as in `PredictionRun.predictions`.
        rng: draws people.
        draws: number of bootstrap samples.

    Returns:
        Columns: predictor; mean_deg, the mean over people, with its interval lower_deg and
        upper_deg; trials_deg and trials_sd_deg (eq. 14 and the spread over trials); bias_deg, the
        mean signed error; gain_deg, how much smaller the error is than that of the constant per
        task, with its interval gain_lower_deg and gain_upper_deg; better_people, in how many
        people; people; predicted and missing moments.
    """
    table = by_person(predictions)
    wide = table.pivot(index="subject", columns="predictor", values="error_deg")
    drawn = rng.integers(len(wide), size=(draws, len(wide)))
    base = wide[BASELINE].to_numpy(dtype=float)
    rows = []
    for name, part in predictions.groupby("predictor", sort=False):
        errors = wide[name].to_numpy(dtype=float)
        gain = base - errors
        known = np.rad2deg(part["error"].to_numpy(dtype=float))
        size = np.abs(known[np.isfinite(known)])
        rows.append(
            {
                "predictor": str(name),
                "mean_deg": _mean(errors),
                **_interval("", errors, drawn),
                "trials_deg": _mean(size),
                "trials_sd_deg": float(size.std(ddof=1)) if len(size) > 1 else np.nan,
                "bias_deg": float(np.rad2deg(mean_angle(part["error"].to_numpy(dtype=float)))),
                "gain_deg": _mean(gain),
                **_interval("gain_", gain, drawn),
                "better_people": int((gain > 0.0).sum()),
                "people": int(np.isfinite(errors).sum()),
                "predicted": len(size),
                "missing": int(len(known) - len(size)),
            }
        )
    return pd.DataFrame(rows).sort_values("mean_deg", ignore_index=True)


def by_person(predictions: pd.DataFrame) -> pd.DataFrame:
    """Give the mean absolute error (deg) of each person and predictor, kinds alike."""
    kinds = _mean_errors(predictions, ["predictor", "subject", "kind"])
    return _mean_over(kinds, ["predictor", "subject"])


def by_kind(predictions: pd.DataFrame) -> pd.DataFrame:
    """Give the mean over people of the absolute error (deg) by kind of moment and predictor."""
    people = _mean_errors(predictions, ["predictor", "kind", "subject"])
    return _mean_over(people, ["predictor", "kind"])


def by_person_and_kind(predictions: pd.DataFrame) -> pd.DataFrame:
    """Give natural and predicted mean angles and the mean absolute error (deg) of each cell."""
    rows = []
    keys = ["predictor", "subject", "side", "kind"]
    for key, part in predictions.groupby(keys, sort=False):
        error = part["error"].to_numpy(dtype=float)
        rows.append(
            dict(zip(keys, key if isinstance(key, tuple) else (key,), strict=True))
            | {
                "natural_deg": float(np.rad2deg(mean_angle(part["natural"].to_numpy(dtype=float)))),
                "predicted_deg": float(
                    np.rad2deg(mean_angle(part["predicted"].to_numpy(dtype=float)))
                ),
                "error_deg": _mean(np.abs(np.rad2deg(error))),
                "trials": len(part),
            }
        )
    return pd.DataFrame(rows)


def spread(
    observations: pd.DataFrame, *, rng: np.random.Generator, draws: int = DRAWS
) -> pd.DataFrame:
    """Give how much natural angles vary within and between people, one row a kind (deg).

    Returns:
        Columns: kind; mean_deg; within_deg, standard deviation over repeats with one arm, pooled
        over people; between_deg, standard deviation of people's means (over arms); each with its
        bootstrap interval over people; people and moments.
    """
    rows = []
    for kind, part in observations.groupby("kind", sort=False):
        people = [arms_of(own) for _, own in part.groupby("subject", sort=False)]
        centres = np.array([mean_angle([mean_angle(arm) for arm in arms]) for arms in people])
        middle = mean_angle(centres)
        means = np.rad2deg(angle_between(centres, middle))
        squares = np.array([sum(_square_sum(arm) for arm in arms) for arms in people])
        freedom = np.array([sum(len(arm) - 1.0 for arm in arms) for arms in people])
        drawn = rng.integers(len(people), size=(draws, len(people)))
        n = len(people)
        within = np.sqrt(_ratio(squares[drawn].sum(axis=1), freedom[drawn].sum(axis=1)))
        between = means[drawn].std(axis=1, ddof=1) if n > 1 else np.full(draws, np.nan)
        rows.append(
            {
                "kind": str(kind),
                "mean_deg": float(np.rad2deg(middle)),
                "within_deg": float(np.sqrt(_ratio(squares.sum(), freedom.sum()))),
                **_limits("within_", within),
                "between_deg": float(means.std(ddof=1)) if n > 1 else np.nan,
                **_limits("between_", between),
                "people": n,
                "moments": len(part),
            }
        )
    return pd.DataFrame(rows)


def arms_of(person: pd.DataFrame) -> list[Float[np.ndarray, " repeats"]]:
    """Give the natural angles of each arm of a person (rad)."""
    return [arm["natural"].to_numpy(dtype=float) for _, arm in person.groupby("side", sort=False)]


def compare_variants(
    observations: pd.DataFrame,
    predictions: pd.DataFrame,
    *,
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> pd.DataFrame:
    """Give one row a variant and predictor: error, and how far natural angles moved (deg).

    Columns: variant, predictor, mean_deg with lower_deg and upper_deg, shift_deg (mean over
    moments of the natural angle less that as recorded), moved_deg (mean size of it), inside (share
    of natural postures within the limits), counts (moments that enter).
    """
    keys = ["subject", "side", "task", "moment", "trial"]
    first = observations.loc[observations["variant"] == BASE.name].set_index(keys)["natural"]
    rows = []
    for variant, part in observations.groupby("variant", sort=False):
        kept = part.loc[part["counts"].astype(bool)]
        here = kept.set_index(keys)["natural"]
        both = here.index.intersection(first.index)
        moved = np.rad2deg(
            angle_between(here.loc[both].to_numpy(float), first.loc[both].to_numpy(float))
        )
        about = {
            "shift_deg": _mean(moved),
            "moved_deg": _mean(np.abs(moved)),
            "inside": float(kept["natural_inside"].mean()),
            "counts": len(kept),
        }
        table = summarise(predictions.loc[predictions["variant"] == variant], rng=rng, draws=draws)
        rows += [
            {"variant": str(variant), **row, **about}
            for row in table.loc[:, ["predictor", "mean_deg", "lower_deg", "upper_deg"]].to_dict(
                "records"
            )
        ]
    return pd.DataFrame(rows)


def of_variant(table: pd.DataFrame, variant: str = BASE.name) -> pd.DataFrame:
    """Give the rows of one variant."""
    return table.loc[table["variant"] == variant].reset_index(drop=True)


def counted(observations: pd.DataFrame) -> pd.DataFrame:
    """Give the moments whose swivel angle counts."""
    return observations.loc[observations["counts"].astype(bool)].reset_index(drop=True)


def _mean_errors(predictions: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    sized = predictions.assign(error_deg=np.rad2deg(predictions["error"].abs()))
    return _mean_over(sized, keys)


def _mean_over(table: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    means = table.groupby(list(keys), sort=False)["error_deg"].mean()
    return pd.DataFrame({"error_deg": means}).reset_index()


def _square_sum(angles: Float[np.ndarray, " repeats"]) -> float:
    """Give the sum of squared deviations from the mean (deg²)."""
    return float((np.rad2deg(angle_between(angles, mean_angle(angles))) ** 2).sum())


def _mean(values: Float[np.ndarray, " values"]) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else float("nan")


def _interval(
    prefix: str, values: Float[np.ndarray, " people"], drawn: np.ndarray
) -> dict[str, float]:
    """Give the bootstrap interval of a mean over people."""
    if not np.isfinite(values).any():
        return {f"{prefix}lower_deg": np.nan, f"{prefix}upper_deg": np.nan}
    known = np.where(np.isfinite(values), values, 0.0)[drawn].sum(axis=1)
    return _limits(prefix, _ratio(known, np.isfinite(values)[drawn].sum(axis=1)))


def _limits(prefix: str, values: Float[np.ndarray, " draws"]) -> dict[str, float]:
    known = values[np.isfinite(values)]
    low, high = np.percentile(known, LEVEL) if known.size else (np.nan, np.nan)
    return {f"{prefix}lower_deg": float(low), f"{prefix}upper_deg": float(high)}


def _ratio(above: ArrayLike, below: ArrayLike) -> np.ndarray:
    """Divide; NaN where there is nothing to divide by."""
    top, bottom = np.asarray(above, dtype=np.float64), np.asarray(below, dtype=np.float64)
    return np.divide(top, bottom, out=np.full(top.shape, np.nan), where=bottom > 0)
