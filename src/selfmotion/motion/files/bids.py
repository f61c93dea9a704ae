"""Motion-BIDS: ``*_motion.tsv`` with its ``*_channels.tsv`` and ``*_motion.json``.

Read are channels of type POS (markers), JNTANG (joint angles), ORNT as quaternions (orientations)
and LATENCY (the time); others are named and left aside. Units come from channels.tsv, axes from
SpatialAxes in ``*_channels.json``, labels from the file name (sub, task, run). Files higher up in
the data set (inheritance) are not looked at.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.arrays_to_study import naming
from selfmotion.motion.files.bids_names import SUFFIX, frame_of, labels_of, sibling
from selfmotion.motion.files.numeric_rows import (
    METRES,
    numbered_lines,
    parse_rows,
    split_cells,
)
from selfmotion.motion.files.storage import RADIANS
from selfmotion.motion.files.table import Table, read_table, read_text
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.markers import MarkerSet
from selfmotion.motion.orientations import Orientations, matrices_from_quaternions
from selfmotion.motion.recording import Recording

NEEDED = ("name", "component", "type", "tracked_point", "units")
QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
ANGLE_UNITS = {"deg": RADIANS["deg"], "rad": 1.0, "degrees": RADIANS["deg"], "radian": 1.0}


@dataclass(frozen=True, eq=False)
class BidsMotion:
    """What one tracking system recorded.

    Attributes:
        markers: channels of type POS, or None.
        recording: channels of type JNTANG, or None.
        orientations: tracked points with quaternions.
        aside: types of channels that were not read, with their number.
        units: unit in the file of each type that was read.
    """

    markers: MarkerSet | None
    recording: Recording | None
    orientations: tuple[Orientations, ...]
    aside: Mapping[str, int]
    units: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class _System:
    """The files of one tracking system, read."""

    channels: Table
    values: np.ndarray
    time: np.ndarray
    labels: Labels
    frames: Mapping[str, Frame]
    source: str


def read_bids(path: str | Path) -> BidsMotion:
    """Read one tracking system of a Motion-BIDS data set.

    Args:
        path: the file ``*_motion.tsv``; ``*_channels.tsv`` and ``*_motion.json`` stand beside it.

    Raises:
        SelfmotionError: one line that names file, channel or field, value and what is allowed.

    Example:
        >>> import tempfile
        >>> from selfmotion.motion.files.bids_writer import write_bids
        >>> reach = Recording(np.arange(3) / 100, q=np.zeros((3, 1)), joints=("elbow",),
        ...                   labels=Labels(subject="01", condition="reach"))
        >>> where = write_bids(Path(tempfile.mkdtemp()), reach)
        >>> where.name, read_bids(where).recording.joints
        ('sub-01_task-reach_tracksys-angles_motion.tsv', ('elbow',))
    """
    path = Path(path)
    if not path.name.endswith(SUFFIX):
        raise FileFormatError(f"{path}: its name must end in {SUFFIX}")
    channels = _channels(sibling(path, "_channels.tsv"))
    about = _json(sibling(path, "_motion.json"))
    values = _values(path, channels)
    time = _time(path, channels, values, about)
    frames = _frames(sibling(path, "_channels.json"))
    system = _System(channels, values, time, labels_of(path), frames, str(path))
    with naming(system.source):
        orientations = _orientations(system)
        read = {"LATENCY", "POS", "JNTANG"} | ({"ORNT"} if orientations else set())
        kinds = [kind.upper() for kind in channels.cells("type") if kind.upper() not in read]
        return BidsMotion(
            _markers(system),
            _recording(system),
            orientations,
            {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)},
            _units(channels),
        )


def _channels(path: Path) -> Table:
    if not path.is_file():
        raise FileFormatError(f"{path}: no such file; Motion-BIDS needs it beside {SUFFIX}")
    table = read_table(path)
    missing = [name for name in NEEDED if name not in table.header]
    if missing:
        raise FileFormatError(f"{path}: no column {missing[0]} (needed are {', '.join(NEEDED)})")
    return table


def _json(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise FileFormatError(f"{path}: no such file; Motion-BIDS needs it beside {SUFFIX}")
    try:
        content = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"{path}: no JSON ({str(error)[:80]})") from None
    if not isinstance(content, dict):
        raise FileFormatError(f"{path}: a JSON object is needed")
    return content


def _values(path: Path, channels: Table) -> np.ndarray:
    """Read the numbers, a column a channel; BIDS allows no header row."""
    lines, _ = numbered_lines(path)
    names = channels.cells("name")
    rows = [(i + 1, split_cells(line, "\t")) for i, line in enumerate(lines) if line.strip()]
    if not rows:
        raise FileFormatError(f"{path}: no samples")
    for number, cells in rows:
        if len(cells) != len(names):
            raise FileFormatError(
                f"{path}: row {number} has {len(cells)} cells; channels.tsv has {len(names)} rows "
                "(gaps are n/a)"
            )
    if rows[0][1] == list(names):
        raise FileFormatError(f"{path}: row 1 holds names; Motion-BIDS allows no header row")
    return parse_rows(path, rows, names)


def _typed(channels: Table, kind: str) -> list[int]:
    return [i for i, found in enumerate(channels.cells("type")) if found.upper() == kind]


def _of(channels: Table, column: str, rows: Sequence[int]) -> list[str]:
    cells = channels.cells(column)
    return [cells[i] for i in rows]


def _scale(channels: Table, row: int, allowed: Mapping[str, float]) -> float:
    unit = channels.cells("units")[row]
    if unit.lower() not in allowed:
        raise FileFormatError(
            f"channels.tsv, channel {channels.cells('name')[row]}: unit {unit[:40]!r}; allowed are "
            f"{', '.join(list(allowed)[:3])}"
        )
    return allowed[unit.lower()]


def _time(path: Path, channels: Table, values: np.ndarray, about: Mapping[str, Any]) -> np.ndarray:
    latency = _typed(channels, "LATENCY")
    if latency:
        return values[:, latency[0]]
    rate = about.get("SamplingFrequency")
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not 0.0 < rate < 1e6:
        raise FileFormatError(
            f"{path}: no LATENCY channel, and SamplingFrequency is {str(rate)[:40]}: a number of "
            "Hz is needed"
        )
    return np.arange(len(values)) / float(rate)


def _frames(path: Path) -> dict[str, Frame]:
    """Give the frames that channels.json describes, by name."""
    if not path.is_file():
        return {}
    levels: Any = _json(path).get("reference_frame", {})
    levels = levels.get("Levels", {}) if isinstance(levels, dict) else {}
    if not isinstance(levels, dict):
        return {}
    return {
        str(name): frame_of(str(level.get("SpatialAxes", "")), str(name))
        for name, level in levels.items()
        if isinstance(level, dict)
    }


def _frame_of_rows(channels: Table, rows: Sequence[int], frames: Mapping[str, Frame]) -> Frame:
    """Give the one frame of these channels; unknown where it is not described."""
    if "reference_frame" not in channels.header:
        return UNKNOWN_FRAME
    names = list(dict.fromkeys(_of(channels, "reference_frame", rows)))
    if len(names) > 1:
        raise FileFormatError(
            f"channels.tsv: reference_frame {' and '.join(names[:2])} beside each other; one frame "
            "is needed"
        )
    return frames.get(names[0], UNKNOWN_FRAME)


def _points(
    channels: Table, rows: Sequence[int], components: Sequence[str]
) -> dict[str, list[int]]:
    """Give the channels of each tracked point, in the order of components."""
    found: dict[str, dict[str, int]] = {}
    for row in rows:
        point, component = (channels.cells(c)[row] for c in ("tracked_point", "component"))
        if component.lower() not in components:
            continue
        if component.lower() in found.setdefault(point, {}):
            raise FileFormatError(f"channels.tsv: {point} has component {component} twice")
        found[point][component.lower()] = row
    for point, held in found.items():
        lacking = [c for c in components if c not in held]
        if lacking:
            raise FileFormatError(f"channels.tsv: {point} lacks component {lacking[0]}")
    return {point: [held[c] for c in components] for point, held in found.items()}


def _markers(system: _System) -> MarkerSet | None:
    channels = system.channels
    rows = _typed(channels, "POS")
    if not rows:
        return None
    points = _points(channels, rows, ("x", "y", "z"))
    if not points:
        raise FileFormatError("channels.tsv: POS channels without component x, y, z")
    stacked = [
        system.values[:, r] * [_scale(channels, i, METRES) for i in r] for r in points.values()
    ]
    return MarkerSet(
        system.time,
        tuple(points),
        np.stack(stacked, axis=1),
        _frame_of_rows(channels, rows, system.frames),
        system.labels,
        system.source,
    )


def _recording(system: _System) -> Recording | None:
    rows = _typed(system.channels, "JNTANG")
    if not rows:
        return None
    factors = [_scale(system.channels, i, ANGLE_UNITS) for i in rows]
    return Recording(
        system.time,
        q=system.values[:, rows] * factors,
        joints=tuple(_of(system.channels, "name", rows)),
        labels=system.labels,
        source=system.source,
    )


def _orientations(system: _System) -> tuple[Orientations, ...]:
    points = _points(system.channels, _typed(system.channels, "ORNT"), QUATERNION)
    return tuple(
        Orientations(
            system.time,
            matrices_from_quaternions(system.values[:, rows]),
            point,
            _frame_of_rows(system.channels, rows, system.frames),
            system.labels,
            system.source,
        )
        for point, rows in points.items()
    )


def _units(channels: Table) -> dict[str, str]:
    """Give the units in the file of each type that is read."""
    rows = {kind: _typed(channels, kind) for kind in ("POS", "JNTANG", "ORNT")}
    return {k: ", ".join(dict.fromkeys(_of(channels, "units", r))) for k, r in rows.items() if r}
