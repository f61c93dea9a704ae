"""Tables of a study as its page shows them: the files beside the page hold every column."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.report.html import format_number
from selfmotion.report.theme import words
from selfmotion.studies.study_statistics import Key

SHARES = {
    "task_share": "task share",
    "task_share_identity": "all weights alike",
    "task_share_others": "weights of other conditions",
    "synergy": "synergy ΔV",
}


def groups_frame(groups: pd.DataFrame, estimates: Mapping[Key, WeightEstimate]) -> pd.DataFrame:
    """Give shares and synergy of each person, side and condition, and what is known of weights.

    Args:
        groups: of a study run.
        estimates: of the same people, sides and conditions.
    """
    table = groups.loc[:, ["subject", "side", "condition", "trials", *SHARES]].rename(
        columns=SHARES
    )
    keys = zip(groups["subject"], groups["side"], groups["condition"], strict=True)
    return table.assign(
        **{
            "joints with weights": [
                _found(estimates.get((str(a), str(b), str(c)))) for a, b, c in keys
            ]
        }
    )


def people_frame(people: pd.DataFrame) -> pd.DataFrame:
    """Give the means over people with their measures in words."""
    return people.assign(what=[SHARES.get(name, name) for name in people["what"]])


def swivel_frame(swivel: pd.DataFrame) -> pd.DataFrame:
    """Give the spread of the swivel angle, intervals in brackets.

    Movements with the elbow off the line stand apart only where there are others.
    """
    rows, seen = [], {}
    for row in swivel.to_dict("records"):
        key = (row["side"], row["condition"], row["moment"])
        if row["selection"] == "all":
            seen[key] = row["movements"]
        elif seen.get(key) == row["movements"]:
            continue
        rows.append(
            {
                "side": row["side"],
                "condition": row["condition"],
                "moment": words(row["moment"]),
                "which": row["selection"],
                "people": row["people"],
                "trials": row["movements"],
                "mean": row["mean_deg"],
                "within": _interval(row, "within"),
                "between": _interval(row, "between"),
            }
        )
    return pd.DataFrame(rows)


def _interval(row: Mapping[Any, Any], name: str) -> str:
    """Write a number with its interval; a dash where it is not known."""
    value, low, high = (row[f"{name}{end}_deg"] for end in ("", "_lower", "_upper"))
    if value != value:
        return "–"
    if low != low:
        return format_number(value)
    value, low, high = (format_number(v, 2) for v in (value, low, high))
    return f"{value} ({low} to {high})".replace(" ", "\u00a0")


def _found(estimate: WeightEstimate | None) -> str:
    """Say how many joints have a weight, and whether the estimate converged."""
    if estimate is None:
        return "–"
    most = max(map(len, estimate.groups), default=0)
    text = f"{most} of {len(estimate.joints)}" if most else "none"
    lost = estimate.status.sentence.startswith("not converged")
    return f"{text}; not converged" if lost else text
