"""OpenSim's tables over time: MOT and STO.

Angles are in the unit that the header's inDegrees names; a file without it is refused unless the
caller states the unit. The file does not say which columns are angles and which are lengths: those
of `is_length` (by OpenSim's names) or those that the caller names are lengths (m). Tables that hold
something else than coordinates (forces, activations) are refused by `read_mot`, and read as they
stand by `read_storage`. nRows and nColumns may be wrong; commas, tabs or spaces part the cells.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float

from selfmotion.errors import FileFormatError, ShapeError
from selfmotion.motion.files.arrays_to_study import naming
from selfmotion.motion.files.numeric_rows import (
    REMARKS,
    delimiter_of,
    numbered_lines,
    parse_rows,
    refuse_cut_off,
    split_cells,
)
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.writing import write_whole

AngleUnit = Literal["rad", "deg"]
RADIANS = {"rad": 1.0, "deg": np.pi / 180.0}
# Lines within which the header must end.
LONGEST_HEADER = 500
YES_NO = {"yes": True, "true": True, "y": True, "1": True}
YES_NO |= {"no": False, "false": False, "n": False, "0": False}
LENGTH_NAME = re.compile(r"(_t[xyz]|_?trans_?[xyz]|_translation_?[xyz]?)$", re.IGNORECASE)
STATE_NAME = re.compile(r"^/?jointset/[^/]+/(?P<name>[^/]+)/(?P<kind>value|speed)$")
# Titles and column names of tables that hold no coordinates.
OTHER_TITLE = re.compile(
    r"static ?optimization|generalized forces|activation|controls|forces|moment ?arm|reaction|"
    r"fiber|probe|marker|^speeds|^accelerations|velocit",
    re.IGNORECASE,
)
OTHER_COLUMN = re.compile(
    r"(_moment|_force|_torque|activation|excitation|_f[xyz]|_[pv][xyz]|ground_force.*|"
    r"ground_torque.*|/forceset/.*|_reserve|_residual|reserve)$",
    re.IGNORECASE,
)
# Beside coordinates in a table of states; they say nothing of the motion.
MUSCLE_STATE = re.compile(r"(activation|fiber_length|/forceset/.*)$", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class StorageTable:
    """What stands in a MOT or STO file, as it stands there.

    Attributes:
        title: first line of the header.
        header: the header's keys, in lower case, to their values.
        columns: names of the columns (n) after time.
        time: (K,) s.
        values: (K, n) in the file's units; NaN where a cell is empty or says so.
        source: file name.
    """

    title: str
    header: Mapping[str, str]
    columns: tuple[str, ...]
    time: Float[np.ndarray, " samples"]
    values: Float[np.ndarray, "samples columns"]
    source: str

    @property
    def in_degrees(self) -> bool | None:
        """Tell whether angles are in degrees; None where the header does not say."""
        return YES_NO.get(self.header.get("indegrees", "").lower())

    @property
    def other_content(self) -> str | None:
        """Say by what the table is known to hold something else than coordinates; None: it is not.

        Muscle states beside coordinates do not count.
        """
        if any(STATE_NAME.match(name) for name in self.columns):
            return None
        if OTHER_TITLE.search(self.title):
            return f"its title is {self.title[:60]!r}"
        odd = [name for name in self.columns if OTHER_COLUMN.search(name)]
        plain = [name for name in self.columns if name not in odd]
        states = plain and all(MUSCLE_STATE.search(name) for name in odd)
        return f"a column is named {odd[0][:60]!r}" if odd and not states else None


def is_length(name: str) -> bool:
    """Tell by OpenSim's names whether a coordinate is a length: ``_tx``, ``transY`` and the like.

    Example:
        >>> [is_length(name) for name in ("pelvis_tx", "box_transX", "elbow_flexion")]
        [True, True, False]
    """
    return LENGTH_NAME.search(name) is not None


def read_storage(path: str | Path) -> StorageTable:
    r"""Read any MOT or STO table of numbers as it stands.

    Raises:
        FileFormatError: one line that names file, row, column, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "effort.sto")
        >>> _ = where.write_text("Activations\ninDegrees=no\nendheader\ntime\tBRA\n0\t0.5\n")
        >>> read_storage(where).columns, read_storage(where).values.tolist()
        (('BRA',), [[0.5]])
    """
    title, header, names, rows = storage_cells(path)
    if header.get("datatype", "double").lower() not in ("double", "float"):
        raise FileFormatError(
            f"{path}: DataType={header['datatype'][:40]}: a table of numbers is needed "
            "(Quaternion: read_orientations)"
        )
    kept = [i for i, name in enumerate(names) if name.lower() not in REMARKS]
    width, names = len(names), [names[i] for i in kept]
    for number, cells in rows:
        if not len(kept) <= len(cells) <= width:
            raise FileFormatError(
                f"{path}: row {number} has {len(cells)} cells: {width} are needed, one a "
                "column (is the file cut off?)"
            )
    picked = [(n, [cells[i] if i < len(cells) else "" for i in kept]) for n, cells in rows]
    numbers = parse_rows(path, picked, names)
    missing = np.flatnonzero(np.isnan(numbers[:, 0]))
    if missing.size:
        raise FileFormatError(f"{path}: row {rows[int(missing[0])][0]}: no time")
    return StorageTable(title, header, tuple(names[1:]), numbers[:, 0], numbers[:, 1:], str(path))


def read_mot(
    path: str | Path,
    *,
    unit: AngleUnit | None = None,
    lengths: Sequence[str] | None = None,
    labels: Labels | None = None,
) -> Study:
    r"""Read coordinates over time from MOT or STO, in rad and m; one recording.

    Of a table of states, ``.../value`` becomes `q` and ``.../speed`` becomes `qd`.

    Args:
        path: the file.
        unit: unit of the angles, where the header has no inDegrees.
        lengths: coordinates that are lengths (m); left out: those of `is_length`.
        labels: whose movement this is.

    Raises:
        SelfmotionError: one line that names file, row or field, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.mot")
        >>> _ = where.write_text("Coordinates\nversion=1\ninDegrees=yes\n"
        ...                      "endheader\ntime,elbow,pelvis_tx\n0,180,0.5\n0.01,90,0.5\n")
        >>> read_mot(where)[0].array("q").round(4).tolist()
        [[3.1416, 0.5], [1.5708, 0.5]]
    """
    table = read_storage(path)
    if table.other_content is not None:
        raise FileFormatError(
            f"{path}: holds no coordinates ({table.other_content}): read_storage gives the table"
        )
    scale = RADIANS[_unit(table, unit)]
    names, q, qd = _coordinates(table)
    unknown = sorted(set(lengths or ()) - set(names))
    if unknown:
        raise FileFormatError(
            f"{path}: no coordinate {unknown[0]!r} (there are {', '.join(names)})"
        )
    lengthy = [is_length(n) if lengths is None else n in lengths for n in names]
    factors = np.where(lengthy, 1.0, scale)
    with naming(str(path)):
        return Study(
            (
                Recording(
                    table.time,
                    q=table.values[:, q] * factors,
                    qd=table.values[:, qd] * factors if qd else None,
                    joints=tuple(names),
                    labels=labels or Labels(),
                    source=str(path),
                ),
            )
        )


def write_mot(
    path: str | Path,
    recording: Recording,
    *,
    unit: AngleUnit = "rad",
    lengths: Sequence[str] | None = None,
) -> Path:
    """Write joint positions as MOT (or STO), whole or not at all. Numbers keep every digit.

    Velocities, hand, labels and frame have no place in a table of coordinates.

    Args:
        path: the file.
        recording: must hold `q` and times in seconds.
        unit: unit of the angles; radians need not know which joints slide.
        lengths: joints that slide, kept in metres with ``unit="deg"``; left out: by `is_length`.

    Raises:
        ShapeError: there are no joint positions, or no seconds.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.mot")
        >>> _ = write_mot(where, Recording([0.0, 0.5], q=[[0.0], [np.pi]]), unit="deg")
        >>> where.read_text().split()[-4:]
        ['0.0', '0.0', '0.5', '180.0']
    """
    if not recording.timed:
        raise ShapeError(f"{recording.name}: has sample numbers but no time in seconds")
    lengthy = [is_length(n) if lengths is None else n in lengths for n in recording.joints]
    values = recording.array("q") / np.where(lengthy, 1.0, RADIANS[unit])
    lines = [
        "Coordinates",
        "version=1",
        f"nRows={recording.n_samples}",
        f"nColumns={recording.n_joints + 1}",
        f"inDegrees={'yes' if unit == 'deg' else 'no'}",
        "endheader",
        "\t".join(["time", *recording.joints]),
    ]
    for instant, row in zip(recording.time.tolist(), values.tolist(), strict=True):
        cells = ["NaN" if value != value else repr(value) for value in row]
        lines.append("\t".join([repr(instant), *cells]))
    return write_whole(path, "\n".join(lines) + "\n")


def storage_cells(
    path: str | Path,
) -> tuple[str, dict[str, str], list[str], list[tuple[int, list[str]]]]:
    """Part a MOT or STO file into title, header, column names and rows of cells."""
    lines, ended = numbered_lines(path)
    end = next(
        (
            i
            for i, line in enumerate(lines[:LONGEST_HEADER])
            if line.strip(' \t;,"').lower() == "endheader"
        ),
        None,
    )
    if end is None:
        raise FileFormatError(f"{path}: no line endheader, so no MOT or STO file (or cut off)")
    at = next((i for i in range(end + 1, len(lines)) if lines[i].strip(' \t;,"')), None)
    if at is None:
        raise FileFormatError(f"{path}: ends after its header")
    delimiter = delimiter_of(lines[at])
    names = _unique(path, at + 1, split_cells(lines[at], delimiter))
    rows = [
        (i + 1, _row(lines[i], delimiter, len(names)))
        for i in range(at + 1, len(lines))
        if lines[i].strip(' \t;,"')
    ]
    if not rows:
        raise FileFormatError(f"{path}: no rows of numbers after row {at + 1}")
    title, header = _header(lines[:end])
    refuse_cut_off(path, len(rows), header.get("nrows"), ended)
    return title, header, names, rows


def _row(line: str, delimiter: str | None, width: int) -> list[str]:
    """Part a row; by white space where that gives the right number of cells and the mark not."""
    cells = split_cells(line, delimiter)
    if len(cells) != width and delimiter not in (None, ","):
        spaced = line.split()
        return spaced if len(spaced) == width else cells
    return cells


def _header(lines: list[str]) -> tuple[str, dict[str, str]]:
    bare = [line.strip(' \t;,"') for line in lines]
    header: dict[str, str] = {}
    for line in bare:
        key, equals, value = line.partition("=")
        if not equals:  # SIMM's motions: `datarows 121`
            key, _, value = line.partition(" ")
        header.setdefault(key.strip().lower(), value.strip())
    return next((line for line in bare if line), ""), header


def _unique(path: str | Path, row: int, names: list[str]) -> list[str]:
    if not names or names[0].lower() != "time":
        found = names[0][:40] if names else ""
        raise FileFormatError(f"{path}: row {row}: first column {found!r}; time is needed")
    if len(names) < 2 or not all(names):
        raise FileFormatError(f"{path}: row {row}: each column needs a name, and one beside time")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise FileFormatError(f"{path}: row {row}: column {twice[0]!r} is there more than once")
    return names


def _unit(table: StorageTable, stated: AngleUnit | None) -> AngleUnit:
    written = table.header.get("indegrees", "")
    if written and table.in_degrees is None:
        raise FileFormatError(f"{table.source}: inDegrees={written[:40]}: allowed are yes and no")
    if table.in_degrees is None:
        if stated is None:
            raise FileFormatError(
                f"{table.source}: the header has no inDegrees, so the unit of the angles is not "
                'known: state it (unit="deg" or "rad"; --angle-unit)'
            )
        return stated
    found: AngleUnit = "deg" if table.in_degrees else "rad"
    if stated not in (None, found):
        raise FileFormatError(f"{table.source}: inDegrees={written}, but {stated!r} was stated")
    return found


def _coordinates(table: StorageTable) -> tuple[list[str], list[int], list[int]]:
    """Give names of the coordinates, and the columns of their positions and velocities."""
    found = [(i, STATE_NAME.match(name)) for i, name in enumerate(table.columns)]
    values = {m["name"]: i for i, m in found if m and m["kind"] == "value"}
    speeds = {m["name"]: i for i, m in found if m and m["kind"] == "speed"}
    if not values:
        plain = {n: i for i, n in enumerate(table.columns) if not MUSCLE_STATE.search(n)}
        # States before OpenSim 4: each coordinate beside its velocity, named with _u at its end.
        speeds = {n[:-2]: i for n, i in plain.items() if n.endswith("_u") and n[:-2] in plain}
        values = {n: i for n, i in plain.items() if n[:-2] not in speeds or not n.endswith("_u")}
    if not values:
        raise FileFormatError(f"{table.source}: no column of a coordinate")
    paired = [speeds[name] for name in values if name in speeds]
    return list(values), list(values.values()), paired if len(paired) == len(values) else []
