"""Read the recordings that a command was given, with an arm where they hold angles only."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from selfmotion.cli.output import Part
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError, ShapeError
from selfmotion.provenance import Provenance, hash_file

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
    from selfmotion.motion.labels import Frame
    from selfmotion.motion.markers import MarkerSet
    from selfmotion.motion.recording import Study

Axis: TypeAlias = Literal["x", "y", "z", "-x", "-y", "-z"]
Inputs: TypeAlias = Annotated[
    list[Path],
    typer.Argument(
        metavar="INPUT",
        help="Files or folders: .npz and .mat (qd and jacobian), .csv, .mot, .sto (joint angles "
        "in rad, or deg in columns named NAME_deg).",
    ),
]
ArmName: TypeAlias = Annotated[
    str | None,
    typer.Option("--arm", metavar="NAME|FILE", help="The arm whose joint angles these are."),
]
TaskName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--task",
        metavar="KIND",
        help="position, planar, pose or pointing; left out: the arm's own.",
    ),
]
Cutoff: TypeAlias = Annotated[
    float | None,
    typer.Option("--cutoff", metavar="HZ", help="Low-pass for angles before differentiation."),
]
LengthUnit: TypeAlias = Annotated[
    Literal["m", "cm", "mm"] | None,
    typer.Option("--length-unit", help="Unit of length, where a file does not name it."),
]
AngleUnit: TypeAlias = Annotated[
    Literal["rad", "deg"] | None,
    typer.Option(
        "--angle-unit",
        help="Unit of angles, where a file does not name it; left out: rad in CSV, and a MOT or "
        "STO without inDegrees is refused.",
    ),
]
Rate: TypeAlias = Annotated[
    float | None,
    typer.Option("--rate", metavar="HZ", help="Samples a second, where a file has no times."),
]
Up: TypeAlias = Annotated[
    Axis | None,
    typer.Option("--up", help="Axis against gravity, where a file does not tell it."),
]
Forward: TypeAlias = Annotated[
    Axis | None,
    typer.Option("--forward", help="Axis that the person faces, where a file does not tell it."),
]
# Options of the contract in commands whose work they cannot change.
IdleJobs: TypeAlias = Annotated[
    int, typer.Option("--jobs", metavar="N", help="Accepted; this takes one process.")
]
IdleResume: TypeAlias = Annotated[
    bool, typer.Option("--resume", help="Accepted; this starts anew each time.")
]
IdleSeed: TypeAlias = Annotated[
    int, typer.Option("--seed", metavar="S", help="Accepted; nothing here is random.")
]


@dataclass(frozen=True)
class Stated:
    """What was typed about files that do not say it themselves; None: nothing.

    Attributes:
        length_unit: unit of positions.
        angle_unit: unit of angles.
        rate: sampling rate (Hz).
        up: axis against gravity.
        forward: axis that the person faces.
    """

    length_unit: Literal["m", "cm", "mm"] | None = None
    angle_unit: Literal["rad", "deg"] | None = None
    rate: float | None = None
    up: Axis | None = None
    forward: Axis | None = None

    def __post_init__(self) -> None:
        """Refuse axes that no frame can have, before any file is read."""
        self.frame()

    def frame(self, default: "Frame | None" = None) -> "Frame | None":
        """Give the frame that was typed, its missing axes those of a default; None: no word of it.

        Raises:
            RangeError: the axes are not perpendicular.
        """
        if self.up is None and self.forward is None:
            return default
        from selfmotion.motion.labels import Frame

        other = (None, None) if default is None else (default.up, default.forward)
        return Frame(self.up or other[0], self.forward or other[1], "stated")

    def choices(self) -> dict[str, object]:
        """Give what was typed, for a provenance."""
        return {k: v for k, v in vars(self).items() if v is not None}


NOTHING = Stated()


class UnreadFile(Part, frozen=True, kw_only=False):
    """A file of a folder that could not be read, and why."""

    file: str
    status: str


def load_recordings(path: Path, stated: Stated = NOTHING) -> "Study":
    """Read a file of joint motion with what was typed about it.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    from selfmotion.motion.files import load

    return load(
        path,
        unit=stated.angle_unit,
        length_unit=stated.length_unit,
        rate=stated.rate,
        frame=stated.frame(),
    )


def load_marker_file(
    path: Path, stated: Stated = NOTHING, *, default: "Frame | None" = None
) -> "MarkerSet":
    """Read a marker file with what was typed about it.

    Args:
        path: the file.
        stated: units, rate and axes.
        default: frame of the laboratory, where nothing was typed.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    from selfmotion.motion.files import load_markers

    frame = stated.frame(default)
    return load_markers(path, unit=stated.length_unit, rate=stated.rate, frame=frame)


def find_files(inputs: list[Path], *, markers: bool = False) -> list[Path]:
    """List the files meant: a folder stands for the recordings in it, sorted by name.

    Args:
        inputs: files and folders.
        markers: whether marker files are meant, not joint motion.

    Raises:
        FileFormatError: a folder holds no recording, or nothing stands at a path.
    """
    from selfmotion.motion.files import MARKER_SUFFIXES, SUFFIXES

    suffixes = (*MARKER_SUFFIXES, ".csv", ".tsv") if markers else (*SUFFIXES,)
    files: list[Path] = []
    for path in inputs:
        if not path.is_dir():
            files.append(path)
            continue
        found = sorted(p for p in path.iterdir() if p.suffix.lower() in suffixes and p.is_file())
        if not found:
            raise FileFormatError(f"{path}: no recording in this folder ({', '.join(suffixes)})")
        files += found
    known: set[Path] = set()
    for path in files:
        if path.resolve() in known:
            raise RangeError(f"{path}: given twice; its movements would count twice")
        known.add(path.resolve())
    return files


def provenance_of(made: Provenance, inputs: list[Path], **choices: object) -> Provenance:
    """Add files with their hashes, and what was chosen on the way from them, to a provenance."""
    hashes = {str(path): hash_file(path) for path in find_files(inputs)}
    known = {name: value for name, value in choices.items() if value is not None}
    return replace(made, inputs=hashes, choices={**made.choices, **known})


def read_study(
    inputs: list[Path],
    *,
    arm: str | None,
    task: str | None,
    cutoff: float | None,
    stated: Stated = NOTHING,
) -> "tuple[Study, list[UnreadFile]]":
    """Read all inputs into one study, ready for the methods.

    A file that was named must be readable. Of a folder's files one that is not is left out, with
    the reason, and the rest goes on.

    Args:
        inputs: files or folders.
        arm: name or model file of the arm whose angles the recordings hold; left out: the
            recordings must hold velocities and Jacobians.
        task: kind of task; left out: the arm's own.
        cutoff: corner frequency (Hz) of the low-pass before differentiation; left out: none.
        stated: units, rate and axes of files that do not say them.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    from selfmotion.motion.recording import Study

    known = None
    if arm is not None:
        from selfmotion.arms import load_arm

        known = load_arm(arm)
    named = {path for path in inputs if not path.is_dir()}
    found: list[Study] = []
    failed: list[UnreadFile] = []
    first: SelfmotionError | None = None
    for path in find_files(inputs):
        try:
            found.append(read_file(path, known, (task, cutoff), stated))
        except SelfmotionError as error:
            if path in named:
                raise
            first = first or error
            failed.append(UnreadFile(str(path), reason(error, path)))
    if first is not None and not found:
        raise first
    return Study(tuple(recording for study in found for recording in study)), failed


def reason(error: Exception, path: Path) -> str:
    """Give what is wrong with a file, without its name in front."""
    return " ".join(str(error).split()).removeprefix(f"{path}: ")


def read_file(
    path: Path, arm: "Arm | None", how: tuple[str | None, float | None], stated: Stated
) -> "Study":
    """Read one file, with an arm where it holds angles only.

    Args:
        path: the file.
        arm: whose angles the file holds; None: it must hold velocities and Jacobians.
        how: kind of task and cutoff (Hz), with an arm.
        stated: units, rate and axes.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    task, cutoff = how
    study = load_recordings(path, stated)
    if arm is None:
        for recording in study:
            if recording.jacobian is None:
                raise ShapeError(
                    f"{recording.name}: holds {', '.join(recording.held)} but no jacobian; "
                    "name the arm that moved, as in --arm exoskeleton"
                )
        return study
    from selfmotion.capture.attach import attach_arm_to_study, frame_of
    from selfmotion.motion.files.stated import merged_frame
    from selfmotion.redundancy.task import task_for

    frame = stated.frame()
    if frame is not None:  # the hand's path is that of the arm, in its ground frame
        merged_frame(f"arm {arm.name}", frame_of(arm), frame)
    return attach_arm_to_study(study, arm, task=task_for(arm, task), cutoff=cutoff)
