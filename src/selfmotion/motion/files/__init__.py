"""Readers of recorded motion, one file each; :func:`load` and :func:`load_markers` find them."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from selfmotion.errors import FileFormatError
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame

if TYPE_CHECKING:
    from selfmotion.motion.markers import MarkerSet
    from selfmotion.motion.recording import Study

__all__ = ["load", "load_markers"]

# Files of these names may hold joint motion, so that a folder of recordings is read by them.
SUFFIXES = {".npz": "npz", ".mat": "mat", ".csv": "csv", ".tsv": "csv", ".txt": "csv"}
SUFFIXES |= {".mot": "storage", ".sto": "storage", ".parquet": "parquet"}
MARKER_SUFFIXES = {".c3d": "c3d", ".trc": "trc"}
MARKER_FORMATS = ("c3d", "trc", "vicon")
HDF5 = b"\x89HDF\r\n\x1a\n"
# MATLAB writes a block of text of this size before the HDF5 part of a v7.3 file.
USER_BLOCK = 512
# A Vicon file may hold other sections before its trajectories; their header alone is looked at.
START = 4096


def load(
    path: str | Path,
    *,
    unit: Literal["rad", "deg"] | None = None,
    length_unit: Literal["m", "cm", "mm"] | None = None,
    rate: float | None = None,
    frame: Frame | None = None,
) -> "Study":
    """Read a file of joint motion: .npz, .mat, .csv, .mot, .sto, .parquet or Motion-BIDS.

    The format is told by the content, then by the name. Joint angles in CSV are radians unless a
    column's name ends in ``_deg``; to say which columns are joints, or which coordinates are
    lengths, call the format's own reader.

    Args:
        path: the file; of Motion-BIDS the ``*_motion.tsv``.
        unit: unit of the angles, where a text file does not name it.
        length_unit: unit of the hand's path, where a CSV does not name it; else metres.
        rate: sampling rate, Hz, where the file has no time.
        frame: the axes of the hand's path, where the file does not tell them; either may be None.

    What is stated and contradicts the file is refused.

    Raises:
        SelfmotionError: one line that names file, row or field, value and what is allowed.

    Example:
        >>> import tempfile, numpy as np
        >>> where = Path(tempfile.mkdtemp(), "reach.npz")
        >>> np.savez(where, q=np.zeros((5, 2)))
        >>> load(where).n_samples
        5
    """
    path = Path(path)
    kind = format_of(path)
    if kind in MARKER_FORMATS:
        raise FileFormatError(
            f"{path}: holds markers, not joint angles: load_markers reads them, `selfmotion "
            "angles` makes angles of them, `selfmotion segment --marker NAME` finds strokes"
        )
    if kind == "csv":
        from selfmotion.motion.files.angles_csv import read_angles_csv

        study = read_angles_csv(path, unit=unit, length_unit=length_unit, rate=rate)
    else:
        from selfmotion.motion.files.stated import refuse_other_unit, with_rate

        study = _load_binary_or_storage(path, kind, unit)
        if any(recording.x is not None for recording in study):
            refuse_other_unit(path, "lengths", "m", length_unit)
        study = with_rate(study, rate)
    from selfmotion.motion.files.stated import with_frame

    return with_frame(study, frame)


def _load_binary_or_storage(path: Path, kind: str, unit: Literal["rad", "deg"] | None) -> "Study":
    """Read a format that names its units, or has them by contract."""
    from selfmotion.motion.files.stated import refuse_other_unit

    if kind == "storage":
        from selfmotion.motion.files.storage import read_mot

        return read_mot(path, unit=unit)
    if kind == "bids":
        return _bids_angles(path, unit)
    refuse_other_unit(path, "angles", "rad", unit)
    if kind == "npz":
        from selfmotion.motion.files.npz import read_npz

        return read_npz(path)
    if kind == "mat":
        from selfmotion.motion.files.mat import read_mat

        return read_mat(path).study
    from selfmotion.motion.files.parquet import read_parquet

    return read_parquet(path)


def load_markers(
    path: str | Path,
    *,
    unit: Literal["m", "cm", "mm"] | None = None,
    rate: float | None = None,
    frame: Frame | None = None,
) -> "MarkerSet":
    r"""Read a file of marker trajectories: C3D, TRC, Vicon Nexus CSV or Motion-BIDS.

    Args:
        path: the file; of Motion-BIDS the ``*_motion.tsv``.
        unit: unit of length, where a C3D or TRC does not name it.
        rate: frames a second, where a C3D does not say; else it must agree with the file.
        frame: the axes of the laboratory: C3D knows at most the up axis, TRC and Vicon's CSV none.
            An axis that is None is taken from the file, if that tells it.

    Raises:
        SelfmotionError: one line that names file, row or field, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.csv")
        >>> _ = where.write_text("Trajectories\n100\n,,P1:STRN,,\nFrame,Sub Frame,X,Y,Z\n"
        ...                      ",,mm,mm,mm\n1,0,1000,0,250\n")
        >>> load_markers(where, frame=Frame(up="z", forward="y")).names
        ('STRN',)
    """
    from dataclasses import replace

    from selfmotion.motion.files.stated import merged_frame, require_rate

    path = Path(path)
    partial = frame is not None and not frame.known
    found = _read_markers(path, (unit, None if partial else frame, rate))
    require_rate(str(path), found.rate, rate)
    if frame is not None and partial:
        return replace(found, frame=merged_frame(str(path), found.frame, frame))
    return found


def _read_markers(
    path: Path, stated: "tuple[Literal['m', 'cm', 'mm'] | None, Frame | None, float | None]"
) -> "MarkerSet":
    """Read by the format's own reader what the caller states as unit, frame and rate."""
    unit, frame, rate = stated
    kind = format_of(path)
    if kind == "c3d":
        from selfmotion.motion.files.c3d import read_c3d

        return read_c3d(path, unit=unit, frame=frame, rate=rate)
    known = frame or UNKNOWN_FRAME
    if kind == "trc":
        from selfmotion.motion.files.trc import read_trc

        return read_trc(path, unit=unit, frame=known)
    if kind == "vicon":
        from selfmotion.motion.files.vicon_csv import read_vicon_csv

        return read_vicon_csv(path, unit=unit, frame=known)
    if kind == "bids":
        return _bids_markers(path, unit, frame)
    raise FileFormatError(
        f"{path}: holds no marker trajectories; allowed are .c3d, .trc, Vicon Nexus .csv and "
        "*_motion.tsv"
    )


def format_of(path: str | Path) -> str:
    """Tell a file's format: npz, mat, csv, storage, parquet, bids, c3d, trc or vicon.

    Raises:
        FileFormatError: there is no such file, or its kind is not known.
    """
    path = Path(path)
    if not path.is_file():
        raise FileFormatError(f"{path}: no such file")
    try:
        with open(path, "rb") as stream:
            start = stream.read(START)
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    if start.startswith(b"PK\x03\x04") and path.suffix.lower() != ".xlsx":
        return "npz"
    if start.startswith((b"MATLAB", HDF5)) or start[USER_BLOCK:].startswith(HDF5):
        return "mat"
    if start.startswith(b"PAR1"):
        return "parquet"
    if path.name.endswith("_motion.tsv"):
        return "bids"
    return _by_text(path, start)


def _by_text(path: Path, start: bytes) -> str:
    encoding = "utf-16" if start[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    lines = start.decode(encoding, "replace").lower().splitlines()
    words = {line.strip(' \t;,"') for line in lines}
    if any("pathfiletype" in line for line in lines[:20]):
        return "trc"
    if "endheader" in words:
        return "storage"
    suffix = path.suffix.lower()
    known = SUFFIXES | MARKER_SUFFIXES
    if suffix not in known:
        raise FileFormatError(
            f"{path}: unknown kind of file {suffix!r}; allowed are {', '.join(known)}"
        )
    found = known[suffix]
    if found == "csv" and any(_starts_vicon(line) for line in words):
        return "vicon"
    return found


def _starts_vicon(line: str) -> bool:
    """Tell whether a line is the title of a section of Vicon Nexus' CSV."""
    return line in ("trajectories", "devices", "model outputs", "joints", "segments")


def _bids_angles(path: Path, unit: str | None) -> "Study":
    from selfmotion.motion.files.bids import ANGLE_UNITS, read_bids
    from selfmotion.motion.files.stated import refuse_other_unit
    from selfmotion.motion.recording import Study

    found = read_bids(path)
    if found.recording is None:
        held = ", ".join([*found.units, *found.aside])
        raise FileFormatError(f"{path}: no channel of type JNTANG (there are {held})")
    for named in found.units["JNTANG"].split(", "):
        known = "deg" if ANGLE_UNITS.get(named.lower()) == ANGLE_UNITS["deg"] else "rad"
        refuse_other_unit(path, "angles", known, unit)
    return Study((found.recording,))


def _bids_markers(path: Path, unit: str | None, frame: Frame | None) -> "MarkerSet":
    from dataclasses import replace

    from selfmotion.motion.files.bids import read_bids
    from selfmotion.motion.files.numeric_rows import scale_to_metres

    found = read_bids(path)
    if found.markers is None:
        held = ", ".join([*found.units, *found.aside])
        raise FileFormatError(f"{path}: no channel of type POS (there are {held})")
    for named in found.units["POS"].split(", "):
        scale_to_metres(path, named, unit, "channels.tsv, unit")
    if frame is None:
        return found.markers
    if found.markers.frame.known and found.markers.frame != frame:
        raise FileFormatError(f"{path}: a frame was stated, but channels.json has another")
    return replace(found.markers, frame=frame)
