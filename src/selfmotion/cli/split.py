"""`selfmotion split`: joint velocity parted into what moves the hand and what does not."""

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from selfmotion.cli.options import Json, Out, Quiet, Report
from selfmotion.cli.output import Contract, Document, Number, Part, Vector, finish, numbers, save
from selfmotion.cli.recordings import (
    AngleUnit,
    ArmName,
    Cutoff,
    Forward,
    IdleJobs,
    IdleResume,
    IdleSeed,
    Inputs,
    LengthUnit,
    Rate,
    Stated,
    TaskName,
    UnreadFile,
    Up,
    provenance_of,
    read_study,
)
from selfmotion.errors import FileFormatError, RangeError, ShapeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.methods.uncontrolled_manifold import ManifoldVariance
    from selfmotion.methods.velocity_split import VelocitySplit
    from selfmotion.motion.recording import Study

IDENTIFY, EQUAL = "identify", "equal"


class Share(Part, frozen=True, kw_only=True):
    """How one recording's squared joint velocity is shared out.

    `task_share` and `null_share` are of the plain joint velocities and add up to 1;
    `task_share_weighted` is the same in the metric of the weights, in which the two parts are
    orthogonal; `null_rms` is the root mean square of each joint's null-space velocity (rad/s).
    """

    name: str
    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    trial: str | None
    task_share: Number
    null_share: Number
    task_share_weighted: Number
    unexplained: Number
    null_rms: Vector


class Manifold(Part, frozen=True, kw_only=True):
    """Variance over repetitions, along and across the uncontrolled manifold, per dimension.

    `variable` is q (rad²) or qd ((rad/s)²); `synergy` is ΔV and `synergy_z` its z-transform, over
    `phase`, the fraction of the movement.
    """

    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    variable: str
    n_trials: int
    phase: Vector
    along: Vector
    across: Vector
    synergy: Vector
    synergy_z: Vector
    mean_synergy_z: Number


class SplitDocument(Document, frozen=True, tag="selfmotion/split/1", kw_only=True):
    """Shares of each recording, and the variance over repetitions where there are any.

    `unread` are files of a folder that could not be read; they do not count.
    """

    joints: list[str]
    weights: Vector
    weights_from: str
    n_dropped: int
    recordings: list[Share]
    manifold: list[Manifold]
    unread: list[UnreadFile]


CONTRACT = Contract(
    SplitDocument, ("split", "examples/reach.csv", "--arm", "exoskeleton", "--json")
)


def split(
    inputs: Inputs,
    weights: Annotated[
        str,
        typer.Option(
            "--weights",
            metavar="identify|equal|W,W,...|FILE.json",
            help="From the same data, all alike, numbers in joint order, or a weights.json.",
        ),
    ] = IDENTIFY,
    arm: ArmName = None,
    task: TaskName = None,
    cutoff: Cutoff = None,
    length_unit: LengthUnit = None,
    angle_unit: AngleUnit = None,
    rate: Rate = None,
    up: Up = None,
    forward: Forward = None,
    jobs: IdleJobs = 1,
    resume: IdleResume = False,
    seed: IdleSeed = 0,
    quiet: Quiet = False,
    json: Json = False,
    out: Out = None,
    report: Report = None,
) -> int:
    """Part joint velocity into what moves the hand and what does not."""
    from selfmotion.methods.velocity_split import split as split_recording

    stated = Stated(length_unit, angle_unit, rate, up, forward)
    read, unread = read_study(inputs, arm=arm, task=task, cutoff=cutoff, stated=stated)
    study, n_dropped = read.drop_gaps()
    joints = study.joints
    refuse_still(study)
    W, origin = choose_weights(weights, study)
    parts = [split_recording(r, weights=W) for r in study]
    variances = manifold_variances(study)
    document = SplitDocument(
        provenance=provenance_of(
            Provenance("split"),
            inputs,
            weights=origin,
            arm=arm,
            task=task,
            cutoff=cutoff,
            **stated.choices(),
        ),
        joints=list(joints),
        weights=numbers(W),
        weights_from=origin,
        n_dropped=n_dropped,
        recordings=[share(p, r.labels.to_dict()) for p, r in zip(parts, study, strict=True)],
        manifold=[manifold(v, key) for key, v in variances.items()],
        unread=unread,
    )
    written = []
    if out is not None:
        written = [save(document, out, "split"), *save_velocities(parts, out)]
    if report is not None:
        from selfmotion.report.split_page import write_split_report

        written.append(write_split_report(report, study, W, parts, variances))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=len(unread))


def refuse_still(study: "Study") -> None:
    """Refuse recordings in which nothing moves, or no joint could stand in for another.

    Raises:
        RangeError: there is no motion to split.
        ShapeError: the arm is not redundant for the task.
    """
    import numpy as np

    from selfmotion.methods.weights.passes import STILL_SPEED

    speed = max(float(np.sqrt(np.mean(r.array("qd") ** 2))) for r in study)
    if not speed > STILL_SPEED:
        raise RangeError(f"{study[0].name}: qd is zero in all samples; motion is needed")
    rows, joints = study[0].array("jacobian").shape[1:]
    if rows >= joints:
        raise ShapeError(
            f"{study[0].name}: jacobian has {rows} task rows for {joints} joints; "
            "allowed are fewer rows than joints"
        )


def choose_weights(text: str, study: "Study") -> "tuple[np.ndarray, str]":
    """Give the weights (n) that an option means, and where they come from.

    Raises:
        SelfmotionError: the text is no number, file or word that gives positive weights.
    """
    import numpy as np

    from selfmotion.methods.velocity_split import weight_vector

    joints = study.joints
    if text == IDENTIFY:
        from selfmotion.methods.identification import identify_weights

        found = identify_weights(study)
        if not found.status.ok:
            raise RangeError(
                f"{study[0].name}: no weights to split by ({found.status.sentence}); "
                f"name some, as in --weights {EQUAL}"
            )
        over = {joint for group in found.structural_groups for joint in group}
        warn_of_unknown([joint for joint in found.unidentifiable if joint in over])
        return found.full_weights, f"identified from the same data ({found.method})"
    if text == EQUAL:
        return np.ones(len(joints)), "all alike"
    if text.lower().endswith(".json"):
        return weights_of_file(Path(text), joints), text
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        raise RangeError(
            f"--weights {text!r}: allowed are {IDENTIFY}, {EQUAL}, {len(joints)} numbers with "
            "commas between, or a .json file of `selfmotion weights`"
        ) from None
    if len(values) != len(joints):
        raise RangeError(
            f"--weights {text}: {len(values)} numbers for {len(joints)} joints "
            f"({', '.join(joints)})"
        )
    return weight_vector(values, joints), "given"


def warn_of_unknown(joints: list[str]) -> None:
    """Say which joints have a weight that the data could not tell."""
    import warnings

    if joints:
        names = ", ".join(joints)
        warnings.warn(f"the shares rest on weights that are not identified: {names}", stacklevel=2)


def weights_of_file(path: Path, joints: tuple[str, ...]) -> "np.ndarray":
    """Read the weights of a weights.json; a joint without a number there counts as 1.

    Raises:
        FileFormatError: the file is not such a document, or lacks a joint.
    """
    from selfmotion.methods.velocity_split import weight_vector

    try:
        document = json_module.loads(path.read_text(encoding="utf-8"))
        known = [None if w is None else float(w) for w in document["weights"]]
        named = dict(zip(document["joints"], known, strict=True))
        groups = document.get("structural_groups", [list(named)])
        relevant = {joint for group in groups for joint in group}
    except (ValueError, KeyError, TypeError):
        raise FileFormatError(f"{path}: not a weights.json (no joints and weights in it)") from None
    for joint in joints:
        if joint not in named:
            raise FileFormatError(
                f"{path}: no weight for joint {joint!r} of the recordings (it has "
                f"{', '.join(named)})"
            )
    values = [named[joint] for joint in joints]
    warn_of_unknown([j for j, v in zip(joints, values, strict=True) if v is None and j in relevant])
    return weight_vector([1.0 if v is None else v for v in values], joints)


def manifold_variances(study: "Study") -> "dict[tuple[str | None, ...], ManifoldVariance]":
    """Compute the variance over repetitions for each person, side, condition and target."""
    from selfmotion.methods.uncontrolled_manifold import manifold_variance

    groups = study.group("subject", "side", "condition", "target")
    return {
        key: manifold_variance(part)
        for key, part in groups.items()
        if len(part) > 1 and all(r.n_samples > 1 for r in part)
    }


def share(part: "VelocitySplit", labels: dict[str, Any]) -> Share:
    """Give the record of one recording."""
    return Share(
        name=part.name,
        **labels,
        task_share=part.task_share,
        null_share=part.null_share,
        task_share_weighted=part.task_share_weighted,
        unexplained=part.unexplained,
        null_rms=numbers(part.null_rms),
    )


def manifold(variance: "ManifoldVariance", key: tuple[str | None, ...]) -> Manifold:
    """Give the record of one group of repetitions."""
    import numpy as np

    labels: dict[str, Any] = dict(zip(("subject", "side", "condition", "target"), key, strict=True))
    z = variance.synergy_z[np.isfinite(variance.synergy_z)]
    return Manifold(
        **labels,
        variable=variance.variable,
        n_trials=variance.n_trials,
        phase=numbers(variance.phase),
        along=numbers(variance.along),
        across=numbers(variance.across),
        synergy=numbers(variance.synergy),
        synergy_z=numbers(variance.synergy_z),
        mean_synergy_z=float(z.mean()) if len(z) else None,
    )


def save_velocities(parts: "list[VelocitySplit]", folder: Path) -> list[Path]:
    """Write velocities.csv: task and null-space velocity of every sample."""
    import pandas as pd

    frames = []
    for part in parts:
        frame = part.to_frame()
        frame.insert(0, "recording", part.name)
        frames.append(frame)
    table = pd.concat(frames, ignore_index=True)
    return [write_whole(folder / "velocities.csv", table.to_csv(index=False))]


def as_text(document: SplitDocument) -> str:
    """Write the shares as a person reads them."""
    names = [r.name for r in document.recordings]
    width = max(len("recording"), *map(len, names))
    lines = [f"weights: {document.weights_from}", f"{'recording':{width}}  task   null space"]
    lines += [
        f"{r.name:{width}}  {_percent(r.task_share)}  {_percent(r.null_share)}"
        for r in document.recordings
    ]
    lines += [f"{bad.file}: not read: {bad.status}" for bad in document.unread]
    for m in document.manifold:
        who = ", ".join(v for v in (m.subject, m.side, m.condition, m.target) if v) or "all"
        lines.append(
            f"{who}, {m.n_trials} repetitions: synergy index z "
            + ("unknown" if m.mean_synergy_z is None else f"{m.mean_synergy_z:.2f}")
            + " (mean over the movement; above 0: variance is kept where the hand does not feel it)"
        )
        if m.condition is None and m.target is None:
            lines.append(
                "  taken for repetitions of one movement: the files name no condition or target"
            )
    return "\n".join(lines)


def _percent(value: float | None) -> str:
    return "   ?  " if value is None or value != value else f"{100 * value:4.1f} %"
