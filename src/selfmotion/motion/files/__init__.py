"""Readers of recorded motion, one file each; :func:`load` finds the right one."""

from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.errors import FileFormatError

if TYPE_CHECKING:
    from selfmotion.motion.recording import Study

__all__ = ["load"]

SUFFIXES = {".npz": "npz", ".mat": "mat", ".csv": "csv", ".tsv": "csv", ".txt": "csv"}
HDF5 = b"\x89HDF\r\n\x1a\n"
# MATLAB writes a block of text of this size before the HDF5 part of a v7.3 file.
USER_BLOCK = 512


def load(path: str | Path) -> "Study":
    """Read a file of recorded motion: .npz, .mat or .csv, told by its content, then its name.

    Joint angles in CSV are radians unless a column's name ends in ``_deg``; for other units or a
    rate in place of a time column call the format's own reader.

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
    match _format(path):
        case "npz":
            from selfmotion.motion.files.npz import read_npz

            return read_npz(path)
        case "mat":
            from selfmotion.motion.files.mat import read_mat

            return read_mat(path).study
        case _:
            from selfmotion.motion.files.angles_csv import read_angles_csv

            return read_angles_csv(path)


def _format(path: Path) -> str:
    if not path.is_file():
        raise FileFormatError(f"{path}: no such file")
    try:
        with open(path, "rb") as stream:
            start = stream.read(USER_BLOCK + len(HDF5))
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    if start.startswith(b"PK\x03\x04"):
        return "npz"
    if start.startswith((b"MATLAB", HDF5)) or start[USER_BLOCK:] == HDF5:
        return "mat"
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        known = ", ".join(SUFFIXES)
        raise FileFormatError(f"{path}: unknown kind of file {suffix!r}; allowed are {known}")
    return SUFFIXES[suffix]
