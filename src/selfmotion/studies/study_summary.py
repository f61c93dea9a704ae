"""Over the people of a study: spread of the swivel angle, shares, synergy, weights, and quality.

Each table has one row a side and condition (and moment, or joint), with intervals over people. For
standard deviations they come from χ², for means and mean log-ratios from t: both take people, and
the repeats of one person, as normal and independent.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import chdtri

from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.uncertainty import interval_factor
from selfmotion.studies.study_statistics import Key

LEVEL = 0.95
# An elbow nearer than this to the line from shoulder to wrist gives no swivel angle worth a mean:
# there 5 mm, what landmarks are off by, turn it by 7 degrees (mm).
LEAST_OFF_LINE = 40.0
SHARES = ("task_share", "task_share_identity", "task_share_others")
MEASURES = (*SHARES, "synergy")
ANY = (-np.inf, np.inf)
QUALITY = (
    "rms_landmark_mm",
    "elbow_disagreement_mm",
    "wrist_disagreement_mm",
    "shoulder_disagreement_mm",
    "upper_arm_sd_mm",
    "forearm_sd_mm",
    "share_at_limit",
)
LIMBS = ["side", "condition"]


@dataclass(frozen=True, eq=False)
class StudySummary:
    """A study over its people.

    Attributes:
        swivel: spread of the swivel angle at each moment, within and between people.
        people: means over people of velocity shares and synergy.
        joints: geometric mean over people of each joint's weight, all conditions pooled.
        quality: how well markers and model agree, over all trials.
    """

    swivel: pd.DataFrame
    people: pd.DataFrame
    joints: pd.DataFrame
    quality: pd.DataFrame


def summarise(
    trials: pd.DataFrame, groups: pd.DataFrame, pooled: Mapping[Key, WeightEstimate]
) -> StudySummary:
    """Make all tables over people."""
    used = trials.loc[trials["ok"].astype(bool)]
    head, tail = "swivel_", "_deg"
    moments = [c[len(head) : -len(tail)] for c in used if c.startswith(head) and c.endswith(tail)]
    return StudySummary(
        swivel_spread(used, moments),
        means_over_people(groups),
        weights_over_people(pooled),
        quality(used),
    )


def swivel_spread(trials: pd.DataFrame, moments: Sequence[str]) -> pd.DataFrame:
    """Give mean and spread of the swivel angle at each moment, in degrees.

    Args:
        trials: the table of a study's trials, with ``swivel_MOMENT_deg`` and
            ``elbow_off_MOMENT_mm``.
        moments: names.

    Returns:
        One row a side, condition, moment and selection (``all``, or ``elbow off the line``: without
        movements whose elbow is within `LEAST_OFF_LINE` of the line from shoulder to wrist):
        people, movements, mean, standard deviation over the repeats of a person, pooled
        (`within`, and `within_median` over people), and of the people's means (`between`).
    """
    rows = []
    for moment in moments:
        angle, off = f"swivel_{moment}_deg", f"elbow_off_{moment}_mm"
        known = trials.dropna(subset=[angle])
        for (side, condition), part in _by_limb(known):
            for selection, kept in (
                ("all", part),
                ("elbow off the line", part.loc[part[off] >= LEAST_OFF_LINE]),
            ):
                if len(kept):
                    head = {"side": side, "condition": condition, "moment": moment}
                    people = [g[angle].to_numpy(float) for _, g in kept.groupby("subject")]
                    rows.append(head | {"selection": selection} | _spread(people))
    return pd.DataFrame(rows)


def means_over_people(groups: pd.DataFrame) -> pd.DataFrame:
    """Give mean, standard deviation and interval over people of shares and synergy."""
    rows = []
    for (side, condition), part in _by_limb(groups):
        for what in MEASURES:
            values = np.asarray(part[what], dtype=float)
            values = values[np.isfinite(values)]
            if values.size:
                head = {"side": side, "condition": condition, "what": what}
                rows.append(head | _mean(values, within=(0.0, 1.0) if what in SHARES else ANY))
    return pd.DataFrame(rows)


def quality(trials: pd.DataFrame) -> pd.DataFrame:
    """Give median and range of how well markers and model agree, over all trials that were used."""
    rows = []
    for what in QUALITY:
        values = np.asarray(trials[what] if what in trials else [], dtype=float)
        values = values[np.isfinite(values)]
        if values.size:
            low, middle, high = np.percentile(values, [5.0, 50.0, 95.0])
            row = {"what": what, "median": middle, "percentile_5": low, "percentile_95": high}
            rows.append(row | {"trials": len(values)})
    return pd.DataFrame(rows)


def weights_over_people(pooled: Mapping[Key, WeightEstimate]) -> pd.DataFrame:
    """Give the mean of each joint's weight over people (geometric, largest = 1).

    A person gives the ratios of their largest group of joints, so that a person in whom one joint
    could not be identified still counts for the others: log-weights are fitted by a level for
    each person and one for each joint. Intervals are those of the jackknife over people.
    """
    rows = []
    for side in dict.fromkeys(key[1] for key in pooled):
        own = [e for (_, s, _), e in pooled.items() if s == side]
        joints, logs = _log_weights(own)
        if joints:
            rows += _joint_rows(side, joints, logs, len(own))
    return pd.DataFrame(rows)


def weights_on_one_scale(estimates: Mapping[str, WeightEstimate]) -> pd.DataFrame:
    """Give people's weights side by side: each person's level is fitted, largest mean = 1.

    Args:
        estimates: of each person, one condition.

    Returns:
        One row a person and identified joint: subject, joint, weight.
    """
    joints, logs = _log_weights(list(estimates.values()))
    found = [subject for subject, e in estimates.items() if e.groups]
    if not joints:
        return pd.DataFrame({"subject": [], "joint": [], "weight": []})
    level = joint_levels(logs)
    scaled = np.exp(_levelled(logs, level) - level.max())
    rows = [
        {"subject": subject, "joint": joint, "weight": scaled[i, j]}
        for i, subject in enumerate(found)
        for j, joint in enumerate(joints)
        if np.isfinite(scaled[i, j])
    ]
    return pd.DataFrame(rows, columns=["subject", "joint", "weight"])


def _log_weights(estimates: Sequence[WeightEstimate]) -> tuple[tuple[str, ...], np.ndarray]:
    """Give the joints identified in anybody, and log-weights (people, joints) of those found."""
    found = [e for e in estimates if e.groups]
    known = {joint for e in found for joint in _largest(e)}
    joints = tuple(j for j in (estimates[0].joints if estimates else ()) if j in known)
    logs = np.full((len(found), len(joints)), np.nan)
    for i, e in enumerate(found):
        for joint in _largest(e):
            logs[i, joints.index(joint)] = np.log(e.weights[e.joints.index(joint)])
    return joints, logs


def _levelled(logs: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Shift each person's log-weights to where they fit the joints' levels best."""
    known = np.isfinite(logs)
    apart = np.where(known, logs - level, 0.0).sum(axis=1) / known.sum(axis=1)
    return logs - apart[:, None]


def _joint_rows(
    side: str, joints: tuple[str, ...], logs: np.ndarray, of: int
) -> list[dict[str, object]]:
    level = joint_levels(logs)
    n = len(logs)
    half = np.full(len(joints), np.nan)
    if n > 2:
        without = np.array([joint_levels(np.delete(logs, i, axis=0)) for i in range(n)])
        spread = np.sqrt((n - 1) / n * ((without - without.mean(axis=0)) ** 2).sum(axis=0))
        half = interval_factor(LEVEL, n) * spread
    top = level.max()
    own = _levelled(logs, level)
    return [
        {
            "side": side,
            "joint": joint,
            "weight": np.exp(level[i] - top),
            "lower": np.exp(level[i] - half[i] - top),
            "upper": np.exp(level[i] + half[i] - top),
            "lowest": np.exp(np.nanmin(own[:, i]) - top),
            "highest": np.exp(np.nanmax(own[:, i]) - top),
            "people": int(np.isfinite(logs[:, i]).sum()),
            "of": of,
        }
        for i, joint in enumerate(joints)
    ]


def joint_levels(logs: np.ndarray) -> np.ndarray:
    """Give the joints' part of log-weights, mean 0, by least squares with a level for each person.

    Args:
        logs: (people, joints), NaN where not identified.

    Returns:
        NaN for all joints where the people's groups do not tie them to each other.

    Example:
        >>> both = [[0.0, 1.0, np.nan], [np.nan, 5.0, 7.0]]
        >>> joint_levels(np.array(both)).round(9).tolist()
        [-1.333333333, -0.333333333, 1.666666667]
    """
    people, joints = logs.shape
    i, j = np.nonzero(np.isfinite(logs))
    design = np.zeros((len(i), people + joints))
    design[np.arange(len(i)), i] = 1.0
    design[np.arange(len(i)), people + j] = 1.0
    found, _, rank, _ = np.linalg.lstsq(design, logs[i, j], rcond=None)
    empty = int((~np.isfinite(logs)).all(axis=1).sum())
    if rank < people - empty + joints - 1:
        return np.full(joints, np.nan)
    return found[people:] - found[people:].mean()


def _largest(estimate: WeightEstimate) -> tuple[str, ...]:
    return tuple(max(estimate.groups, key=len))


def _by_limb(table: pd.DataFrame) -> list[tuple[tuple[str, str], pd.DataFrame]]:
    if not len(table):
        return []
    named = table.assign(**{k: table[k].fillna("") for k in LIMBS})
    groups = named.groupby(LIMBS, sort=False)
    return [((str(side), str(condition)), part) for (side, condition), part in groups]  # pyright: ignore[reportGeneralTypeIssues]


def _spread(people: Sequence[np.ndarray]) -> dict[str, object]:
    """Describe angles (deg) of several people by their spread, on the circle."""
    everything = np.deg2rad(np.concatenate(people))
    centre = float(np.rad2deg(np.arctan2(np.sin(everything).mean(), np.cos(everything).mean())))
    near = [(angles - centre + 180.0) % 360.0 - 180.0 for angles in people]
    means = np.array([angles.mean() for angles in near])
    squares = np.array([angles.var(ddof=1) if len(angles) > 1 else np.nan for angles in near])
    dof = sum(len(angles) - 1 for angles in near)
    total = sum(float(((a - m) ** 2).sum()) for a, m in zip(near, means, strict=True))
    known = squares[np.isfinite(squares)]
    return {
        "people": len(people),
        "movements": len(everything),
        "mean_deg": centre + float(means.mean()),
        **_deviation("within", float(np.sqrt(total / dof)) if dof else np.nan, dof),
        "within_median_deg": float(np.sqrt(np.median(known))) if known.size else np.nan,
        **_deviation(
            "between", float(means.std(ddof=1)) if len(means) > 1 else np.nan, len(means) - 1
        ),
    }


def _deviation(name: str, value: float, dof: int) -> dict[str, float]:
    """Give a standard deviation with its interval from χ²."""
    low, high = np.nan, np.nan
    if dof > 0:
        tail = 0.5 * (1.0 - LEVEL)
        low = value * float(np.sqrt(dof / chdtri(dof, tail)))
        high = value * float(np.sqrt(dof / chdtri(dof, 1.0 - tail)))
    return {f"{name}_deg": value, f"{name}_lower_deg": low, f"{name}_upper_deg": high}


def _mean(values: np.ndarray, *, within: tuple[float, float]) -> dict[str, object]:
    """Describe people's values; an interval ends where values do, which costs it no coverage."""
    n = len(values)
    spread = float(values.std(ddof=1)) if n > 1 else np.nan
    half = interval_factor(LEVEL, n) * spread / np.sqrt(n) if n > 1 else np.nan
    mean = float(values.mean())
    lower, upper = np.clip([mean - half, mean + half], *within).tolist()
    return {"people": n, "mean": mean, "sd": spread, "lower": lower, "upper": upper}
