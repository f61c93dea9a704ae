"""`selfmotion donders DIR --study FILE.toml`: surfaces, laws and predictions of recorded people."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.output import Document, Number, Part, finish, save
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.studies.donders_people import DondersPeople

TABLES = ("surfaces", "laws", "predictions", "reaches")


class MeanOverPeople(Part, frozen=True, kw_only=True):
    """Mean over people with its 95 % interval; null: too few people."""

    mean: Number
    lower: Number
    upper: Number
    n: int


class Thickness(MeanOverPeople, frozen=True, kw_only=True):
    """Standard deviation (degrees) beside the surface of the other repeats."""

    segment: str
    task: str


class PredictionError(MeanOverPeople, frozen=True, kw_only=True):
    """Root mean square error of the swivel angle (degrees); left_out: repeat, task or nothing."""

    left_out: str
    place: str
    predictor: str


class ReachMeasure(MeanOverPeople, frozen=True, kw_only=True):
    """One measure of planned reaches: apart_mm, bow_mm, a_net, swivel_error_deg, and others."""

    task: str
    model: str
    measure: str


class FailedItem(Part, frozen=True, kw_only=True):
    """A file, person or pose that could not be used."""

    name: str
    status: str


class DondersPeopleDocument(Document, frozen=True, tag="selfmotion/donders-people/1", kw_only=True):
    """What came of the people; the tables in the --out folder hold more."""

    people: list[str]
    thickness: list[Thickness]
    errors: list[PredictionError]
    reaches: list[ReachMeasure]
    failed: list[FailedItem]


@dataclass(frozen=True)
class PeopleChoices:
    """What the command line asks.

    Attributes:
        study: the study file.
        effort: whether to predict by least muscle effort too.
        jobs: people at once.
        quiet: show no progress.
        out: folder for the tables.
        report: HTML file.
        json: whether to print the document.
    """

    study: Path
    effort: bool
    jobs: int
    quiet: bool
    out: Path | None
    report: Path | None
    json: bool


def analyse_people(folders: list[Path], choices: PeopleChoices) -> int:
    """Run the analysis and print or write what came of it."""
    from selfmotion.cli.progress import progress
    from selfmotion.studies.donders_people import donders_people
    from selfmotion.studies.study_file import find_trials, load_study_file
    from selfmotion.studies.trial_run import plan_people

    study = load_study_file(choices.study)
    n_arms = len(plan_people(find_trials(study, folders)))
    with progress(n_arms, "people", quiet=choices.quiet) as done:
        run = donders_people(
            folders, study, effort=choices.effort, jobs=choices.jobs, on_person=done
        )
    document = as_document(run)
    written = []
    if choices.out is not None:
        written = [save(document, choices.out, "donders-people")]
        for name in TABLES:
            text = getattr(run, name).to_csv(index=False)
            written.append(write_whole(choices.out / f"{name}.csv", text))
        from selfmotion.report.donders_page import save_pictures

        written += save_pictures(choices.out, run)
    if choices.report is not None:
        from selfmotion.report.donders_page import write_donders_report

        written.append(write_donders_report(choices.report, run))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=choices.json, failed=len(run.failed))


def as_document(run: "DondersPeople") -> DondersPeopleDocument:
    """Give the run as its JSON document."""
    import pandas as pd

    from selfmotion.studies.donders_people import rms_by_person
    from selfmotion.studies.people_means import by_person
    from selfmotion.studies.reach_measures import MEASURES

    rms = rms_by_person(run.predictions)
    reaches = [pd.DataFrame()]
    if len(run.reaches):
        size = run.reaches.assign(swivel_error_deg=run.reaches["swivel_error_deg"].abs())
        reaches = [by_person(size, m, ["task", "model"]).assign(measure=m) for m in MEASURES]
    return DondersPeopleDocument(
        provenance=run.provenance,
        people=[f"{s.postures.subject}, {s.postures.side}" for s in run.shown],
        thickness=[
            Thickness(**row)
            for row in _records(by_person(run.surfaces, "held_out_deg", ["segment", "task"]))
        ],
        errors=[
            PredictionError(**row)
            for row in _records(by_person(rms, "rms_deg", ["left_out", "place", "predictor"]))
        ],
        reaches=[ReachMeasure(**row) for table in reaches for row in _records(table)],
        failed=[FailedItem(name=name, status=why) for name, why in run.failed],
    )


def _records(table: "pd.DataFrame") -> list[dict]:
    """Give rows with None for what is not known."""
    return [
        {k: None if isinstance(v, float) and v != v else v for k, v in row.items()}
        for row in table.to_dict("records")
    ]


def as_text(document: DondersPeopleDocument) -> str:
    """Write what came of the people as a person reads it."""
    lines = [f"{len(document.people)} arms: {'; '.join(document.people)}"]
    lines.append("thickness of surfaces, repeats held out (deg): mean over people (95 %)")
    lines += [f"  {t.segment:9} {t.task:16} {_span(t)}" for t in document.thickness]
    lines.append("error of the swivel angle, rms (deg)")
    for e in document.errors:
        lines.append(f"  {e.left_out:8} left out, {e.place:8} {e.predictor:18} {_span(e)}")
    if document.reaches:
        lines.append("reaches, planned and recorded")
    for r in document.reaches:
        lines.append(f"  {r.task:16} {r.model:28} {r.measure:18} {_span(r)}")
    lines += [f"not used: {item.name}: {item.status}" for item in document.failed]
    return "\n".join(lines)


def _span(one: MeanOverPeople) -> str:
    known = [one.mean, one.lower, one.upper]
    mean, lower, upper = ("?" if v is None else f"{v:.3g}" for v in known)
    return f"{mean} ({lower} to {upper}; {one.n})"
