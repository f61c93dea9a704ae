"""From the named arrays of one file (.npz, flat .mat) to a study of views on them.

Fields: ``qd (K,n)`` with ``jacobian (K,m,n)``, or ``q (K,n)``, or ``x (K,m)``; optional ``xd``,
``time (K)`` s or ``dt`` s, ``joints (n)``, ``rows (m)``, the labels ``subject side condition
target trial`` as one value or one a sample, ``frame_up`` and ``frame_forward``. Each run of equal
labels becomes a recording.
"""

from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.arrays import as_float_array, require_finite
from selfmotion.errors import RangeError, SelfmotionError, ShapeError, UnknownNameError
from selfmotion.motion.checks import (
    CONSISTENCY,
    check_shapes,
    refuse_infinite,
    refuse_partial_gaps,
    velocity_residual,
)
from selfmotion.motion.labels import LABEL_NAMES, UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.recording import FIELDS, Recording, Study, sample_numbers

if TYPE_CHECKING:
    from collections.abc import Iterator

# `recording` tells apart recordings that carry the same labels.
RUN_NAMES = (*LABEL_NAMES, "recording")
KNOWN = (*FIELDS, "time", "dt", "joints", "rows", *RUN_NAMES, "frame_up", "frame_forward")
NEEDED = "qd with jacobian, or q, or x"


@contextmanager
def naming(source: str) -> "Iterator[None]":
    """Put the file's name before the message of whatever error its content raises."""
    try:
        yield
    except SelfmotionError as error:
        raise type(error)(f"{source}: {error}") from None


@dataclass(frozen=True, eq=False)
class _Shared:
    """What all recordings of a file have in common."""

    joints: tuple[str, ...]
    rows: tuple[str, ...]
    frame: Frame
    source: str
    step: float | None  # s from sample to sample where the file gives no time; None: not known


def study_from_arrays(source: str, arrays: Mapping[str, np.ndarray]) -> Study:
    """Check the arrays of a file and cut them into recordings, as views.

    Samples of one trial that lie apart in the file are brought together, at the cost of a copy.

    Args:
        source: the file's name, for messages and `Recording.source`.
        arrays: field names to arrays; fields that are not known are left aside.

    Raises:
        SelfmotionError: one line that names file, field, value and what is allowed.
    """
    with naming(source):
        _refuse_misspelt(arrays)
        numbers = _numeric_fields(arrays)
        samples = len(next(iter(numbers.values())))
        shared = _Shared(
            joints=_texts("joints", arrays),
            rows=_texts("rows", arrays),
            frame=_frame(arrays),
            source=source,
            step=_step(arrays),
        )
        starts, keys = _runs(arrays, samples)
        instants = _instants(arrays, samples)
        stops = np.append(starts[1:], samples)
        members: dict[tuple[str, ...], list[slice]] = {}
        for key, start, stop in zip(keys, starts.tolist(), stops.tolist(), strict=True):
            members.setdefault(key, []).append(slice(start, stop))
        recordings = [_recording(k, m, numbers, instants, shared) for k, m in members.items()]
        for recording in recordings:
            require_consistent(recording)
    return Study(tuple(recordings))


def require_whole_gaps(source: str, arrays: Mapping[str, np.ndarray]) -> None:
    """Refuse samples of which only a part is NaN (see `refuse_partial_gaps`).

    For files of computed arrays. A table of joint angles may well lack one joint for a while.
    """
    with naming(source):
        for name in FIELDS:
            array = np.asarray(arrays.get(name, 0.0))
            if array.ndim > 1 and array.size and array.dtype.kind == "f":
                refuse_partial_gaps(name, array)


def require_consistent(recording: Recording) -> None:
    """Refuse a task velocity that the joints' velocities do not make.

    Raises:
        RangeError: |xd - J qd| exceeds `CONSISTENCY` times |xd|.
    """
    if not {"xd", "qd", "jacobian"} <= set(recording.held):
        return
    residual = velocity_residual(*(recording.array(k) for k in ("jacobian", "qd", "xd")))
    if residual > CONSISTENCY:
        labels = f" of {recording.labels}" if str(recording.labels) else ""
        raise RangeError(
            f"xd{labels} differs from jacobian @ qd by {100 * residual:.3g} % of its size: allowed "
            f"is {100 * CONSISTENCY:g} % (check units, signs, the order of joints and the frame)"
        )


def _refuse_misspelt(arrays: Mapping[str, np.ndarray]) -> None:
    for name in arrays:
        if name in KNOWN:
            continue
        folded = name.lower().replace("_", "")
        near = get_close_matches(folded, KNOWN, n=1, cutoff=0.85)
        if near and near[0] not in arrays:
            raise UnknownNameError(
                f"unknown field {name!r}; did you mean {near[0]!r}? (known: {', '.join(KNOWN)})"
            )


def _numeric_fields(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Give the sampled fields as checked float64 arrays that agree in shape."""
    found = {
        name: as_float_array(name, arrays[name], ndim=3 if name == "jacobian" else 2)
        for name in FIELDS
        if name in arrays
    }
    if not ("q" in found or "x" in found or {"qd", "jacobian"} <= found.keys()):
        names = ", ".join(sorted(arrays)) or "nothing"
        raise UnknownNameError(f"{NEEDED} is needed; it holds {names}")
    lengths = {name: len(array) for name, array in found.items()}
    first = next(iter(lengths))
    for name, length in lengths.items():
        if length != lengths[first]:
            raise ShapeError(
                f"{name} has shape {found[name].shape}: {lengths[first]} samples are needed along "
                f"axis 0, as in {first} {found[first].shape}"
            )
    if lengths[first] < 2:
        raise ShapeError(f"{first} has {lengths[first]} sample(s): at least 2 are needed")
    check_shapes({"time": sample_numbers(lengths[first])} | found)
    for name, array in found.items():
        refuse_infinite(name, array)
    return found


def _step(arrays: Mapping[str, np.ndarray]) -> float | None:
    if "dt" not in arrays:
        return None
    step = as_float_array("dt", arrays["dt"])
    if step.size != 1 or not 0.0 < step.item() < np.inf:
        raise RangeError(f"dt = {np.array2string(step, threshold=4)}: one positive number, s")
    return step.item()


def _instants(arrays: Mapping[str, np.ndarray], samples: int) -> np.ndarray | None:
    """Give the time of each sample; None where each recording starts at zero on its own."""
    if "time" not in arrays:
        return None
    time = as_float_array("time", np.squeeze(np.asarray(arrays["time"])))
    if time.shape != (samples,):
        raise ShapeError(
            f"time has shape {np.shape(arrays['time'])}: ({samples},) is needed, one a sample"
        )
    require_finite("time", time)
    return time


def _recording(
    key: tuple[str, ...],
    members: list[slice],
    numbers: Mapping[str, np.ndarray],
    time: np.ndarray | None,
    shared: _Shared,
) -> Recording:
    where = members[0]
    if len(members) > 1:
        where = np.concatenate([np.arange(part.start, part.stop) for part in members])
    parts = {name: array[where] for name, array in numbers.items()}
    if time is not None:
        instants = time[where]
    else:
        instants = sample_numbers(len(next(iter(parts.values())))) * (shared.step or 1.0)
    labels = Labels(*(value or None for value in key[: len(LABEL_NAMES)]))
    with naming(str(labels) if str(labels) else "all samples"):
        return Recording(
            instants,
            **parts,
            joints=shared.joints,
            rows=shared.rows,
            labels=labels,
            frame=shared.frame,
            source=shared.source,
            timed=time is not None or shared.step is not None,
        )


def _runs(
    arrays: Mapping[str, np.ndarray], samples: int
) -> tuple[np.ndarray, list[tuple[str, ...]]]:
    """Give where each run of equal labels starts, and the labels there ('' where not given)."""
    columns = {name: _label(name, arrays, samples) for name in RUN_NAMES}
    changes = np.zeros(samples, dtype=bool)
    changes[0] = True
    for column in columns.values():
        if len(column) == samples:
            changes[1:] |= column[1:] != column[:-1]
    starts = np.flatnonzero(changes)
    keys = [
        tuple(
            _label_text(name, column[start if len(column) == samples else 0])
            for name, column in columns.items()
        )
        for start in starts.tolist()
    ]
    return starts, keys


def _label(name: str, arrays: Mapping[str, np.ndarray], samples: int) -> np.ndarray:
    """Give a label as an array of one value, or of one a sample."""
    array = np.asarray(arrays.get(name, "")).squeeze().reshape(-1)
    if array.dtype.kind not in "biufUS":
        raise ShapeError(f"{name}: expected text or whole numbers, found dtype {array.dtype}")
    if len(array) not in (1, samples):
        raise ShapeError(
            f"{name} has shape {np.shape(arrays[name])}: one value or ({samples},) is needed"
        )
    return array


def _label_text(name: str, value: np.generic) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace").strip()
    if isinstance(value, np.floating):
        if not float(value).is_integer():
            raise RangeError(f"{name} = {value}: allowed is text or a whole number")
        return str(int(value))
    return str(value).strip()


def _texts(name: str, arrays: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    if name not in arrays:
        return ()
    array = np.asarray(arrays[name])
    if array.dtype.kind not in "US":
        raise ShapeError(f"{name}: expected text, found dtype {array.dtype}")
    return tuple(_label_text(name, value) for value in array.reshape(-1))


def _frame(arrays: Mapping[str, np.ndarray]) -> Frame:
    up, forward = (_texts(name, arrays) for name in ("frame_up", "frame_forward"))
    if not up and not forward:
        return UNKNOWN_FRAME
    return Frame(up=up[0] if up else None, forward=forward[0] if forward else None, name="file")
