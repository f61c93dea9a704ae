"""Writing Motion-BIDS: ``*_motion.tsv``, ``*_channels.tsv`` and their two JSON files."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.errors import RangeError, ShapeError
from selfmotion.motion.files.bids_names import MISSING, SUFFIX, spatial_axes
from selfmotion.motion.files.storage import RADIANS
from selfmotion.motion.markers import MarkerSet
from selfmotion.motion.recording import Recording
from selfmotion.writing import write_whole

COLUMNS = ("name", "component", "type", "tracked_point", "units", "reference_frame")


def write_bids(
    folder: str | Path,
    motion: Recording | MarkerSet,
    *,
    tracksys: str | None = None,
    task: str | None = None,
) -> Path:
    """Write joint angles (deg) or markers (m) as Motion-BIDS, each file whole or not at all.

    The folder is the one named ``motion`` of a subject; the four files are written into it. Labels
    become entities of the file name: subject, condition (task) and trial (run, if a number).
    Velocities and the hand's path have no place there.

    Args:
        folder: where the files go; it is made if it does not exist.
        motion: what to write; it needs times in seconds.
        tracksys: name of the tracking system; left out: ``angles`` or ``markers``.
        task: name of the task; left out: the condition.

    Returns:
        The path of the ``*_motion.tsv``.

    Raises:
        ShapeError: no joint angles, no seconds, or one sample only.
        RangeError: subject or task is not known.

    Example:
        >>> import tempfile
        >>> from selfmotion.motion import Frame, Labels
        >>> from selfmotion.motion.files.bids import read_bids
        >>> seen = MarkerSet(np.arange(3) / 100, ("STRN",), np.ones((3, 1, 3)), Frame("z", "y"),
        ...                  Labels(subject="01", condition="reach"))
        >>> read_bids(write_bids(Path(tempfile.mkdtemp()), seen)).markers.frame.up
        'z'
    """
    if motion.n_samples < 2 or motion.rate is None:
        raise ShapeError(f"{motion.name}: two samples with times in seconds are needed")
    markers = isinstance(motion, MarkerSet)
    system = tracksys or ("markers" if markers else "angles")
    stem = _stem(motion, task or motion.labels.condition, system)
    rows = _marker_rows(motion) if markers else _joint_rows(motion)
    values = motion.positions.reshape(motion.n_samples, -1) if markers else _degrees(motion)
    latency = motion.time - motion.time[0]
    about: dict[str, Any] = {
        "TaskName": task or motion.labels.condition,
        "TrackingSystemName": system,
        "SamplingFrequency": motion.rate,
        "TrackedPointsCount": motion.n_markers if markers else motion.n_joints,
        "MotionChannelCount": len(rows) + 1,
        "MissingValues": MISSING,
        "RecordingDuration": float(latency[-1]),
    }
    rows = [["latency", MISSING, "LATENCY", MISSING, "s", MISSING], *rows]
    table = "".join("\t".join(row) + "\n" for row in [COLUMNS, *rows])
    lines = []
    for instant, row in zip(latency.tolist(), values.tolist(), strict=True):
        cells = [MISSING if value != value else repr(value) for value in row]
        lines.append("\t".join([repr(instant), *cells]) + "\n")
    folder = Path(folder)
    levels = {"reference_frame": {"Levels": _levels(motion)}}
    write_whole(folder / f"{stem}_channels.json", json.dumps(levels, indent=2) + "\n")
    write_whole(folder / f"{stem}_channels.tsv", table)
    write_whole(folder / f"{stem}_motion.json", json.dumps(about, indent=2) + "\n")
    return write_whole(folder / f"{stem}{SUFFIX}", "".join(lines))


def _stem(motion: Recording | MarkerSet, task: str | None, system: str) -> str:
    """Build the file name; entities hold letters and digits only."""
    subject = motion.labels.subject
    for word, value in (("subject", subject), ("task", task), ("tracksys", system)):
        if not value or not re.sub(r"[^0-9A-Za-z]", "", value):
            raise RangeError(f"{motion.name}: {word} {value!r}: BIDS needs letters or digits")
    plain = [re.sub(r"[^0-9A-Za-z]", "", str(value)) for value in (subject, task, system)]
    stem = f"sub-{plain[0]}_task-{plain[1]}_tracksys-{plain[2]}"
    run = motion.labels.trial or ""
    return f"{stem}_run-{run}" if run.isdecimal() else stem


def _marker_rows(markers: MarkerSet) -> list[list[str]]:
    frame = "global" if markers.frame.known else MISSING
    return [
        [f"{name}_{axis}", axis, "POS", name, "m", frame]
        for name in markers.names
        for axis in "xyz"
    ]


def _joint_rows(recording: Recording) -> list[list[str]]:
    return [[name, MISSING, "JNTANG", name, "deg", MISSING] for name in recording.joints]


def _degrees(recording: Recording) -> np.ndarray:
    return recording.array("q") / RADIANS["deg"]


def _levels(motion: Recording | MarkerSet) -> dict[str, dict[str, str]]:
    if not isinstance(motion, MarkerSet) or not motion.frame.known:
        return {}
    axes = spatial_axes(motion.frame)
    return {"global": {"SpatialAxes": axes, "RotationRule": "right-hand"}}
