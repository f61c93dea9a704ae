"""`selfmotion weights DIR --study FILE.toml`: a whole study, from its files to its statistics."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from selfmotion.cli.batches import BatchChoices
from selfmotion.cli.output import Contract, Document, Number, Part, finish, save
from selfmotion.errors import RangeError
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.studies.study_run import StudyRun

TABLES = ("trials", "groups", "weights", "tests", "changes", "swivel")
OVER_PEOPLE = ("swivel", "people", "joints", "quality")


class StudyWeight(Part, frozen=True, kw_only=True):
    """One joint of one person on one side in one condition; null: not identified (see reason).

    The condition `all conditions` is that of all of the person's movements together.
    """

    subject: str
    side: str
    condition: str
    joint: str
    weight: Number
    lower: Number
    upper: Number
    stderr_log: Number
    contribution: Number
    reason: str


class StudyGroup(Part, frozen=True, kw_only=True):
    """One person on one side in one condition."""

    subject: str
    side: str
    condition: str
    trials: int
    task_share: Number
    task_share_identity: Number
    task_share_others: Number
    unexplained: Number
    synergy: Number
    synergy_z: Number
    status: str


class StudyTest(Part, frozen=True, kw_only=True):
    """One comparison within people; without a test the sentence says why."""

    comparison: str
    level: str
    people: int
    sentence: str


class SwivelSpread(Part, frozen=True, kw_only=True):
    """Swivel angle at one moment (degrees), with its spread within and between people.

    `within`: standard deviation over a person's repeats, pooled; `between`: of people's means.
    `selection`: all movements, or those whose elbow is far enough off the line from shoulder to
    wrist.
    """

    side: str
    condition: str
    moment: str
    selection: str
    people: int
    movements: int
    mean_deg: Number
    within_deg: Number
    within_lower_deg: Number
    within_upper_deg: Number
    within_median_deg: Number
    between_deg: Number
    between_lower_deg: Number
    between_upper_deg: Number


class PeopleMean(Part, frozen=True, kw_only=True):
    """Mean over people of a share or of the synergy index, with its 95 % interval."""

    side: str
    condition: str
    what: str
    people: int
    mean: Number
    sd: Number
    lower: Number
    upper: Number


class JointMean(Part, frozen=True, kw_only=True):
    """Geometric mean over people of a joint's weight, largest = 1, all conditions together."""

    side: str
    joint: str
    weight: Number
    lower: Number
    upper: Number
    lowest: Number
    highest: Number
    people: int
    of: int


class FailedFile(Part, frozen=True, kw_only=True):
    """A file that could not be used."""

    file: str
    status: str


class StudyDocument(Document, frozen=True, tag="selfmotion/weights-study/1", kw_only=True):
    """What came of a study; the tables in the --out folder hold more columns."""

    n_files: int
    failed: list[FailedFile]
    weights: list[StudyWeight]
    groups: list[StudyGroup]
    tests: list[StudyTest]
    swivel: list[SwivelSpread]
    people: list[PeopleMean]
    joints: list[JointMean]


CONTRACT = Contract(
    StudyDocument,
    (
        "weights",
        "examples/study",
        "--study",
        "examples/study/study.toml",
        "--arm",
        "exoskeleton",
        "--json",
    ),
)


@dataclass(frozen=True)
class StudyChoices:
    """What the command line asks of a study.

    Attributes:
        study: the study file.
        arm: name or model file.
        method: estimator.
        seed: of the sign flips.
        batch: where it runs.
        report: HTML file to write.
        json: whether to print the document.
    """

    study: Path
    arm: str | None
    method: Literal["ml", "paper", "feedback"]
    seed: int
    batch: BatchChoices
    report: Path | None
    json: bool


def weigh_study(folders: list[Path], choices: StudyChoices) -> int:
    """Run a study and print or write what came of it."""
    from selfmotion.batch import Runner
    from selfmotion.cli.progress import progress
    from selfmotion.studies.study_file import find_trials, load_study_file, unused_moments
    from selfmotion.studies.study_run import StudyPlan, run_study

    if choices.arm is None:
        raise RangeError("--study: name the arm that moved, as in --arm upper_limb_anatomical")
    if choices.report is not None and choices.report.is_dir():
        raise RangeError(f"--report {choices.report}: a folder stands where the file should go")
    study = load_study_file(choices.study)
    plan = StudyPlan(
        tuple(folders), study, choices.arm, choices.method, choices.batch.out, choices.seed
    )
    trials = find_trials(study, plan.folders)
    for sentence in unused_moments(study, trials):
        warnings.warn(sentence, stacklevel=2)
    where = choices.batch
    with progress(len(trials), "trials", quiet=where.quiet) as done:
        runner = Runner(jobs=where.jobs, scheduler=where.scheduler, resume=where.resume)
        run = run_study(plan, runner, on_start=lambda _: done)
    document = as_document(run)
    written = []
    if where.out is not None:
        written = [save(document, where.out, "weights-study")]
        for name in TABLES:
            text = getattr(run, name).to_csv(index=False)
            written.append(write_whole(where.out / f"{name}.csv", text))
        for name in OVER_PEOPLE:
            text = getattr(run.summary, name).to_csv(index=False)
            written.append(write_whole(where.out / f"over_people_{name}.csv", text))
        from selfmotion.report.study_page import write_pictures

        written += write_pictures(run, where.out / "figures")
    if choices.report is not None:
        from selfmotion.report.study_page import write_study_report

        written.append(write_study_report(choices.report, run))
    text = "\n".join([as_text(run), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=choices.json, failed=run.n_failed)


def as_document(run: "StudyRun") -> StudyDocument:
    """Give a study as its JSON document."""
    bad = run.trials.loc[~run.trials["ok"].astype(bool)]
    return StudyDocument(
        provenance=run.provenance,
        n_files=len(run.trials),
        failed=[FailedFile(**row) for row in _rows(bad, FailedFile)],
        weights=[StudyWeight(**row) for row in _rows(run.weights, StudyWeight)],
        groups=[StudyGroup(**row) for row in _rows(run.groups, StudyGroup)],
        tests=[StudyTest(**row) for row in _rows(run.tests, StudyTest)],
        swivel=[SwivelSpread(**row) for row in _rows(run.summary.swivel, SwivelSpread)],
        people=[PeopleMean(**row) for row in _rows(run.summary.people, PeopleMean)],
        joints=[JointMean(**row) for row in _rows(run.summary.joints, JointMean)],
    )


def as_text(run: "StudyRun") -> str:
    """Write a study as a person reads it."""
    from selfmotion.studies.study_statistics import comparison_lines

    bad = run.trials.loc[~run.trials["ok"].astype(bool)]
    lines = [f"{len(run.trials)} files, {len(bad)} of them could not be used"]
    lines += [f"  {row['file']}: {row['status']}" for row in bad.to_dict("records")]
    lines.append("person  side  condition: task share (all weights alike), synergy; status")
    lines += [
        f"{g['subject']}  {g['side']}  {g['condition']}: {g['task_share']:.2f} "
        f"({g['task_share_identity']:.2f}), {g['synergy']:.2f}; {g['status']}"
        for g in run.groups.to_dict("records")
    ]
    lines += [
        f"swivel angle, {s['side']} {s['condition']}, {s['moment'].replace('_', ' ')} "
        f"({s['selection']}): {s['mean_deg']:.0f} deg, within people {_or_dash(s['within_deg'])}, "
        f"between {_or_dash(s['between_deg'])} ({s['people']} "
        f"{'person' if s['people'] == 1 else 'people'})"
        for s in run.summary.swivel.to_dict("records")
        if s["moment"] not in ("start", "end")
    ]
    lines += comparison_lines(run.tests)
    return "\n".join(lines)


def _or_dash(value: float) -> str:
    """Write a number; a dash where it is not known."""
    return "-" if value != value else f"{value:.1f}"


def _rows(table: "pd.DataFrame", kind: type[Part]) -> list[dict[str, Any]]:
    """Give a table's rows with the keys of a record; what is missing is null."""
    keys = kind.__struct_fields__
    if not len(table):
        return []
    rows = table.to_dict("records")
    return [{k: None if row[k] != row[k] else row[k] for k in keys} for row in rows]
