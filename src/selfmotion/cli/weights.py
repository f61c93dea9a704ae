"""`selfmotion weights`: how costly each joint is, identified from recorded motion."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from selfmotion._version import __version__
from selfmotion.cli.options import Json, Out, Report
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
from selfmotion.cli.recordings import ArmName, Cutoff, Inputs, TaskName, read_study
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.methods.weight_estimate import WeightEstimate
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

    correlation: Matrix
    principal_shares: Vector
    relative_phase_deg: Matrix | None


class WeightsDocument(
    Estimate, frozen=True, tag_field="schema", tag="selfmotion/weights/1", kw_only=True
):
    """Weights of the joints, pooled over all that was read, and of its parts if asked for."""

    version: str = __version__
    provenance: Provenance
    n_dropped: int
    per: str
    items: list[Item]
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
    method: Annotated[
        Literal["ml", "paper", "feedback"],
        typer.Option("--method", help="ml: least null-space motion. paper: Algorithm 1."),
    ] = "ml",
    null_ratio: Annotated[
        float, typer.Option("--null-ratio", help="γ of Algorithm 1, 0 to 1.")
    ] = 0.9,
    null_schedule: Annotated[
        Literal["constant", "printed"],
        typer.Option("--null-schedule", help="How γ goes on: constant, or as the paper prints it."),
    ] = "constant",
    per: Annotated[
        Literal["all", "recording", "trial", "window"],
        typer.Option("--per", help="Also estimate each file, trial or time window alone."),
    ] = "all",
    windows: Annotated[
        int, typer.Option("--windows", help="Windows of a movement, with --per window.")
    ] = 5,
    json: Json = False,
    out: Out = None,
    report: Report = None,
) -> int:
    """Identify how costly each joint is, from recorded motion."""
    from selfmotion.methods.identification import identify_weights
    from selfmotion.methods.weight_series import weights_by_window

    study, n_dropped = read_study(inputs, arm=arm, task=task, cutoff=cutoff).drop_gaps()

    def identify(part: "Study") -> "WeightEstimate":
        return identify_weights(
            part, method=method, null_ratio=null_ratio, null_schedule=null_schedule
        )

    pooled = identify(study)
    if per == "window":
        series = weights_by_window(
            study,
            windows=windows,
            method=method,
            null_ratio=null_ratio,
            null_schedule=null_schedule,
        )
        parts = dict(zip(series.names, series.estimates, strict=True))
    else:
        parts = parts_of(study, identify, per)
    items = [Item(name=n, failed=not e.status.ok, **record(e)) for n, e in parts.items()]
    document = WeightsDocument(
        provenance=pooled.provenance,
        **record(pooled),
        n_dropped=n_dropped,
        per=per,
        items=items,
        comparators=comparators(study),
    )
    written = []
    if out is not None:
        written = [save(document, out, "weights"), *save_tables(pooled, parts, out)]
    if report is not None:
        from selfmotion.report.weights_page import write_weights_report

        written.append(write_weights_report(report, study, pooled, identify))
    text = "\n".join([as_text(pooled), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=sum(item.failed for item in items))


def parts_of(
    study: "Study", identify: "Callable[[Study], WeightEstimate]", per: str
) -> "dict[str, WeightEstimate]":
    """Estimate each file or trial alone; one that fails says why, and the rest goes on."""
    from selfmotion.methods.weight_series import estimate_each

    names = {"recording": lambda r: r.source, "trial": lambda r: r.name}
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
    """Compute the measures that know nothing of the task."""
    import numpy as np

    from selfmotion.methods.coordination import (
        principal_components,
        relative_phase,
        velocity_correlation,
    )

    angles = all(r.q is not None and r.n_samples > 1 for r in study)
    phase = np.degrees(relative_phase(study).mean_absolute) if angles else None
    return Comparators(
        correlation=numbers(velocity_correlation(study)),
        principal_shares=numbers(principal_components(study).share),
        relative_phase_deg=None if phase is None else numbers(phase),
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
    width = max(len(joint) for joint in estimate.joints)
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
    lines.append(
        f"left to the null space: {100 * estimate.unexplained:.1f} % of squared joint velocity "
        f"({100 * estimate.unexplained_identity:.1f} % with all weights alike)"
    )
    return "\n".join(lines)
