"""Left against right, task against task: paired tests on log-ratios of weights over people.

Hotelling's T² needs more people than ratios. Where there are too few, that is said, means and
t-intervals of each log-ratio stand in the table, and the test is made for the segments of the arm
(girdle, shoulder, elbow, wrist), whose contributions are sums over their joints.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from selfmotion.errors import SelfmotionError
from selfmotion.methods.hotelling import compare_weights, log_ratios
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.uncertainty import interval_factor

Key = tuple[str, str, str]  # subject, side, condition
# Joints by the beginning of their names.
SEGMENTS = {
    "scapula": "girdle",
    "shoulder": "shoulder",
    "elevation": "shoulder",
    "elv": "shoulder",
    "elbow": "elbow",
    "wrist": "wrist",
    "pro": "wrist",
    "deviation": "wrist",
    "flexion": "wrist",
}
LEAST_PEOPLE = 3


@dataclass(frozen=True)
class Comparison:
    """Two conditions of the same people.

    Attributes:
        name: as in ``drink, right against left``.
        first: key without the subject (side, condition).
        second: the same of the other.
    """

    name: str
    first: tuple[str, str]
    second: tuple[str, str]


def comparisons(keys: Sequence[Key]) -> tuple[Comparison, ...]:
    """List what can be compared: sides within a condition, conditions within a side.

    Example:
        >>> [c.name for c in comparisons([("P1", "right", "reach"), ("P1", "left", "reach")])]
        ['reach: right against left']
    """
    parts = list(dict.fromkeys(key[1:] for key in keys))
    found = []
    for condition in dict.fromkeys(condition for _, condition in parts):
        if ("right", condition) in parts and ("left", condition) in parts:
            sides = ("right", condition), ("left", condition)
            found.append(Comparison(f"{condition}: right against left", *sides))
    for side in dict.fromkeys(side for side, _ in parts):
        here = [part for part in parts if part[0] == side]
        for first, second in combinations(here, 2):
            name = f"{side}: {first[1]} against {second[1]}"
            found.append(Comparison(name, first, second))
    return tuple(found)


def compare_all(
    estimates: Mapping[Key, WeightEstimate], *, rng: np.random.Generator
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Make all comparisons.

    Args:
        estimates: of each person, side and condition.
        rng: for the sign flips where not all can be tried.

    Returns:
        The tests, up to two rows a comparison (joints, segments), each with a sentence, for the
        people in whom weights were identified both times; and the
        descriptive table, one row for each comparison and joint or segment: mean over people of
        the change of the log-ratio to the mean joint, with its t-interval.
    """
    tests, changes = [], []
    for comparison in comparisons(list(estimates)):
        people = [
            subject
            for subject in dict.fromkeys(key[0] for key in estimates)
            if (subject, *comparison.first) in estimates
            and (subject, *comparison.second) in estimates
        ]
        pairs = [
            (estimates[(p, *comparison.first)], estimates[(p, *comparison.second)]) for p in people
        ]
        found = [pair for pair in pairs if all(estimate.groups for estimate in pair)]
        for level, (names, first, second) in _levels(found).items():
            row = {
                "comparison": comparison.name,
                "level": level,
                "people": len(found),
                "without_weights": len(pairs) - len(found),
            }
            tests.append(row | _test(names, first, second, rng))
            changes += [
                {"comparison": comparison.name, "level": level, **change}
                for change in _changes(names, first, second)
            ]
    return pd.DataFrame(tests), pd.DataFrame(changes)


def comparison_lines(tests: pd.DataFrame) -> list[str]:
    """Say what came of the comparisons: a line for each test made, one for each reason for none.

    Example:
        >>> rows = [{"comparison": c, "level": "joints", "sentence": "no test"} for c in "ab"]
        >>> comparison_lines(pd.DataFrame(rows))
        ['no test. So in: a (joints); b (joints)']
    """
    lines: list[str] = []
    without: dict[str, list[str]] = {}
    for row in tests.to_dict("records"):
        name, t2 = f"{row['comparison']} ({row['level']})", row.get("t2", np.nan)
        if t2 == t2:
            lines.append(f"{name}: {row['sentence']}")
        else:
            without.setdefault(row["sentence"], []).append(name)
    return lines + [f"{why}. So in: {'; '.join(names)}" for why, names in without.items()]


def segment_of(joint: str) -> str:
    """Give the segment that a joint belongs to, by its name.

    Example:
        >>> segment_of("scapula_protraction"), segment_of("knee_angle")
        ('girdle', 'knee_angle')
    """
    return SEGMENTS.get(joint.partition("_")[0], joint)


def _levels(
    pairs: Sequence[tuple[WeightEstimate, WeightEstimate]],
) -> dict[str, tuple[list[str], np.ndarray, np.ndarray]]:
    """Give weights (people, joints or segments) of both conditions, for what all have."""
    if not pairs:
        none = np.empty((0, 0))
        return {"joints": ([], none, none)}
    joints = pairs[0][0].joints
    both = np.array([[_largest_group(e) for e in pair] for pair in pairs])  # people, 2, joints
    known = np.asarray(np.isfinite(both).all(axis=(0, 1)))
    names = [joint for joint, there in zip(joints, known, strict=True) if there]
    first, second = both[:, 0][:, known], both[:, 1][:, known]
    segments = list(dict.fromkeys(segment_of(name) for name in names))
    member = np.array([[segment_of(name) == s for name in names] for s in segments], dtype=float)
    # A segment's contribution is the sum over its joints; its weight is the inverse of that.
    summed = [1.0 / ((1.0 / w) @ member.T) if names else w for w in (first, second)]
    return {"joints": (names, first, second), "segments": (segments, summed[0], summed[1])}


def _largest_group(estimate: WeightEstimate) -> np.ndarray:
    """Give the weights of the largest group, NaN elsewhere: ratios mean nothing across groups."""
    largest = max(estimate.groups, key=len)
    return np.where(np.isin(estimate.joints, largest), estimate.weights, np.nan)


def _test(
    names: list[str], first: np.ndarray, second: np.ndarray, rng: np.random.Generator
) -> dict[str, object]:
    n, ratios = len(first), len(names) - 1
    row: dict[str, object] = {"compared": ", ".join(names), "ratios": max(ratios, 0)}
    if n <= ratios or ratios < 1 or n < LEAST_PEOPLE:
        need = max(ratios + 1, LEAST_PEOPLE)
        what = f"{_count(n, 'person', 'people')} for {_count(ratios, 'ratio', 'ratios')}"
        what = what if ratios > 0 else "no ratio that all have"
        return row | {"sentence": f"{what}: no test ({need} people needed), see the table of means"}
    try:
        test = compare_weights(first, second, rng=rng)
    except SelfmotionError as error:
        return row | {"sentence": f"no test: {error}"}
    return row | {
        "t2": test.t2,
        "f": test.f,
        "df": f"{test.df[0]}, {test.df[1]}",
        "p": test.p_value,
        "p_permutation": test.p_permutation,
        "effect": test.effect,
        "sentence": str(test),
    }


def _count(number: int, one: str, more: str) -> str:
    return f"{number} {one if number == 1 else more}"


def _changes(names: list[str], first: np.ndarray, second: np.ndarray) -> list[dict[str, object]]:
    """Describe the change of each log-weight against the mean of all (centred log-ratios)."""
    if len(names) < 2:
        return []
    change = _centred(second) - _centred(first)
    n = len(change)
    mean = change.mean(axis=0)
    half = np.full(len(names), np.nan)
    if n > 1:
        half = interval_factor(0.95, n) * change.std(axis=0, ddof=1) / np.sqrt(n)
    return [
        {"what": name, "mean_log_change": m, "lower": m - h, "upper": m + h, "people": n}
        for name, m, h in zip(names, mean.tolist(), half.tolist(), strict=True)
    ]


def _centred(weights: np.ndarray) -> np.ndarray:
    logs = np.concatenate([np.zeros((len(weights), 1)), log_ratios(weights)], axis=1)
    return logs - logs.mean(axis=1, keepdims=True)
