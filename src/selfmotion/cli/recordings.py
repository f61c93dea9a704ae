"""Read the recordings that a command was given, with an arm where they hold angles only."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from selfmotion.errors import FileFormatError, RangeError, ShapeError
from selfmotion.provenance import Provenance, hash_file

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
    from selfmotion.motion.recording import Study

Inputs: TypeAlias = Annotated[
    list[Path],
    typer.Argument(
        metavar="INPUT...",
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
    typer.Option("--task", help="position, planar, pose or pointing; left out: the arm's own."),
]
Cutoff: TypeAlias = Annotated[
    float | None,
    typer.Option("--cutoff", metavar="HZ", help="Low-pass for angles before differentiation."),
]


def find_files(inputs: list[Path]) -> list[Path]:
    """List the files meant: a folder stands for the recordings in it, sorted by name.

    Raises:
        FileFormatError: a folder holds no recording, or nothing stands at a path.
    """
    from selfmotion.motion.files import SUFFIXES

    files: list[Path] = []
    for path in inputs:
        if not path.is_dir():
            files.append(path)
            continue
        found = sorted(p for p in path.iterdir() if p.suffix.lower() in SUFFIXES and p.is_file())
        if not found:
            raise FileFormatError(f"{path}: no recording in this folder ({', '.join(SUFFIXES)})")
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
    inputs: list[Path], *, arm: str | None, task: str | None, cutoff: float | None
) -> "Study":
    """Read all inputs into one study, ready for the methods.

    Args:
        inputs: files or folders.
        arm: name or model file of the arm whose angles the recordings hold; left out: the
            recordings must hold velocities and Jacobians.
        task: kind of task; left out: the arm's own.
        cutoff: corner frequency (Hz) of the low-pass before differentiation; left out: none.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    from selfmotion.motion.recording import Study

    known = None
    if arm is not None:
        from selfmotion.arms import load_arm

        known = load_arm(arm)
    recordings = [r for path in find_files(inputs) for r in _read(path, known, task, cutoff)]
    return Study(tuple(recordings))


def _read(path: Path, arm: "Arm | None", task: str | None, cutoff: float | None) -> "Study":
    from selfmotion.motion.files import load

    study = load(path)
    if arm is None:
        for recording in study:
            if recording.jacobian is None:
                raise ShapeError(
                    f"{recording.name}: holds {', '.join(recording.held)} but no jacobian; "
                    "name the arm that moved, as in --arm exoskeleton"
                )
        return study
    from selfmotion.capture.attach import attach_arm_to_study
    from selfmotion.redundancy.task import task_for

    return attach_arm_to_study(study, arm, task=task_for(arm, task), cutoff=cutoff)
