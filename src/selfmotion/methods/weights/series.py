"""Weights of each trial, and of each part of the movement.

[Khoramshahi2022] section 5: weights average over time; estimating them in intervals gives insight
into temporal coordination, at the price of fewer samples a weight.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Float

from selfmotion.errors import RangeError, SelfmotionError, ShapeError
from selfmotion.methods.identification import identify_weights
from selfmotion.methods.weights.estimate import WeightEstimate, nothing_identified
from selfmotion.methods.weights.options import (
    DEFAULT_OPTIONS,
    IdentificationOptions,
    Method,
)
from selfmotion.motion.recording import Recording, Study
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class WeightSeries:
    """One estimate an item; an item that failed has NaN and a status that says why.

    Attributes:
        names: what each item is: a recording's name, or ``"0.2-0.4"`` of the movement.
        estimates: in the same order.
        edges: first and last fraction of the movement of each item (items, 2).
    """

    names: tuple[str, ...]
    estimates: tuple[WeightEstimate, ...]
    edges: Float[np.ndarray, "items 2"]

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row an item and joint."""
        import pandas as pd

        tables = []
        for name, edge, estimate in zip(self.names, self.edges, self.estimates, strict=True):
            table = estimate.to_frame()
            table.insert(0, "item", name)
            table.insert(1, "from", edge[0])
            table.insert(2, "to", edge[1])
            table["status"] = estimate.status.sentence
            tables.append(table)
        return pd.concat(tables, ignore_index=True)


def weights_by_trial(
    data: Recording | Study | Sequence[Recording],
    *,
    method: Method = "ml",
    null_ratio: float | Sequence[float] = 0.9,
    null_schedule: Literal["constant", "printed"] = "constant",
    options: IdentificationOptions = DEFAULT_OPTIONS,
) -> WeightSeries:
    """Identify weights of each recording alone; arguments as in `identify_weights`.

    Each estimate describes its trial: the standard errors rest on stretches of it, and slow
    null-space motion of one trial shifts its weights by more than they say.

    Example:
        >>> t = np.linspace(0, 6, 60)
        >>> qd, J = np.outer(np.sin(t), [0.1, 0.9]), np.ones((60, 1, 2))      # eq. 14
        >>> two = [Recording(t, qd=qd, jacobian=J), Recording(t, qd=qd[:, ::-1], jacobian=J)]
        >>> [e.contribution.round(6).tolist() for e in weights_by_trial(two).estimates]
        [[0.1, 0.9], [0.9, 0.1]]
    """

    def identify(part: Study) -> WeightEstimate:
        return identify_weights(
            part, method=method, null_ratio=null_ratio, null_schedule=null_schedule, options=options
        )

    trials = Study((data,) if isinstance(data, Recording) else tuple(data))
    estimates = [_attempt(identify, (trial,), method) for trial in trials]
    edges = np.tile([0.0, 1.0], (len(trials), 1))
    return WeightSeries(tuple(trial.name for trial in trials), tuple(estimates), edges)


def estimate_each(
    parts: Mapping[str, Iterable[Recording]],
    identify: Callable[[Study], WeightEstimate],
    method: Method = "ml",
) -> dict[str, WeightEstimate]:
    """Estimate each part of the data alone; one that fails has a status, and the rest goes on.

    Args:
        parts: name to recordings, as of one person, one file or one condition.
        identify: takes the part's recordings.
        method: what to call the method in the estimate of a part that failed.
    """
    return {name: _attempt(identify, tuple(part), method) for name, part in parts.items()}


def weights_by_window(
    data: Recording | Study | Sequence[Recording],
    *,
    windows: int | Sequence[float] = 5,
    method: Method = "ml",
    null_ratio: float | Sequence[float] = 0.9,
    null_schedule: Literal["constant", "printed"] = "constant",
    options: IdentificationOptions = DEFAULT_OPTIONS,
) -> WeightSeries:
    """Identify weights of each part of the movement, pooled over recordings.

    Args:
        data: recordings; time runs from 0 (start) to 1 (end) in each of them.
        windows: number of equal parts, or their edges, ascending from 0 to 1.
        method: as in `identify_weights`.
        null_ratio: as in `identify_weights`.
        null_schedule: as in `identify_weights`.
        options: as in `identify_weights`.

    Raises:
        RangeError: edges that do not ascend within 0 to 1.

    Example:
        >>> t = np.linspace(0, 1, 80)
        >>> share = np.where(t[:, None] < 0.5, [0.1, 0.9], [0.4, 0.6])
        >>> one = Recording(t, qd=np.cos(t)[:, None] * share, jacobian=np.ones((80, 1, 2)))
        >>> series = weights_by_window(one, windows=2)
        >>> [e.contribution.round(6).tolist() for e in series.estimates]
        [[0.1, 0.9], [0.4, 0.6]]
    """

    def identify(part: Study) -> WeightEstimate:
        return identify_weights(
            part, method=method, null_ratio=null_ratio, null_schedule=null_schedule, options=options
        )

    trials = Study((data,) if isinstance(data, Recording) else tuple(data))
    edges = _edges(windows)
    estimates = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        cut = [_cut(trial, low, high, last=bool(high == edges[-1])) for trial in trials]
        part = tuple(piece for piece in cut if piece is not None)
        estimates.append(_attempt(identify, part or trials.recordings[:1], method, empty=not part))
    names = tuple(f"{a:.4g}-{b:.4g}" for a, b in zip(edges[:-1], edges[1:], strict=True))
    return WeightSeries(names, tuple(estimates), np.stack([edges[:-1], edges[1:]], axis=1))


def _edges(windows: int | Sequence[float]) -> np.ndarray:
    if isinstance(windows, int):
        if windows < 1:
            raise RangeError(f"windows = {windows}: allowed is 1 or more")
        return np.linspace(0.0, 1.0, windows + 1)
    edges = np.asarray(windows, dtype=np.float64)
    if edges.ndim != 1 or len(edges) < 2:
        raise ShapeError(f"windows: edges of shape {edges.shape}; at least two are needed")
    if not ((np.diff(edges) > 0.0).all() and edges[0] >= 0.0 and edges[-1] <= 1.0):
        raise RangeError(f"windows = {edges.tolist()}: allowed are ascending edges within 0 to 1")
    return edges


def _cut(trial: Recording, low: float, high: float, *, last: bool) -> Recording | None:
    """Take the samples with low <= fraction < high as views (the last window takes its end)."""
    start, end = trial.time[0], trial.time[-1]
    bounds = start + np.array([low, high]) * (end - start)
    first = int(np.searchsorted(trial.time, bounds[0], side="left"))
    stop = int(np.searchsorted(trial.time, bounds[1], side="right" if last else "left"))
    return trial.window(first, stop) if stop > first else None


def _attempt(
    identify: Callable[[Study], WeightEstimate],
    part: Sequence[Recording],
    method: Method,
    *,
    empty: bool = False,
) -> WeightEstimate:
    joints = part[0].joints
    provenance = Provenance("identify_weights", choices={"method": method})
    if empty:
        return nothing_identified(joints, method, "no samples in this window", provenance)
    try:
        return identify(Study(tuple(part)))
    except SelfmotionError as error:
        return nothing_identified(joints, method, str(error), provenance)
