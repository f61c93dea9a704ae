"""Marker trajectories in C3D, by ezc3d.

Units come from POINT:UNITS, the up axis from POINT:Y_SCREEN where the file has it; C3D does not
say which way the person faces. Points of model outputs (POINT:ANGLES, FORCES, MOMENTS, POWERS,
SCALARS) are no markers and are left out. Analog channels are not read.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.c3d_layout import check_layout
from selfmotion.motion.files.numeric_rows import scale_to_metres
from selfmotion.motion.files.trc import LengthUnit
from selfmotion.motion.labels import AXES, UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.markers import MarkerSet, without_prefix

OUTPUTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")


@dataclass(frozen=True, eq=False)
class C3dTable:
    """What stands in a C3D file, before units.

    Attributes:
        names: the marker labels, as in the file, stripped.
        unit: POINT:UNITS; None where it is not there or empty.
        rate: frames a second; 0 where the file does not say.
        first: number of the first frame, from 0.
        values: (K, M, 3) in the unit of the file; NaN where a marker was not seen.
        up: the axis that POINT:Y_SCREEN names, or None.
        outputs: labels of points that are model outputs and no markers.
    """

    names: tuple[str, ...]
    unit: str | None
    rate: float
    first: int
    values: np.ndarray
    up: str | None
    outputs: tuple[str, ...]


def read_c3d(
    path: str | Path,
    *,
    unit: LengthUnit | None = None,
    frame: Frame | None = None,
    rate: float | None = None,
    labels: Labels | None = None,
) -> MarkerSet:
    """Read marker trajectories from a C3D file; time counts from the first frame of the trial.

    Args:
        path: the file.
        unit: unit of length, where the file names none.
        frame: the axes of the laboratory; left out: the up axis of POINT:Y_SCREEN, if any, and
            an unknown forward axis.
        rate: frames a second, where the file says 0.
        labels: whose movement this is; left out: a subject's prefix tells the subject.

    Raises:
        FileFormatError: one line that names file, field, value and what is allowed.

    Example:
        >>> import tempfile, ezc3d
        >>> made = ezc3d.c3d()
        >>> made["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
        >>> made["parameters"]["POINT"]["LABELS"]["value"] = ["P1:STRN "]
        >>> made["parameters"]["POINT"]["RATE"]["value"] = [100.0]
        >>> made["data"]["points"] = np.full((4, 1, 3), 500.0)
        >>> where = Path(tempfile.mkdtemp(), "reach.c3d")
        >>> _ = made.write(str(where))
        >>> seen = read_c3d(where)
        >>> seen.names, seen.labels.subject, seen.point("STRN")[2].tolist()
        (('STRN',), 'P1', [0.5, 0.5, 0.5])
    """
    table = read_c3d_table(path)
    scale = scale_to_metres(path, table.unit, unit, "POINT:UNITS")
    hertz = rate if table.rate == 0.0 and rate is not None else table.rate
    if not 0.0 < hertz < 1e6:
        raise FileFormatError(
            f"{path}: rate {hertz:g} Hz; a positive number is needed (rate=..., --rate)"
        )
    names, prefix = without_prefix(table.names)
    known = Frame(table.up, None, "file") if table.up else UNKNOWN_FRAME
    return MarkerSet(
        (table.first + np.arange(len(table.values))) / hertz,
        names,
        table.values * scale,
        frame or known,
        labels or Labels(subject=prefix),
        str(path),
    )


def read_c3d_table(path: str | Path) -> C3dTable:
    """Read labels, unit, rate and points of a C3D file as they stand.

    Raises:
        FileFormatError: one line that names file and field.
    """
    layout = check_layout(path)
    content = _content(path)
    parameters = content["parameters"]
    if "POINT" not in parameters:
        raise FileFormatError(f"{path}: no group POINT, so no markers")
    point = parameters["POINT"]
    points = np.asarray(content["data"]["points"], dtype=np.float64)
    if points.ndim != 3 or not points.size:
        raise FileFormatError(f"{path}: no marker trajectories in this C3D file")
    if points.shape[1] != layout.points or layout.frames not in (None, points.shape[2]):
        raise FileFormatError(
            f"{path}: {points.shape[1]} points in {points.shape[2]} frames were read; the header "
            f"says {layout.points} in {layout.frames}"
        )
    names = _labels(point, points.shape[1])
    outputs = {text for kind in OUTPUTS for text in _texts(point, kind)}
    kept = [i for i, name in enumerate(names) if name not in outputs]
    if not kept:
        raise FileFormatError(f"{path}: all {len(names)} points are model outputs, no markers")
    values = np.ascontiguousarray(points[:3, kept].transpose(2, 1, 0))
    values[np.isnan(values).any(axis=2) | (values == 0.0).all(axis=2)] = np.nan
    return C3dTable(
        tuple(names[i] for i in kept),
        next((text for text in _texts(point, "UNITS") if text), None),
        float(content["header"]["points"]["frame_rate"]),
        int(content["header"]["points"]["first_frame"]),
        values,
        _axis(_texts(point, "Y_SCREEN")),
        tuple(name for name in names if name in outputs),
    )


def _content(path: str | Path) -> Mapping[str, Any]:
    """Let ezc3d read the file; whatever it raises becomes one line."""
    import ezc3d

    try:
        return ezc3d.c3d(str(path))
    except Exception as error:  # ezc3d raises whatever its C++ did
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise FileFormatError(f"{path}: cannot be read as C3D ({reason})") from None


def _texts(group: Mapping[str, Any], name: str) -> list[str]:
    """Give the texts of a parameter and of its continuations (LABELS2, LABELS3, ...)."""
    texts: list[str] = []
    for suffix in ("", *map(str, range(2, 100))):
        if name + suffix not in group:
            break
        found = group[name + suffix]["value"]
        texts += [str(text).strip() for text in found] if isinstance(found, list) else []
    return texts


def _labels(point: Mapping[str, Any], count: int) -> list[str]:
    """Give a label for each point; those without one keep their place under a number."""
    texts = _texts(point, "LABELS")[:count]
    texts += [""] * (count - len(texts))
    return [text or f"unlabelled_{i + 1}" for i, text in enumerate(texts)]


def _axis(texts: list[str]) -> str | None:
    """Read an axis such as ``+Z``; None for anything else."""
    axis = texts[0].lower().removeprefix("+") if texts else ""
    return axis if axis in AXES else None
