"""What a file holds, in which units and axes, and where it has gaps; for people and programs."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from selfmotion.errors import FileFormatError
from selfmotion.motion.files import format_of, load, load_markers
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.markers import MarkerSet
from selfmotion.motion.orientations import Orientations
from selfmotion.motion.recording import Study

MODELS = frozenset({".osim", ".urdf", ".mjcf"})
FORMATS = {
    "npz": "NumPy archive",
    "mat": "MATLAB",
    "csv": "CSV",
    "storage": "OpenSim MOT/STO",
    "parquet": "Parquet",
    "bids": "Motion-BIDS",
    "c3d": "C3D",
    "trc": "TRC",
    "vicon": "Vicon Nexus CSV",
}


@dataclass(frozen=True)
class Gap:
    """Samples that are missing of one marker, joint or orientation.

    Attributes:
        name: what is missing; ``all`` of a recording without names.
        missing: number of samples.
        longest: samples of the longest gap.
    """

    name: str
    missing: int
    longest: int


@dataclass(frozen=True)
class FileContent:
    """What one file holds.

    Attributes:
        format: the file's format.
        holds: joint angles, velocities and Jacobians, markers, orientations, or a table.
        recordings: number of recordings (trials, or sensors).
        samples: samples of all recordings together.
        seconds: duration of the recordings together; None where there are no seconds.
        rate: mean rate of the first recording, Hz; None where there is none.
        names: joints, markers, sensors or columns.
        units: what the file says of its units, by quantity.
        frame: the axes, unknown where the file does not tell them.
        labels: the labels of the recordings, each once.
        gaps: what is missing, only where something is.
        notes: what a user should know: a header that is wrong, what was left aside.
    """

    format: str
    holds: str
    recordings: int
    samples: int
    seconds: float | None
    rate: float | None
    names: tuple[str, ...]
    units: dict[str, str]
    frame: Frame = UNKNOWN_FRAME
    labels: tuple[Labels, ...] = ()
    gaps: tuple[Gap, ...] = ()
    notes: tuple[str, ...] = field(default=())


@dataclass(frozen=True)
class Known:
    """What a caller knows of a file that does not say it itself; None: nothing.

    Attributes:
        angle_unit: unit of angles.
        length_unit: unit of positions.
        rate: sampling rate (Hz).
        frame: axes; either may be None.
    """

    angle_unit: Literal["rad", "deg"] | None = None
    length_unit: Literal["m", "cm", "mm"] | None = None
    rate: float | None = None
    frame: Frame | None = None

    def load(self, path: Path) -> Study:
        """Read joint motion."""
        return load(
            path,
            unit=self.angle_unit,
            length_unit=self.length_unit,
            rate=self.rate,
            frame=self.frame,
        )

    def load_markers(self, path: Path) -> MarkerSet:
        """Read markers."""
        return load_markers(path, unit=self.length_unit, rate=self.rate, frame=self.frame)

    def load_orientations(self, path: Path) -> tuple[Orientations, ...]:
        """Read orientations."""
        from selfmotion.motion.files.orientation import read_orientations

        return read_orientations(path, rate=self.rate, frame=self.frame)


UNKNOWN = Known()


def describe(path: str | Path, known: Known = UNKNOWN) -> FileContent:
    r"""Say what a file holds.

    Args:
        path: the file.
        known: what the caller knows of it.

    Raises:
        SelfmotionError: it cannot be read, with the reason.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.csv")
        >>> _ = where.write_text("time,elbow_deg\n0.00,90\n0.01,\n0.02,91\n")
        >>> found = describe(where)
        >>> found.holds, found.rate, found.units["angles"], found.gaps[0].missing
        ('joint angles', 100.0, 'deg', 1)
    """
    path = Path(path)
    if path.suffix.lower() in MODELS:
        raise FileFormatError(f"{path}: a model, no recording: `selfmotion arms` describes it")
    match format_of(path):
        case "c3d":
            return _c3d(path, known)
        case "trc":
            return _trc(path, known)
        case "vicon":
            return _vicon(path, known)
        case "storage":
            return _storage(path, known)
        case "bids":
            return _bids(path, known)
        case "csv":
            return _csv(path, known)
        case kind:
            return _arrays(path, kind, known)


def gap_lengths(missing: np.ndarray) -> tuple[int, int]:
    """Count the missing samples, and those of the longest gap.

    Example:
        >>> gap_lengths(np.array([True, False, True, True]))
        (3, 2)
    """
    if not missing.any():
        return 0, 0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], missing.astype(np.int8), [0]])))
    return int(missing.sum()), int((edges[1::2] - edges[::2]).max())


def _c3d(path: Path, known: Known) -> FileContent:
    from selfmotion.motion.files.c3d import read_c3d_table

    markers = known.load_markers(path)
    table = read_c3d_table(path)
    notes = []
    if table.outputs:
        notes.append(f"{len(table.outputs)} points are model outputs and left aside")
    unnamed = sum(name.startswith("unlabelled_") for name in table.names)
    if unnamed:
        notes.append(f"{unnamed} trajectories have no label")
    return _of_markers("c3d", markers, {"lengths": _said(table.unit, known)}, notes)


def _trc(path: Path, known: Known) -> FileContent:
    from selfmotion.motion.files.trc import read_trc_table

    markers = known.load_markers(path)
    header = read_trc_table(path).header
    notes = _count_notes("NumFrames", header.get("numframes"), markers.n_samples)
    notes += _count_notes("NumMarkers", header.get("nummarkers"), markers.n_markers)
    return _of_markers("trc", markers, {"lengths": _said(header.get("units"), known)}, notes)


def _vicon(path: Path, known: Known) -> FileContent:
    return _of_markers("vicon", known.load_markers(path), {"lengths": _vicon_unit(path, known)})


def _said(unit: str | None, known: Known) -> str:
    """Give the unit that the file names, or that the caller stated."""
    return unit or f"{known.length_unit} (stated)"


def _count_notes(what: str, promised: str | None, found: int) -> list[str]:
    if promised is None or promised == str(found):
        return []
    return [f"its header says {what} {promised[:20]}; {found} are there"]


def _storage(path: Path, known: Known) -> FileContent:
    from selfmotion.motion.files.storage import is_length, read_storage, storage_cells

    if storage_cells(path)[1].get("datatype", "").lower() == "quaternion":
        return _of_orientations("storage", known.load_orientations(path), "quaternions w, x, y, z")
    table = read_storage(path)
    notes = _count_notes("nRows", table.header.get("nrows"), len(table.time))
    if table.other_content is not None:
        rate = _rate(table.time)
        return FileContent(
            FORMATS["storage"], f"a table: {table.title}"[:80], 1, len(table.time),
            float(table.time[-1] - table.time[0]), rate, table.columns, {"time": "s"},
            gaps=_gaps(table.columns, [np.isnan(table.values)]),
            notes=(*notes, f"no coordinates: {table.other_content}"),
        )  # fmt: skip
    study = known.load(path)
    told = {True: "deg (inDegrees=yes)", False: "rad (inDegrees=no)"}
    unit = f"{known.angle_unit} (stated)" if table.in_degrees is None else told[table.in_degrees]
    lengths = [name for name in study.joints if is_length(name)]
    if lengths and unit.startswith("deg"):
        notes.append(f"taken for lengths by name: {', '.join(lengths)}")
    units = {"angles": unit} | ({"lengths": "m"} if lengths else {})
    return _of_study("storage", study, units, notes)


def _bids(path: Path, known: Known) -> FileContent:
    from selfmotion.motion.files.bids import read_bids

    found = read_bids(path)
    aside = [f"{count} channels of type {kind} left aside" for kind, count in found.aside.items()]
    if found.recording is not None:
        study = known.load(path)
        if found.markers is not None:
            aside.append(f"{found.markers.n_markers} markers are there too")
        return _of_study("bids", study, {"angles": found.units["JNTANG"]}, aside)
    if found.markers is not None:
        return _of_markers("bids", known.load_markers(path), {"lengths": found.units["POS"]}, aside)
    if found.orientations:
        return _of_orientations("bids", found.orientations, "quaternions", aside)
    kinds = ", ".join(found.aside) or "none"
    raise FileFormatError(f"{path}: no channel of type POS, JNTANG or ORNT (types: {kinds})")


def _csv(path: Path, known: Known) -> FileContent:
    from selfmotion.motion.files.angles_csv import column_units
    from selfmotion.motion.files.orientation import orientation_columns
    from selfmotion.motion.files.table import read_table

    columns = orientation_columns(read_table(path).header)
    if columns:
        form = columns[0].form.replace("_", " ")
        return _of_orientations("csv", known.load_orientations(path), form)
    study = known.load(path)
    units = column_units(path)
    angle = f"{known.angle_unit} (stated)" if known.angle_unit else "rad (not named)"
    length = f"{known.length_unit} (stated)" if known.length_unit else "m (not named)"
    angles = {units.get(name) or angle for name in study.joints}
    named = {"angles": ", ".join(sorted(angles))}
    if study[0].n_rows:
        rows = {units.get(f"hand_{row}") or length for row in study[0].rows}
        named["lengths"] = ", ".join(sorted(rows))
    return _of_study("csv", study, named)


def _arrays(path: Path, kind: str, known: Known) -> FileContent:
    """Describe what is in SI units by contract: .npz, .mat, Parquet."""
    if kind == "npz":
        from selfmotion.motion.files.npz import npz_arrays
        from selfmotion.motion.files.orientation import WIDTHS

        form = next((name for name in npz_arrays(path) if name in WIDTHS), None)
        if form is not None:
            return _of_orientations("npz", known.load_orientations(path), form.replace("_", " "))
    study = known.load(path)
    return _of_study(kind, study, {"angles": "rad (by contract)", "lengths": "m (by contract)"})


def _of_study(
    kind: str, study: Study, units: dict[str, str], notes: Sequence[str] = ()
) -> FileContent:
    first = study[0]
    held = {"q": "joint angles", "qd": "joint velocities", "jacobian": "Jacobians"}
    words = [word for name, word in held.items() if name in first.held]
    words += ["the hand's path"] if "x" in first.held else []
    seconds = sum(float(r.time[-1] - r.time[0]) for r in study) if first.timed else None
    known = "q" if "q" in first.held else ("qd" if "qd" in first.held else "x")
    names = first.rows if known == "x" else first.joints
    return FileContent(
        FORMATS[kind],
        ", ".join(words),
        len(study),
        study.n_samples,
        seconds,
        first.rate,
        names,
        units | ({"time": "s"} if first.timed else {"time": "sample numbers"}),
        first.frame,
        tuple(dict.fromkeys(r.labels for r in study if str(r.labels))),
        _gaps(names, [np.isnan(r.array(known)) for r in study if r.array(known).size]),
        tuple(notes),
    )


def _of_markers(
    kind: str, markers: MarkerSet, units: dict[str, str], notes: Sequence[str] = ()
) -> FileContent:
    missing = markers.missing()
    never = [name for name, gap in zip(markers.names, missing.T, strict=True) if gap.all()]
    if never:
        notes = [*notes, f"never seen: {', '.join(never)}"]
    return FileContent(
        FORMATS[kind],
        "markers",
        1,
        markers.n_samples,
        float(markers.time[-1] - markers.time[0]),
        markers.rate,
        markers.names,
        units | {"time": "s"},
        markers.frame,
        (markers.labels,) if str(markers.labels) else (),
        _gaps(markers.names, [missing]),
        tuple(notes),
    )


def _of_orientations(
    kind: str, found: Sequence[Orientations], form: str, notes: Sequence[str] = ()
) -> FileContent:
    first = found[0]
    seconds = sum(float(o.time[-1] - o.time[0]) for o in found) if first.timed else None
    names = tuple(dict.fromkeys(o.segment or "all" for o in found))
    counts = [(o.segment or "all", *gap_lengths(o.gaps())) for o in found]
    return FileContent(
        FORMATS[kind],
        f"orientations ({form})",
        len(found),
        sum(o.n_samples for o in found),
        seconds,
        first.rate,
        names,
        {"time": "s" if first.timed else "sample numbers"},
        first.frame,
        tuple(dict.fromkeys(o.labels for o in found if str(o.labels))),
        tuple(Gap(*count) for count in counts if count[1]),
        tuple(notes),
    )


def _gaps(names: Sequence[str], masks: Iterable[np.ndarray]) -> tuple[Gap, ...]:
    """Count gaps of each column over all recordings; gaps do not run from one to the next."""
    totals = {name: [0, 0] for name in names}
    for mask in masks:
        for name, column in zip(names, mask.T, strict=True):
            missing, longest = gap_lengths(column)
            totals[name] = [totals[name][0] + missing, max(totals[name][1], longest)]
    return tuple(Gap(name, *counts) for name, counts in totals.items() if counts[0])


def _rate(time: np.ndarray) -> float | None:
    span = float(time[-1] - time[0])
    return (len(time) - 1) / span if span > 0.0 else None


def _vicon_unit(path: Path, known: Known) -> str:
    """Give the units in the row above the samples; the reader has checked that they are there."""
    from selfmotion.motion.files.table import read_text

    lines = [line.strip(' \t;,"').lower() for line in read_text(path).splitlines()]
    units = lines[lines.index("trajectories") + 4].replace(";", ",").replace("\t", ",")
    found = sorted({cell.strip() for cell in units.split(",") if cell.strip()})
    return _said(", ".join(found), known)
