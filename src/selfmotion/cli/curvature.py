"""`selfmotion curvature`: how far paths veer from the straight line, and to which side.

Measures and tests are those of [Tommasino2017], doi 10.3389/fnbot.2017.00065.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import typer

from selfmotion.cli.curvature_tests import (
    CurvedMovement,
    DirectionTest,
    Loop,
    direction_tests,
    loops,
    marked,
)
from selfmotion.cli.options import Jobs, Json, Out, Quiet, Report, Resume, Scheduler, StudyFile
from selfmotion.cli.output import Contract, Document, Part, finish, save
from selfmotion.cli.recordings import (
    AngleUnit,
    ArmName,
    Cutoff,
    Forward,
    IdleSeed,
    Inputs,
    LengthUnit,
    Rate,
    Stated,
    TaskName,
    UnreadFile,
    Up,
    find_files,
    reason,
)
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.provenance import Provenance, hash_file
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.batch import Outcome
    from selfmotion.cli.batches import BatchChoices
    from selfmotion.studies.curved_paths import CurveJob, ReadAs

Line: TypeAlias = Literal["movement", "center-out"]


class CurvatureDocument(Document, frozen=True, tag="selfmotion/curvature/1", kw_only=True):
    """Curvature of every movement, hysteresis of each pair out and back, tests by direction.

    `unread` are files of a folder that could not be read.
    """

    line: str
    movements: list[CurvedMovement]
    hysteresis: list[Loop]
    tests: list[DirectionTest]
    unread: list[UnreadFile]


CONTRACT = Contract(
    CurvatureDocument, ("curvature", "examples/reach.csv", "--arm", "exoskeleton", "--json")
)


def curvature(
    inputs: Inputs,
    arm: ArmName = None,
    task: TaskName = None,
    cutoff: Cutoff = None,
    line: Annotated[
        Line,
        typer.Option(
            "--line",
            help="movement: from onset to offset. center-out: between the targets of that "
            "experiment, by the labels target (E, NE, ...) and condition (outbound, inbound).",
        ),
    ] = "movement",
    pair: Annotated[
        str,
        typer.Option(
            "--pair",
            metavar="OUT,BACK",
            help="Conditions whose movements make a loop to a target and back, for hysteresis.",
        ),
    ] = "outbound,inbound",
    length_unit: LengthUnit = None,
    angle_unit: AngleUnit = None,
    rate: Rate = None,
    up: Up = None,
    forward: Forward = None,
    study_file: StudyFile = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    seed: IdleSeed = 0,
    quiet: Quiet = False,
    json: Json = False,
    out: Out = None,
    report: Report = None,
) -> int:
    """Measure how far paths veer from straight lines, and to which side."""
    from selfmotion.cli.batches import BatchChoices
    from selfmotion.studies.curved_paths import ReadAs

    stated = Stated(length_unit, angle_unit, rate, up, forward)
    ways = typed_pair(pair)
    read = ReadAs(arm, task, cutoff, angle_unit, length_unit, rate, stated.frame())
    todo = jobs_of(inputs, read, line, study_file)
    batch = BatchChoices("curvature", out, jobs, scheduler, resume, quiet)
    rows, unread = run(todo, inputs, batch)
    found = marked([as_movement(row) for row in rows])
    choices = {"arm": arm, "task": task, "cutoff": cutoff, "line": line, "pair": list(ways)}
    choices |= stated.choices()
    document = CurvatureDocument(
        provenance=Provenance(
            "curvature",
            inputs={str(job.path): hash_file(job.path) for job in todo},
            choices={k: v for k, v in choices.items() if v is not None},
        ),
        line=line,
        movements=found,
        hysteresis=loops(found, ways),
        tests=direction_tests(found, ways),
        unread=unread,
    )
    written = [] if out is None else [save(document, out, "curvature"), *save_tables(document, out)]
    if report is not None:
        from selfmotion.report.curvature_page import write_curvature_report

        paths = [row["path"] for row in rows]
        tables = (table(found), table(document.hysteresis), table(document.tests))
        bad = [f"{one.file}: not read: {one.status}" for one in unread]
        made = document.provenance
        written.append(write_curvature_report(report, paths, tables, made, unread=bad))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    failed = sum(m.failed for m in found) + len(unread)
    return finish(document, text, json=json, failed=failed)


def typed_pair(text: str) -> tuple[str, str]:
    """Read the two conditions of a loop.

    Raises:
        RangeError: not two different words.
    """
    words = [word.strip() for word in text.split(",")]
    if len(words) != 2 or not all(words) or words[0] == words[1]:
        raise RangeError(f"--pair {text!r}: two conditions are needed, as in outbound,inbound")
    return words[0], words[1]


def jobs_of(
    inputs: list[Path], read: "ReadAs", line: Line, study_file: Path | None
) -> "list[CurveJob]":
    """List the files to measure; a study file's pattern gives them labels.

    Raises:
        SelfmotionError: a path does not exist, or a folder holds nothing that fits.
    """
    from selfmotion.studies.curved_paths import CurveJob

    if study_file is None:
        return [CurveJob(path, read, line) for path in find_files(inputs)]
    from selfmotion.studies.study_file import find_trials, load_study_file

    trials = find_trials(load_study_file(study_file), inputs)
    return [CurveJob(trial.path, read, line, trial.labels) for trial in trials]


def run(
    todo: "list[CurveJob]", inputs: list[Path], batch: "BatchChoices"
) -> tuple[list[dict[str, Any]], list[UnreadFile]]:
    """Measure all files; of a folder, one that cannot be read is left out with its reason.

    Raises:
        FileFormatError: a file that was named, or every file, cannot be read.
    """
    import warnings

    from selfmotion.batch import Item
    from selfmotion.cli.batches import fingerprint, run_items
    from selfmotion.studies.curved_paths import measure_file

    items = [Item(str(j.path), j, fingerprint(hash_file(j.path), j)) for j in todo]
    outcomes = run_items(measure_file, items, batch)
    rows: list[dict[str, Any]] = []
    unread: list[UnreadFile] = []
    for job, outcome in zip(todo, outcomes, strict=True):
        if outcome.result is not None:
            rows += outcome.result["movements"]
            for sentence in outcome.result["warnings"]:
                warnings.warn(sentence, stacklevel=2)
            continue
        if job.path in inputs or not any(o.status.ok for o in outcomes):
            raise refusal(outcome)
        error = FileFormatError(outcome.status.sentence)
        unread.append(UnreadFile(str(job.path), reason(error, job.path)))
    return rows, unread


def refusal(outcome: "Outcome") -> Exception:
    """Give the exception for a file that could not be read; a defect stays one."""
    sentence = outcome.status.sentence
    if sentence.startswith("internal error"):
        return RuntimeError(sentence)
    return FileFormatError(sentence)


def as_movement(row: dict[str, Any]) -> CurvedMovement:
    """Give the record of one movement."""
    from selfmotion.studies.curved_paths import MEASURED

    values = {k: v for k, v in row.items() if k != "path"}
    return CurvedMovement(**values, stands_apart=False, failed=row["status"] != MEASURED)


def table(rows: Sequence[Part]) -> Any:
    """Give records as a data frame."""
    import pandas as pd
    from msgspec.structs import asdict

    return pd.DataFrame([asdict(row) for row in rows])


def save_tables(document: CurvatureDocument, folder: Path) -> list[Path]:
    """Write curvature.csv, a row a movement, hysteresis.csv, a row a pair, and tests.csv."""
    parts = {"curvature.csv": document.movements, "hysteresis.csv": document.hysteresis}
    return [
        write_whole(folder / name, table(rows).to_csv(index=False))
        for name, rows in {**parts, "tests.csv": document.tests}.items()
    ]


def as_text(document: CurvatureDocument) -> str:
    """Write movements and tests as a person reads them."""
    width = max(len("movement"), *(len(m.name) for m in document.movements))
    lines = [f"{'movement':{width}}    A_sum    A_net"]
    for m in document.movements:
        if m.a_sum is None or m.a_net is None:
            lines.append(f"{m.name:{width}}  {m.status}")
            continue
        apart = "  stands apart" if m.stands_apart else ""
        lines.append(f"{m.name:{width}} {m.a_sum:8.4f} {m.a_net:8.4f}{apart}")
    lines += [f"{bad.file}: not read: {bad.status}" for bad in document.unread]
    verdicts = {"a_net": ("mean A_net", "veers", "no veer shown")}
    verdicts["hysteresis"] = ("mean hysteresis", "the ways differ", "no difference shown")
    for test in document.tests:
        if test.measure not in verdicts:
            continue
        what, yes, no = verdicts[test.measure]
        known = (test.subject, test.side, test.condition, test.target)
        who = ", ".join(v for v in known if v) or "all"
        p = "?" if test.p_corrected is None else f"{test.p_corrected:.2g}"
        verdict = yes if test.differs else no
        lines.append(f"{who}: {what} {test.mean:.4f} of {test.n}, p = {p}, {verdict}")
    return "\n".join(lines)
