"""`selfmotion curvature`: how far paths veer from the straight line, and to which side.

Measures and tests are those of [Tommasino2017], doi 10.3389/fnbot.2017.00065.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from selfmotion.cli.options import Json, Out
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers, save
from selfmotion.cli.recordings import (
    ArmName,
    Cutoff,
    Inputs,
    TaskName,
    find_files,
    provenance_of,
    read_study,
)
from selfmotion.errors import RangeError, SelfmotionError, ShapeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.motion.recording import Recording, Study

Line = Literal["movement", "center-out"]
UpAxis = Literal["x", "y", "z", "-x", "-y", "-z"]


class CurvedMovement(Part, frozen=True, kw_only=True):
    """Areas between one path and its straight line, over the squared length of that line.

    `a_right` and `a_left` lie right and left of the line, seen along the movement; `a_sum` is
    their sum and `a_net` right minus left. `duration` is in s where `timed`, else in samples;
    `length` is in m (m at 1 m for a pointing wrist). `stands_apart`: its duration or length is
    more than two interquartile ranges from the median of the person; the tests leave it out. A
    recording that could not be used has a status that says why.
    """

    name: str
    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    trial: str | None
    duration: Number
    timed: bool
    length: Number
    a_right: Number
    a_left: Number
    a_sum: Number
    a_net: Number
    stands_apart: bool
    failed: bool
    status: str


class DirectionTest(Part, frozen=True, kw_only=True):
    """Student's t of the mean over the repetitions of one direction against zero.

    `p_corrected` is after Holm for the directions of the person; `note` says that A_sum cannot be
    negative. Null: fewer than two repetitions, or no spread.
    """

    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    measure: str
    n: int
    mean: Number
    sd: Number
    t: Number
    p: Number
    p_corrected: Number
    differs: bool
    note: str


class CurvatureDocument(Document, frozen=True, tag="selfmotion/curvature/1", kw_only=True):
    """Curvature of every movement, and tests by direction (target and condition)."""

    line: str
    movements: list[CurvedMovement]
    tests: list[DirectionTest]


CONTRACT = Contract(
    CurvatureDocument, ("curvature", "examples/reach.csv", "--arm", "exoskeleton", "--json")
)


def curvature(
    inputs: Inputs,
    arm: ArmName = None,
    task: TaskName = None,
    cutoff: Cutoff = None,
    line: Annotated[
        Line,
        typer.Option(
            "--line",
            help="movement: from onset to offset. center-out: between the targets of that "
            "experiment, by the labels target (E, NE, ...) and condition (outbound, inbound).",
        ),
    ] = "movement",
    up: Annotated[
        UpAxis | None,
        typer.Option("--up", help="Axis against gravity, of paths in space that do not say it."),
    ] = None,
    json: Json = False,
    out: Out = None,
) -> int:
    """Measure how far paths veer from straight lines, and to which side."""
    study = read_paths(inputs, arm=arm, task=task, cutoff=cutoff)
    found = marked([attempt(r, lambda r=r: measured(r, line, up)) for r in study])
    document = CurvatureDocument(
        provenance=provenance_of(
            Provenance("curvature"), inputs, arm=arm, task=task, cutoff=cutoff, line=line, up=up
        ),
        line=line,
        movements=found,
        tests=direction_tests([m for m in found if not (m.failed or m.stands_apart)]),
    )
    written = [] if out is None else [save(document, out, "curvature"), *save_tables(document, out)]
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=sum(m.failed for m in found))


def read_paths(
    inputs: list[Path], *, arm: str | None, task: str | None, cutoff: float | None
) -> "Study":
    """Read recordings that hold paths, or angles with an arm.

    Raises:
        SelfmotionError: one line that names the file and what is wrong with it.
    """
    if arm is not None:
        return read_study(inputs, arm=arm, task=task, cutoff=cutoff)[0]
    if task is not None:
        raise RangeError(f"--task {task}: has a meaning only with --arm")
    from selfmotion.motion.files import load
    from selfmotion.motion.filters import with_velocities
    from selfmotion.motion.recording import Study

    recordings = [r for path in find_files(inputs) for r in load(path)]
    for recording in recordings:
        if recording.x is None:
            raise ShapeError(
                f"{recording.name}: holds {', '.join(recording.held)} but no path x; "
                "name the arm that moved, as in --arm exoskeleton"
            )
    if cutoff is not None:
        recordings = [with_velocities(r, cutoff=cutoff) for r in recordings]
    return Study(tuple(recordings))


def attempt(recording: "Recording", measure: Callable[[], dict[str, float]]) -> CurvedMovement:
    """Measure one recording; one that fails says why, and the rest goes on."""
    known: dict[str, Any] = dict.fromkeys(
        ("duration", "length", "a_right", "a_left", "a_sum", "a_net")
    )
    status = "measured"
    try:
        known |= measure()
    except SelfmotionError as error:
        status = str(error)
    return CurvedMovement(
        name=recording.name,
        **recording.labels.to_dict(),
        timed=recording.timed,
        **known,
        stands_apart=False,
        failed=status != "measured",
        status=status,
    )


def measured(recording: "Recording", line: Line, up: UpAxis | None) -> dict[str, float]:
    """Give duration, length and areas of one movement, between onset and offset."""
    import numpy as np

    from selfmotion.methods.curvature import path_areas
    from selfmotion.motion.segment import movement_bounds, path_length

    whole = recording.drop_gaps()[0]
    time, x = whole.time, position(whole)
    if len(time) < 3:
        raise ShapeError(f"{recording.name}: {len(time)} samples; at least 3 are needed")
    bounds = movement_bounds(np.linalg.norm(np.gradient(x, time, axis=0), axis=1))
    part = slice(bounds.onset, bounds.offset + 1)
    path = x[part]
    ends = (path[0], path[-1]) if line == "movement" else center_out_ends(whole)
    seen_from = up_direction(whole, up) if x.shape[1] == 3 else None
    areas = path_areas(path, *ends, up=seen_from)
    return {
        "duration": float(time[bounds.offset] - time[bounds.onset]),
        "length": path_length(path),
        "a_right": areas.right,
        "a_left": areas.left,
        "a_sum": areas.total,
        "a_net": areas.net,
    }


def position(recording: "Recording") -> "np.ndarray":
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


def up_direction(recording: "Recording", up: UpAxis | None) -> "np.ndarray":
    """Give the direction (3,) from which right and left are seen.

    Raises:
        RangeError: neither the option nor the recording says it.
    """
    import numpy as np

    axis = up or recording.frame.up
    if axis is None:
        raise RangeError(
            f"{recording.name}: a path in space whose up axis is not known; name it, as in --up z"
        )
    direction = np.zeros(3)
    direction["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return direction


def center_out_ends(recording: "Recording") -> "tuple[np.ndarray, np.ndarray]":
    """Give the targets between which a movement of the center-out experiment runs.

    Raises:
        RangeError: a label is missing or unknown.
        ShapeError: the path is not that of a pointing wrist.
    """
    from selfmotion.studies.center_out import CENTRE, DIRECTIONS, NAMES, target_places

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


def marked(movements: list[CurvedMovement]) -> list[CurvedMovement]:
    """Mark the movements that stand apart from those of the same person and side."""
    from msgspec.structs import replace

    from selfmotion.motion.segment import stands_apart

    out = list(movements)
    for key in dict.fromkeys((m.subject, m.side) for m in movements):
        some = [i for i, m in enumerate(movements) if (m.subject, m.side) == key and not m.failed]
        apart = stands_apart([movements[i].duration or 0.0 for i in some])
        apart = apart | stands_apart([movements[i].length or 0.0 for i in some])
        for i, far in zip(some, apart.tolist(), strict=True):
            out[i] = replace(movements[i], stands_apart=far)
    return out


def direction_tests(movements: list[CurvedMovement]) -> list[DirectionTest]:
    """Test A_net and A_sum of each direction, corrected over the directions of a person."""
    from selfmotion.methods.curvature import VACUOUS

    out = []
    for person in dict.fromkeys((m.subject, m.side) for m in movements):
        own = [m for m in movements if (m.subject, m.side) == person]
        out += _tests_of_person(own, "a_net", "") + _tests_of_person(own, "a_sum", VACUOUS)
    return out


def _tests_of_person(own: list[CurvedMovement], measure: str, note: str) -> list[DirectionTest]:
    from selfmotion.methods.curvature import mean_tests

    groups: dict[tuple[str | None, str | None], list[float]] = {}
    for m in own:
        groups.setdefault((m.condition, m.target), []).append(getattr(m, measure))
    found = mean_tests(list(groups.values()), [str(way) for way in groups], note=note)
    columns = ("mean", "sd", "t", "p", "p_corrected")
    values = {name: numbers(getattr(found, name)) for name in columns}
    return [
        DirectionTest(
            subject=own[0].subject,
            side=own[0].side,
            condition=condition,
            target=target,
            measure=measure,
            n=int(found.n[i]),
            **{name: column[i] for name, column in values.items()},
            differs=bool(found.differs[i]),
            note=note,
        )
        for i, (condition, target) in enumerate(groups)
    ]


def save_tables(document: CurvatureDocument, folder: Path) -> list[Path]:
    """Write curvature.csv, one row a movement, and tests.csv, one row a direction and measure."""
    import pandas as pd
    from msgspec.structs import asdict

    parts = {"curvature.csv": document.movements, "tests.csv": document.tests}
    return [
        write_whole(folder / name, pd.DataFrame([asdict(row) for row in rows]).to_csv(index=False))
        for name, rows in parts.items()
    ]


def as_text(document: CurvatureDocument) -> str:
    """Write movements and tests as a person reads them."""
    width = max(len("movement"), *(len(m.name) for m in document.movements))
    lines = [f"{'movement':{width}}    A_sum    A_net"]
    for m in document.movements:
        if m.a_sum is None or m.a_net is None:
            lines.append(f"{m.name:{width}}  {m.status}")
            continue
        apart = "  stands apart" if m.stands_apart else ""
        lines.append(f"{m.name:{width}} {m.a_sum:8.4f} {m.a_net:8.4f}{apart}")
    for test in document.tests:
        if test.measure == "a_net":
            known = (test.subject, test.side, test.condition, test.target)
            who = ", ".join(v for v in known if v) or "all"
            p = "?" if test.p_corrected is None else f"{test.p_corrected:.2g}"
            verdict = "veers" if test.differs else "no veer shown"
            lines.append(f"{who}: mean A_net {test.mean:.4f} of {test.n}, p = {p}, {verdict}")
    return "\n".join(lines)
