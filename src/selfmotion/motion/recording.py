"""Recorded motion: one movement of one person, and the study that holds many of them.

Time is axis 0 everywhere. Units are seconds, radians (metres for prismatic joints) and metres.
Arrays are held as read-only views: building, windowing and selecting copy no samples.
"""

import warnings
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, no_type_check

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import (
    JacobianSamples,
    JointSamples,
    SampleMask,
    TaskSamples,
    as_float_array,
    freeze,
)
from selfmotion.errors import NotFiniteError, RangeError, ShapeError, unknown_name
from selfmotion.motion.checks import CHUNK, check_shapes, check_time, full_names, refuse_infinite
from selfmotion.motion.labels import LABEL_NAMES, UNKNOWN_FRAME, Frame, Labels

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["Frame", "GapWarning", "Labels", "Recording", "Study", "UNKNOWN_FRAME", "sample_numbers"]

FIELDS = ("q", "qd", "x", "xd", "jacobian")
ROW_NAMES = {2: ("x", "y"), 3: ("x", "y", "z"), 6: ("x", "y", "z", "rot_x", "rot_y", "rot_z")}


class GapWarning(UserWarning):
    """Samples that hold NaN were dropped; the message counts them."""


def sample_numbers(n_samples: int) -> Float[np.ndarray, " samples"]:
    """Number samples 0, 1, 2, ...: the `time` of a recording that has none (``timed=False``)."""
    return np.arange(n_samples, dtype=np.float64)


# no_type_check: what files hold arrives here unchecked, and bad shapes must meet the checks below
# (one line for the user) before any run-time type checker.
@no_type_check
@dataclass(frozen=True, eq=False)
class Recording:
    """One movement (trial) of one person.

    It holds the posture `q`, or the velocities `qd` with the `jacobian`, or the path `x`; what
    else is known comes beside it. NaN stands for a gap; infinite values are refused.

    Attributes:
        time: instants (K,), s, strictly increasing; sample numbers where `timed` is False.
        q: joint positions (K, n), rad (m for prismatic joints).
        qd: joint velocities (K, n), rad/s (m/s).
        x: task positions (K, m), m (rad for rotations).
        xd: task velocities (K, m), m/s (rad/s).
        jacobian: task Jacobian (K, m, n): ``xd = jacobian @ qd``.
        joints: joint names (n); ``joint_1`` ... where not given.
        rows: names of the task rows (m); ``x, y, z, rot_x, rot_y, rot_z`` where they fit.
        labels: subject, side, condition, target, trial.
        frame: the axes in which `x`, `xd` and `jacobian` are expressed.
        source: file name, or ``"simulated"``.
        timed: whether `time` is in seconds; if False nothing may be reported per second.

    Raises:
        ShapeError: shapes disagree, names repeat, or none of the needed fields is there.
        NotFiniteError: an infinite value, or a NaN in `time`.
        RangeError: `time` does not increase.

    Example:
        >>> walk = Recording(np.arange(5) / 100, q=np.zeros((5, 3)), labels=Labels(subject="P1"))
        >>> walk.n_samples, walk.n_joints, walk.rate, walk.joints
        (5, 3, 100.0, ('joint_1', 'joint_2', 'joint_3'))
    """

    time: Float[np.ndarray, " samples"]
    q: JointSamples | None = None
    qd: JointSamples | None = None
    x: TaskSamples | None = None
    xd: TaskSamples | None = None
    jacobian: JacobianSamples | None = None
    joints: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()
    labels: Labels = Labels()
    frame: Frame = UNKNOWN_FRAME
    source: str = "simulated"
    timed: bool = True

    def __post_init__(self) -> None:
        """Check everything and take read-only views."""
        time = as_float_array("time", self.time, ndim=1)
        check_time(time)
        arrays = {"time": time}
        for name in FIELDS:
            value = getattr(self, name)
            if value is not None:
                arrays[name] = as_float_array(name, value, ndim=3 if name == "jacobian" else 2)
        n_joints, n_rows = check_shapes(arrays)
        for name, array in arrays.items():
            refuse_infinite(name, array)
            object.__setattr__(self, name, freeze(array.view()))
        rows = ROW_NAMES.get(n_rows, tuple(f"row_{i + 1}" for i in range(n_rows)))
        joints = tuple(f"joint_{i + 1}" for i in range(n_joints))
        object.__setattr__(self, "joints", full_names("joints", self.joints, joints))
        object.__setattr__(self, "rows", full_names("rows", self.rows, rows))

    @property
    def n_samples(self) -> int:
        """Number of samples K."""
        return len(self.time)

    @property
    def n_joints(self) -> int:
        """Number of joints n (0 for a path alone)."""
        return len(self.joints)

    @property
    def n_rows(self) -> int:
        """Number of task rows m (0 where there is neither task motion nor Jacobian)."""
        return len(self.rows)

    @property
    def rate(self) -> float | None:
        """Mean sampling rate, Hz; None without seconds or with one sample."""
        if not self.timed or self.n_samples < 2:
            return None
        return float((self.n_samples - 1) / (self.time[-1] - self.time[0]))

    @property
    def name(self) -> str:
        """What to call the recording in a message: its source and labels."""
        return f"{self.source} ({self.labels})" if str(self.labels) else self.source

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the fields that are there, among q, qd, x, xd, jacobian."""
        return tuple(name for name in FIELDS if getattr(self, name) is not None)

    def array(self, name: str) -> np.ndarray:
        """Give a field that the caller cannot do without.

        Raises:
            ShapeError: the recording does not hold it.
        """
        if name not in FIELDS:
            raise unknown_name("field", name, FIELDS)
        value = getattr(self, name)
        if value is None:
            raise ShapeError(f"{self.name}: {name} is needed; it holds {', '.join(self.held)}")
        return value

    def window(self, start: int, stop: int) -> "Recording":
        """Cut samples start to stop (exclusive) out, as views.

        Raises:
            RangeError: the window is empty or leaves the recording.
        """
        if not 0 <= start < stop <= self.n_samples:
            raise RangeError(
                f"window {start}:{stop}: allowed is 0 <= start < stop <= {self.n_samples}"
            )
        return self._take(slice(start, stop))

    def gaps(self) -> SampleMask:
        """Mark the samples at which any field is NaN."""
        mask = np.zeros(self.n_samples, dtype=bool)
        for name in self.held:
            array = self.array(name)
            for at in range(0, self.n_samples, CHUNK):
                part = array[at : at + CHUNK]
                mask[at : at + CHUNK] |= np.isnan(part).reshape(len(part), -1).any(axis=1)
        return mask

    def drop_gaps(self) -> tuple["Recording", int]:
        """Leave out samples that hold NaN, with a :class:`GapWarning` that counts them.

        Returns:
            The recording (itself, if there is no gap) and the number of samples left out.

        Raises:
            NotFiniteError: no sample remains.

        Example:
            >>> q = np.zeros((4, 2)); q[1] = np.nan
            >>> with warnings.catch_warnings(record=True, action="always") as seen:
            ...     whole, dropped = Recording(np.arange(4.0), q=q).drop_gaps()
            >>> whole.n_samples, dropped, str(seen[0].message)
            (3, 1, 'simulated: 1 of 4 samples holds NaN and is left out')
        """
        kept, dropped = _without_gaps(self)
        if dropped:
            _warn_of_gaps(self.name, dropped, self.n_samples)
        return kept, dropped

    def to_xarray(self) -> "xr.Dataset":
        """Give a Dataset with dimensions time, joint and axis (the task rows)."""
        import xarray as xr

        dims = {
            "q": ("time", "joint"),
            "qd": ("time", "joint"),
            "x": ("time", "axis"),
            "xd": ("time", "axis"),
            "jacobian": ("time", "axis", "joint"),
        }
        coords: dict[str, object] = {"time": self.time}
        if self.n_joints:
            coords["joint"] = list(self.joints)
        if self.n_rows:
            coords["axis"] = list(self.rows)
        known = {k: v for k, v in self.labels.to_dict().items() if v is not None}
        attrs = known | {
            "source": self.source,
            "time_unit": "s" if self.timed else "sample",
            "frame_up": self.frame.up or "unknown",
            "frame_forward": self.frame.forward or "unknown",
        }
        return xr.Dataset({k: (dims[k], self.array(k)) for k in self.held}, coords, attrs)

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a sample: labels, time, joints, velocities, hand (rad, m, s).

        Columns are ``time`` (``sample`` without seconds), each joint's name, ``NAME_velocity``,
        ``hand_x``, ``hand_x_velocity``; the Jacobian has no place in a table and is left out.
        """
        import pandas as pd

        columns: dict[str, object] = {k: v for k, v in self.labels.to_dict().items() if v}
        columns["time" if self.timed else "sample"] = self.time
        hand = [f"hand_{row}" for row in self.rows]
        for field, names, suffix in (
            ("q", self.joints, ""),
            ("qd", self.joints, "_velocity"),
            ("x", hand, ""),
            ("xd", hand, "_velocity"),
        ):
            if field in self.held:
                columns |= {f"{k}{suffix}": self.array(field)[:, i] for i, k in enumerate(names)}
        return pd.DataFrame(columns)

    def _take(self, where: "slice | np.ndarray") -> "Recording":
        """Index every array along time."""
        parts = {name: self.array(name)[where] for name in self.held}
        return replace(self, time=self.time[where], **parts)


@dataclass(frozen=True, eq=False)
class Study:
    """Recordings of one or many people, in order; iterable, with a length.

    Attributes:
        recordings: the movements; they share no samples' copy, only views.

    Example:
        >>> still = np.zeros((4, 2))
        >>> study = Study(tuple(
        ...     Recording(np.arange(4.0), q=still, labels=Labels(subject=s, condition=c))
        ...     for s in ("P1", "P2") for c in ("natural", "viscous")))
        >>> len(study.select(condition="viscous")), list(study.group("subject"))
        (2, [('P1',), ('P2',)])
    """

    recordings: tuple[Recording, ...]

    def __post_init__(self) -> None:
        """Refuse a study without recordings."""
        object.__setattr__(self, "recordings", tuple(self.recordings))
        if not self.recordings:
            raise ShapeError("study: 0 recordings; at least one is needed")

    def __iter__(self) -> Iterator[Recording]:
        """Go through the recordings in order."""
        return iter(self.recordings)

    def __len__(self) -> int:
        """Count the recordings."""
        return len(self.recordings)

    def __getitem__(self, number: int) -> Recording:
        """Give one recording by its number."""
        return self.recordings[number]

    @property
    def n_samples(self) -> int:
        """Samples of all recordings together."""
        return sum(recording.n_samples for recording in self)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joint names that all recordings share.

        Raises:
            ShapeError: two recordings have different joints.
        """
        first = self.recordings[0]
        for other in self:
            if other.joints != first.joints:
                raise ShapeError(
                    f"{other.name}: joints {', '.join(other.joints)} differ from those of "
                    f"{first.name}: {', '.join(first.joints)}"
                )
        return first.joints

    @property
    def index(self) -> "pd.DataFrame":
        """Labels, source, samples and duration (s, NaN without seconds), one row a recording."""
        import pandas as pd

        rows = []
        for r in self:
            seconds = float(r.time[-1] - r.time[0]) if r.timed else float("nan")
            extra = {"source": r.source, "samples": r.n_samples, "duration": seconds}
            rows.append(r.labels.to_dict() | extra)
        return pd.DataFrame(rows)

    def values(self, label: str) -> tuple[str | None, ...]:
        """Give the distinct values of a label, in order of appearance."""
        if label not in LABEL_NAMES:
            raise unknown_name("label", label, LABEL_NAMES)
        return tuple(dict.fromkeys(getattr(r.labels, label) for r in self))

    def select(
        self,
        *,
        subject: str | Collection[str] | None = None,
        side: str | Collection[str] | None = None,
        condition: str | Collection[str] | None = None,
        target: str | Collection[str] | None = None,
        trial: str | Collection[str] | None = None,
    ) -> "Study":
        """Keep the recordings whose labels are as asked (one value or several); None: any.

        Raises:
            UnknownNameError: no recording has such a label.
            RangeError: each label exists, but not together.
        """
        asked = dict(zip(LABEL_NAMES, (subject, side, condition, target, trial), strict=True))
        kept = self.recordings
        for label, value in asked.items():
            if value is None:
                continue
            wanted = {value} if isinstance(value, str) else set(value)
            known = [str(v) for v in self.values(label) if v is not None]
            for name in sorted(wanted - set(known)):
                raise unknown_name(label, name, known)
            kept = tuple(r for r in kept if getattr(r.labels, label) in wanted)
        if not kept:
            words = ", ".join(f"{k} {v!r}" for k, v in asked.items() if v is not None)
            raise RangeError(f"select: no recording has {words} together")
        return Study(kept)

    def group(self, *labels: str) -> dict[tuple[str | None, ...], "Study"]:
        """Part the study by labels, in order of appearance; no recording is copied."""
        groups: dict[tuple[str | None, ...], list[Recording]] = {}
        for label in labels:
            self.values(label)  # refuses a label that does not exist
        for recording in self:
            key = tuple(getattr(recording.labels, label) for label in labels)
            groups.setdefault(key, []).append(recording)
        return {key: Study(tuple(members)) for key, members in groups.items()}

    def drop_gaps(self) -> tuple["Study", int]:
        """Leave out samples that hold NaN, with one :class:`GapWarning` for all recordings.

        A recording of nothing but gaps is left out whole.

        Raises:
            NotFiniteError: no sample of any recording remains.
        """
        some = [recording for recording in self if not recording.gaps().all()]
        if not some:
            raise NotFiniteError(f"{self[0].name}: all samples hold NaN; none remains")
        pairs = [_without_gaps(recording) for recording in some]
        dropped = self.n_samples - sum(kept.n_samples for kept, _ in pairs)
        if not dropped:
            return self, 0
        sources = tuple(dict.fromkeys(r.source for r in self))
        where = sources[0] if len(sources) == 1 else f"{len(sources)} files"
        _warn_of_gaps(where, dropped, self.n_samples)
        return Study(tuple(kept for kept, _ in pairs)), dropped


def _without_gaps(recording: Recording) -> tuple[Recording, int]:
    mask = recording.gaps()
    dropped = int(mask.sum())
    if dropped == recording.n_samples:
        raise NotFiniteError(f"{recording.name}: all {dropped} samples hold NaN; none remains")
    return (recording._take(~mask), dropped) if dropped else (recording, 0)


def _warn_of_gaps(where: str, dropped: int, total: int) -> None:
    verb = "holds NaN and is" if dropped == 1 else "hold NaN and are"
    message = f"{where}: {dropped} of {total} samples {verb} left out"
    warnings.warn(message, GapWarning, stacklevel=3)
