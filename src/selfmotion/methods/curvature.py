"""Curvature of paths: areas to the right and left of the straight line, hysteresis, and tests.

[Tommasino2017], doi 10.3389/fnbot.2017.00065, after Charles & Hogan (Exp. Brain Res. 203:63, 2010).
For a movement, A_R and A_L are the areas that the path encloses with the line between its targets
on the right and on the left (seen along the movement), over the squared distance of the targets;
A_sum = A_R + A_L, A_net = A_R - A_L, and the hysteresis of an outbound movement and its return is
A_net(out) + A_net(in).

Deviations: p-values are corrected for the number of movements tested together (Holm). The paper's
test A_sum ≠ 0 is reported but marked: A_sum cannot be negative, so that it says nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike
from scipy.special import stdtr  # scipy.stats takes a second to import

from selfmotion.arrays import as_float_array, require_finite
from selfmotion.errors import RangeError, ShapeError
from selfmotion.spatial import unit

if TYPE_CHECKING:
    import pandas as pd

Reference = Literal["targets", "movement"]
VACUOUS = "A_sum cannot be negative: this test says nothing"
LEVEL = 0.05
OUT_AND_BACK = ("outbound", "inbound")


@dataclass(frozen=True)
class PathAreas:
    """Areas between a path and its straight line, over the squared distance of the targets.

    Attributes:
        right: A_R, not negative.
        left: A_L, not negative.
    """

    right: float
    left: float

    @property
    def total(self) -> float:
        """A_sum."""
        return self.right + self.left

    @property
    def net(self) -> float:
        """A_net: positive where the path veers to the right."""
        return self.right - self.left


def path_areas(
    path: ArrayLike,
    start: ArrayLike,
    end: ArrayLike,
    *,
    reference: Reference = "targets",
    up: ArrayLike | None = None,
) -> PathAreas:
    """Give the areas that a path encloses with a straight line.

    The ends of the path are closed by perpendiculars to the line. The path is split where it
    crosses the line, and each piece between crossings counts with its net area.

    Args:
        path: (K, 2), or (K, 3) with `up` (m).
        start: target where the movement begins (m).
        end: target where it should end.
        reference: "targets": the line between the targets (the paper's text); "movement": from
            the first to the last sample (the caption of its Fig. 4).
        up: (3,) direction from which right and left are seen; paths in space need it.

    Returns:
        A_R and A_L over the squared distance between start and end.

    Raises:
        ShapeError: the arrays do not fit.
        NotFiniteError: a value is not finite.
        RangeError: start and end coincide, or the line is parallel to `up`.

    Example:
        A path north that bulges to the east, along the legs of a right-angled triangle:

        >>> path_areas([[0, 0], [0.5, 0.5], [0, 1]], [0, 0], [0, 1])
        PathAreas(right=0.25, left=0.0)
    """
    x = as_float_array("path", path, ndim=2)
    require_finite("path", x)
    a, b = (as_float_array(n, v, ndim=1) for n, v in (("start", start), ("end", end)))
    if len(x) < 2 or x.shape[1] not in (2, 3) or a.shape != b.shape or a.shape != x.shape[1:]:
        raise ShapeError(
            f"path {x.shape}, start {a.shape}, end {b.shape}: expected (samples, 2 or 3) and "
            "targets of the same width"
        )
    if (x.shape[1] == 3) != (up is not None):
        raise ShapeError("up: needed for a path in space, and only there")
    distance = float(np.linalg.norm(b - a))
    if not distance > 1e-9:
        raise RangeError("start and end: they coincide, so that there is no straight line")
    if reference == "movement":
        a, b = x[0], x[-1]
    along = unit("the line", b - a)
    beside = (x - a) @ _rightward(along, up)
    right, left = _lobes((x - a) @ along, beside)
    return PathAreas(right / distance**2, left / distance**2)


def path_hysteresis(
    net: ArrayLike,
    ways: Sequence[tuple[str | None, str | None]],
    trials: Sequence[str | None] | None = None,
    *,
    directions: tuple[str, str] = OUT_AND_BACK,
) -> dict[str | None, Float[np.ndarray, " pairs"]]:
    """Sum A_net of each movement out and of the movement back that belongs to it, by target.

    The first movement out of a trial belongs to its first back to the same target, and so on.

    Args:
        net: (B,) A_net; NaN where a movement could not be used, which keeps its place.
        ways: target and direction of each movement.
        trials: trial of each; left out: all are of one.
        directions: how the way out and the way back are called.

    Returns:
        Target to the sums of its pairs, in order of appearance, NaN where one of the two is.
        Targets without a pair are left out.

    Raises:
        ShapeError: the lists are not as many.

    Example:
        >>> ways = [("NE", "outbound"), ("NE", "inbound"), ("E", "outbound")]
        >>> {k: v.round(2).tolist() for k, v in path_hysteresis([0.1, 0.2, 0.0], ways).items()}
        {'NE': [0.3]}
    """
    values = as_float_array("net", net, ndim=1)
    known = [None] * len(values) if trials is None else list(trials)
    if not len(values) == len(ways) == len(known):
        raise ShapeError(f"net: {len(values)} movements, {len(ways)} ways, {len(known)} trials")
    legs: dict[tuple[str | None, str | None], tuple[list[float], list[float]]] = {}
    for value, (target, direction), trial in zip(values.tolist(), ways, known, strict=True):
        if direction in directions:
            legs.setdefault((target, trial), ([], []))[directions.index(direction)].append(value)
    sums: dict[str | None, list[float]] = {}
    for (target, _), (out, back) in legs.items():
        # Where the two differ in number, the movements that belong to none come last.
        pairs = [a + b for a, b in zip(out, back, strict=False)]
        if pairs:
            sums.setdefault(target, []).extend(pairs)
    return {target: np.array(pairs) for target, pairs in sums.items()}


def holm(p_values: ArrayLike) -> Float[np.ndarray, " tests"]:
    """Correct p-values for their number, after Holm; NaN stays NaN and does not count.

    Example:
        >>> holm([0.01, 0.04, 0.03]).round(3).tolist()
        [0.03, 0.06, 0.06]
    """
    p = as_float_array("p_values", p_values, ndim=1)
    out = np.full(len(p), np.nan)
    known = np.flatnonzero(np.isfinite(p))
    order = known[np.argsort(p[known], kind="stable")]
    factors = np.arange(len(order), 0, -1)
    out[order] = np.minimum(np.maximum.accumulate(factors * p[order]), 1.0)
    return out


@dataclass(frozen=True, eq=False)
class MeanTests:
    """Tests of the mean of several groups against a value each, corrected together.

    Attributes:
        names: what each group is.
        n: (G,) number of movements.
        mean: (G,) their mean.
        sd: (G,) their standard deviation.
        against: (G,) the value tested against.
        t: (G,) Student's t; NaN with fewer than two movements or without spread.
        p: (G,) two-sided p-value.
        p_corrected: (G,) after Holm.
        note: what to know about the test.
    """

    names: tuple[str, ...]
    n: np.ndarray
    mean: np.ndarray
    sd: np.ndarray
    against: np.ndarray
    t: np.ndarray
    p: np.ndarray
    p_corrected: np.ndarray
    note: str = ""

    @property
    def differs(self) -> np.ndarray:
        """Which groups differ from their value after correction, at 5 %."""
        return np.nan_to_num(self.p_corrected, nan=1.0) < LEVEL

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a group."""
        import pandas as pd

        return pd.DataFrame(
            {
                "group": self.names,
                "n": self.n,
                "mean": self.mean,
                "sd": self.sd,
                "against": self.against,
                "t": self.t,
                "df": self.n - 1,
                "p": self.p,
                "p_corrected": self.p_corrected,
                "differs": self.differs,
                "note": self.note,
            }
        )


def mean_tests(
    groups: Sequence[ArrayLike],
    names: Sequence[str],
    *,
    against: ArrayLike = 0.0,
    note: str = "",
) -> MeanTests:
    """Test the mean of each group by Student's t, corrected for the number of groups.

    Args:
        groups: G lists of numbers (A_net of the repetitions of one movement, say).
        names: G names.
        against: one value, or G (the areas that a model predicts).
        note: remark for the table.

    Raises:
        ShapeError: groups, names and values are not as many.
        NotFiniteError: a number is not finite.

    Example:
        >>> tests = mean_tests([[0.1, 0.2, 0.15], [-0.1, 0.1, 0.0]], ["E", "N"])
        >>> tests.p.round(3).tolist()
        [0.035, 1.0]
    """
    values = np.broadcast_to(as_float_array("against", against), (len(groups),))
    if len(names) != len(groups):
        raise ShapeError(f"names: {len(names)} for {len(groups)} groups")
    samples = [as_float_array(f"group {n}", g, ndim=1) for n, g in zip(names, groups, strict=True)]
    for name, x in zip(names, samples, strict=True):
        require_finite(f"group {name}", x)
    n = np.array([len(x) for x in samples])
    mean = np.array([x.mean() if len(x) else np.nan for x in samples])
    sd = np.array([x.std(ddof=1) if len(x) > 1 else np.nan for x in samples])
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(sd > 0.0, (mean - values) / (sd / np.sqrt(n)), np.nan)
    p = 2.0 * stdtr(np.maximum(n - 1, 1), -np.abs(t))
    return MeanTests(tuple(names), n, mean, sd, values.copy(), t, p, holm(p), note)


def _rightward(along: np.ndarray, up: ArrayLike | None) -> np.ndarray:
    """Give the unit direction to the right of a movement along `along`."""
    if up is None:
        return np.array([along[1], -along[0]])
    side = np.cross(along, unit("up", up))
    if not np.linalg.norm(side) > 1e-6:
        raise RangeError("up: parallel to the movement, which then has no right and left")
    return unit("right", side)


def _lobes(s: np.ndarray, d: np.ndarray) -> tuple[float, float]:
    """Sum the net areas of the pieces between crossings, on the right (d > 0) and on the left."""
    crossing = np.flatnonzero(d[:-1] * d[1:] < 0.0)
    share = d[crossing] / (d[crossing] - d[crossing + 1])
    where = s[crossing] + share * (s[crossing + 1] - s[crossing])
    s, d = np.insert(s, crossing + 1, where), np.insert(d, crossing + 1, 0.0)
    strips = 0.5 * (d[:-1] + d[1:]) * np.diff(s)
    side = np.sign(d[:-1] + d[1:])
    # A new piece begins where the side changes, or where the path touches the line.
    begins = np.concatenate([[True], (side[1:] != side[:-1]) | (d[1:-1] == 0.0)])
    piece = np.cumsum(begins) - 1
    areas = np.abs(np.bincount(piece, weights=strips))
    sides = side[begins]
    return float(areas[sides > 0.0].sum()), float(areas[sides < 0.0].sum())
