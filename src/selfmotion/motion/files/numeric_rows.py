"""Rows of numbers under a header of several lines, as motion capture and OpenSim write them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.table import MISSING, read_text

# Columns of these names hold remarks about single samples, not numbers.
REMARKS = frozenset({"event", "events", "marker", "comment", "comments"})
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
METRES |= {"meters": 1.0, "metres": 1.0, "meter": 1.0, "metre": 1.0}
METRES |= {"millimeters": 1e-3, "millimetres": 1e-3, "centimeters": 1e-2, "centimetres": 1e-2}


def delimiter_of(line: str) -> str | None:
    """Tell what parts the cells of a line: tab, semicolon or comma; None for white space."""
    return next((mark for mark in ("\t", ";", ",") if mark in line), None)


def split_cells(line: str, delimiter: str | None) -> list[str]:
    """Part a line into stripped cells; empty cells at its end fall away."""
    cells = [cell.strip(' "\t\r') for cell in line.split(delimiter)]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def numbered_lines(path: str | Path) -> tuple[list[str], bool]:
    """Read the lines of a text file, and whether the last one ends as a line should."""
    text = read_text(path)
    return text.splitlines(), text.endswith(("\n", "\r"))


def refuse_cut_off(path: str | Path, rows: int, promised: str | None, ended: bool) -> None:
    """Refuse a file that lacks rows and ends within a line: its last number may lack digits.

    A header may promise too many rows (files are edited), and the last line end may be missing;
    both at once is a file that was cut off.

    Raises:
        FileFormatError: the file is cut off.
    """
    if not ended and promised is not None and promised.isdigit() and rows < int(promised[:12]):
        raise FileFormatError(
            f"{path}: {rows} of {promised[:12]} rows, and no line end after the last: the file is "
            "cut off"
        )


def parse_rows(
    path: str | Path, rows: Sequence[tuple[int, list[str]]], columns: Sequence[str]
) -> Float[np.ndarray, "rows columns"]:
    """Turn rows of cells into numbers; empty and missing cells are NaN.

    Args:
        path: the file, for messages.
        rows: line numbers with the cells there, none longer than `columns`.
        columns: column names, for messages.

    Raises:
        FileFormatError: a cell is no finite number; the message names row, column and cell.
    """
    width = len(columns)
    full = [cells + [""] * (width - len(cells)) for _, cells in rows]
    try:
        if any("_" in cell for cells in full for cell in cells):
            raise ValueError  # NumPy, like Python, would read 1_0 as ten
        values = np.array([[cell or "nan" for cell in cells] for cells in full], dtype=np.float64)
    except ValueError:
        values = np.array([[_number(cell) for cell in cells] for cells in full])
    values = values.reshape(len(full), width)
    bad = np.isinf(values)  # also what is no number at all
    if bad.any():
        i, j = (int(k) for k in np.argwhere(bad)[0])
        raise FileFormatError(
            f"{path}: row {rows[i][0]}, column {columns[j]}: {full[i][j][:40]!r} is no finite "
            "number (an empty cell or NaN marks a gap)"
        )
    return values


def scale_to_metres(path: str | Path, found: str | None, stated: str | None, where: str) -> float:
    """Give the metres in one of the file's units of length.

    Args:
        path: the file, for messages.
        found: the unit that the file names; None or empty: none.
        stated: the unit that the caller states.
        where: the field of the file that names it, for messages.

    Raises:
        FileFormatError: no unit, one that is not known, or two that disagree.
    """
    named = (found or "").strip().lower()
    if not named and stated is None:
        raise FileFormatError(
            f'{path}: {where} is empty, so the unit of length is not known: state it (unit="mm", '
            '"cm" or "m"; --length-unit)'
        )
    unit = named or str(stated)
    if unit not in METRES:
        raise FileFormatError(
            f"{path}: {where} {unit[:40]!r}: allowed are {', '.join(list(METRES)[:3])}"
        )
    if stated is not None and METRES.get(stated) != METRES[unit]:
        raise FileFormatError(f"{path}: {where} says {unit!r}, but {stated!r} was stated")
    return METRES[unit]


def _number(cell: str) -> float:
    """Read a number, NaN for a missing one; infinity for what is neither."""
    if cell.lower() in MISSING:
        return float("nan")
    # 0,5 but not 1,234.5, and not 1_000, which Python would take.
    text = cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell
    try:
        return float("inf") if "_" in text else float(text)
    except ValueError:
        return float("inf")
