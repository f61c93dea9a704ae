"""The options --follow, --cost and --rest of `selfmotion ik`: a timed path of targets."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from selfmotion.cli.output import Number, Part, numbers
from selfmotion.errors import FileFormatError, RangeError, unknown_name

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.batch import Item
    from selfmotion.cli.tables import Rows
    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.reaching.ik_tasks import HandRows

KINDS = ("displacement", "velocity", "acceleration")
TIME = "time"
Follow: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--follow", help="Targets are a path, with a column time (s): each from the one before."
    ),
]
CostTexts: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--cost",
        metavar="KIND[:JOINT]=W",
        help="Along a path: weight of displacement, velocity or acceleration; repeatable.",
    ),
]
RestTexts: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--rest",
        metavar="JOINT=DEG",
        help="Along a path: where displacement counts from (default: the first posture).",
    ),
]


class PathPart(Part, frozen=True, kw_only=True):
    """How a path was followed; weights of the squared displacement, velocity, acceleration.

    `rest` in radians, null where it is the first posture; `largest_step` is the largest change of
    a joint between samples.
    """

    ok: bool
    status: str
    largest_step: Number
    displacement: list[Number]
    velocity: list[Number]
    acceleration: list[Number]
    rest: list[Number]


@dataclass(frozen=True)
class PathChoices:
    """What the joints pay, one number a joint; rest is NaN where the first posture counts."""

    displacement: tuple[float, ...]
    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    rest: tuple[float, ...]


def path_choices(
    costs: Sequence[str], rest: Sequence[str], weights: Sequence[float] | None, arm: "Arm"
) -> PathChoices:
    """Read --cost and --rest, in order; velocity costs `weights`, or 1, unless told otherwise.

    Raises:
        SelfmotionError: a text is not of that form, or there is no such joint.
    """
    n = arm.n_joints
    table = {kind: [0.0] * n for kind in KINDS}
    table["velocity"] = [1.0] * n if weights is None else list(weights)
    for text in costs:
        name, _, value = text.partition("=")
        kind, colon, joint = name.partition(":")
        if kind.strip() not in KINDS:
            raise unknown_name(f"kind in --cost {text!r}:", kind.strip(), KINDS)
        weight = _number(value)
        if not (math.isfinite(weight) and weight >= 0.0):
            raise RangeError(
                f"--cost {text!r}: write kind=weight or kind:joint=weight, a weight of 0 or above"
            )
        places = [_joint("--cost", text, joint, arm)] if colon else range(n)
        for j in places:
            table[kind.strip()][j] = weight
    angles = [math.nan] * n
    for text in rest:
        joint, _, value = text.partition("=")
        angle = _number(value)
        if not abs(angle) <= 360.0:
            raise RangeError(f"--rest {text!r}: write joint=angle, from -360 to 360 degrees")
        angles[_joint("--rest", text, joint, arm)] = math.radians(angle)
    for j, name in enumerate(arm.joints):
        if not any(table[kind][j] > 0.0 for kind in KINDS):
            raise RangeError(f"--cost: {name} costs nothing; each joint needs a weight above 0")
    displacement, velocity, acceleration = (tuple(table[kind]) for kind in KINDS)
    return PathChoices(displacement, velocity, acceleration, tuple(angles))


def path_times(rows: "Rows") -> "np.ndarray":
    """Give the times (s) of a path's rows.

    Raises:
        FileFormatError: there is no column time, a cell is empty, a row has a gap, or time does
            not increase.
    """
    import numpy as np

    table = rows.table
    if TIME not in table.header:
        raise FileFormatError(
            f"{table.path}: no column {TIME} (there are: {', '.join(table.header)}); --follow "
            "needs one, in seconds"
        )
    for problem in rows.problems:
        if problem:
            raise FileFormatError(f"{problem}; a path has no gaps")
    times = table.numbers(TIME)
    late = np.flatnonzero(~(np.diff(times, prepend=-np.inf) > 0))
    if late.size:
        raise table.refusal(int(late[0]), TIME, "must be above that of the row before")
    return times


def path_item(task: "HandRows", goals: "np.ndarray", times: "np.ndarray", choices: Any) -> "Item":
    """Make the one batch item of a path; `choices` are those of the run."""
    from selfmotion.batch import Item
    from selfmotion.cli.batches import fingerprint, hash_if_file
    from selfmotion.provenance import hash_arrays

    mark = fingerprint(choices, hash_if_file(choices.arm), hash_arrays(goals, times))
    return Item("path", (choices, task, goals, times), mark)


def follow_part(payload: "tuple[Any, HandRows, np.ndarray, np.ndarray]") -> dict[str, Any]:
    """Follow the path; gives the keys of the items and of the `PathPart`."""
    import numpy as np

    from selfmotion.methods.constrained_path import PathCosts, follow

    choices, task, goals, times = payload
    path: PathChoices = choices.path
    costs = PathCosts(path.displacement, path.velocity, path.acceleration, path.rest)
    found = follow(task, goals, time=times, costs=costs)
    error, n_held = task.error(found.q, goals), len(task.axes)
    near, turned = (np.linalg.norm(e, axis=1) for e in (error[:, :n_held], error[:, n_held:]))
    unknown = [None] * len(times)
    return {
        "place": list(range(len(times))),
        "time": times.tolist(),
        "q": numbers(found.q),
        "error_mm": numbers(1e3 * near),
        "error_deg": numbers(np.degrees(turned)),
        "iterations": unknown,
        "restarts": unknown,
        "status": ["solved" if ok else "not reached" for ok in found.met],
        "failed": (~found.met).tolist(),
        "path": {
            "ok": found.status.ok,
            "status": found.status.sentence,
            "largest_step": found.largest_step,
        },
    }


def path_part(choices: PathChoices, result: dict[str, Any]) -> PathPart:
    """Give the document's part about the path."""
    return PathPart(
        **result,
        displacement=list(choices.displacement),
        velocity=list(choices.velocity),
        acceleration=list(choices.acceleration),
        rest=[None if math.isnan(v) else v for v in choices.rest],
    )


def _joint(option: str, text: str, name: str, arm: "Arm") -> int:
    if name.strip() not in arm.joints:
        raise unknown_name(f"joint in {option} {text!r}:", name.strip(), arm.joints)
    return arm.joints.index(name.strip())


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
