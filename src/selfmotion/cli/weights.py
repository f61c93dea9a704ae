"""`selfmotion weights`: how costly each joint is, identified from recorded motion."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from selfmotion._version import __version__
from selfmotion.cli.options import (
    Jobs,
    Json,
    Out,
    Quiet,
    Report,
    Resume,
    Scheduler,
    Seed,
    StudyFile,
)
from selfmotion.cli.output import (
    Contract,
    Matrix,
    Number,
    Part,
    Vector,
    finish,
    numbers,
    save,
)
from selfmotion.cli.recordings import (
    AngleUnit,
    ArmName,
    Cutoff,
    Forward,
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
from selfmotion.errors import SelfmotionError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.methods.weights.estimate import WeightEstimate
    from selfmotion.motion.recording import Recording, Study


class Estimate(Part, frozen=True, kw_only=True):
    """Weights of the joints, from all samples of one part of the data.

    A joint without a number stands in `unidentifiable`, with the reason. `lower` and `upper` are
    95 % limits; `unexplained` is the share of squared joint velocity that is left to the null
    space, and `unexplained_identity` the same with all weights alike.
    """

    joints: list[str]
    weights: Vector
    lower: Vector
    upper: Vector
    contribution: Vector
    contribution_eq26: Vector
    groups: list[list[str]]
    structural_groups: list[list[str]]
    unidentifiable: dict[str, str]
    stderr_log: Vector
    stderr_kind: str
    method: str
    iterations: int
    unexplained: Number
    unexplained_identity: Number
    n_samples: int
    n_trials: int
    status: str


class Item(Estimate, frozen=True, kw_only=True):
    """The same for one recording, trial or window of time."""

    name: str
    failed: bool


class Comparators(Part, frozen=True, kw_only=True):
    """What is usually computed in place of weights; none of it knows the task.

    `correlation` of joint velocities, `principal_shares` of their variance, and, where angles
    are there, `relative_phase_deg`: mean absolute continuous relative phase.
    """

    correlation: Matrix | None
    principal_shares: Vector | None
    relative_phase_deg: Matrix | None


class WeightsDocument(
    Estimate, frozen=True, tag_field="schema", tag="selfmotion/weights/1", kw_only=True
):
    """Weights of the joints, pooled over all that was read, and of its parts if asked for.

    `unread` are files of a folder that could not be read; they do not count.
    """

    version: str = __version__
    provenance: Provenance
    n_dropped: int
    n_rank_deficient: int
    per: str
    items: list[Item]
    unread: list[UnreadFile]
    comparators: Comparators


CONTRACT = Contract(
    WeightsDocument,
    (
        "weights",
        "examples/reach.csv",
        "--arm",
        "exoskeleton",
        "--per",
        "window",
        "--windows",
        "2",
        "--json",
    ),
)


def weights(
    inputs: Inputs,
    arm: ArmName = None,
    task: TaskName = None,
    cutoff: Cutoff = None,
    length_unit: LengthUnit = None,
    angle_unit: AngleUnit = None,
    rate: Rate = None,
    up: Up = None,
    forward: Forward = None,
    method: Annotated[
        Literal["ml", "paper", "feedback"],
        typer.Option(
            "--method",
            help="ml: least null-space motion. feedback: the same, with null-space motion that "
            "posture drives. paper: Algorithm 1.",
        ),
    ] = "ml",
    null_ratio: Annotated[
        float | None,
        typer.Option(
            "--null-ratio", metavar="RATIO", help="γ of Algorithm 1, 0 to 1; left out: 0.9."
        ),
    ] = None,
    null_schedule: Annotated[
        Literal["constant", "printed"] | None,
        typer.Option("--null-schedule", help="How γ goes on: constant, or as the paper prints it."),
    ] = None,
    per: Annotated[
        Literal["all", "person", "recording", "trial", "window"],
        typer.Option(
            "--per",
            help="Also estimate each part alone: person, side and condition; file; trial; window.",
        ),
    ] = "all",
    windows: Annotated[
        int | None,
        typer.Option(
            "--windows", metavar="N", help="Windows of a movement, with --per window; left out: 5."
        ),
    ] = None,
    study_file: StudyFile = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    seed: Seed = 0,
    quiet: Quiet = False,
    json: Json = False,
    out: Out = None,
    report: Report = None,
) -> int:
    """Identify how costly each joint is, from recorded motion."""
    if study_file is not None:
        from selfmotion.cli.batches import BatchChoices
        from selfmotion.cli.study_weights import StudyChoices, weigh_study

        batch = BatchChoices("weights", out, jobs, scheduler, resume, quiet)
        return weigh_study(inputs, StudyChoices(study_file, arm, method, seed, batch, report, json))
    from selfmotion.methods.identification import identify_weights
    from selfmotion.methods.weights.series import weights_by_window

    warn_of_idle(method, per, null_ratio=null_ratio, null_schedule=null_schedule, windows=windows)
    ratio, schedule = 0.9 if null_ratio is None else null_ratio, null_schedule or "constant"
    stated = Stated(length_unit, angle_unit, rate, up, forward)
    read, unread = read_study(inputs, arm=arm, task=task, cutoff=cutoff, stated=stated)
    study, n_dropped = read.drop_gaps()
    if per != "person" and not quiet:
        warn_of_pooling(study)

    def identify(part: "Study") -> "WeightEstimate":
        return identify_weights(part, method=method, null_ratio=ratio, null_schedule=schedule)

    pooled = identify(study)
    if per == "window":
        series = weights_by_window(
            study,
            windows=5 if windows is None else windows,
            method=method,
            null_ratio=ratio,
            null_schedule=schedule,
        )
        parts = dict(zip(series.names, series.estimates, strict=True))
    else:
        parts = parts_of(study, identify, per)
    items = [Item(name=n, failed=not e.status.ok, **record(e)) for n, e in parts.items()]
    document = WeightsDocument(
        provenance=provenance_of(
            pooled.provenance, inputs, arm=arm, task=task, cutoff=cutoff, **stated.choices()
        ),
        **record(pooled),
        n_dropped=n_dropped,
        n_rank_deficient=pooled.n_rank_deficient,
        per=per,
        items=items,
        unread=unread,
        comparators=comparators(study),
    )
    written = []
    if out is not None:
        written = [save(document, out, "weights"), *save_tables(pooled, parts, out)]
    if report is not None:
        from selfmotion.report.weights_page import write_weights_report

        written.append(write_weights_report(report, study, pooled, identify))
    texts = [as_text(pooled), *(f"\n{name}: {as_text(e)}" for name, e in parts.items())]
    texts += [f"{bad.file}: not read: {bad.status}" for bad in unread]
    text = "\n".join([*texts, *(f"wrote {path}" for path in written)])
    failed = sum(item.failed for item in items) + (not pooled.status.ok) + len(unread)
    return finish(document, text, json=json, failed=failed)


def warn_of_idle(method: str, per: str, **given: object) -> None:
    """Say when an option has no effect."""
    import warnings

    idle = [name for name in ("null_ratio", "null_schedule") if given[name] is not None]
    if idle and method != "paper":
        names = " and ".join("--" + name.replace("_", "-") for name in idle)
        warnings.warn(f"{names}: no effect with --method {method} (paper only)", stacklevel=2)
    if given["windows"] is not None and per != "window":
        warnings.warn(f"--windows: no effect with --per {per} (window only)", stacklevel=2)


def warn_of_pooling(study: "Study") -> None:
    """Say when people, sides or conditions are thrown together."""
    import warnings

    many = [
        f"{len(values)} {label}s"
        for label in ("subject", "side", "condition")
        if len(values := set(study.values(label))) > 1
    ]
    if many:
        warnings.warn(
            f"pooled over {', '.join(many)}; --per person estimates each alone", stacklevel=2
        )


def parts_of(
    study: "Study", identify: "Callable[[Study], WeightEstimate]", per: str
) -> "dict[str, WeightEstimate]":
    """Estimate each file or trial alone; one that fails says why, and the rest goes on."""
    from selfmotion.methods.weights.series import estimate_each

    names = {
        "person": lambda r: (
            ", ".join(v for v in (r.labels.subject, r.labels.side, r.labels.condition) if v)
            or "unlabelled"
        ),
        "recording": lambda r: r.source,
        "trial": lambda r: r.name,
    }
    if per not in names:
        return {}
    parts: dict[str, list[Recording]] = {}
    for recording in study:
        parts.setdefault(names[per](recording), []).append(recording)
    return estimate_each(parts, identify)


def record(estimate: "WeightEstimate") -> dict[str, Any]:
    """Give the keys of an `Estimate`."""
    interval = estimate.interval()
    return {
        "joints": list(estimate.joints),
        "weights": numbers(estimate.weights),
        "lower": numbers(interval[:, 0]),
        "upper": numbers(interval[:, 1]),
        "contribution": numbers(estimate.contribution),
        "contribution_eq26": numbers(estimate.contribution_eq26),
        "groups": [list(group) for group in estimate.groups],
        "structural_groups": [list(group) for group in estimate.structural_groups],
        "unidentifiable": dict(estimate.unidentifiable),
        "stderr_log": numbers(estimate.stderr_log),
        "stderr_kind": estimate.stderr_kind,
        "method": estimate.method,
        "iterations": estimate.iterations,
        "unexplained": estimate.unexplained,
        "unexplained_identity": estimate.unexplained_identity,
        "n_samples": estimate.n_samples,
        "n_trials": estimate.n_trials,
        "status": estimate.status.sentence,
    }


def comparators(study: "Study") -> Comparators:
    """Compute the measures that know nothing of the task; null where one does not exist."""
    import numpy as np

    from selfmotion.methods.coordination import (
        principal_components,
        relative_phase,
        velocity_correlation,
    )

    def known(measure: Callable[[], "np.ndarray"]) -> Any:
        try:
            return numbers(measure())
        except SelfmotionError:  # a constant velocity has no correlation; the weights stand
            return None

    angles = all(r.q is not None and r.n_samples > 1 for r in study)
    return Comparators(
        correlation=known(lambda: velocity_correlation(study)),
        principal_shares=known(lambda: principal_components(study).share),
        relative_phase_deg=known(lambda: np.degrees(relative_phase(study).mean_absolute))
        if angles
        else None,
    )


def save_tables(
    pooled: "WeightEstimate", parts: "dict[str, WeightEstimate]", folder: Path
) -> list[Path]:
    """Write weights.csv, one row a part and joint; the whole is the part called "all"."""
    import pandas as pd

    frames = [e.to_frame().assign(part=name) for name, e in {"all": pooled, **parts}.items()]
    table = pd.concat(frames, ignore_index=True)
    table.insert(0, "part", table.pop("part"))
    return [write_whole(folder / "weights.csv", table.to_csv(index=False))]


def as_text(estimate: "WeightEstimate") -> str:
    """Write an estimate as a person reads it."""
    width = max(len("joint"), *(len(joint) for joint in estimate.joints))
    lines = [
        f"{estimate.n_samples} samples in {estimate.n_trials} trials; method {estimate.method}; "
        f"{estimate.status.sentence}",
        f"{'joint':{width}}  weight   95 % interval    contribution",
    ]
    interval = estimate.interval()
    for i, joint in enumerate(estimate.joints):
        if joint in estimate.unidentifiable:
            lines.append(f"{joint:{width}}  not identified: {estimate.unidentifiable[joint]}")
            continue
        low, high = interval[i]
        lines.append(
            f"{joint:{width}}  {estimate.weights[i]:6.3f}   {low:6.3f} - {high:6.3f}   "
            f"{estimate.contribution[i]:6.3f}"
        )
    if estimate.n_rank_deficient:
        lines.append(f"{estimate.n_rank_deficient} samples left out: the arm was singular there")
    lines.append(
        f"left to the null space: {100 * estimate.unexplained:.1f} % of squared joint velocity "
        f"({100 * estimate.unexplained_identity:.1f} % with all weights alike)"
    )
    return "\n".join(lines)
