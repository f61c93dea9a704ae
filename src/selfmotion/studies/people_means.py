"""Means over people with intervals: each person counts once, however many movements they made."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

if TYPE_CHECKING:
    import pandas as pd

LEVEL = 0.95


def by_person(table: "pd.DataFrame", measure: str, keys: list[str]) -> "pd.DataFrame":
    """Average a measure over each arm's rows, then over arms, with a 95 % interval (Student).

    Returns:
        A table, one row a combination of the keys: mean, lower, upper, n (arms).
    """
    import pandas as pd

    of_arms: dict[tuple[str, ...], list[float]] = {}
    for key, values in grouped(table, measure, [*keys, "subject", "side"]).items():
        if np.isfinite(values).any():
            of_arms.setdefault(key[:-2], []).append(float(np.nanmean(values)))
    rows = []
    for key, values in of_arms.items():
        mean, half = interval(np.array(values))
        named = dict(zip(keys, key, strict=True))
        spread = {"mean": mean, "lower": mean - half, "upper": mean + half}
        rows.append({**named, **spread, "n": len(values)})
    return pd.DataFrame(rows, columns=[*keys, "mean", "lower", "upper", "n"])


def grouped(
    table: "pd.DataFrame", measure: str, keys: list[str]
) -> dict[tuple[str, ...], np.ndarray]:
    """Collect a column by the values of others, in order of appearance."""
    out: dict[tuple[str, ...], list[float]] = {}
    for *key, value in table[[*keys, measure]].itertuples(index=False, name=None):
        out.setdefault(tuple(map(str, key)), []).append(float(value))
    return {key: np.array(values) for key, values in out.items()}


def means_by(table: "pd.DataFrame", keys: list[str], columns: list[str]) -> "pd.DataFrame":
    """Average columns over rows that agree in the keys, in order of appearance, without NaN.

    Example:
        >>> import pandas as pd
        >>> one = pd.DataFrame({"task": ["a", "b", "a"], "x": [1.0, 5.0, 3.0]})
        >>> means_by(one, ["task"], ["x"]).to_dict("list")
        {'task': ['a', 'b'], 'x': [2.0, 5.0]}
    """
    import pandas as pd

    rows: dict[tuple[str, ...], dict[str, float]] = {}
    for column in columns:
        for key, values in grouped(table, column, keys).items():
            known = values[np.isfinite(values)]
            rows.setdefault(key, {})[column] = float(known.mean()) if known.size else np.nan
    named = [dict(zip(keys, key, strict=True)) | means for key, means in rows.items()]
    return pd.DataFrame(named, columns=[*keys, *columns])


def rows_of(table: "pd.DataFrame", values: Mapping[str, str]) -> "pd.DataFrame":
    """Give the rows in which the columns named hold these values."""
    keep = np.ones(len(table), dtype=bool)
    for column, value in values.items():
        keep &= (table[column] == value).to_numpy()
    return table.loc[keep]


def interval(values: np.ndarray) -> tuple[float, float]:
    """Give the mean and half the width of its 95 % interval (Student); NaN with one value.

    Example:
        >>> [round(v, 3) for v in interval(np.array([1.0, 2.0, 3.0]))]
        [2.0, 2.484]
    """
    n = len(values)
    if n < 2:
        return float(values.mean()) if n else float("nan"), float("nan")
    quantile = float(stdtrit(n - 1, 0.5 + 0.5 * LEVEL))
    return float(values.mean()), float(quantile * values.std(ddof=1) / np.sqrt(n))
