"""Marker trajectories as Vicon Nexus exports them to CSV.

The section "Trajectories" holds: the rate, a line of marker labels (three columns each, with the
subject's prefix), Frame and Sub Frame, the units, one row a frame. Other sections (devices, model
outputs, joints) are passed over, and not written. The file does not say which way the axes point:
the caller does.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from selfmotion.errors import FileFormatError, RangeError
from selfmotion.motion.files.numeric_rows import METRES, scale_to_metres
from selfmotion.motion.files.table import read_text
from selfmotion.motion.files.trc import LengthUnit
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.markers import MarkerSet, without_prefix
from selfmotion.writing import write_whole

SECTION = "trajectories"
# Share of a frame by which a time may differ from its frame's, from rounding.
FRAME_ROUNDING = 1e-3
LEAD = 2  # the columns Frame and Sub Frame


def read_vicon_csv(
    path: str | Path,
    *,
    unit: LengthUnit | None = None,
    frame: Frame = UNKNOWN_FRAME,
    labels: Labels | None = None,
) -> MarkerSet:
    r"""Read the marker trajectories of a Vicon Nexus CSV file.

    Time counts from frame 1. Markers without any sample are kept, as gaps. The subject's prefix
    becomes the label `subject`, unless labels are given.

    Args:
        path: the file; comma, semicolon or tab between cells, with or without BOM.
        unit: unit of length, where the row of units is empty.
        frame: the axes of the laboratory, which the file does not tell.
        labels: whose movement this is; left out: the prefix tells the subject.

    Raises:
        FileFormatError: one line that names the file, the row and what is wrong there.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.csv")
        >>> _ = where.write_text("Trajectories\n100\n,,P1:STRN,,\nFrame,Sub Frame,X,Y,Z\n"
        ...                      ",,mm,mm,mm\n1,0,1000,0,250\n2,0,,,\n")
        >>> seen = read_vicon_csv(where)
        >>> seen.names, seen.labels.subject, seen.point("STRN")[0].tolist()
        (('STRN',), 'P1', [1.0, 0.0, 0.25])
    """
    text = read_text(path)
    lines = text.splitlines()
    start = _section_start(path, lines)
    mark = next((m for m in (",", ";", "\t") if m in lines[start + 3]), ",")
    cells = [[cell.strip() for cell in line.split(mark)] for line in lines[start + 1 : start + 5]]
    rate = _rate(path, start + 2, cells[0][0])
    names = _names(path, start + 3, cells[1])
    scale = _scales((path, start + 5), cells[3], len(names), unit)
    rows = _rows(lines[start + 5 :], mark)
    if not rows:
        raise FileFormatError(f"{path}: no frames after row {start + 5}")
    if not text.endswith(("\n", "\r")):
        _refuse_cut_off(path, len(lines), rows)
    values = _values(path, start + 6, rows, LEAD + 3 * len(names))
    bare, prefix = without_prefix(names)
    found = MarkerSet(
        (values[:, 0] - 1.0) / rate,
        bare,
        (values[:, LEAD:] * scale).reshape(len(values), -1, 3),
        frame,
        labels or Labels(subject=prefix),
        str(path),
    )
    return found if labels is None else replace(found, labels=labels)


def write_vicon_csv(
    path: str | Path,
    markers: MarkerSet,
    *,
    unit: LengthUnit = "mm",
    frame: Frame | None = None,
) -> Path:
    """Write marker trajectories as Vicon Nexus does; whole or not at all.

    Numbers keep every digit. Time is written as frame numbers from 1, so it must be evenly spaced
    and start at a whole frame. The label `subject` becomes the prefix; others have no place.

    Args:
        path: the file.
        markers: what to write.
        unit: unit of length in the file.
        frame: axes to turn the positions into; left out: as they are.

    Raises:
        RangeError: the samples are not evenly spaced in time, or fewer than two; or a frame is
            asked for and that of the markers is not known.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.csv")
        >>> seen = MarkerSet(np.arange(3) / 100, ("STRN",), np.full((3, 1, 3), 0.5))
        >>> read_vicon_csv(write_vicon_csv(where, seen)).point("STRN")[2].tolist()
        [0.5, 0.5, 0.5]
    """
    turned = markers if frame is None else markers.in_frame(frame)
    rate, first = _frame_numbers(turned)
    prefix = f"{turned.labels.subject}:" if turned.labels.subject else ""
    lines = [
        ["Trajectories"],
        [repr(rate)],
        ["", "", *(cell for name in turned.names for cell in (prefix + name, "", ""))],
        ["Frame", "Sub Frame", *("XYZ" * turned.n_markers)],
        ["", "", *([unit] * 3 * turned.n_markers)],
    ]
    flat = (turned.positions / METRES[unit]).reshape(turned.n_samples, -1)
    for i, row in enumerate(flat.tolist()):
        cells = ["" if value != value else repr(value) for value in row]
        lines.append([str(first + i), "0", *cells])
    return write_whole(path, "".join(",".join(cells) + "\n" for cells in lines))


def _frame_numbers(markers: MarkerSet) -> tuple[float, int]:
    """Give the rate (Hz) and the first frame's number.

    Raises:
        RangeError: frame numbers cannot tell the times.
    """
    rate = markers.rate
    if rate is None:
        raise RangeError(f"{markers.name}: one sample; a rate needs two")
    near = round(rate, 6)  # 100.00000000000001 is 100
    rate = near if abs(near - rate) < 1e-9 * rate else rate
    frames = markers.time * rate + 1.0
    first = round(float(frames[0]))
    off = np.abs(frames - first - np.arange(len(frames)))
    if first < 1 or off.max() > FRAME_ROUNDING:
        at = int(np.argmax(off))
        raise RangeError(
            f"{markers.name}: time[{at}] = {markers.time[at]:g} s is no whole frame at {rate:g} Hz "
            "(frames are numbered from 1 at 0 s); resample it evenly"
        )
    return rate, first


def _section_start(path: str | Path, lines: list[str]) -> int:
    """Find the line that says Trajectories; its header needs four more."""
    for i, line in enumerate(lines):
        if line.strip(' \t;,"').lower() == SECTION:
            if len(lines) < i + 5:
                raise FileFormatError(
                    f"{path}: ends at row {len(lines)}, within the header of its trajectories"
                )
            if "frame" not in lines[i + 3].lower():
                raise FileFormatError(
                    f"{path}: row {i + 4}: {lines[i + 3][:40]!r} where Frame,Sub Frame,X,Y,Z,... "
                    "is needed"
                )
            return i
    raise FileFormatError(f"{path}: no line that says Trajectories, so no Vicon marker file")


def _rate(path: str | Path, row: int, cell: str) -> float:
    try:
        rate = float(cell)
    except ValueError:
        rate = float("nan")
    if not 0.0 < rate < 1e6:
        raise FileFormatError(f"{path}: row {row}: rate {cell[:40]!r}; allowed is a number of Hz")
    return rate


def _names(path: str | Path, row: int, cells: list[str]) -> list[str]:
    while cells and not cells[-1]:
        cells = cells[:-1]
    names = cells[LEAD::3]
    if not names:
        raise FileFormatError(f"{path}: row {row}: no marker labels")
    stray = next((c for i, c in enumerate(cells) if c and (i < LEAD or (i - LEAD) % 3)), None)
    if stray is not None or not all(names):
        raise FileFormatError(
            f"{path}: row {row}: marker labels must stand over every third column from column 3"
            + (f"; {stray[:40]!r} does not" if stray else "; one is missing")
        )
    return names


def _scales(
    where: tuple[str | Path, int], cells: list[str], n_markers: int, stated: LengthUnit | None
) -> np.ndarray:
    """Give the metres in the unit of each column; a row without any unit needs a stated one."""
    path, row = where
    units = cells[LEAD : LEAD + 3 * n_markers]
    if not any(cells):
        units = [""] * (3 * n_markers)
    if len(units) != 3 * n_markers:
        raise FileFormatError(
            f"{path}: row {row}: {len(units)} units for {n_markers} markers of 3 columns each"
        )
    scale = {name: scale_to_metres(path, name, stated, f"row {row}: unit") for name in {*units}}
    return np.array([scale[name] for name in units])


def _rows(lines: list[str], mark: str) -> list[list[str]]:
    """Take rows until a blank line ends the section."""
    rows = []
    for line in lines:
        if not line.strip(" \t;,"):
            break
        rows.append(line.split(mark))
    return rows


def _refuse_cut_off(path: str | Path, row: int, rows: list[list[str]]) -> None:
    """Refuse a last row that stops short of the others, in the middle of the line.

    Its last number may have lost digits, which nothing in the number tells.
    """
    if len(rows) > 1 and len(rows[-1]) < len(rows[-2]):
        raise FileFormatError(
            f"{path}: row {row} ends after {len(rows[-1])} of {len(rows[-2])} cells without an end "
            "of line: the file was cut off; copy it again, or delete that row"
        )


def _values(path: str | Path, first: int, rows: list[list[str]], width: int) -> np.ndarray:
    """Turn cells into numbers (rows, width); empty cells are NaN, but the frame is needed."""
    out = np.full((len(rows), width), np.nan)
    for i, row in enumerate(rows):
        if any(cell.strip() for cell in row[width:]):
            raise FileFormatError(
                f"{path}: row {first + i} has {len(row)} cells; {width} are expected"
            )
        try:
            numbers = [float(c) if c and not c.isspace() else np.nan for c in row[:width]]
        except ValueError:
            raise _bad_cell(path, first + i, row[:width]) from None
        out[i, : len(numbers)] = numbers  # Nexus leaves the last empty cells of a row out
    bad = np.flatnonzero(~np.isfinite(out[:, 0]) | np.isinf(out).any(axis=1))
    if bad.size:
        at = int(bad[0])
        raise FileFormatError(
            f"{path}: row {first + at}: frame {rows[at][0][:40]!r} or an infinite coordinate; "
            "frames are numbered, gaps are empty cells"
        )
    return out


def _bad_cell(path: str | Path, row: int, cells: list[str]) -> FileFormatError:
    column = next(i for i, cell in enumerate(cells) if not _is_number(cell))
    return FileFormatError(
        f"{path}: row {row}, column {column + 1}: {cells[column][:40]!r} is no number"
    )


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip() or "nan")
    except ValueError:
        return False
    return True
