"""`selfmotion ik`: postures inside the joint limits that bring the hand to targets."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec
import typer

from selfmotion.cli.batches import BatchChoices, fingerprint, hash_if_file, run_items
from selfmotion.cli.frames import MODEL, FrameName, ground_from_file
from selfmotion.cli.ik_document import (
    IkDocument,
    as_text,
    n_failed,
    records,
    save_table,
    write_report_of,
)
from selfmotion.cli.ik_path import (
    CostTexts,
    Follow,
    PathChoices,
    RestTexts,
    follow_part,
    path_choices,
    path_item,
    path_part,
    path_times,
)
from selfmotion.cli.models import (
    Limits,
    WeightsText,
    load_any_arm,
    typed_weights,
    with_typed_limits,
)
from selfmotion.cli.options import Jobs, Json, Out, Quiet, Report, Resume, Scheduler, threads_for
from selfmotion.cli.output import Contract, finish, numbers, save
from selfmotion.cli.poses import POSITION, transforms
from selfmotion.cli.tables import QUATERNION, Rows, read_rows, with_unit_quaternions
from selfmotion.errors import RangeError, unknown_name
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.batch import Item
    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.reaching.ik_seeds import SeedTable
    from selfmotion.methods.reaching.ik_tasks import HandRows

TASKS = ("position", "pose", "rows=x,y,z,rot_y")
TURNS = ("rot_x", "rot_y", "rot_z")
# Targets in one item of a batch.
PART = 2000
# Restarts unless told otherwise; there are no more postures to start from than those.
RESTARTS, MOST_RESTARTS = 20, 40


CONTRACT = Contract(
    IkDocument, ("ik", "examples/targets.csv", "--limit", "elbow_flexion=64.2:114", "--json")
)


@dataclass(frozen=True)
class IkChoices:
    """What all targets of a run have in common."""

    arm: str
    rows: tuple[str, ...]
    limits: tuple[str, ...]
    weights: tuple[float, ...] | None
    method: Literal["default", "paper"]
    restarts: int | None
    threads: int
    path: PathChoices | None


def ik(
    targets: Annotated[
        Path,
        typer.Argument(metavar="TARGETS", help=".csv with x,y,z (m), for a pose also qx,qy,qz,qw."),
    ],
    arm: Annotated[str, typer.Option("--arm", metavar="NAME|FILE", help="The arm.")] = "upper_limb",
    task: Annotated[
        str,
        typer.Option(
            "--task", metavar="position|pose|rows=...", help="What is held, as rows=x,y,z,rot_y."
        ),
    ] = "position",
    limit: Limits = None,
    weights: WeightsText = None,
    method: Annotated[
        Literal["default", "paper"],
        typer.Option("--method", help="default: always inside the limits. paper: eqs 10 to 16."),
    ] = "default",
    restarts: Annotated[
        int | None,
        typer.Option("--restarts", metavar="N", help="Starts after the first; 20 unless given."),
    ] = None,
    follow: Follow = False,
    cost: CostTexts = None,
    rest: RestTexts = None,
    frame: FrameName = MODEL,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    quiet: Quiet = False,
) -> int:
    """Find postures inside the joint limits that bring the hand to targets."""
    model = with_typed_limits(load_any_arm(arm), limit)
    W = typed_weights(weights, model)
    refuse_at_odds(follow=follow, method=method, restarts=restarts, only_path=bool(cost or rest))
    W = None if W is None else tuple(W.tolist())
    choices = IkChoices(
        arm,
        held_rows(task),
        tuple(limit or ()),
        W,
        method,
        restarts,
        threads_for(jobs) if scheduler is None else 1,
        path_choices(cost or (), rest or (), W, model) if follow else None,
    )
    batch = BatchChoices("ik", out, 1, scheduler, resume, quiet)
    rows = read_targets(targets, choices.rows)
    goals = goals_in_ground(rows, choices.rows, ground_from_file(frame, model))
    document = solve_file(rows, goals, choices, batch)
    document = msgspec.structs.replace(
        document, provenance=provenance_of(model, choices, targets, frame)
    )
    written = [] if out is None else [save(document, out, "ik"), save_table(document, out)]
    if report is not None:
        written.append(write_report_of(report, document))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=n_failed(document))


def refuse_at_odds(*, follow: bool, method: str, restarts: int | None, only_path: bool) -> None:
    """Refuse options that exclude each other.

    Raises:
        RangeError: two do, or a number is out of range.
    """
    if restarts is not None and not 0 <= restarts <= MOST_RESTARTS:
        raise RangeError(f"--restarts {restarts}: allowed is 0 to {MOST_RESTARTS}")
    if restarts and method == "paper":
        raise RangeError("--restarts: --method paper starts once")
    if only_path and not follow:
        raise RangeError("--cost and --rest are for a path: add --follow")
    if follow and (method == "paper" or restarts is not None):
        raise RangeError("--follow takes each posture from the one before: no --method, --restarts")


def solve_file(
    rows: Rows, goals: "np.ndarray", choices: IkChoices, batch: BatchChoices
) -> IkDocument:
    """Solve all targets of a file, or follow them as a path."""
    hand = task_and_seeds(choices)[0] if choices.path is None else task_of(choices)
    if choices.path is None:
        outcomes = run_items(solve_part, ik_items(rows, goals, choices), batch)
    else:
        item = path_item(hand, goals, path_times(rows), choices)
        outcomes = run_items(follow_part, [item], batch)
    followed = outcomes[0].result if choices.path is not None and outcomes else None
    return IkDocument(
        provenance=Provenance("solve_ik"),
        arm=hand.arm.name,
        joints=list(hand.arm.joints),
        lower=numbers(hand.arm.lower),
        upper=numbers(hand.arm.upper),
        rows=list(hand.rows),
        path=path_part(choices.path, followed["path"]) if choices.path and followed else None,
        targets=records(rows, outcomes),
    )


def held_rows(task: str) -> tuple[str, ...]:
    """Give the rows that --task means.

    Raises:
        SelfmotionError: the text is none of those allowed.
    """
    from selfmotion.methods.reaching.ik_tasks import ROWS

    if task in ("position", "pose"):
        return ROWS[:3] if task == "position" else ROWS
    kind, equals, names = task.partition("=")
    if kind != "rows" or not equals:
        raise unknown_name("--task", task, TASKS)
    rows = tuple(name.strip() for name in names.split(","))
    for row in rows:
        if row not in ROWS:
            raise unknown_name(f"row in --task {task!r}:", row, ROWS)
    if len(set(rows)) < len(rows):
        raise RangeError(f"--task {task!r}: a row stands twice")
    return tuple(row for row in ROWS if row in rows)


def read_targets(path: Path, held: tuple[str, ...]) -> Rows:
    """Read the columns that the task needs; orientation as quaternion or as roll, pitch, yaw.

    Raises:
        SelfmotionError: one line that names file, row, column and value.
    """
    position = [row for row in held if row in POSITION]
    turns = [row for row in held if row in TURNS]
    if not turns:
        return without_far(read_rows(path, position, bare=position), position)
    bare = ("id", *QUATERNION, *POSITION)
    rows = without_far(read_rows(path, position, [QUATERNION, turns], bare=bare), position)
    if rows.has(QUATERNION):
        return with_unit_quaternions(rows)
    if not rows.has(turns):
        read_rows(path, [*position, *QUATERNION])  # says which column is missing
    return rows


def without_far(rows: Rows, position: list[str]) -> Rows:
    """Mark rows whose position is so far that it can only be a slip.

    Raises:
        FileFormatError: no row is left.
    """
    from selfmotion.methods.reaching.ik_tasks import FARTHEST

    problems = [""] * len(rows)
    for name in position:
        for i, value in enumerate(rows.columns[name].tolist()):
            if abs(value) > FARTHEST:
                where = f"{rows.table.path}: row {rows.table.rows[i]}, column {name}"
                problems[i] = problems[i] or f"{where}: {value:g} m is beyond {FARTHEST:g}"
    return rows.with_problems(problems)


def goals_in_ground(rows: Rows, held: tuple[str, ...], T_ground_file: "np.ndarray") -> "np.ndarray":
    """Give targets as values of the rows (K, m), or, from quaternions, as frames (K, 4, 4).

    Raises:
        RangeError: the file has other axes than the model, and not all of x, y, z and the
            orientation are known that it takes to turn them.
    """
    import numpy as np

    moved = not np.array_equal(T_ground_file, np.eye(4))
    if any(row in TURNS for row in held) and rows.has(QUATERNION):
        position = {name: rows.columns.get(name, np.zeros(len(rows))) for name in POSITION}
        if moved and not rows.has(POSITION):
            raise RangeError("--frame: x, y and z are needed to turn a target into other axes")
        whole = Rows(rows.table, rows.ids, {**rows.columns, **position}, rows.problems)
        return transforms(whole, T_ground_file)
    values = rows.array(held)
    if moved:
        if tuple(held) != POSITION:
            raise RangeError(
                "--frame: only positions x, y, z, or these with a quaternion, can be turned into "
                "other axes"
            )
        values = values @ T_ground_file[:3, :3].T + T_ground_file[:3, 3]
    return values


def task_of(choices: IkChoices) -> "HandRows":
    """Build the task."""
    from selfmotion.methods.reaching.ik_tasks import HandRows

    arm = with_typed_limits(load_any_arm(choices.arm), list(choices.limits))
    return HandRows(arm, choices.rows)


@functools.lru_cache(maxsize=2)
def task_and_seeds(choices: IkChoices) -> "tuple[HandRows, SeedTable]":
    """Build the task, and the table of postures to start from."""
    from selfmotion.methods.reaching.ik_seeds import seed_table

    task = task_of(choices)
    return task, seed_table(task)


def ik_items(rows: Rows, goals: "np.ndarray", choices: IkChoices) -> "list[Item]":
    """Make batch items of the rows that hold a target, many each."""
    import numpy as np

    from selfmotion.batch import Item
    from selfmotion.provenance import hash_arrays

    good = np.flatnonzero(rows.good)
    items = []
    for first in range(0, len(good), PART):
        part = good[first : first + PART]
        mark = fingerprint(choices, hash_if_file(choices.arm), hash_arrays(part, goals[part]))
        payload = (choices, part.tolist(), goals[part])
        items.append(Item(f"rows {part[0]} to {part[-1]}", payload, mark))
    return items


def solve_part(payload: "tuple[IkChoices, list[int], np.ndarray]") -> dict[str, Any]:
    """Solve some targets; gives their place in the file and the keys of a `TargetItem`."""
    import numpy as np

    from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik

    choices, part, goals = payload
    task, seeds = task_and_seeds(choices)
    again = RESTARTS if choices.restarts is None else choices.restarts
    options = IkOptions(restarts=again, threads=choices.threads)
    if choices.method == "paper":
        options = IkOptions(scheme="published", max_iterations=1000, restarts=0)
    found = solve_ik(task, goals, weights=choices.weights, options=options, seeds=seeds)
    return {
        "place": part,
        "q": numbers(found.q),
        "error_mm": numbers(1e3 * found.position_error),
        "error_deg": numbers(np.degrees(found.rotation_error)),
        "iterations": found.iterations.tolist(),
        "restarts": found.restarts.tolist(),
        "status": found.sentences(),
        "failed": (~found.solved).tolist(),
    }


def provenance_of(arm: "Arm", choices: IkChoices, targets: Path, frame: str) -> Provenance:
    """Say where the results come from."""
    from selfmotion.provenance import hash_file

    settings = {
        "arm": arm.name,
        "source": arm.source,
        "rows": list(choices.rows),
        "method": choices.method if choices.path is None else "follow",
        "restarts": choices.restarts,
        "limits": list(choices.limits),
        "weights": None if choices.weights is None else list(choices.weights),
        "frame": frame,
    }
    step = "solve_ik" if choices.path is None else "follow"
    return Provenance(step, inputs={"targets": hash_file(targets)}, choices=settings)
