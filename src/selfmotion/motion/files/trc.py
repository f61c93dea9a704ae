"""Marker trajectories in TRC (Motion Analysis; read and written by OpenSim).

Units come from the header and nowhere else. TRC does not say which way the axes point: the caller
does. Tabs, commas or semicolons part the cells; NumFrames and NumMarkers may be wrong; empty
cells, NaN and a triple of exact zeros (as several exporters write what they did not see) are gaps.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.numeric_rows import (
    METRES,
    REMARKS,
    delimiter_of,
    numbered_lines,
    parse_rows,
    refuse_cut_off,
    scale_to_metres,
    split_cells,
)
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.markers import MarkerSet, without_prefix
from selfmotion.writing import write_whole

LengthUnit = Literal["m", "cm", "mm"]
LEAD = 2  # the columns Frame# and Time
HEADER_LINES = 5
ALIASES = {"numofframes": "numframes", "numofmarkers": "nummarkers", "unit": "units"}


@dataclass(frozen=True, eq=False)
class TrcTable:
    """What stands in a TRC file, before units.

    Attributes:
        header: keys of line 2 (lower case) to the values of line 3.
        names: the marker labels, as in the file.
        frames: the frame numbers (K,), NaN where there is none.
        time: (K,) s as in the file, NaN where there is none.
        values: (K, M, 3) in the unit of the file; NaN where a marker was not seen.
    """

    header: Mapping[str, str]
    names: tuple[str, ...]
    frames: np.ndarray
    time: np.ndarray
    values: np.ndarray


def read_trc(
    path: str | Path,
    *,
    unit: LengthUnit | None = None,
    frame: Frame = UNKNOWN_FRAME,
    labels: Labels | None = None,
) -> MarkerSet:
    r"""Read marker trajectories from a TRC file.

    Args:
        path: the file.
        unit: unit of length, where the header names none.
        frame: the axes of the laboratory, which the file does not tell.
        labels: whose movement this is; left out: a subject's prefix tells the subject.

    Raises:
        FileFormatError: one line that names file, row or field, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.trc")
        >>> _ = where.write_text("PathFileType\t4\t(X/Y/Z)\treach.trc\n"
        ...     "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t2\t1\tmm\n"
        ...     "Frame#\tTime\tSTRN\n\t\tX1\tY1\tZ1\n\n1\t0.00\t1000\t0\t250\n2\t0.01\n")
        >>> seen = read_trc(where, frame=Frame(up="y", forward="x"))
        >>> seen.names, seen.point("STRN").tolist()
        (('STRN',), [[1.0, 0.0, 0.25], [nan, nan, nan]])
    """
    table = read_trc_table(path)
    scale = scale_to_metres(path, table.header.get("units"), unit, "header field Units")
    names, prefix = without_prefix(table.names)
    return MarkerSet(
        _times(path, table),
        names,
        table.values * scale,
        frame,
        labels or Labels(subject=prefix),
        str(path),
    )


def read_trc_table(path: str | Path) -> TrcTable:
    """Read header, labels and numbers of a TRC file as they stand.

    Raises:
        FileFormatError: one line that names file, row, value and what is allowed.
    """
    lines, ended = numbered_lines(path)
    start = next((i for i, line in enumerate(lines[:20]) if line.strip(' \t;,"')), 0)
    if not lines or "pathfiletype" not in lines[start].lower():
        raise FileFormatError(f"{path}: row {start + 1}: no PathFileType, so no TRC file")
    top = lines[start : start + HEADER_LINES]
    if len(top) < HEADER_LINES:
        raise FileFormatError(f"{path}: ends at row {len(lines)}, within its header")
    delimiter = delimiter_of(top[3])
    keys, values = (split_cells(line, delimiter) for line in top[1:3])
    header = {ALIASES.get(k.lower(), k.lower()): v for k, v in zip(keys, values, strict=False)}
    names, columns = _names(path, start + 4, split_cells(top[3], delimiter), top[4], delimiter)
    rows = [
        (i + 1, split_cells(line, delimiter))
        for i, line in enumerate(lines)
        if i >= start + HEADER_LINES and line.strip(' \t;,"')
    ]
    if not rows:
        raise FileFormatError(f"{path}: no rows of samples after row {start + HEADER_LINES}")
    refuse_cut_off(path, len(rows), header.get("numframes"), ended)
    _check_lengths(path, rows, len(columns), ended)
    width = LEAD + 3 * len(names)
    numbers = parse_rows(path, [(n, cells[:width]) for n, cells in rows], columns[:width])
    return TrcTable(
        header, names, numbers[:, 0], numbers[:, 1], _positions(numbers[:, LEAD:], len(names))
    )


def write_trc(
    path: str | Path, markers: MarkerSet, *, unit: LengthUnit = "mm", frame: Frame | None = None
) -> Path:
    """Write marker trajectories as TRC; whole or not at all. Numbers keep every digit.

    A marker at exactly the origin is a gap to those who read it. Labels and frame have no place.

    Args:
        path: the file.
        markers: what to write.
        unit: unit of length in the file.
        frame: axes to turn the positions into, such as ``Frame(up="y", forward="x")`` for
            OpenSim; left out: as they are.

    Raises:
        RangeError: a frame is asked for and that of the markers is not known.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.trc")
        >>> seen = MarkerSet(np.arange(3) / 100, ("STRN",), np.full((3, 1, 3), 0.5))
        >>> read_trc(write_trc(where, seen)).point("STRN")[2].tolist()
        [0.5, 0.5, 0.5]
    """
    turned = markers if frame is None else markers.in_frame(frame)
    rate = repr(turned.rate or 0.0)
    count, m = str(turned.n_samples), str(turned.n_markers)
    numbers = range(1, turned.n_markers + 1)
    lines = [
        ["PathFileType", "4", "(X/Y/Z)", Path(path).name],
        ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"]
        + ["OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"],
        [rate, rate, count, m, unit, rate, "1", count],
        ["Frame#", "Time", *(cell for name in turned.names for cell in (name, "", ""))],
        ["", "", *(f"{axis}{i}" for i in numbers for axis in "XYZ")],
        [],
    ]
    flat = (turned.positions / METRES[unit]).reshape(turned.n_samples, -1)
    for i, (instant, row) in enumerate(zip(turned.time.tolist(), flat.tolist(), strict=True)):
        cells = ["" if value != value else repr(value) for value in row]
        lines.append([str(i + 1), repr(instant), *cells])
    return write_whole(path, "".join("\t".join(cells) + "\n" for cells in lines))


def _names(
    path: str | Path, row: int, cells: list[str], axes: str, delimiter: str | None
) -> tuple[tuple[str, ...], list[str]]:
    """Give the marker labels, and a name for every column (remarks after the markers too)."""
    if len(cells) < LEAD or "frame" not in cells[0].lower() or "time" not in cells[1].lower():
        found = " ".join(cells[:2])[:40]
        raise FileFormatError(f"{path}: row {row}: {found!r} where Frame# and Time are needed")
    labels = cells[LEAD:]
    while labels and labels[-1].lower() in REMARKS:
        labels.pop()
    while labels and not labels[-1]:
        labels.pop()
    remarks = len([cell for cell in cells[LEAD + len(labels) :] if cell])
    triples = len([cell for cell in split_cells(axes, delimiter) if cell]) // 3
    spaced = not any(label for i, label in enumerate(labels) if i % 3)
    names = labels[::3] if spaced else [label for label in labels if label]
    if spaced:  # trajectories without a label stay, so that the columns keep their places
        names += [""] * (triples - len(names))
        names = [name or f"unlabelled_{i + 1}" for i, name in enumerate(names)]
    if not names or len(names) != triples:
        raise FileFormatError(
            f"{path}: row {row}: {len(names)} marker labels for {triples} triples X, Y, Z in row "
            f"{row + 1}"
        )
    columns = ["Frame#", "Time", *(f"{name}:{axis}" for name in names for axis in "XYZ")]
    return tuple(names), columns + ["remark"] * remarks


def _check_lengths(
    path: str | Path, rows: list[tuple[int, list[str]]], width: int, ended: bool
) -> None:
    """Refuse rows with too many cells, and a last row that was cut off.

    Rows may be shorter: exporters leave empty cells at the end of a row out.
    """
    for number, cells in rows:
        if len(cells) > width:
            raise FileFormatError(
                f"{path}: row {number} has {len(cells)} cells; its header has {width} columns"
            )
    number, cells = rows[-1]
    if not ended and len(cells) < len(rows[0][1]):
        raise FileFormatError(
            f"{path}: row {number} ends after {len(cells)} of {width} cells: the file is cut off"
        )


def _positions(flat: np.ndarray, n_markers: int) -> np.ndarray:
    """Give (K, M, 3) with NaN for whole triples that are not there or exactly zero."""
    values = flat.reshape(len(flat), n_markers, 3).copy()
    unseen = np.isnan(values).any(axis=2) | (values == 0.0).all(axis=2)
    values[unseen] = np.nan
    return values


def _times(path: str | Path, table: TrcTable) -> np.ndarray:
    """Give the times; by frame number and rate where the column Time was rounded too coarsely."""
    time, frames = table.time, table.frames
    if np.isfinite(time).all() and (np.diff(time) > 0.0).all():
        return time
    try:
        rate = float(table.header.get("datarate", "nan"))
    except ValueError:
        rate = float("nan")
    if not (0.0 < rate < 1e6 and np.isfinite(frames).all() and (np.diff(frames) > 0.0).all()):
        raise FileFormatError(
            f"{path}: column Time does not increase, and Frame# with DataRate does not tell the "
            "time either"
        )
    counted = (frames - frames[0]) / rate
    known = np.isfinite(time)
    offset = time[known][0] - counted[known][0] if known.any() else 0.0
    if known.any() and np.abs(time - counted - offset)[known].max() > 1.0 / rate:
        raise FileFormatError(
            f"{path}: column Time does not increase, and differs from Frame# at DataRate {rate:g} "
            "Hz by more than one sample"
        )
    return counted + offset
