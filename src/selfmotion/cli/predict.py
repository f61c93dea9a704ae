"""`selfmotion predict`: laws of posture against people, one person left out at a time."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

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
from selfmotion.cli.output import Contract, Document, Number, Part, finish, save
from selfmotion.errors import RangeError
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.batch import Outcome
    from selfmotion.cli.batches import BatchChoices
    from selfmotion.studies.prediction import PredictionRun
    from selfmotion.studies.prediction_tables import PredictionTables

Row = TypeVar("Row", bound=Part)


class PredictorSummary(Part, frozen=True, kw_only=True):
    """How far one predictor misses people's swivel angle (degrees).

    `mean_deg` is the mean over people of the absolute error, with its 95 % interval over people;
    `trials_deg` and `trials_sd_deg` are [Li2022] eq. 14 and its spread over moments; `bias_deg` the
    mean signed error; `gain_deg` what is gained on the constant per task, with its interval.
    """

    predictor: str
    mean_deg: Number
    lower_deg: Number
    upper_deg: Number
    trials_deg: Number
    trials_sd_deg: Number
    bias_deg: Number
    gain_deg: Number
    gain_lower_deg: Number
    gain_upper_deg: Number
    better_people: int
    people: int
    predicted: int
    missing: int


class KindError(Part, frozen=True, kw_only=True):
    """Mean over people of the absolute error of one predictor at one kind of moment."""

    predictor: str
    kind: str
    error_deg: Number


class PersonError(Part, frozen=True, kw_only=True):
    """Mean natural and predicted angles of one arm of a person at one kind of moment."""

    predictor: str
    subject: str
    side: str
    kind: str
    natural_deg: Number
    predicted_deg: Number
    error_deg: Number
    trials: int


class KindSpread(Part, frozen=True, kw_only=True):
    """How natural angles vary: over repeats, and over people's means (standard deviations)."""

    kind: str
    mean_deg: Number
    within_deg: Number
    within_lower_deg: Number
    within_upper_deg: Number
    between_deg: Number
    between_lower_deg: Number
    between_upper_deg: Number
    people: int
    moments: int


class VariantError(Part, frozen=True, kw_only=True):
    """The same with another shoulder centre, or other limits.

    `shift_deg` is how far natural angles moved in the mean, `moved_deg` the mean size of that,
    `inside` the share of natural postures inside the limits.
    """

    variant: str
    predictor: str
    mean_deg: Number
    lower_deg: Number
    upper_deg: Number
    shift_deg: Number
    moved_deg: Number
    inside: Number
    counts: int


class SeenMoment(Part, frozen=True, kw_only=True):
    """One moment: the natural swivel angle (rad), and what each predictor says (rad)."""

    subject: str
    side: str
    task: str
    moment: str
    trial: str
    natural: Number
    start: Number
    elbow_radius_m: Number
    feasible_low: Number
    feasible_high: Number
    natural_inside: bool
    effort_ratio: Number
    counts: bool
    predicted: dict[str, Number]


class NotComputed(Part, frozen=True, kw_only=True):
    """A baseline of [Li2022] Table IV that could not be computed, and why."""

    predictor: str
    reason: str


class Failed(Part, frozen=True, kw_only=True):
    """A person, file or moment that could not be used."""

    item: str
    status: str


class PredictDocument(Document, frozen=True, tag="selfmotion/predict/1", kw_only=True):
    """Predicted against natural swivel angles; each person predicted from the others only."""

    baseline: str
    people: int
    moments: int
    moments_left_out: int
    summary: list[PredictorSummary]
    kinds: list[KindError]
    persons: list[PersonError]
    spread: list[KindSpread]
    sensitivity: list[VariantError]
    observations: list[SeenMoment]
    not_computed: list[NotComputed]
    failed: list[Failed]


CONTRACT = Contract(
    PredictDocument,
    ("predict", "examples/people", "--study", "examples/people/study.toml", "--json", "--quiet"),
)


def predict(
    folders: Annotated[
        list[Path],
        typer.Argument(metavar="DIR...", help="Folders of marker files, searched below too."),
    ],
    study_file: StudyFile = None,
    sensitivity: Annotated[
        bool,
        typer.Option(
            "--sensitivity",
            help="Also with other shoulder centres (±10 mm, landmarks, acromion) and other limits.",
        ),
    ] = False,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    seed: Seed = 0,
    quiet: Quiet = False,
    json: Json = False,
    out: Out = None,
    report: Report = None,
) -> int:
    """Hold laws of natural posture against recorded people."""
    from selfmotion.cli.batches import BatchChoices

    if study_file is None:
        raise RangeError("--study: name the study file, which says whose file is which")
    batch = BatchChoices("predict", out, jobs, scheduler, resume, quiet)
    run = run_prediction(folders, study_file, sensitivity=sensitivity, batch=batch)
    from selfmotion.studies.prediction_tables import tables_of  # after what tells of progress

    tables = tables_of(run, seed=seed)
    document = as_document(run, tables)
    written = []
    if out is not None:
        written = [save(document, out, "predict")]
        for name, table in tables.named().items():
            written.append(write_whole(out / f"{name}.csv", table.to_csv(index=False)))
    if report is not None:
        from selfmotion.report.prediction_page import write_prediction_report

        written.append(write_prediction_report(report, run, tables))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=len(run.failed))


def run_prediction(
    folders: list[Path],
    study_file: Path,
    *,
    sensitivity: bool = False,
    batch: "BatchChoices | None" = None,
    on_start: "Callable[[int], Callable[[Outcome], None]] | None" = None,
) -> "PredictionRun":
    """Run all predictors on the people of a study.

    Args:
        folders: where the recordings are.
        study_file: how they are named and read.
        sensitivity: whether other shoulder centres and limits are tried too.
        batch: where it runs.
        on_start: is told the number of arms and gives what to call as each is completed; left
            out: a bar on a terminal.
    """
    from selfmotion.cli.batches import BatchChoices
    from selfmotion.cli.progress import progress, stages

    where = batch or BatchChoices("predict")
    with stages(quiet=where.quiet or on_start is not None) as tell:
        tell("reading what the folders hold")
        from selfmotion.batch import Runner
        from selfmotion.studies.prediction import PredictionPlan, plan_items, predict_people
        from selfmotion.studies.study_file import load_study_file

        plan = PredictionPlan(tuple(folders), load_study_file(study_file), sensitivity, where.out)
        runner = Runner(jobs=where.jobs, scheduler=where.scheduler, resume=where.resume)
        n_arms = len(plan_items(plan)) if on_start is None else 0
    if on_start is not None:
        return predict_people(plan, runner, on_start=on_start)
    with progress(n_arms, "arms", quiet=where.quiet) as done:
        return predict_people(plan, runner, on_start=lambda _: done)


def as_document(run: "PredictionRun", tables: "PredictionTables") -> PredictDocument:
    """Give a run as its JSON document."""
    from selfmotion.methods.predictors.catalogue import BASELINE, NOT_COMPUTED

    counts = tables.observations["counts"].to_numpy(dtype=bool)
    people = tables.observations["subject"].to_numpy(dtype=str)[counts]
    return PredictDocument(
        provenance=tables.provenance,
        baseline=BASELINE,
        people=len(set(people.tolist())),
        moments=int(counts.sum()),
        moments_left_out=int((~counts).sum()),
        summary=rows(tables.summary, PredictorSummary),
        kinds=rows(tables.kinds, KindError),
        persons=rows(tables.persons, PersonError),
        spread=rows(tables.spread, KindSpread),
        sensitivity=rows(tables.sensitivity, VariantError),
        observations=rows(tables.observations, SeenMoment),
        not_computed=[NotComputed(predictor=k, reason=why) for k, why in NOT_COMPUTED],
        failed=[Failed(item=what, status=why) for what, why in run.failed],
    )


def as_text(document: PredictDocument) -> str:
    """Write the result as a person reads it."""
    width = max(len(s.predictor) for s in document.summary)
    lines = [
        f"{document.people} people, {document.moments} moments ({document.moments_left_out} left "
        "out: elbow on the line from shoulder to wrist)",
        f"{'predictor':{width}}  error (deg), 95 %     less than the constant, 95 %",
    ]
    for s in document.summary:
        lines.append(
            f"{s.predictor:{width}}  {_f(s.mean_deg)} ({_f(s.lower_deg)} to {_f(s.upper_deg)})   "
            f"{_f(s.gain_deg)} ({_f(s.gain_lower_deg)} to {_f(s.gain_upper_deg)})"
        )
    lines += [
        f"{s.kind}: natural angle {_f(s.mean_deg)} deg, within {_f(s.within_deg)}, between people "
        f"{_f(s.between_deg)}"
        for s in document.spread
    ]
    lines += [f"not computed: {n.predictor}: {n.reason}" for n in document.not_computed]
    lines += [f"not used: {f.item}: {f.status}" for f in document.failed]
    return "\n".join(lines)


def rows(table: "pd.DataFrame", kind: type[Row]) -> list[Row]:
    """Turn a table into records; what is missing is null."""
    keys = kind.__struct_fields__
    if not len(table):
        return []
    records: list[dict[str, Any]] = table.to_dict("records")  # pyright: ignore[reportAssignmentType]
    return [kind(**{k: _plain(row[k]) for k in keys}) for row in records]


def _plain(value: Any) -> Any:
    return None if value is None or value != value else value


def _f(value: Number) -> str:
    return "  -" if value is None else f"{value:5.1f}"
