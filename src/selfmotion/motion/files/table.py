"""Delimited text as spreadsheets and laboratories write it, read without guessing.

Comma, semicolon or tab between cells; decimal comma where cells are not parted by commas (or are
quoted); BOM, blank lines, lines that start with ``#`` and an empty last column are passed over.
"""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from selfmotion.errors import FileFormatError

MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-nan"})
# One cell may not be longer than this; a binary file taken for text easily is.
LONGEST_CELL = 100_000


@dataclass(frozen=True, eq=False)
class Table:
    """Cells of a delimited text file, as text.

    Attributes:
        path: file name, for messages.
        header: column names, in order, all different.
        columns: the cells of each column, stripped, top to bottom.
        rows: line number in the file of each row of cells.
    """

    path: str
    header: tuple[str, ...]
    columns: tuple[tuple[str, ...], ...]
    rows: tuple[int, ...]

    def cells(self, name: str) -> tuple[str, ...]:
        """Give the cells of a column."""
        return self.columns[self.header.index(name)]

    def numbers(self, name: str) -> Float[np.ndarray, " rows"]:
        """Give a column as numbers; empty cells, NaN and NA give NaN.

        Raises:
            FileFormatError: a cell is no finite number; the message names row, column and cell.
        """
        cells = self.cells(name)
        try:
            if any("_" in cell for cell in cells):
                raise ValueError  # NumPy, like Python, would read 1_0 as ten
            values = np.array(cells, dtype=np.float64)
        except ValueError:
            values = np.array([self._number(name, i, cell) for i, cell in enumerate(cells)])
        infinite = np.flatnonzero(np.isinf(values))
        if infinite.size:
            at = int(infinite[0])
            raise self.refusal(at, name, "must be finite (an empty cell marks a gap)")
        return values

    def refusal(self, row: int, name: str, allowed: str) -> FileFormatError:
        """Build the error that names file, row, column and cell, and says what is allowed."""
        cell = self.cells(name)[row]
        return FileFormatError(
            f"{self.path}: row {self.rows[row]}, column {name}: {cell[:40]!r} {allowed}"
        )

    def _number(self, name: str, row: int, cell: str) -> float:
        if cell.lower() in MISSING:
            return float("nan")
        # 0,5 but not 1,234.5, and not 1_000, which Python would take.
        text = cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell
        try:
            if "_" in text:
                raise ValueError
            return float(text)
        except ValueError:
            raise self.refusal(row, name, "is no number") from None


def read_table(path: str | Path) -> Table:
    r"""Read a text file with one line of column names, then rows of cells.

    Raises:
        FileFormatError: no file, no text, no names, names twice, or a row of another length.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "angles.csv")
        >>> _ = where.write_text("time;elbow_deg\n0,00;90\n0,01;91,5\n", encoding="utf-8-sig")
        >>> table = read_table(where)
        >>> table.header, table.numbers("elbow_deg").tolist()
        (('time', 'elbow_deg'), [90.0, 91.5])
    """
    lines = read_text(path).splitlines()
    kept = [(i + 1, line) for i, line in enumerate(lines) if line.strip(' \t;,"') != ""]
    kept = [(i, line) for i, line in kept if not line.lstrip(' "').startswith("#")]
    if len(kept) < 2:
        raise FileFormatError(f"{path}: {len(kept)} line(s): column names and rows are needed")
    delimiter = _delimiter(kept[0][1])
    try:
        reader = csv.reader((line for _, line in kept), delimiter=delimiter, strict=True)
        cells = [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        raise FileFormatError(f"{path}: cannot be read as delimited text ({error})") from None
    if len(cells) != len(kept):
        raise FileFormatError(f"{path}: a quoted cell runs over a line end; that is not allowed")
    header, width = _header(path, kept[0][0], cells)
    for (number, _), row in zip(kept[1:], cells[1:], strict=True):
        if len(row) < width or any(row[width:]):
            raise FileFormatError(
                f"{path}: row {number} has {len(row)} cells: {width} are needed, one a column"
            )
    columns = tuple(zip(*(row[:width] for row in cells[1:]), strict=True))
    return Table(str(path), header, columns, tuple(number for number, _ in kept[1:]))


def read_text(path: str | Path) -> str:
    """Read a text file as laboratories write it: UTF-8 with or without BOM, UTF-16 or Latin-1.

    Raises:
        FileFormatError: no file, no text, or a line too long for a table.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    encoding = "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError:
        text = raw.decode("latin-1")  # spreadsheets on Windows: a degree sign in a column name
    text = text.removeprefix("\ufeff")
    if "\0" in text:
        raise FileFormatError(f"{path}: no text file (it holds zero bytes)")
    if max(map(len, text.splitlines()), default=0) > LONGEST_CELL:
        raise FileFormatError(f"{path}: no table (a line is longer than {LONGEST_CELL} characters)")
    return text


def _delimiter(header: str) -> str:
    """Tell the delimiter by the line of names, in which no number can hold a comma."""
    outside_quotes = re.sub(r'"[^"]*"', "", header)
    return next((mark for mark in (";", "\t", ",") if mark in outside_quotes), ",")


def _header(path: str | Path, row: int, cells: list[list[str]]) -> tuple[tuple[str, ...], int]:
    names = cells[0]
    while names and not names[-1]:
        names = names[:-1]
    for i, name in enumerate(names):
        if not name:
            raise FileFormatError(f"{path}: row {row}: column {i + 1} has no name")
        if re.fullmatch(r"[-+]?[\d.,]+([eE][-+]?\d+)?", name):
            raise FileFormatError(
                f"{path}: row {row}: {name!r} where the name of column {i + 1} is needed"
            )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise FileFormatError(f"{path}: row {row}: column {twice[0]!r} is there more than once")
    return tuple(names), len(names)
