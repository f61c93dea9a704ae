"""How much the paths in a file curve: one item of a batch, from the file to plain numbers.

Measures are those of [Tommasino2017], doi 10.3389/fnbot.2017.00065, between onset and offset.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from selfmotion.arms import load_arm
from selfmotion.capture.attach import attach_arm_to_study, frame_of
from selfmotion.errors import RangeError, SelfmotionError, ShapeError
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.curvature import path_areas
from selfmotion.motion.files import load
from selfmotion.motion.files.stated import merged_frame
from selfmotion.motion.filters import with_velocities
from selfmotion.motion.labels import Frame, Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.motion.segment import equally_spaced, movement_bounds, path_length
from selfmotion.redundancy.task import task_for
from selfmotion.studies.center_out import CENTRE, DIRECTIONS, NAMES, target_places

Line = Literal["movement", "center-out"]
MEASURED = "measured"
# Samples of a path that go with its numbers, for pictures.
DRAWN_SAMPLES = 50
MEASURES = ("duration", "length", "a_right", "a_left", "a_sum", "a_net")


@dataclass(frozen=True)
class ReadAs:
    """What the caller knows of a file, and with which arm it is read.

    Attributes:
        arm: name or model file, where the file holds angles; None: it holds paths.
        task: kind of task; None: the arm's own.
        cutoff: low-pass before differentiation (Hz); None: none.
        angle_unit: of angles that name none.
        length_unit: of lengths that name none.
        rate: sampling rate (Hz), where there is no time.
        frame: axes, where the file does not tell them.
    """

    arm: str | None = None
    task: str | None = None
    cutoff: float | None = None
    angle_unit: Literal["rad", "deg"] | None = None
    length_unit: Literal["m", "cm", "mm"] | None = None
    rate: float | None = None
    frame: Frame | None = None


@dataclass(frozen=True)
class CurveJob:
    """One file to measure.

    Attributes:
        path: the file.
        read: how.
        line: between the ends of the movement, or between the targets of the center-out experiment.
        labels: of the file's one recording, read from its name; None: as the file has them.
    """

    path: Path
    read: ReadAs = field(default_factory=ReadAs)
    line: Line = "movement"
    labels: Labels | None = None


def measure_file(job: CurveJob) -> dict[str, Any]:
    """Measure every movement in a file.

    Returns:
        ``movements``: for each its name, labels, measures (None where it could not be measured),
        status, and ``path``, (50, 2 or 3) m; ``warnings``: what was said on the way.

    Raises:
        SelfmotionError: the file cannot be read.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "reach.npz")
        >>> u = np.linspace(0.0, np.pi, 101)
        >>> np.savez(where, x=np.stack([0.1 * np.sin(u), 0.5 - 0.5 * np.cos(u)], axis=1), time=u)
        >>> found = measure_file(CurveJob(where))["movements"][0]
        >>> found["status"], found["a_net"] > 0.0
        ('measured', True)
    """
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", UserWarning)
        study = read_paths(job)
        movements = [_attempt(r, lambda r=r: measure_path(r, job.line)) for r in study]
    return {"movements": movements, "warnings": [str(w.message) for w in said]}


def read_paths(job: CurveJob) -> Study:
    """Read recordings that hold paths, or angles with an arm.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    read = job.read
    study = load(
        job.path,
        unit=read.angle_unit,
        length_unit=read.length_unit,
        rate=read.rate,
        frame=read.frame if read.arm is None else None,
    )
    if job.labels is not None:
        study = _labelled(study, job)
    if read.arm is not None:
        arm = _arm(read.arm)
        if read.frame is not None:  # the hand's path is that of the arm, in its ground frame
            merged_frame(f"arm {arm.name}", frame_of(arm), read.frame)
        return attach_arm_to_study(study, arm, task=task_for(arm, read.task), cutoff=read.cutoff)
    if read.task is not None:
        raise RangeError(f"task {read.task}: has a meaning only with an arm (--arm)")
    for recording in study:
        if recording.x is None:
            raise ShapeError(
                f"{recording.name}: holds {', '.join(recording.held)} but no path x; "
                "name the arm that moved, as in --arm exoskeleton"
            )
    if read.cutoff is None:
        return study
    return Study(tuple(with_velocities(r, cutoff=read.cutoff) for r in study))


def measure_path(recording: Recording, line: Line) -> dict[str, Any]:
    """Give duration, length and areas of one movement, between onset and offset, and its path.

    Raises:
        SelfmotionError: the movement cannot be measured.
    """
    whole = recording.drop_gaps()[0]
    time, x = whole.time, position(whole)
    if len(time) < 3:
        raise ShapeError(f"{recording.name}: {len(time)} samples; at least 3 are needed")
    bounds = movement_bounds(np.linalg.norm(np.gradient(x, time, axis=0), axis=1))
    part = slice(bounds.onset, bounds.offset + 1)
    path = x[part]
    ends = (path[0], path[-1]) if line == "movement" else center_out_ends(whole)
    areas = path_areas(path, *ends, up=up_direction(whole) if x.shape[1] == 3 else None)
    values = (areas.right, areas.left, areas.total, areas.net)
    duration = float(time[bounds.offset] - time[bounds.onset])
    return dict(zip(MEASURES, (duration, path_length(path), *values), strict=True)) | {
        "path": equally_spaced(time[part], path, n_samples=DRAWN_SAMPLES).tolist()
    }


def position(recording: Recording) -> Float[np.ndarray, "samples axes"]:
    """Give the path (K, 2) or (K, 3): the place rows of what the task moves.

    Raises:
        ShapeError: the rows are not those of a place.
    """
    x = recording.array("x")
    if x.shape[1] == 6 and recording.rows[:3] == ("x", "y", "z"):
        return x[:, :3]
    if x.shape[1] not in (2, 3):
        raise ShapeError(
            f"{recording.name}: x has {x.shape[1]} rows ({', '.join(recording.rows)}); allowed "
            "are 2 or 3 of a place, or 6 of a pose"
        )
    return x


def up_direction(recording: Recording) -> Float[np.ndarray, "3"]:
    """Give the direction from which right and left are seen.

    Raises:
        RangeError: the recording does not say it.
    """
    axis = recording.frame.up
    if axis is None:
        raise RangeError(
            f"{recording.name}: a path in space whose up axis is not known; name it, as in --up z"
        )
    direction = np.zeros(3)
    direction["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return direction


def center_out_ends(
    recording: Recording,
) -> tuple[Float[np.ndarray, "2"], Float[np.ndarray, "2"]]:
    """Give the targets between which a movement of the center-out experiment runs.

    Raises:
        RangeError: a label is missing or unknown.
        ShapeError: the path is not that of a pointing wrist.
    """
    name, direction = recording.labels.target, recording.labels.condition
    if name not in NAMES or direction not in DIRECTIONS:
        raise RangeError(
            f"{recording.name}: target {name!r}, condition {direction!r}; with --line center-out "
            f"allowed are {', '.join(NAMES)} and {' or '.join(DIRECTIONS)}"
        )
    if recording.array("x").shape[1] != 2:
        raise ShapeError(f"{recording.name}: --line center-out needs a path in the plane (x, y)")
    place = target_places()[NAMES.index(name)]
    return (CENTRE, place) if direction == "outbound" else (place, CENTRE)


def _attempt(recording: Recording, measure: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Measure one recording; one that fails says why, and the rest goes on."""
    found: dict[str, Any] = {"name": recording.name, **recording.labels.to_dict()}
    found |= {"timed": recording.timed, "status": MEASURED, "path": []}
    found |= dict.fromkeys(MEASURES)
    try:
        return found | measure()
    except SelfmotionError as error:
        return found | {"status": " ".join(str(error).split())}


def _labelled(study: Study, job: CurveJob) -> Study:
    from dataclasses import replace

    if len(study) > 1:
        raise ShapeError(
            f"{job.path}: holds {len(study)} recordings; labels from its name are those of one"
        )
    return Study((replace(study[0], labels=job.labels),))


@lru_cache(maxsize=2)
def _arm(name: str) -> Arm:
    return load_arm(name)
