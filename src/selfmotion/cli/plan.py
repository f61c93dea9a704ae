"""`selfmotion plan`: how a person moves to targets, by passive motion."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from selfmotion.cli.laws import FROM_DAMPING, law_of, typed_posture, typed_spring
from selfmotion.cli.legs import Legs, areas, center_out_legs, file_legs
from selfmotion.cli.models import load_any_arm, typed_weights
from selfmotion.cli.options import Json, Out, Quiet, Report
from selfmotion.cli.output import (
    Contract,
    Document,
    Matrix,
    Number,
    Part,
    Vector,
    finish,
    numbers,
    save,
)
from selfmotion.cli.plan_choices import path_to_imitate, typed_potentials
from selfmotion.cli.recordings import IdleJobs, IdleResume, TaskName
from selfmotion.errors import RangeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.passive.joint_law import JointLaw
    from selfmotion.methods.passive.task_planners import Planner
    from selfmotion.methods.passive_motion import PlannedMotion, PlanSettings
    from selfmotion.redundancy.task import Task


# Error allowed in a step where further potentials act (rad): muscle effort, which a solver gives,
# is not smooth enough for less.
TOLERANCE = 1e-6


class Movement(Part, frozen=True, kw_only=True):
    """One movement: time (s) from 0, q (rad, one row a sample), x in the task's units.

    `a_right` and `a_left` are the areas between path and straight line over its squared length,
    from onset to offset; `a_net` is positive to the right. `end_error` is in the task's units.
    """

    target: str
    direction: str | None
    time: Vector
    q: Matrix
    x: Matrix
    end_error: Number
    a_right: Number
    a_left: Number
    a_net: Number
    status: str
    failed: bool


class PlanDocument(Document, frozen=True, tag="selfmotion/plan/1", kw_only=True):
    """Planned movements; hysteresis is A_net outbound plus inbound, by target."""

    arm: str
    joints: list[str]
    units: list[str]
    model: str
    stiffness: Matrix
    rest: Vector
    spring: list[Matrix]
    movements: list[Movement]
    hysteresis: dict[str, Number]


CONTRACT = Contract(
    PlanDocument, ("plan", "--arm", "wrist", "--center-out", "--steps", "10", "--json")
)


def plan(
    arm: Annotated[str, typer.Option("--arm", metavar="NAME|FILE", help="The arm.")] = "wrist",
    targets: Annotated[
        Path | None,
        typer.Option(
            "--targets",
            metavar="FILE",
            help=".csv of places in order (x,y,z in m; target: names); each movement starts "
            "where the last ended.",
        ),
    ] = None,
    center_out: Annotated[
        bool,
        typer.Option("--center-out", help="Eight targets at 15 deg around the centre, and back."),
    ] = False,
    law: Annotated[
        Path | None,
        typer.Option(
            "--law",
            metavar="FILE.toml",
            help="stiffness (N m/rad), rest (rad) or rest_deg, damping_time, spring_time (s); "
            "left out, for the wrist: that of the paper's Fig. 3.",
        ),
    ] = None,
    task: TaskName = None,
    model: Annotated[
        Literal["lambda0", "pmp1", "pmp2"], typer.Option("--model", help="Which passive motion.")
    ] = "lambda0",
    spring: Annotated[
        str,
        typer.Option("--spring", metavar="VALUE|from-damping", help="Task spring, or by eq. 10."),
    ] = FROM_DAMPING,
    duration: Annotated[
        float, typer.Option("--duration", metavar="S", help="Length of a movement.")
    ] = 0.4,
    steps: Annotated[
        int,
        typer.Option("--steps", metavar="N", min=1, help="Intervals of the output of a movement."),
    ] = 100,
    planner: Annotated[
        Literal["spring", "minimum-jerk"] | None,
        typer.Option("--planner", help="What pulls the hand (default: the spring)."),
    ] = None,
    start: Annotated[
        str | None,
        typer.Option("--start", metavar="A,B,...", help="First posture, degrees in joint order."),
    ] = None,
    lock: Annotated[
        list[str] | None,
        typer.Option("--lock", metavar="JOINT", help="A joint that does not move; repeatable."),
    ] = None,
    path: Annotated[
        Path | None,
        typer.Option(
            "--path",
            metavar="FILE.csv",
            help="Imitate the shape of this recorded path (time in s; x,y,z in m), as a dynamic "
            "movement primitive.",
        ),
    ] = None,
    potential: Annotated[
        list[str] | None,
        typer.Option(
            "--potential",
            metavar="KIND[=...]",
            help="Pull of the joints beside the law: gravity[=SHARE], "
            "limits[=MARGIN_DEG:STRENGTH], effort=JOULES (arms with muscles); repeatable.",
        ),
    ] = None,
    weights: Annotated[
        str | None,
        typer.Option(
            "--damping-weights",
            "--weights",
            metavar="W,W,...|FILE.json",
            help="Damping of the joints instead of the law's: numbers in joint order, or a "
            "weights.json.",
        ),
    ] = None,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: IdleJobs = 1,
    resume: IdleResume = False,
    quiet: Quiet = False,
) -> int:
    """Plan how a person moves to targets, by passive motion."""
    from dataclasses import replace

    from selfmotion.redundancy.task import task_for

    chosen = load_any_arm(arm)
    if (targets is None) == (not center_out):
        raise RangeError("give either --targets FILE or --center-out")
    goal_task = task_for(chosen, task)
    joint_law = law_of(law, chosen)
    settings = settings_of(model, typed_spring(spring), duration, steps)
    pull = planner_of(planner, path, goal_task)
    own = typed_potentials(potential or (), arm, chosen)
    settings = replace(settings, planner=pull, potentials=own, locked=tuple(lock or ()))
    if own:
        settings = replace(settings, tolerance=TOLERANCE)
    settings = replace(settings, damping=typed_weights(weights, chosen))
    first = None if start is None else typed_posture(start, chosen)
    if targets is None:
        legs = center_out_legs(goal_task, joint_law, settings, first)
    else:
        legs = file_legs(targets, goal_task, joint_law, settings, first)
    movements = [movement(legs, i, chosen) for i in range(len(legs.motion))]
    document = PlanDocument(
        provenance=provenance_of(
            legs.motion, joint_law, {"targets": targets, "law": law, "path": path}
        ),
        arm=chosen.name,
        joints=list(chosen.joints),
        units=list(goal_task.units),
        model=model,
        stiffness=numbers(joint_law.stiffness),
        rest=numbers(joint_law.rest),
        spring=numbers(legs.motion.spring),
        movements=movements,
        hysteresis=hysteresis(movements),
    )
    written = [] if out is None else [save(document, out, "plan"), save_table(legs, out)]
    if report is not None:
        from selfmotion.report.plan_page import write_plan_report

        written.append(write_plan_report(report, named(legs), movement_table(movements)))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=sum(m.failed for m in movements))


def settings_of(
    model: Literal["lambda0", "pmp1", "pmp2"],
    spring: float | Literal["from-damping"],
    duration: float,
    steps: int,
) -> "PlanSettings":
    """Give the settings that all plans have."""
    from selfmotion.methods.passive_motion import PlanSettings

    return PlanSettings(model=model, spring=spring, duration=duration, n_steps=steps)


def planner_of(name: str | None, path: Path | None, task: "Task") -> "Planner":
    """Give what pulls the hand.

    Raises:
        SelfmotionError: both a planner and a path are named, or the file holds no such path.
    """
    from selfmotion.methods.passive.task_planners import MinimumJerk, TargetSpring

    if path is not None:
        if name is not None:
            raise RangeError(f"--path and --planner {name}: give one of them")
        return path_to_imitate(path, task)
    return MinimumJerk() if name == "minimum-jerk" else TargetSpring()


def movement(legs: Legs, i: int, arm: "Arm") -> Movement:
    """Give the record of one movement."""
    motion = legs.motion
    right, left = areas(motion.time, motion.x[i], legs.origins[i], motion.targets[i], arm)
    return Movement(
        target=legs.targets[i],
        direction=legs.directions[i],
        time=numbers(motion.time),
        q=numbers(motion.q[i]),
        x=numbers(motion.x[i]),
        end_error=numbers(motion.end_error[i]),
        a_right=right,
        a_left=left,
        a_net=None if right is None or left is None else right - left,
        status=motion.statuses[i].sentence,
        failed=not motion.statuses[i].ok,
    )


def hysteresis(movements: list[Movement]) -> dict[str, float | None]:
    """Sum A_net of the way out and the way back, for each target that has both."""
    from selfmotion.methods.curvature import path_hysteresis

    net = [float("nan") if m.a_net is None else m.a_net for m in movements]
    found = path_hysteresis(net, [(m.target, m.direction) for m in movements])
    return {str(target): numbers(pairs)[0] for target, pairs in found.items()}


def provenance_of(
    motion: "PlannedMotion", law: "JointLaw", files: dict[str, Path | None]
) -> Provenance:
    """Say where the results come from."""
    from selfmotion.provenance import hash_file

    inputs = {name: hash_file(path) for name, path in files.items() if path is not None}
    origin = "wrist of Fig. 3" if files["law"] is None else "file"
    times = {"damping_time": law.damping_time, "spring_time": law.spring_time, "law": origin}
    return Provenance("plan", inputs=inputs, choices={**motion.provenance.choices, **times})


def named(legs: Legs) -> "PlannedMotion":
    """Label the movements by target and direction."""
    both = zip(legs.targets, legs.directions, strict=True)
    return legs.motion.named(tuple(n if way is None else f"{n} {way}" for n, way in both))


def movement_table(movements: list[Movement]) -> "pd.DataFrame":
    """Give a table, one row a movement."""
    import pandas as pd

    names = ("target", "direction", "end_error", "a_right", "a_left", "a_net", "status")
    return pd.DataFrame([{name: getattr(m, name) for name in names} for m in movements])


def save_table(legs: Legs, folder: Path) -> Path:
    """Write plan.csv: one row a sample."""
    return write_whole(folder / "plan.csv", named(legs).to_frame().to_csv(index=False))


def as_text(document: PlanDocument) -> str:
    """Write the movements as a person reads them."""
    lines = [
        f"arm {document.arm}, model {document.model}",
        "movement          end error  A_right   A_left    A_net",
    ]
    for m in document.movements:
        name = f"{m.target} {m.direction or ''}".strip()
        shares = "".join(_cell(value) for value in (m.a_right, m.a_left, m.a_net))
        lines.append(f"{name:16} {_cell(m.end_error)}{shares}  {m.status}")
    if document.hysteresis:
        pairs = (f"{name} {_cell(value).strip()}" for name, value in document.hysteresis.items())
        lines.append("hysteresis: " + ", ".join(pairs))
    return "\n".join(lines)


def _cell(value: float | None) -> str:
    return "        ?" if value is None else f" {value:8.4f}"
