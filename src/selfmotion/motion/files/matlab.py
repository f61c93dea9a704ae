"""MATLAB files, v5 to v7.3, as plain Python: structs to dicts, cells to lists, text to str.

Numeric arrays keep MATLAB's dimensions whatever the version: a v7.3 file is HDF5, in which they
are stored in reverse order. Struct arrays become lists of dicts, in MATLAB's column-major order.
Tables, strings and other objects are not documented by MATLAB; they become None.
"""

import warnings
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.matlab_v5 import read_v5

Tree: TypeAlias = dict[str, Any] | list[Any] | np.ndarray | str | None

# Deeper nesting than this is a damaged file whose references run in circles.
DEEPEST = 24
HDF5 = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512


def read_matlab(path: str | Path) -> dict[str, Tree]:
    """Read all variables of a .mat file.

    Raises:
        FileFormatError: no file, no MATLAB file, or cut off or damaged; one line.
    """
    path = Path(path)
    if not path.is_file():
        raise FileFormatError(f"{path}: no such file")
    try:
        with open(path, "rb") as stream:
            start = stream.read(USER_BLOCK + len(HDF5))
        is_hdf5 = start.startswith(HDF5) or start[USER_BLOCK:] == HDF5
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is wrong shows in the values
            variables = _read_v73(path) if is_hdf5 else read_v5(path.read_bytes())
    except FileFormatError as error:
        raise FileFormatError(f"{path}: {error}") from None
    except Exception as error:  # the parsers raise anything on damaged bytes
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise FileFormatError(
            f"{path}: no complete MATLAB file (cut off or damaged: {reason})"
        ) from None
    if not variables:
        raise FileFormatError(f"{path}: holds no variables")
    return variables


def _read_v73(path: Path) -> dict[str, Tree]:
    import h5py

    with h5py.File(path, "r") as file:
        items = {_text(name): item for name, item in file.items() if _text(name)[0] != "#"}
        if items and not any("MATLAB_class" in item.attrs for item in items.values()):
            raise FileFormatError("HDF5, but not written by MATLAB (no MATLAB_class)")
        return {name: _from_v73(file, item, 0) for name, item in items.items()}


def _from_v73(file: Any, item: Any, depth: int) -> Tree:
    import h5py

    _check_depth(depth)
    kind = _matlab_class(item)
    if isinstance(item, h5py.Group):
        return _struct_v73(file, item, depth) if kind in ("struct", "") else None
    if not isinstance(item, h5py.Dataset):
        return None
    if item.attrs.get("MATLAB_empty", 0):
        return {"cell": [], "struct": [], "char": ""}.get(kind, np.empty((0, 0)))
    if kind == "cell" or (kind == "" and item.dtype == h5py.ref_dtype):
        return [_from_v73(file, file[ref], depth + 1) for ref in item[()].ravel()]
    if kind == "char":
        # Stored as numbers of UTF-16 units, transposed as all arrays.
        return np.asarray(item[()]).T.ravel().astype("<u2").tobytes().decode("utf-16-le", "replace")
    if item.dtype.kind not in "biuf":
        return None
    return np.asarray(item[()]).T


def _struct_v73(file: Any, group: Any, depth: int) -> Tree:
    """Read a struct; in an array of structs each field is a dataset of references, unmarked."""
    import h5py

    fields = {_text(name): item for name, item in group.items()}
    arrays = [
        isinstance(item, h5py.Dataset) and item.dtype == h5py.ref_dtype and not _matlab_class(item)
        for item in fields.values()
    ]
    if not fields or not all(arrays):
        return {name: _from_v73(file, item, depth + 1) for name, item in fields.items()}
    columns = {name: item[()].ravel() for name, item in fields.items()}
    count = min(map(len, columns.values()))
    return _one_or_list(
        [{k: _from_v73(file, file[refs[i]], depth + 1) for k, refs in columns.items()}
         for i in range(count)]
    )  # fmt: skip


def _matlab_class(item: Any) -> str:
    kind = item.attrs.get("MATLAB_class", b"")
    return _text(kind)


def _text(name: Any) -> str:
    """Give a name as text; h5py leaves what it cannot decode in bytes."""
    return name.decode("latin-1") if isinstance(name, bytes) else str(name)


def _one_or_list(structs: list[Any]) -> Tree:
    return structs[0] if len(structs) == 1 else structs


def _check_depth(depth: int) -> None:
    if depth > DEEPEST:
        raise FileFormatError(f"nested more than {DEEPEST} deep: damaged")
