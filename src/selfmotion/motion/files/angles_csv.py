"""Joint angles as delimited text: one row a sample, one column a joint.

Columns: ``time`` (s) or ``time_ms``, or ``sample`` where there are no seconds; one a joint; where
known ``JOINT_velocity``, ``hand_x`` ... (m) and ``hand_x_velocity``; and the labels ``subject side
condition target trial``. A unit stands at the end of a name (``elbow_deg``, ``elbow_rad``,
``hand_x_mm``), in brackets (``elbow [deg]``), or in a row of units below the names. An angle whose
unit is nowhere named is in radians, and refused where it leaves one turn either way.
"""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from selfmotion.errors import FileFormatError, RangeError, ShapeError, unknown_name
from selfmotion.motion.files.arrays_to_study import RUN_NAMES, study_from_arrays
from selfmotion.motion.files.table import Table, read_table
from selfmotion.motion.labels import LABEL_NAMES
from selfmotion.motion.recording import Recording, Study
from selfmotion.writing import write_whole

AngleUnit = Literal["rad", "deg"]
LengthUnit = Literal["m", "cm", "mm"]
DEGREE = np.pi / 180.0
ANGLES = {"rad": 1.0, "radian": 1.0, "radians": 1.0}
ANGLES |= {"deg": DEGREE, "degree": DEGREE, "degrees": DEGREE, "°": DEGREE}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3}
UNITS = ANGLES | LENGTHS | TIMES
# Ends of names that are units; "_m" and "_s" would take the end off many a joint's name.
SUFFIX_UNITS = ("deg", "rad", "mm", "cm", "ms")
# Beyond one turn either way an angle without a unit is taken for degrees that lost theirs.
PLAUSIBLE_RADIANS = 2.0 * np.pi
# Farther than this from the origin (m) no hand is recorded; millimetres without a unit are.
PLAUSIBLE_METRES = 20.0
# Names that mean positions or quaternions elsewhere; taken for joints they would pass in silence.
NOT_JOINTS = frozenset({"x", "y", "z", "qx", "qy", "qz", "qw"})
VELOCITY = "_velocity"
SPEED_NAME = re.compile(r"(^|\s)(velocity|speed|acceleration)$", re.IGNORECASE)


@dataclass(frozen=True)
class _Column:
    """A column of numbers: its place in the file, its bare name and its unit if named."""

    header: str
    name: str
    unit: str | None


def read_angles_csv(
    path: str | Path,
    *,
    unit: AngleUnit | None = None,
    length_unit: LengthUnit | None = None,
    rate: float | None = None,
    joints: Sequence[str] | None = None,
) -> Study:
    r"""Read joint angles; each run of equal labels is a recording.

    Args:
        path: the file.
        unit: unit of the angles whose column names none; None: radians, checked for plausibility.
        length_unit: the same of the hand's path; None: metres, checked for plausibility.
        rate: sampling rate, Hz, where the file has no time.
        joints: names of the columns that are joint angles; the others are left aside. Left out:
            all beside time, labels and the hand.

    Raises:
        SelfmotionError: one line that names file, row, column, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "angles.csv")
        >>> _ = where.write_text("time,shoulder,elbow_deg\n0.00,0.1,90\n0.01,0.2,180\n")
        >>> reach = read_angles_csv(where)[0]
        >>> reach.joints, np.round(reach.array("q")[1], 3).tolist(), reach.rate
        (('shoulder', 'elbow'), [0.2, 3.142], 100.0)
    """
    table, units = _split_units(read_table(path))
    arrays: dict[str, np.ndarray] = {
        name: np.array(table.cells(name)) for name in RUN_NAMES if name in table.header
    }
    columns = _columns(table, units, joints)
    twice = sorted({c.name for c in columns if [d.name for d in columns].count(c.name) > 1})
    if twice:
        raise FileFormatError(f"{table.path}: column {twice[0]!r} is there in more than one unit")
    arrays |= _clock(table, columns, rate)
    moving = [c for c in columns if c.name not in ("time", "sample", "frame")]
    hand = [c for c in moving if c.name.startswith("hand_")]
    angles = [c for c in moving if c not in hand]
    arrays |= _pair(table, angles, unit, ("q", "qd", "joints"))
    arrays |= _pair(table, hand, length_unit, ("x", "xd", "rows"))
    if "q" not in arrays:
        raise FileFormatError(f"{table.path}: no column of joint angles beside time and labels")
    return study_from_arrays(table.path, arrays)


def column_units(path: str | Path) -> dict[str, str | None]:
    """Give the unit that each column of numbers names, by bare column name; None: it names none.

    Raises:
        FileFormatError: no table, or a unit that is not known.
    """
    table, units = _split_units(read_table(path))
    columns = [_column(table, h, units) for h in table.header if h not in RUN_NAMES]
    return {column.name: column.unit for column in columns}


def write_angles_csv(
    path: str | Path, recordings: Study | Sequence[Recording], *, unit: AngleUnit = "rad"
) -> Path:
    """Write joint angles (and velocities and the hand, where held) that the reader gives back.

    Degrees are marked by ``_deg`` at the end of the column's name. Numbers keep every digit.

    Raises:
        ShapeError: the recordings differ in joints, rows, fields or having a time.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "angles.csv")
        >>> _ = write_angles_csv(where, [Recording([0, 1], q=[[0.0], [np.pi]])], unit="deg")
        >>> where.read_text().split()
        ['time,joint_1_deg', '0.0,0.0', '1.0,180.0']
    """
    study = recordings if isinstance(recordings, Study) else Study(tuple(recordings))
    first = study[0]
    for other in study:
        for what in ("joints", "rows", "held", "timed"):
            if getattr(other, what) != getattr(first, what):
                raise ShapeError(f"{other.name}: {what} differ from those of {first.name}")
    labels = [label for label in LABEL_NAMES if any(study.values(label))]
    numbered = len({r.labels for r in study}) < len(study)
    buffer = io.StringIO()
    out = csv.writer(buffer, lineterminator="\n")
    names = _written_names(first, unit)
    out.writerow([*labels, *(["recording"] if numbered else []), *names])
    for i, recording in enumerate(study):
        known = [getattr(recording.labels, label) or "" for label in labels]
        known += [str(i)] if numbered else []
        for row in _written_values(recording, unit):
            cells = ["" if np.isnan(value) else repr(value) for value in row]
            out.writerow([*known, *cells])
    return write_whole(path, buffer.getvalue())


def _written_names(recording: Recording, unit: AngleUnit) -> list[str]:
    suffix = "_deg" if unit == "deg" else ""
    names = ["time" if recording.timed else "sample"]
    for field, joint in (("q", ""), ("qd", VELOCITY)):
        if field in recording.held:
            names += [f"{name}{joint}{suffix}" for name in recording.joints]
    for field, end in (("x", ""), ("xd", VELOCITY)):
        if field in recording.held:
            names += [f"hand_{name}{end}" for name in recording.rows]
    return names


def _written_values(recording: Recording, unit: AngleUnit) -> list[list[float]]:
    scale = {"q": DEGREE, "qd": DEGREE} if unit == "deg" else {}
    held = [name for name in ("q", "qd", "x", "xd") if name in recording.held]
    parts = [recording.array(name) / scale.get(name, 1.0) for name in held]
    return np.concatenate([recording.time[:, None], *parts], axis=1).tolist()


def _split_units(table: Table) -> tuple[Table, dict[str, str]]:
    """Take a row of units off the top, if there is one."""
    tops = zip(table.header, table.columns, strict=True)
    first = {name: cells[0].strip("[]() ").lower() for name, cells in tops}
    named = {name: _bare_unit(text) for name, text in first.items() if text not in ("", "-")}
    if not named or not all(text in UNITS for text in named.values()):
        return table, {}
    if len(table.rows) < 2:
        raise FileFormatError(f"{table.path}: no rows below the units")
    columns = tuple(cells[1:] for cells in table.columns)
    return Table(table.path, table.header, columns, table.rows[1:]), named


def _bare_unit(text: str) -> str:
    return re.sub(r"(/s|/sec|\*s\^-1|\.s-1)$", "", text.strip().lower())


def _columns(table: Table, units: dict[str, str], joints: Sequence[str] | None) -> list[_Column]:
    """Name the columns of numbers, of the joints those that are asked for."""
    columns = [_column(table, h, units) for h in table.header if h not in RUN_NAMES]
    if joints is None:
        for column in columns:
            # "Finger Velocity" among joint angles: taken for one, it would pass in silence.
            if SPEED_NAME.search(column.name):
                raise FileFormatError(
                    f"{table.path}: column {column.header}: no joint angle by its name; name the "
                    "columns that are (joints=...), or a joint's velocity JOINT_velocity"
                )
        return columns
    known = [c.name for c in columns]
    for name in joints:
        if name not in known:
            raise unknown_name("column", name, known)
    wanted = {*joints, *(f"{name}{VELOCITY}" for name in joints)}
    clocks = ("time", "sample", "frame")
    return [c for c in columns if c.name in wanted or c.name in clocks]


def _column(table: Table, header: str, units: dict[str, str]) -> _Column:
    """Part a column's name from its unit."""
    name, unit = header.strip(), units.get(header)
    bracket = re.fullmatch(r"(.+?)\s*[\[(]\s*([^\])]+?)\s*[\])]", name)
    suffix = re.fullmatch(rf"(.+)_({'|'.join(SUFFIX_UNITS)})", name, re.IGNORECASE)
    if name.lower() == "time_s":
        suffix = re.fullmatch(r"(.+)_(s)", name, re.IGNORECASE)
    for match in (bracket, suffix):
        if match is None:
            continue
        name, found = match[1], _bare_unit(match[2])
        if found not in UNITS:
            raise FileFormatError(
                f"{table.path}: column {header}: unknown unit {found!r} (known: {', '.join(UNITS)})"
            )
        if unit is not None and UNITS[unit] != UNITS[found]:
            raise FileFormatError(f"{table.path}: column {header}: its unit row says {unit!r}")
        unit = found
    if name.lower() in ("time", "t", "sample", "frame", "frame#"):
        name = {"t": "time", "frame#": "frame"}.get(name.lower(), name.lower())
    if name.lower() in NOT_JOINTS:
        raise FileFormatError(
            f"{table.path}: column {header}: a joint's name is needed (a position of the hand is "
            "hand_x, hand_y, hand_z, in metres)"
        )
    return _Column(header, name, unit)


def _clock(table: Table, columns: list[_Column], rate: float | None) -> dict[str, np.ndarray]:
    """Give the time of each sample, or the step, or neither where samples are only numbered."""
    named = {c.name: c for c in columns}
    if rate is not None and not 0.0 < rate < np.inf:
        raise RangeError(f"rate = {rate:g} Hz: must be positive and finite")
    if "time" in named:
        if rate is not None:
            raise RangeError(f"{table.path}: rate = {rate:g} Hz, but there is a column time")
        column = named["time"]
        if column.unit is not None and column.unit not in TIMES:
            raise FileFormatError(f"{table.path}: column {column.header}: time is in s or ms")
        values = table.numbers(column.header)
        missing = np.flatnonzero(np.isnan(values))
        if missing.size:
            raise table.refusal(int(missing[0]), column.header, "where a time is needed")
        return {"time": values * TIMES[column.unit or "s"]}
    if rate is not None:
        return {"dt": np.array(1.0 / rate)}
    if "sample" in named:
        return {}
    raise FileFormatError(
        f"{table.path}: no column time (s): name it so, or state the rate (rate=..., --rate), or "
        "name a column sample"
    )


def _pair(
    table: Table,
    columns: list[_Column],
    unit: AngleUnit | LengthUnit | None,
    fields: tuple[str, str, str],
) -> dict[str, np.ndarray]:
    """Read positions and, where there are such columns, their velocities, in the same order."""
    position, velocity, names = fields
    bare = {c.name: c for c in columns if not c.name.endswith(VELOCITY)}
    rates = {c.name.removesuffix(VELOCITY): c for c in columns if c.name.endswith(VELOCITY)}
    if rates and set(rates) != set(bare):
        odd = sorted(set(rates) ^ set(bare))[0]
        raise FileFormatError(f"{table.path}: {odd}: position and velocity are both needed")
    if not bare:
        return {}
    kind = LENGTHS if position == "x" else ANGLES | LENGTHS
    out = {names: np.array([name.removeprefix("hand_") for name in bare])}
    for field, group in ((position, bare), (velocity, {k: rates[k] for k in bare if rates})):
        if group:
            out[field] = np.stack([_values(table, c, unit, kind) for c in group.values()], axis=1)
    return out


def _values(
    table: Table,
    column: _Column,
    unit: AngleUnit | LengthUnit | None,
    kind: dict[str, float],
) -> np.ndarray:
    """Read a column in SI units; refuse one without a unit that cannot be radians or metres."""
    values = table.numbers(column.header)
    named = column.unit or unit
    if named is not None:
        if named not in kind:
            allowed = ", ".join(kind)
            raise FileFormatError(
                f"{table.path}: column {column.header}: unit {named!r}; allowed are {allowed}"
            )
        return values * kind[named]
    angle = "rad" in kind
    bound = PLAUSIBLE_RADIANS if angle else PLAUSIBLE_METRES
    beyond = np.flatnonzero(np.abs(values) > bound)
    if beyond.size and not column.name.endswith(VELOCITY):
        name = column.name
        raise table.refusal(
            int(beyond[0]),
            column.header,
            f"is beyond 2 pi rad: name the column {name}_deg (or {name}_rad), or state the unit "
            "(unit=..., --angle-unit)"
            if angle
            else f"is beyond {bound:g} m: name the column {name}_mm (or {name} [m]), or state the "
            "unit (length_unit=..., --length-unit)",
        )
    return values
