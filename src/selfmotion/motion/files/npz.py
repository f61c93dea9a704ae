"""The library's own recordings file: NumPy's .npz, without pickled objects.

Fields are those of :mod:`selfmotion.motion.files.arrays_to_study`: at least ``qd (K,n)`` with
``jacobian (K,m,n)``, or ``q (K,n)``.
"""

import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from selfmotion.errors import FileFormatError, ShapeError
from selfmotion.motion.files.arrays_to_study import require_whole_gaps, study_from_arrays
from selfmotion.motion.labels import LABEL_NAMES
from selfmotion.motion.recording import FIELDS, Recording, Study
from selfmotion.writing import whole_file


def read_npz(path: str | Path) -> Study:
    """Read recordings: one for each run of equal labels, as views on the file's arrays.

    Raises:
        SelfmotionError: one line that names file, field, value and what is allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.npz")
        >>> qd, jac = np.ones((6, 3)), np.ones((6, 2, 3))
        >>> np.savez(where, qd=qd, jacobian=jac, trial=[1, 1, 1, 2, 2, 2])
        >>> [(r.labels.trial, r.n_samples, r.timed) for r in read_npz(where)]
        [('1', 3, False), ('2', 3, False)]
    """
    arrays = npz_arrays(path)
    require_whole_gaps(str(path), arrays)
    return study_from_arrays(str(path), arrays)


def write_npz(path: str | Path, recordings: Study | Sequence[Recording]) -> Path:
    """Write recordings to one .npz that :func:`read_npz` gives back; whole or not at all.

    Raises:
        ShapeError: the recordings differ in joints, rows, fields, frame or having a time.
        OSError: the file cannot be written.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.npz")
        >>> _ = write_npz(where, [Recording(np.arange(3) / 100, q=np.zeros((3, 2)))])
        >>> read_npz(where)[0].rate
        100.0
    """
    study = recordings if isinstance(recordings, Study) else Study(tuple(recordings))
    first = study[0]
    for other in study:
        for what in ("joints", "rows", "held", "frame", "timed"):
            if getattr(other, what) != getattr(first, what):
                raise ShapeError(
                    f"{other.name}: {what} {getattr(other, what)} differ from "
                    f"{getattr(first, what)} of {first.name}; one file holds one kind"
                )
    fields = {k: np.concatenate([r.array(k) for r in study]) for k in FIELDS if k in first.held}
    if first.timed:
        fields["time"] = np.concatenate([r.time for r in study])
    fields |= {"joints": np.array(first.joints), "rows": np.array(first.rows)}
    if first.frame.known:
        fields["frame_up"] = np.array(first.frame.up)
        fields["frame_forward"] = np.array(first.frame.forward)
    fields = {k: v for k, v in fields.items() if v.size} | _label_fields(study)
    with whole_file(path) as aside, open(aside, "wb") as stream:
        np.savez(stream, allow_pickle=False, **fields)
    return Path(path)


def _label_fields(study: Study) -> dict[str, np.ndarray]:
    """Repeat each label over the samples of its recording; number recordings labelled alike."""
    counts = [r.n_samples for r in study]
    fields = {
        label: np.repeat([getattr(r.labels, label) or "" for r in study], counts)
        for label in LABEL_NAMES
        if any(study.values(label))
    }
    if len({r.labels for r in study}) < len(study):
        fields["recording"] = np.repeat(np.arange(len(study)), counts)
    return fields


def npz_arrays(path: str | Path) -> dict[str, np.ndarray]:
    """Read every array of an .npz archive by name; whatever is wrong with it becomes one line.

    Raises:
        FileFormatError: no archive, a damaged one, or one with Python objects in it.
    """
    if not Path(path).is_file():
        raise FileFormatError(f"{path}: no such file")
    try:
        with open(path, "rb") as stream:
            if stream.read(2) not in (b"PK", b"\x93N"):  # neither an archive nor a bare array
                raise FileFormatError(f"{path}: not an .npz archive, whatever its name says")
        with open(path, "rb") as stream, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # old headers; what is wrong shows in the values
            archive = np.load(stream, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise FileFormatError(f"{path}: one bare array; an .npz archive is needed")
            with archive:
                return {name: _array(path, archive, name) for name in archive.files}
    except FileFormatError:
        raise
    except (zipfile.BadZipFile, EOFError):
        raise FileFormatError(f"{path}: no complete .npz archive (cut off or damaged)") from None
    except Exception as error:  # zip and header parsers raise anything on damaged bytes
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FileFormatError(f"{path}: cannot be read as .npz ({reason})") from None


def _array(path: str | Path, archive: "np.lib.npyio.NpzFile", name: str) -> np.ndarray:
    try:
        return archive[name]
    except ValueError as error:
        if "allow_pickle" in str(error):
            raise FileFormatError(
                f"{path}: {name} holds Python objects: numbers or text are allowed"
            ) from None
        raise
