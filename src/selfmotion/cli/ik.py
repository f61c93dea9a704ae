"""`selfmotion ik`: postures inside the joint limits that bring the hand to targets."""

import functools
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from selfmotion.cli.batches import BatchChoices, fingerprint, hash_if_file, run_items
from selfmotion.cli.frames import MODEL, FrameName, ground_from_file
from selfmotion.cli.models import (
    Limits,
    WeightsText,
    load_any_arm,
    typed_weights,
    with_typed_limits,
)
from selfmotion.cli.options import Jobs, Json, Out, Quiet, Resume, Scheduler
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers, save
from selfmotion.cli.poses import POSITION, transforms
from selfmotion.cli.tables import QUATERNION, Name, Rows, read_rows, with_unit_quaternions
from selfmotion.errors import RangeError, unknown_name
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.batch import Item, Outcome
    from selfmotion.methods.reaching.ik_seeds import SeedTable
    from selfmotion.methods.reaching.ik_tasks import HandRows

TASKS = ("position", "pose", "rows=x,y,z,rot_y")
TURNS = ("rot_x", "rot_y", "rot_z")
# Targets in one item of a batch.
PART = 2000


class TargetItem(Part, frozen=True, kw_only=True):
    """The posture for one target: q in joint order (rad), as near as it comes if not solved.

    Null where the row holds no target. An error is 0 where nothing of its kind is held.
    """

    id: Name
    q: list[Number] | None
    error_mm: Number
    error_deg: Number
    iterations: int | None
    restarts: int | None
    status: str
    failed: bool


class IkDocument(Document, frozen=True, tag="selfmotion/ik/1", kw_only=True):
    """Postures for targets; limits in radians."""

    arm: str
    joints: list[str]
    lower: list[Number]
    upper: list[Number]
    rows: list[str]
    targets: list[TargetItem]


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
    scheme: Literal["box", "published"]
    threads: int


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
    scheme: Annotated[
        Literal["box", "published"],
        typer.Option("--scheme", help="box: always inside the limits. published: eqs 10 to 16."),
    ] = "box",
    frame: FrameName = MODEL,
    json: Json = False,
    out: Out = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    quiet: Quiet = False,
) -> int:
    """Find postures inside the joint limits that bring the hand to targets."""
    model = with_typed_limits(load_any_arm(arm), limit)
    W = typed_weights(weights, model)
    choices = IkChoices(
        arm,
        held_rows(task),
        tuple(limit or ()),
        None if W is None else tuple(W.tolist()),
        scheme,
        threads_for(jobs) if scheduler is None else 1,
    )
    batch = BatchChoices("ik", out, 1, scheduler, resume, quiet)
    rows = read_targets(targets, choices.rows)
    goals = goals_in_ground(rows, choices.rows, ground_from_file(frame, model))
    hand = task_and_seeds(choices)[0]
    outcomes = run_items(solve_part, ik_items(rows, goals, choices), batch)
    document = IkDocument(
        provenance=provenance_of(hand, choices, targets, frame),
        arm=model.name,
        joints=list(model.joints),
        lower=numbers(model.lower),
        upper=numbers(model.upper),
        rows=list(hand.rows),
        targets=records(rows, outcomes),
    )
    written = [] if out is None else [save(document, out, "ik"), save_table(document, out)]
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=sum(t.failed for t in document.targets))


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


def threads_for(jobs: int) -> int:
    """Give the number of threads that --jobs means.

    Raises:
        RangeError: it is neither -1 nor above 0.
    """
    if jobs < 1 and jobs != -1:
        raise RangeError(f"--jobs {jobs}: allowed is 1 and above, or -1 for every core")
    return jobs if jobs > 0 else os.cpu_count() or 1


def read_targets(path: Path, held: tuple[str, ...]) -> Rows:
    """Read the columns that the task needs; orientation as quaternion or as roll, pitch, yaw.

    Raises:
        SelfmotionError: one line that names file, row, column and value.
    """
    position = [row for row in held if row in POSITION]
    turns = [row for row in held if row in TURNS]
    if not turns:
        return read_rows(path, position, bare=position)
    bare = ("id", *QUATERNION, *POSITION)
    rows = read_rows(path, position, [QUATERNION, turns], bare=bare)
    if rows.has(QUATERNION):
        return with_unit_quaternions(rows)
    if not rows.has(turns):
        read_rows(path, [*position, *QUATERNION])  # says which column is missing
    return rows


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


@functools.lru_cache(maxsize=2)
def task_and_seeds(choices: IkChoices) -> "tuple[HandRows, SeedTable]":
    """Build the task, and the table of postures to start from."""
    from selfmotion.methods.reaching.ik_seeds import seed_table
    from selfmotion.methods.reaching.ik_tasks import HandRows

    arm = with_typed_limits(load_any_arm(choices.arm), list(choices.limits))
    task = HandRows(arm, choices.rows)
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
    options = IkOptions(scheme=choices.scheme, threads=choices.threads)
    if choices.scheme == "published":
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


def records(rows: Rows, outcomes: "list[Outcome]") -> list[TargetItem]:
    """Give a record for every row, in the file's order."""
    found: dict[int, dict[str, Any]] = {}
    for outcome in outcomes:
        result = outcome.result or {"place": []}
        for k, i in enumerate(result["place"]):
            found[i] = {key: values[k] for key, values in result.items() if key != "place"}
    reason = next((o.status.sentence for o in outcomes if o.result is None), "not computed")
    unknown = dict.fromkeys(("q", "error_mm", "error_deg", "iterations", "restarts"))
    return [
        TargetItem(
            id=name, **found.get(i, {**unknown, "status": problem or reason, "failed": True})
        )
        for i, (name, problem) in enumerate(zip(rows.ids, rows.problems, strict=True))
    ]


def provenance_of(hand: "HandRows", choices: IkChoices, targets: Path, frame: str) -> Provenance:
    """Say where the results come from."""
    from selfmotion.provenance import hash_file

    settings = {
        "arm": hand.arm.name,
        "source": hand.arm.source,
        "rows": list(hand.rows),
        "scheme": choices.scheme,
        "limits": list(choices.limits),
        "weights": None if choices.weights is None else list(choices.weights),
        "frame": frame,
    }
    return Provenance("solve_ik", inputs={"targets": hash_file(targets)}, choices=settings)


def save_table(document: IkDocument, folder: Path) -> Path:
    """Write ik.csv: one row a target, joints in radians."""
    import pandas as pd

    empty = [None] * len(document.joints)
    table = pd.DataFrame(
        {
            "id": t.id,
            **dict(zip(document.joints, t.q or empty, strict=True)),
            "error_mm": t.error_mm,
            "error_deg": t.error_deg,
            "iterations": t.iterations,
            "status": t.status,
        }
        for t in document.targets
    )
    return write_whole(folder / "ik.csv", table.to_csv(index=False))


def as_text(document: IkDocument) -> str:
    """Write postures as a person reads them, in degrees."""
    from math import degrees

    solved = sum(not t.failed for t in document.targets)
    lines = [
        f"arm {document.arm}, held: {', '.join(document.rows)}; "
        f"{solved} of {len(document.targets)} targets solved",
        "degrees, in order: " + ", ".join(document.joints),
    ]
    for t in document.targets:
        angles = " ".join(f"{degrees(v):7.1f}" for v in t.q or [] if v is not None)
        lines.append(f"target {t.id}: {angles}  {t.status}".replace(":   ", ": "))
    return "\n".join(lines)
