"""Recordings as Parquet: the columns of the angles CSV, in radians, with every digit.

Needs pyarrow, which comes with the extra ``parquet``. Names, units and the frame stand in the
file's own metadata too, so that the reader guesses nothing.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion.errors import FileFormatError, MissingExtraError, ShapeError
from selfmotion.motion.files.arrays_to_study import RUN_NAMES, study_from_arrays
from selfmotion.motion.recording import Recording, Study
from selfmotion.writing import whole_file

if TYPE_CHECKING:
    import pandas as pd

KEY = b"selfmotion"
FIELDS = ("q", "qd", "x", "xd")


def write_parquet(path: str | Path, recordings: Study | Sequence[Recording]) -> Path:
    """Write recordings as one table, a row a sample; whole or not at all.

    Columns are those of `Recording.to_frame`, after a number ``recording``. Jacobians have no
    place in a table.

    Raises:
        ShapeError: the recordings differ in joints, rows, fields, frame or having a time.
        MissingExtraError: pyarrow is not installed.
    """
    arrow = _pyarrow()
    study = recordings if isinstance(recordings, Study) else Study(tuple(recordings))
    first = study[0]
    for other in study:
        for what in ("joints", "rows", "held", "frame", "timed"):
            if getattr(other, what) != getattr(first, what):
                raise ShapeError(f"{other.name}: {what} differ from those of {first.name}")
    import pandas as pd

    tables = [r.to_frame().assign(recording=i) for i, r in enumerate(study)]
    table = arrow.Table.from_pandas(pd.concat(tables, ignore_index=True), preserve_index=False)
    about = {
        "units": {"angles": "rad", "lengths": "m", "time": "s" if first.timed else "samples"},
        "joints": first.joints,
        "rows": first.rows,
        "frame": [first.frame.up, first.frame.forward],
        "held": [name for name in FIELDS if name in first.held],
    }
    metadata = {**(table.schema.metadata or {}), KEY: json.dumps(about).encode()}
    from pyarrow import parquet

    with whole_file(path) as aside:
        parquet.write_table(table.replace_schema_metadata(metadata), aside)
    return Path(path)


def write_parquet_table(path: str | Path, table: "pd.DataFrame") -> Path:
    """Write any table as Parquet; whole or not at all.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    arrow = _pyarrow()
    from pyarrow import parquet

    with whole_file(path) as aside:
        parquet.write_table(arrow.Table.from_pandas(table, preserve_index=False), aside)
    return Path(path)


def read_parquet(path: str | Path) -> Study:
    """Read recordings that :func:`write_parquet` wrote.

    Raises:
        FileFormatError: not such a file, or a damaged one.
        MissingExtraError: pyarrow is not installed.
    """
    _pyarrow()
    from pyarrow import parquet

    try:
        with open(path, "rb") as stream:
            table = parquet.ParquetFile(stream).read()
        about = json.loads((table.schema.metadata or {})[KEY])
        frame = table.to_pandas()
        fields = _fields(frame, about)
    except KeyError as error:
        raise FileFormatError(
            f"{path}: no Parquet file of this library ({error} is missing)"
        ) from None
    except Exception as error:  # Arrow raises many kinds on damaged bytes
        reason = " ".join(str(error).split())[:120]
        raise FileFormatError(f"{path}: cannot be read as Parquet ({reason})") from None
    return study_from_arrays(str(path), fields)


def _fields(frame: Any, about: Any) -> dict[str, np.ndarray]:
    """Give the table as fields of `study_from_arrays`."""
    hand = [f"hand_{row}" for row in about["rows"]]
    names = {"q": about["joints"], "qd": [f"{j}_velocity" for j in about["joints"]]}
    names |= {"x": hand, "xd": [f"{h}_velocity" for h in hand]}
    fields = {k: frame[list(names[k])].to_numpy(np.float64) for k in about["held"] if k in FIELDS}
    fields |= {k: frame[k].fillna("").to_numpy().astype(str) for k in RUN_NAMES[:-1] if k in frame}
    fields["recording"] = frame["recording"].to_numpy(np.int64)
    if about["units"]["time"] == "s":
        fields["time"] = frame["time"].to_numpy(np.float64)
    fields |= {k: np.array(about[k]) for k in ("joints", "rows") if about[k]}
    up, forward = about["frame"]
    if up and forward:
        fields |= {"frame_up": np.array(up), "frame_forward": np.array(forward)}
    return fields


def _pyarrow() -> Any:
    try:
        import pyarrow
    except ImportError:
        raise MissingExtraError(
            "Parquet needs pyarrow: install it, or selfmotion[parquet]"
        ) from None
    return pyarrow
