"""Rows of numbers by column name, as commands take them: poses, targets, postures.

What is wrong with the file as a whole is raised. What is wrong with one row (a gap, a quaternion
that is none) belongs to that row, so that the others are computed all the same.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from selfmotion.errors import FileFormatError, unknown_name

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.motion.files.table import Table

Name: TypeAlias = int | str
AngleUnit: TypeAlias = Literal["rad", "deg"]

# Ends of column names that are units, and what one of them is in SI.
ANGLE_UNITS = {"_rad": 1.0, "_deg": 0.017453292519943295}
LENGTH_UNITS = {"_m": 1.0, "_cm": 1e-2, "_mm": 1e-3}
QUATERNION = ("qx", "qy", "qz", "qw")
RATES = ("_velocity", "_acceleration")
LENGTHS = frozenset({"x", "y", "z"})
# Beyond one turn an angle without a unit is taken for degrees that lost theirs.
PLAUSIBLE = 6.283185307179586
# Columns that say what a row is.
ABOUT = frozenset({"id", "time", "sample", "subject", "side", "condition", "target", "trial"})
# A quaternion's length may be off by this, from rounding.
ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a table, in SI units.

    Attributes:
        table: the cells.
        ids: name of each row: its cell in the column `id`, else its number from 1.
        columns: name to values (K,).
        problems: what is wrong with each row, naming file, row, column and value; else empty.
    """

    table: "Table"
    ids: tuple[Name, ...]
    columns: "dict[str, np.ndarray]"
    problems: tuple[str, ...]

    def __len__(self) -> int:
        """Count the rows."""
        return len(self.ids)

    @property
    def good(self) -> "np.ndarray":
        """Tell which rows have no problem, (K,)."""
        import numpy as np

        return np.array([not problem for problem in self.problems])

    def array(self, names: Sequence[str]) -> "np.ndarray":
        """Give some columns as (K, len(names))."""
        import numpy as np

        return np.stack([self.columns[name] for name in names], axis=1)

    def has(self, names: Sequence[str]) -> bool:
        """Tell whether all these columns were there."""
        return all(name in self.columns for name in names)

    def labels(self, name: str) -> tuple[str, ...] | None:
        """Give a column of text, or None if it is not there."""
        return self.table.cells(name) if name in self.table.header else None

    def with_problems(self, problems: Sequence[str]) -> "Rows":
        """Add to what is wrong; what was found first stays.

        Raises:
            FileFormatError: nothing is left without a problem.
        """
        both = tuple(old or new for old, new in zip(self.problems, problems, strict=True))
        if all(both):
            raise FileFormatError(both[0])
        return replace(self, problems=both)


def read_rows(
    path: str | Path,
    needed: Sequence[str],
    optional: Sequence[Sequence[str]] = (),
    *,
    bare: Sequence[str] = (),
    strict: bool = False,
    angle_unit: AngleUnit | None = None,
) -> Rows:
    """Read a table by column names; angles also as NAME_deg, lengths as NAME_mm or NAME_cm.

    Args:
        path: the file.
        needed: columns that must be there.
        optional: groups of columns, each there as a whole or not at all.
        bare: columns of a file without a line of names, in order.
        strict: refuse columns of other names, except those in `ABOUT`.
        angle_unit: of angles whose column does not name it; left out: rad.

    Raises:
        UnknownNameError: a column's name is not known, and `strict` is set.
        FileFormatError: no table, a column is missing or there twice, a cell is no number, an
            angle without unit is beyond one turn, a column names another unit than `angle_unit`,
            an id stands twice, or no row is without gap.
    """
    table = _table(path, bare)
    if strict:
        _refuse_unknown(table, needed, optional)
    names = list(needed)
    for group in optional:
        there = [name for name in group if _headers(table, name)]
        if there and len(there) < len(group):
            _refuse_missing(table, [name for name in group if name not in there])
        names += there
    _refuse_missing(table, [name for name in needed if not _headers(table, name)])
    columns = {name: _column(table, name, angle_unit) for name in names}
    rows = Rows(table, _ids(table), columns, ("",) * len(table.rows))
    return rows.with_problems(_gaps(table, columns))


def with_unit_quaternions(rows: Rows, names: Sequence[str] = QUATERNION) -> Rows:
    """Check that the four columns are unit quaternions, row by row.

    Raises:
        FileFormatError: no row is left.
    """
    import numpy as np

    lengths = np.linalg.norm(rows.array(names), axis=1)
    return rows.with_problems(
        [
            ""
            if not abs(length - 1.0) > ROUNDING
            else f"{rows.table.path}: row {line}, columns {names[0]} to {names[-1]}: a quaternion "
            f"of length {length:.6g}; it must be 1 to within {ROUNDING:g}"
            for line, length in zip(rows.table.rows, lengths, strict=True)
        ]
    )


def _table(path: str | Path, bare: Sequence[str]) -> "Table":
    """Read the cells; a file whose first line holds numbers has the names in `bare`."""
    from selfmotion.motion.files.numeric_rows import delimiter_of, split_cells
    from selfmotion.motion.files.table import Table, read_table, read_text

    lines = enumerate(read_text(path).splitlines(), start=1)
    kept = [(i, line) for i, line in lines if line.strip(' \t;,"') and not line.startswith("#")]
    if not kept:
        raise FileFormatError(f"{path}: the file is empty")
    cells = [(i, split_cells(line.strip(), delimiter_of(line.strip()))) for i, line in kept]
    if not bare or not all(_is_number(cell) for cell in cells[0][1][1:]):
        return read_table(path)
    for i, row in cells:
        if len(row) != len(bare):
            raise FileFormatError(
                f"{path}: row {i} has {len(row)} cells: {len(bare)} are needed "
                f"({' '.join(bare)}), or a first line of column names"
            )
    columns = tuple(zip(*(row for _, row in cells), strict=True))
    return Table(str(path), tuple(bare), columns, tuple(i for i, _ in cells))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _units(name: str) -> dict[str, float]:
    return LENGTH_UNITS if name in LENGTHS else ANGLE_UNITS


def _headers(table: "Table", name: str) -> list[str]:
    """Give the columns that hold a quantity, with or without a unit."""
    ends: Collection[str] = () if name in QUATERNION else _units(name)
    return [h for h in (name, *(name + end for end in ends)) if h in table.header]


def _refuse_unknown(
    table: "Table", needed: Sequence[str], optional: Sequence[Sequence[str]]
) -> None:
    names = [*needed, *(name for group in optional for name in group)]
    known = {header for name in names for header in _headers(table, name)}
    for header in table.header:
        if header not in known and header not in ABOUT:
            raise unknown_name(f"column in {table.path}:", header, list(needed))


def _refuse_missing(table: "Table", missing: Sequence[str]) -> None:
    if missing:
        raise FileFormatError(
            f"{table.path}: no column {', '.join(missing)} (there are: {', '.join(table.header)})"
        )


def _column(table: "Table", name: str, angle_unit: AngleUnit | None) -> "np.ndarray":
    """Give a quantity in SI units."""
    import numpy as np

    found = _headers(table, name)
    if len(found) > 1:
        raise FileFormatError(f"{table.path}: columns {' and '.join(found)} hold the same thing")
    header = found[0]
    values = table.numbers(header)
    units = _units(name)
    is_angle = units is ANGLE_UNITS and not name.endswith(RATES + QUATERNION)
    if is_angle and angle_unit is not None:
        named = header.removeprefix(name).removeprefix("_") or angle_unit
        if named != angle_unit:
            raise FileFormatError(
                f"{table.path}: column {header} names its unit, but {angle_unit} was stated"
            )
        return values * ANGLE_UNITS[f"_{named}"]
    if header == name and is_angle:
        far = np.flatnonzero(np.abs(values) > PLAUSIBLE)
        if far.size:
            raise table.refusal(
                int(far[0]), header, f"is beyond 2 pi rad: name the column {name}_deg if degrees"
            )
    return values * units.get(header.removeprefix(name), 1.0)


def _gaps(table: "Table", columns: "dict[str, np.ndarray]") -> list[str]:
    """Name the first gap of each row."""
    import numpy as np

    gaps = [""] * len(table.rows)
    for name, values in columns.items():
        header = _headers(table, name)[0]
        for i in np.flatnonzero(np.isnan(values)).tolist():
            gaps[i] = gaps[i] or str(table.refusal(i, header, "is no finite number"))
    return gaps


def _ids(table: "Table") -> tuple[Name, ...]:
    """Name the rows; whole numbers stay numbers."""
    if "id" not in table.header:
        return tuple(range(1, len(table.rows) + 1))
    ids = tuple(_whole(cell) for cell in table.cells("id"))
    seen: set[Name] = set()
    for i, name in enumerate(ids):
        if name in seen:
            raise table.refusal(i, "id", "stands twice; each row needs its own")
        seen.add(name)
    return ids


def _whole(cell: str) -> Name:
    try:
        value = float(cell)
    except ValueError:
        return cell
    return int(value) if value.is_integer() else cell
