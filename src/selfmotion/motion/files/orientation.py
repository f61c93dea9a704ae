"""Orientations over time (inertial sensors): CSV, NPZ, and OpenSim's quaternion tables (STO).

CSV columns tell the form by name, before which a segment's name may stand (``hand_qx``):
quaternions ``qx qy qz qw`` (also ``quat_x`` ..., or ``x y z w``) in any order, matrices ``r11`` to
``r33`` (row, column), rotation vectors ``rx ry rz`` (also ``rotvec_x`` ...) in rad, or in degrees
where a name ends in ``_deg``. NPZ holds ``quaternions (K,4)``, ``matrices (K,3,3)`` or
``rotation_vectors (K,3)``; quaternions there are x, y, z, w unless ``quaternion_order`` says
otherwise. Beside them: ``time`` (s), ``sample`` or nothing, and labels. Empty cells, NaN and
quaternions of zeros are gaps.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from selfmotion.errors import FileFormatError, RangeError, ShapeError
from selfmotion.motion.files.arrays_to_study import RUN_NAMES, naming, study_from_arrays
from selfmotion.motion.files.npz import npz_arrays
from selfmotion.motion.files.numeric_rows import parse_rows
from selfmotion.motion.files.storage import storage_cells
from selfmotion.motion.files.table import Table, read_table
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame
from selfmotion.motion.orientations import (
    Orientations,
    matrices_from_quaternions,
    matrices_from_vectors,
)

Order = Literal["xyzw", "wxyz"]
Form = Literal["quaternions", "matrices", "rotation_vectors"]
MATRIX_PARTS = tuple(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
# Sets of column names that make an orientation; of those that fit a file the first counts.
COLUMNS: tuple[tuple[Form, tuple[str, ...]], ...] = (
    ("quaternions", ("qx", "qy", "qz", "qw")),
    ("quaternions", ("quat_x", "quat_y", "quat_z", "quat_w")),
    ("quaternions", ("quatx", "quaty", "quatz", "quatw")),
    ("quaternions", ("x", "y", "z", "w")),
    ("matrices", MATRIX_PARTS),
    ("rotation_vectors", ("rotvec_x", "rotvec_y", "rotvec_z")),
    ("rotation_vectors", ("rx", "ry", "rz")),
)
WIDTHS: dict[Form, tuple[int, ...]] = {
    "quaternions": (4,),
    "matrices": (3, 3),
    "rotation_vectors": (3,),
}
TIMES = {"time": 1.0, "t": 1.0, "time_s": 1.0, "time_ms": 1e-3}


@dataclass(frozen=True)
class _Found:
    """The columns of one segment's orientation."""

    form: Form
    segment: str
    headers: tuple[str, ...]
    scale: float = 1.0


def read_orientations(
    path: str | Path,
    *,
    order: Order | None = None,
    rate: float | None = None,
    frame: Frame | None = None,
) -> tuple[Orientations, ...]:
    r"""Read orientations over time: one for each segment and each run of equal labels.

    Args:
        path: .csv, .tsv or .txt with named columns, .npz, or .sto with DataType=Quaternion.
        order: order of an array's quaternions, where an .npz does not say; left out: x, y, z, w.
        rate: sampling rate, Hz, where the file has no time.
        frame: the axes of the ground, where the file does not tell.

    Raises:
        SelfmotionError: one line that names file, row or field, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "hand.csv")
        >>> _ = where.write_text("time,qw,qx,qy,qz\n0.00,1,0,0,0\n0.01,0.6,0,0,0.8\n")
        >>> turned = read_orientations(where)[0]
        >>> turned.quaternions()[1].round(3).tolist(), turned.pointing()[1].round(3).tolist()
        ([0.0, 0.0, 0.8, 0.6], [-0.96, 0.0])
    """
    if rate is not None and not 0.0 < rate < np.inf:
        raise RangeError(f"rate = {rate:g} Hz: must be positive and finite")
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        arrays = dict(npz_arrays(path))
        form, values = _npz_values(path, arrays, order)
        fields = _with_rate(path, arrays, rate)
        return tuple(_cut(path, _Found(form, "", ()), values, fields, frame))
    if suffix == ".sto":
        return _from_storage(path, frame)
    table = read_table(path)
    found = orientation_columns(table.header)
    if not found:
        raise FileFormatError(
            f"{path}: no orientation among the columns {', '.join(table.header)[:80]} (needed are "
            "qx, qy, qz, qw, or r11 to r33, or rx, ry, rz)"
        )
    beside = _with_rate(path, _beside(table), rate)
    out: list[Orientations] = []
    for segment in found:
        values = np.stack([table.numbers(header) for header in segment.headers], axis=1)
        out += _cut(path, segment, values * segment.scale, beside, frame)
    return tuple(out)


def orientation_columns(header: Sequence[str]) -> list[_Found]:
    """Find the sets of columns that hold an orientation, one a segment."""
    bare = {re.sub(r"\s*[\[(].*?[\])]\s*$", "", name).strip().lower(): name for name in header}
    degrees = {key for key, name in bare.items() if "deg" in name.lower().removeprefix(key)}
    out: dict[str, _Found] = {}
    for form, parts in COLUMNS:
        endings = ("", "_deg", "_rad") if form == "rotation_vectors" else ("",)
        for ending in endings:
            last = parts[0] + ending
            for key in bare:
                prefix = key.removesuffix(last)
                names = [f"{prefix}{part}{ending}" for part in parts]
                lone = parts == ("x", "y", "z", "w") and prefix
                if not key.endswith(last) or lone or not all(n in bare for n in names):
                    continue
                if prefix and prefix[-1].isalnum():
                    continue
                in_degrees = ending == "_deg" or degrees.issuperset(names)
                scale = np.pi / 180.0 if in_degrees and form == "rotation_vectors" else 1.0
                headers = tuple(bare[n] for n in names)
                out.setdefault(prefix, _Found(form, prefix.strip("_.-: "), headers, scale))
    return list(out.values())


def _beside(table: Table) -> dict[str, np.ndarray]:
    """Give labels and time of a table, as fields of `study_from_arrays`."""
    fields = {name: np.array(table.cells(name)) for name in RUN_NAMES if name in table.header}
    for name in table.header:
        if name.lower() in TIMES:
            values = table.numbers(name)
            missing = np.flatnonzero(np.isnan(values))
            if missing.size:
                raise table.refusal(int(missing[0]), name, "where a time is needed")
            fields["time"] = values * TIMES[name.lower()]
            break
    return fields


def _with_rate(
    path: str | Path, fields: dict[str, np.ndarray], rate: float | None
) -> dict[str, np.ndarray]:
    if rate is None:
        return fields
    if "time" in fields or "dt" in fields:
        raise RangeError(f"{path}: rate = {rate:g} Hz, but the file has its own time")
    return fields | {"dt": np.array(1.0 / rate)}


def _npz_values(
    path: str | Path, arrays: dict[str, np.ndarray], order: Order | None
) -> tuple[Form, np.ndarray]:
    """Take the one array of orientations out of the fields, as x, y, z, w if quaternions."""
    held: list[Form] = [form for form in WIDTHS if form in arrays]
    if len(held) != 1:
        names = ", ".join(arrays) or "nothing"
        raise FileFormatError(
            f"{path}: one of {', '.join(WIDTHS)} is needed; it holds {names[:80]}"
        )
    form = held[0]
    values = np.asarray(arrays.pop(form))
    if values.dtype.kind not in "iuf" or values.shape[1:] != WIDTHS[form] or not len(values):
        raise ShapeError(
            f"{path}: {form} has shape {values.shape} of {values.dtype}; allowed are numbers of "
            f"shape (samples, {', '.join(map(str, WIDTHS[form]))})"
        )
    written = arrays.pop("quaternion_order", None)
    if form == "quaternions":
        named = order or "xyzw"
        if written is not None:
            named = str(np.asarray(written).reshape(-1)[0]) if np.size(written) else ""
        if named not in ("xyzw", "wxyz"):
            raise RangeError(f"{path}: quaternion_order {named[:20]!r}: allowed are xyzw and wxyz")
        if order not in (None, named):
            raise RangeError(f"{path}: quaternion_order is {named}, but {order} was stated")
        values = values if named == "xyzw" else np.roll(values, -1, axis=1)
    return form, values.reshape(len(values), -1).astype(np.float64)


def _from_storage(path: str | Path, frame: Frame | None) -> tuple[Orientations, ...]:
    """Read OpenSim's table of quaternions: a column a sensor, cells ``w,x,y,z``."""
    _, header, names, rows = storage_cells(path)
    kind = header.get("datatype", "double")
    if kind.lower() != "quaternion":
        raise FileFormatError(
            f"{path}: DataType={kind[:40]}; orientations need DataType=Quaternion"
        )
    for number, cells in rows:
        if len(cells) != len(names):
            raise FileFormatError(f"{path}: row {number} has {len(cells)} cells, not {len(names)}")
    beside = {"time": parse_rows(path, [(n, cells[:1]) for n, cells in rows], ["time"])[:, 0]}
    out: list[Orientations] = []
    for i, name in enumerate(names[1:], start=1):
        parts = [(n, [c.strip() for c in cells[i].split(",")]) for n, cells in rows]
        odd = next((n for n, cells in parts if len(cells) != 4 and cells != [""]), None)
        if odd is not None:
            raise FileFormatError(f"{path}: row {odd}, column {name}: four numbers w,x,y,z needed")
        values = parse_rows(path, parts, [f"{name} {part}" for part in "wxyz"])
        found = _Found("quaternions", name, ())
        out += _cut(path, found, np.roll(values, -1, axis=1), beside, frame)
    return tuple(out)


def _cut(
    path: str | Path,
    found: _Found,
    values: np.ndarray,
    beside: Mapping[str, np.ndarray],
    frame: Frame | None,
) -> list[Orientations]:
    """Cut the samples where labels change, and turn each piece into rotations."""
    known = {k: v for k, v in beside.items() if k not in ("q", "qd", "x", "xd", "jacobian")}
    known = {k: v for k, v in known.items() if k not in ("joints", "rows")}
    pieces = study_from_arrays(str(path), known | {"x": values})
    out = []
    for piece in pieces:
        with naming(piece.name):
            out.append(
                Orientations(
                    piece.time,
                    _matrices(found.form, piece.array("x")),
                    found.segment,
                    _frame(path, piece.frame, frame),
                    piece.labels,
                    str(path),
                    piece.timed,
                )
            )
    return out


def _matrices(form: Form, values: np.ndarray) -> np.ndarray:
    if form == "quaternions":
        return matrices_from_quaternions(values)
    if form == "rotation_vectors":
        return matrices_from_vectors(values)
    return values.reshape(-1, 3, 3)


def _frame(path: str | Path, found: Frame, stated: Frame | None) -> Frame:
    if stated is not None and found not in (UNKNOWN_FRAME, stated):
        raise RangeError(f"{path}: a frame was stated, but the file has its own")
    return stated or found
