"""Moments of a movement: at which sample a reach ends, a cup is grasped, a drink is half done.

A study file says by rules, for each condition, what its moments are::

    [moments.drink]
    strokes = 4                                          # reach, to the mouth, back, withdraw
    grasp = {stroke = 1, at = "end"}
    mid_drink = {between = [2, 3], at = "slowest"}

    [moments.reach]
    strokes = 1
    end_of_reach = {stroke = 1, at = "end"}

A rule names a stroke (counted from 1) and its ``start``, ``peak`` or ``end``; or two strokes and
the moment between their peaks at which the hand is ``slowest``, or the ``middle`` of the time
between the end of one and the start of the other; or, with no stroke, ``at = "farthest"``: the hand
is farthest from where it began. `strokes` says how many the movement should have: the depth of the
valley that parts two strokes is lowered until so many remain. A movement that has another number
has none of the moments that count strokes, and says so. Every movement has ``start`` and ``end``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError, unknown_name
from selfmotion.motion.strokes import Stroke, StrokeRules, find_strokes, movement_span

OF_STROKE = ("start", "peak", "end")
BETWEEN_STROKES = ("slowest", "middle")
OF_PATH = ("farthest",)
PLACES = (*OF_STROKE, *BETWEEN_STROKES, *OF_PATH)
ALWAYS = ("start", "end")
# Shares of the lower peak below which speed parts two strokes, tried in turn.
VALLEYS = (0.5, 0.4, 0.3, 0.2, 0.1, 0.05)
KEYS = ("at", "stroke", "between")


@dataclass(frozen=True)
class MomentRule:
    """Where one moment is.

    Attributes:
        at: one of start, peak, end (of a stroke), slowest, middle (between two), farthest.
        stroke: counted from 1; None where two are named, or none is needed.
        between: two strokes, the earlier first.
    """

    at: str
    stroke: int | None = None
    between: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        """Check that the place fits the strokes named."""
        if self.at not in PLACES:
            raise unknown_name("moment", self.at, PLACES)
        if self.stroke is not None and self.between is not None:
            raise RangeError("a moment takes stroke or between, not both")
        named = OF_PATH if self.between is None else BETWEEN_STROKES
        named = named if self.stroke is None else OF_STROKE
        if self.at not in named:
            needs = "stroke = N" if self.at in OF_STROKE else "between = [N, M]"
            needs = "neither stroke nor between" if self.at in OF_PATH else needs
            raise RangeError(f"at = {self.at!r}: needs {needs}")
        if self.stroke is not None and self.stroke < 1:
            raise RangeError(f"stroke = {self.stroke}: strokes count from 1")
        if self.between is not None and not 1 <= self.between[0] < self.between[1]:
            raise RangeError(
                f"between = [{self.between[0]}, {self.between[1]}]: two strokes, counted from 1, "
                "the earlier first"
            )

    @property
    def last_stroke(self) -> int:
        """The highest stroke that is named; 0: none."""
        return max(self.stroke or 0, *(self.between or (0, 0)))


@dataclass(frozen=True)
class ConditionMoments:
    """The moments of one condition.

    Attributes:
        rules: moment to rule.
        strokes: how many strokes the movement should have; None: as many as are found.
    """

    rules: Mapping[str, MomentRule] = field(default_factory=dict, hash=False)
    strokes: int | None = None

    def __post_init__(self) -> None:
        """Check that the strokes named are among those expected."""
        if self.strokes is not None and self.strokes < 1:
            raise RangeError(f"strokes = {self.strokes}: at least 1")
        for name, rule in self.rules.items():
            if name in ALWAYS:
                raise RangeError(f"{name}: every movement has it, it takes no rule")
            if self.strokes is not None and rule.last_stroke > self.strokes:
                raise RangeError(f"{name}: stroke {rule.last_stroke} of {self.strokes}")


@dataclass(frozen=True)
class FoundMoments:
    """The moments of one movement.

    Attributes:
        samples: moment to sample; ``start`` and ``end`` always.
        missing: moment to the reason why it could not be found.
    """

    samples: Mapping[str, int]
    missing: Mapping[str, str]


def read_moments(table: Mapping[str, object]) -> dict[str, ConditionMoments]:
    """Read the table ``moments`` of a study file: condition to its moments.

    Raises:
        SelfmotionError: one line that names condition, moment and what is allowed.

    Example:
        >>> rules = read_moments({"drink": {"grasp": {"stroke": 1, "at": "end"}}})
        >>> rules["drink"].rules["grasp"]
        MomentRule(at='end', stroke=1, between=None)
    """
    found = {}
    for condition, moments in table.items():
        where = f"moments.{condition}"
        if not isinstance(moments, dict):
            raise RangeError(f"{where} = {moments!r}: a table of moments is needed")
        try:
            strokes = moments.get("strokes")
            if strokes is not None and not _whole(strokes):
                raise RangeError(f"strokes = {strokes!r}: a whole number is needed")
            rules = {k: _rule(k, v) for k, v in moments.items() if k != "strokes"}
            found[condition] = ConditionMoments(rules, strokes)
        except SelfmotionError as error:
            raise type(error)(f"{where}: {error}") from None
    return found


def find_moments(
    moments: ConditionMoments,
    path: Float[np.ndarray, "samples 3"],
    time: Float[np.ndarray, " samples"],
    speed: Float[np.ndarray, " samples"],
    *,
    rest_share: float = 0.05,
) -> FoundMoments:
    """Find the moments of one movement.

    Args:
        moments: the rules of its condition.
        path: of the hand (m); NaN in gaps.
        time: s.
        speed: of the hand (m/s); NaN in gaps, which count as rest.
        rest_share: share of peak speed that counts as rest; 0: the whole recording is movement.

    Raises:
        NotFiniteError: the hand was never seen.
        RangeError: nothing moves.

    Example:
        >>> t = np.linspace(0.0, 2.0, 201)
        >>> x = np.stack([1.0 - np.cos(np.pi * t), 0 * t, 0 * t], axis=1)
        >>> rules = ConditionMoments({"turn": MomentRule("farthest")})
        >>> found = find_moments(rules, x, t, np.abs(np.sin(np.pi * t)))
        >>> dict(found.samples)
        {'start': 1, 'end': 199, 'turn': 100}
    """
    if not np.isfinite(speed).any():
        raise NotFiniteError("moments: the hand was never seen")
    samples: dict[str, int] = {}
    samples["start"], samples["end"] = _span(speed, rest_share)
    strokes = _strokes(moments, np.nan_to_num(speed), time, rest_share)
    missing = {}
    for name, rule in moments.rules.items():
        if rule.at in OF_PATH:
            samples[name] = _farthest(path, samples["start"])
        elif moments.strokes is not None and len(strokes) != moments.strokes:
            missing[name] = f"{len(strokes)} strokes instead of {moments.strokes}"
        elif rule.last_stroke > len(strokes):
            missing[name] = f"{len(strokes)} strokes, no stroke {rule.last_stroke}"
        else:
            samples[name] = _sample(rule, strokes, speed)
    return FoundMoments(samples, missing)


def _rule(name: str, given: object) -> MomentRule:
    if not isinstance(given, dict):
        raise RangeError(f'{name} = {given!r}: a table is needed, as in {{stroke = 1, at = "end"}}')
    for key in given:
        if key not in KEYS:
            raise unknown_name(f"key of {name}", key, KEYS)
    at, stroke, between = given.get("at"), given.get("stroke"), given.get("between")
    if not isinstance(at, str):
        raise RangeError(f"{name}: at = one of {', '.join(PLACES)} is needed")
    pair = None
    if between is not None:
        if not isinstance(between, list) or len(between) != 2 or not all(map(_whole, between)):
            raise RangeError(f"{name}: between = {between!r}: two whole numbers are needed")
        pair = (int(between[0]), int(between[1]))
    if stroke is not None and not _whole(stroke):
        raise RangeError(f"{name}: stroke = {stroke!r}: a whole number is needed")
    try:
        return MomentRule(at, stroke, pair)
    except SelfmotionError as error:
        raise type(error)(f"{name}: {error}") from None


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _span(speed: np.ndarray, rest_share: float) -> tuple[int, int]:
    if not rest_share:
        return 0, len(speed) - 1
    return movement_span(speed, share=rest_share)


def _strokes(
    moments: ConditionMoments, speed: np.ndarray, time: np.ndarray, rest_share: float
) -> tuple[Stroke, ...]:
    """Find strokes, parted by valleys so deep that the wanted number remains where it can."""
    if not any(rule.last_stroke for rule in moments.rules.values()):
        return ()
    found = ()
    for valley in VALLEYS:
        found = find_strokes(speed, time, rules=StrokeRules(share=rest_share, valley=valley))
        if moments.strokes is None or len(found) <= moments.strokes:
            break
    return found


def _sample(rule: MomentRule, strokes: tuple[Stroke, ...], speed: np.ndarray) -> int:
    if rule.between is None:
        stroke = strokes[(rule.stroke or 1) - 1]
        return {"start": stroke.onset, "peak": stroke.peak, "end": stroke.offset}[rule.at]
    first, second = (strokes[n - 1] for n in rule.between)
    if rule.at == "middle":
        return (first.offset + second.onset) // 2
    return first.peak + int(np.nanargmin(speed[first.peak : second.peak + 1]))


def _farthest(path: np.ndarray, start: int) -> int:
    seen = np.flatnonzero(np.isfinite(path).all(axis=1))
    origin = path[seen[np.searchsorted(seen, start).clip(max=len(seen) - 1)]]
    return int(np.nanargmax(np.linalg.norm(path - origin, axis=1)))
