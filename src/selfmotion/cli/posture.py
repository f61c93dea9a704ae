"""`selfmotion posture`: the natural posture for hand poses, by least muscle effort."""

import functools
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from selfmotion.cli.batches import BatchChoices, fingerprint, hash_if_file, run_items
from selfmotion.cli.body import NO_BODY, BodyName, body_choice, body_of
from selfmotion.cli.frames import MODEL, FrameName, ground_from_file
from selfmotion.cli.options import Jobs, Json, Out, Quiet, Report, Resume, Scheduler
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers, save
from selfmotion.cli.person_size import (
    Lengths,
    Mass,
    PersonChoices,
    Strength,
    load_person,
    segment_lengths_of,
)
from selfmotion.cli.poses import transforms
from selfmotion.cli.robot import held_joints
from selfmotion.cli.tables import Name, Rows, read_rows, with_unit_quaternions
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from selfmotion.batch import Item, Outcome
    from selfmotion.methods.effort.posture_result import NaturalPosture
    from selfmotion.methods.natural_posture import PostureFinder
    from selfmotion.redundancy.manifold import ManifoldFinder

COLUMNS = ("id", "qx", "qy", "qz", "qw", "x", "y", "z")
ModelName = Annotated[
    str,
    typer.Option("--model", metavar="myoarm|FILE.osim|FILE.xml", help="The arm with muscles."),
]
Convention = Annotated[
    Literal["plain", "opensim"] | None,
    typer.Option("--convention", help="How effort is computed; left out: as suits the model."),
]
HandLoad = Annotated[
    float, typer.Option("--hand-load", metavar="KG", help="Mass held in the hand.")
]


class Minimum(Part, frozen=True, kw_only=True):
    """A posture of locally least effort; angles in radians.

    `at` is the joint limit or body that it leans on, `valley` the swivel angles between which
    effort stays within a thousandth of it.
    """

    swivel: Number
    effort: Number
    q: dict[str, Number]
    at: str
    valley: list[Number]
    tied: bool
    beside_jump: bool


class EffortJump(Part, frozen=True, kw_only=True):
    """A swivel angle at which muscles jump over what they wrap, and effort on either side."""

    swivel: Number
    muscles: list[str]
    effort: list[Number]


class Robot(Part, frozen=True, kw_only=True):
    """The robot's posture for the same hand pose; q in its joint order."""

    q: list[Number] | None
    swivel: Number
    failed: bool
    status: str


class PoseItem(Part, frozen=True, kw_only=True):
    """What was found for one hand pose; angles in radians, null where there is none.

    `feasible_swivel` holds the intervals of swivel angle inside the joint limits.
    """

    id: Name
    status: str
    failed: bool
    swivel: Number
    effort: Number
    q: dict[str, Number]
    minima: list[Minimum]
    feasible_swivel: list[list[Number]]
    jumps: list[EffortJump]
    robot: Robot | None
    seconds: Number


class PostureDocument(Document, frozen=True, tag="selfmotion/posture/1", kw_only=True):
    """Natural postures of hand poses."""

    model: str
    convention: str
    coordinates: list[str]
    robot_joints: list[str] | None
    poses: list[PoseItem]


CONTRACT = Contract(PostureDocument, ("posture", "examples/poses.csv", "--json"))


@dataclass(frozen=True)
class PostureChoices:
    """What every pose of a run has in common; a worker builds its finder from it."""

    model: str
    convention: str | None
    search: str
    on_jump: str
    hand_load: float
    robot: str | None
    held: tuple[tuple[str, float], ...]
    body: str
    person: PersonChoices


def posture(
    poses: Annotated[
        Path,
        typer.Argument(
            metavar="POSES", help="Rows `id qx qy qz qw x y z` (m), or .csv with these names."
        ),
    ],
    model: ModelName = "myoarm",
    convention: Convention = None,
    frame: FrameName = MODEL,
    search: Annotated[
        Literal["certain", "paper"],
        typer.Option("--search", help="Along the whole manifold, or the published search."),
    ] = "certain",
    on_jump: Annotated[
        Literal["keep", "exclude"],
        typer.Option("--on-jump", help="Minima beside a jump of effort."),
    ] = "keep",
    hand_load: HandLoad = 0.0,
    robot: Annotated[
        Path | None,
        typer.Option(
            "--robot", metavar="FILE.urdf", help="Give a 7-joint robot the natural swivel angle."
        ),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option("--hold", metavar="JOINT=DEG", help="Let a joint of the robot rest."),
    ] = None,
    body: BodyName = NO_BODY,
    lengths: Lengths = None,
    mass: Mass = None,
    strength: Strength = "area",
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    quiet: Quiet = False,
) -> int:
    """Find the natural posture for hand poses, by least muscle effort."""
    batch = BatchChoices("posture", out, jobs, scheduler, resume, quiet)
    rows = with_unit_quaternions(read_rows(poses, COLUMNS[1:], bare=COLUMNS))
    person = PersonChoices(segment_lengths_of(lengths), mass, strength)
    machine = None if robot is None else str(robot)
    choices = PostureChoices(
        *(model, convention, search, on_jump, hand_load, machine, held_joints(hold, machine)),
        *(body, person),
    )
    finder = posture_finder(choices)
    robot_finder = None if robot is None else finder_of_robot(choices)
    T = transforms(rows, ground_from_file(frame, finder.model.arm))
    outcomes = run_items(find_one, pose_items(rows, T, choices), batch)
    document = PostureDocument(
        provenance=provenance_of(finder, choices, poses, frame),
        model=finder.model.arm.name,
        convention=finder.model.convention,
        coordinates=list(finder.model.arm.joints),
        robot_joints=None if robot_finder is None else list(robot_finder.arm.joints),
        poses=pose_records(rows, outcomes, finder.model.arm.joints),
    )
    written: list[Path] = []
    if out is not None:
        written = [save(document, out, "posture"), save_table(document, out)]
    if report is not None:
        from selfmotion.report.posture_page import write_posture_report

        drawn = [(str(pose.id), T[i]) for i, pose in enumerate(document.poses) if pose.minima]
        table = in_degrees(document)
        written.append(write_posture_report(report, finder, drawn, table, document.provenance))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=sum(p.failed for p in document.poses))


def pose_items(rows: Rows, T: "np.ndarray", choices: PostureChoices) -> "list[Item]":
    """Make batch items of the rows that hold a pose."""
    from selfmotion.batch import Item

    files = [hash_if_file(name) for name in (choices.model, choices.robot or "")]
    return [
        Item(str(name), (choices, pose.tolist()), fingerprint(choices, files, pose.tolist()))
        for name, pose, problem in zip(rows.ids, T, rows.problems, strict=True)
        if not problem
    ]


@functools.lru_cache(maxsize=2)
def posture_finder(choices: PostureChoices) -> "PostureFinder":
    """Load the model and make it ready."""
    from dataclasses import replace

    from selfmotion.methods.natural_posture import PostureFinder, SearchOptions
    from selfmotion.muscles.static_optimization import EffortOptions

    model = load_person(choices.model, choices.convention, choices.person)
    effort = replace(EffortOptions.of(model.convention), hand_load=choices.hand_load)
    search = SearchOptions(search=choices.search, on_jump=choices.on_jump)
    shapes = body_of(choices.body, model.arm)
    clearance = None if shapes is None else shapes.clearance(model.arm)
    return PostureFinder.of(model, effort=effort, search=search, clearance=clearance)


@functools.lru_cache(maxsize=2)
def finder_of_robot(choices: PostureChoices) -> "ManifoldFinder":
    """Load the robot and make it ready.

    Raises:
        SelfmotionError: it cannot be read, or has not seven joints that carry a shoulder, an
            elbow and a wrist.
    """
    from selfmotion.cli.robot import read_robot
    from selfmotion.redundancy.manifold import ManifoldFinder

    assert choices.robot is not None
    model = posture_finder(choices).model.arm
    return ManifoldFinder.of(read_robot(choices.robot, model, choices.held))


def find_one(payload: tuple[PostureChoices, list[list[float]]]) -> dict[str, Any]:
    """Find the posture for one hand pose: the keys of a `PoseItem` that depend on it."""
    import numpy as np

    choices, pose = payload
    finder, T = posture_finder(choices), np.array(pose)
    begin = time.perf_counter()
    found = finder.find(T)
    seconds = time.perf_counter() - begin
    robot = None
    if choices.robot is not None:
        from selfmotion.cli.robot import robot_posture

        swivel = found.swivel if found.minima else None
        placed = robot_posture(finder_of_robot(choices), T, swivel)
        robot = {
            "q": None if placed.q is None else numbers(placed.q),
            "swivel": placed.swivel,
            "failed": not placed.ok,
            "status": placed.sentence,
        }
    return {**pose_keys(found), "robot": robot, "seconds": seconds}


def pose_keys(found: "NaturalPosture") -> dict[str, Any]:
    """Turn a result into what JSON can hold."""
    names = found.coordinates
    return {
        "status": found.status.sentence,
        "failed": not found.status.ok,
        "swivel": numbers(found.swivel),
        "effort": numbers(found.effort),
        "q": dict(zip(names, numbers(found.q), strict=True)),
        "minima": [
            {
                "swivel": numbers(m.swivel),
                "effort": numbers(m.effort),
                "q": dict(zip(names, numbers(m.q), strict=True)),
                "at": m.at,
                "valley": numbers(m.valley),
                "tied": bool(m.tied),
                "beside_jump": bool(m.beside_jump),
            }
            for m in found.minima
        ],
        "feasible_swivel": [numbers(interval) for interval in found.feasible_swivel],
        "jumps": [
            {"swivel": j.swivel, "muscles": list(j.muscles), "effort": numbers(j.effort)}
            for j in found.jumps
        ],
    }


def pose_records(
    rows: Rows, outcomes: "list[Outcome]", coordinates: tuple[str, ...]
) -> list[PoseItem]:
    """Give a record for every row, in the file's order."""
    import msgspec

    by_key = {outcome.key: outcome for outcome in outcomes}
    nothing: dict[str, Any] = {
        "failed": True,
        "swivel": None,
        "effort": None,
        "q": dict.fromkeys(coordinates),
        "minima": [],
        "feasible_swivel": [],
        "jumps": [],
        "robot": None,
        "seconds": None,
    }
    records = []
    for name, problem in zip(rows.ids, rows.problems, strict=True):
        keys = {**nothing, "status": problem}
        if not problem:
            outcome = by_key[str(name)]
            keys = outcome.result or {**nothing, "status": outcome.status.sentence}
        records.append(msgspec.convert({"id": name, **keys}, PoseItem))
    return records


def provenance_of(
    finder: "PostureFinder", choices: PostureChoices, poses: Path, frame: str
) -> Provenance:
    """Say where the results come from."""
    from selfmotion.provenance import hash_file

    files = {"poses": str(poses), "model": choices.model, "robot": choices.robot or ""}
    inputs = {name: hash_file(path) for name, path in files.items() if Path(path).is_file()}
    settings = {
        "model": finder.model.arm.name,
        "source": finder.model.arm.source,
        "convention": finder.model.convention,
        "search": choices.search,
        "on_jump": choices.on_jump,
        "hand_load": choices.hand_load,
        "lower": finder.effort.lower,
        "loads": list(finder.effort.loads),
        "frame": frame,
        **body_choice(choices.body),
    }
    return Provenance("natural_posture", inputs=inputs, choices=settings)


def save_table(document: PostureDocument, folder: Path) -> Path:
    """Write posture.csv: one row a pose, angles in radians."""
    return write_whole(folder / "posture.csv", as_frame(document).to_csv(index=False))


def as_frame(document: PostureDocument) -> "pd.DataFrame":
    """Give a table, one row a pose, angles in radians."""
    import pandas as pd

    return pd.DataFrame(
        {"id": p.id, "status": p.status, "swivel": p.swivel, "effort": p.effort, **p.q}
        for p in document.poses
    )


def in_degrees(document: PostureDocument) -> "pd.DataFrame":
    """Give the same table with angles in degrees."""
    import numpy as np

    table = as_frame(document)
    angles = ["swivel", *document.coordinates]
    table[angles] = np.degrees(table[angles].astype(float))
    return table


def as_text(document: PostureDocument) -> str:
    """Write the postures as a person reads them, in degrees."""
    from math import degrees

    lines = [f"model {document.model}, convention {document.convention}"]
    for pose in document.poses:
        lines.append(f"pose {pose.id}: {pose.status}")
        if pose.swivel is None or pose.effort is None:
            continue
        angles = ", ".join(
            f"{name} {degrees(value):.1f}" for name, value in pose.q.items() if value is not None
        )
        lines.append(f"  swivel {degrees(pose.swivel):.1f} deg, effort {pose.effort:.4g}")
        lines.append(f"  {angles} (deg)")
        if pose.robot is not None:
            lines.append(f"  robot: {pose.robot.status}")
    return "\n".join(lines)
