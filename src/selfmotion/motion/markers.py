"""Marker positions over time: what motion capture records before there are joint angles.

Units are metres and seconds; NaN marks a marker that was not seen. The frame is part of the data.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, no_type_check

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import as_float_array, freeze, require_shape
from selfmotion.errors import RangeError, ShapeError, unknown_name
from selfmotion.motion.checks import check_time, refuse_infinite
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels

if TYPE_CHECKING:
    import pandas as pd


# no_type_check: what files hold arrives here unchecked; bad shapes must meet the checks below.
@no_type_check
@dataclass(frozen=True, eq=False)
class MarkerSet:
    """Positions of named markers in one recording.

    Attributes:
        time: instants (K,), s, strictly increasing.
        names: the M markers, each once, without a subject's prefix.
        positions: (K, M, 3) m in `frame`; NaN where a marker was not seen. A marker of which one
            coordinate is missing is missing as a whole.
        frame: the axes of `positions`.
        labels: subject, side, condition, target, trial.
        source: file name, or ``"simulated"``.

    Raises:
        ShapeError: shapes disagree, a name is empty or stands twice, or there is no marker.
        NotFiniteError: an infinite position.
        RangeError: `time` does not increase.

    Example:
        >>> seen = MarkerSet(np.arange(4) / 100, ("STRN", "RFTP"), np.zeros((4, 2, 3)))
        >>> seen.n_samples, seen.n_markers, round(seen.rate)
        (4, 2, 100)
    """

    time: Float[np.ndarray, " samples"]
    names: tuple[str, ...]
    positions: Float[np.ndarray, "samples markers 3"]
    frame: Frame = UNKNOWN_FRAME
    labels: Labels = Labels()
    source: str = "simulated"

    def __post_init__(self) -> None:
        """Check everything and take read-only views."""
        time = as_float_array("time", self.time, ndim=1)
        check_time(time)
        names = tuple(str(name) for name in self.names)
        _check_names(self.source, names)
        positions = as_float_array("positions", self.positions, ndim=3)
        require_shape("positions", positions, (len(time), len(names), 3))
        refuse_infinite("positions", positions)
        gaps = np.isnan(positions)
        if not np.array_equal(gaps.any(axis=2), gaps.all(axis=2)):
            positions = np.where(gaps.any(axis=2, keepdims=True), np.nan, positions)
        object.__setattr__(self, "time", freeze(time.view()))
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "positions", freeze(positions.view()))

    @property
    def n_samples(self) -> int:
        """Number of samples K."""
        return len(self.time)

    @property
    def n_markers(self) -> int:
        """Number of markers M."""
        return len(self.names)

    @property
    def rate(self) -> float | None:
        """Mean sampling rate, Hz; None with one sample."""
        if self.n_samples < 2:
            return None
        return float((self.n_samples - 1) / (self.time[-1] - self.time[0]))

    @property
    def name(self) -> str:
        """What to call the recording in a message: its source and labels."""
        return f"{self.source} ({self.labels})" if str(self.labels) else self.source

    def index(self, name: str) -> int:
        """Give the position of a marker among `names`.

        Raises:
            UnknownNameError: there is no such marker.
        """
        if name not in self.names:
            raise unknown_name(f"marker of {self.source}", name, self.names)
        return self.names.index(name)

    def point(self, name: str) -> Float[np.ndarray, "samples 3"]:
        """Give the path of one marker (K, 3), m.

        Raises:
            UnknownNameError: there is no such marker.
        """
        return self.positions[:, self.index(name)]

    def select(self, names: Sequence[str]) -> "MarkerSet":
        """Keep the markers named, in that order.

        Raises:
            UnknownNameError: there is no such marker.
        """
        columns = [self.index(name) for name in names]
        return replace(self, names=tuple(names), positions=self.positions[:, columns])

    def window(self, start: int, stop: int) -> "MarkerSet":
        """Cut samples start to stop (exclusive) out.

        Raises:
            RangeError: the window is empty or leaves the recording.
        """
        if not 0 <= start < stop <= self.n_samples:
            raise RangeError(
                f"window {start}:{stop}: allowed is 0 <= start < stop <= {self.n_samples}"
            )
        return replace(self, time=self.time[start:stop], positions=self.positions[start:stop])

    def missing(self) -> Bool[np.ndarray, "samples markers"]:
        """Mark where a marker was not seen."""
        return np.isnan(self.positions[..., 0])

    def in_frame(self, frame: Frame) -> "MarkerSet":
        """Turn all positions into another frame's axes; the origin stays.

        Raises:
            RangeError: an axis of either frame is not known.

        Example:
            >>> seen = MarkerSet(np.zeros(1), ("A",), np.array([[[1., 2., 3.]]]), Frame("z", "y"))
            >>> seen.in_frame(Frame("y", "x")).positions[0, 0].tolist()
            [2.0, 3.0, 1.0]
        """
        turn = self.frame.rotation_to(frame)
        return replace(self, positions=self.positions @ turn.T, frame=frame)

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a sample: time and NAME_x, NAME_y, NAME_z (m)."""
        import pandas as pd

        columns: dict[str, object] = {k: v for k, v in self.labels.to_dict().items() if v}
        columns["time"] = self.time
        for i, name in enumerate(self.names):
            columns |= {f"{name}_{a}": self.positions[:, i, j] for j, a in enumerate("xyz")}
        return pd.DataFrame(columns)


def without_prefix(names: Sequence[str]) -> tuple[tuple[str, ...], str | None]:
    """Part marker names from a subject's prefix (``P1:RSHO``), if all that have one share it.

    Returns:
        The bare names, and the prefix; the names as they are and None, where prefixes differ.

    Example:
        >>> without_prefix(["P1:RSHO", "P1:STRN"])
        (('RSHO', 'STRN'), 'P1')
    """
    parts = [name.rpartition(":") for name in names]
    prefixes = {prefix for prefix, colon, _ in parts if colon}
    if len(prefixes) != 1:
        return tuple(names), None
    return tuple(bare for _, _, bare in parts), prefixes.pop()


def without_prefix_of(markers: MarkerSet, wanted: Collection[str]) -> MarkerSet:
    """Take a subject's prefix off where other markers (of an object, say) have another one.

    Markers wanted that are there as they are named stay so.

    Raises:
        RangeError: two prefixes both have markers that are wanted: two people.

    Example:
        >>> seen = MarkerSet(np.zeros(1), ("box:A", "P1:STRN"), np.zeros((1, 2, 3)))
        >>> found = without_prefix_of(seen, {"STRN"})
        >>> found.names, found.labels.subject
        (('box:A', 'STRN'), 'P1')
    """
    parts = [name.rpartition(":") for name in markers.names]
    missing = {*wanted} - {*markers.names}
    prefixes = sorted({prefix for prefix, colon, bare in parts if colon and bare in missing})
    if not prefixes:
        return markers
    if len(prefixes) > 1:
        raise RangeError(
            f"{markers.name}: markers of {' and '.join(prefixes[:2])} beside each other; one "
            "person is needed"
        )
    names = tuple(
        bare if prefix == prefixes[0] and bare in missing else name
        for name, (prefix, _, bare) in zip(markers.names, parts, strict=True)
    )
    labels = markers.labels
    if labels.subject is None:
        labels = replace(labels, subject=prefixes[0])
    return replace(markers, names=names, labels=labels)


def _check_names(source: str, names: tuple[str, ...]) -> None:
    if not names:
        raise ShapeError(f"{source}: 0 markers; at least one is needed")
    if not all(names):
        raise ShapeError(f"{source}: marker {names.index('') + 1} has no name")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ShapeError(f"{source}: marker {twice[0]!r} is there more than once")
