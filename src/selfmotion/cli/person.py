"""`selfmotion person`: one person through all four methods."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from selfmotion.cli.options import Jobs, Json, Out, Quiet, Report, StudyFile, threads_for
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers, save
from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.studies.one_person import OnePerson
    from selfmotion.studies.study_file import StudyFile as Settings
    from selfmotion.studies.trial_run import PersonTrials


class SplintEffect(Part, frozen=True, kw_only=True):
    """What a splinted elbow changes; ranges are means over movements (rad)."""

    path_kept: Number
    compensation: list[str]
    range_before: list[Number]
    range_after: list[Number]
    weights_before: list[Number]
    weights_after: list[Number]


class PlanError(Part, frozen=True, kw_only=True):
    """Planned beside recorded movements: means over the movements of a task."""

    task: str
    model: str
    path_mm: Number
    posture_deg: Number
    swivel_deg: Number


class PostureError(Part, frozen=True, kw_only=True):
    """Mean size of the error of the predicted swivel angle (degrees)."""

    task: str
    moment: str
    natural_deg: Number
    effort_deg: Number
    bounded_deg: Number


class Missing(Part, frozen=True, kw_only=True):
    """What could not be had, and why."""

    what: str
    status: str


class ArmOfPerson(Part, frozen=True, kw_only=True):
    """One arm of one person; angles in radians where the name does not say degrees."""

    subject: str
    side: str
    movements: int
    lengths_m: dict[str, Number]
    joints: list[str]
    weights: list[Number]
    weights_status: str
    law_joints: list[str]
    stiffness: list[list[Number]]
    rest: list[Number]
    thickness_deg: Number
    ranges: dict[str, tuple[Number, Number]]
    volume_m3: dict[str, Number]
    plans: list[PlanError]
    postures: list[PostureError]
    splint: SplintEffect | None
    missing: list[Missing]
    status: str


class PersonDocument(Document, frozen=True, tag="selfmotion/person/1", kw_only=True):
    """The arms that were asked for."""

    arms: list[ArmOfPerson]
    failed: list[Missing]
    files: list[str]


CONTRACT = Contract(
    PersonDocument,
    ("person", "examples/people", "--study", "examples/people/study.toml")
    + ("--subject", "P1", "--json"),
)


def person(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR", help="Folders of recordings.")],
    study: StudyFile = None,
    subject: Annotated[
        str | None, typer.Option(metavar="NAME", help="Who; left out: everybody in the folders.")
    ] = None,
    side: Annotated[
        Literal["right", "left"] | None, typer.Option(help="Which arm; left out: both.")
    ] = None,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Jobs = 1,
    quiet: Quiet = False,
) -> int:
    """Run all four methods on one person's recordings, and what follows."""
    from selfmotion.cli.progress import stages

    if study is None:
        raise RangeError("--study is missing: a file that says whose recording is which")
    threads = threads_for(jobs)
    if out is not None:  # what cannot be written is said before minutes of work
        out.mkdir(parents=True, exist_ok=True)
    with stages(quiet=quiet) as tell:
        tell("reading what the folders hold")
        plans, settings = arms_of(folders, study, subject, side)
        if report is not None and len(plans) > 1:
            names = ", ".join(f"{p.subject} {p.side}" for p in plans)
            raise RangeError(
                f"--report is about one arm, and there are {len(plans)} ({names}); choose with "
                "--subject and --side, or write all of them with --out"
            )
        found, failed = analyse(plans, settings, threads, tell)
    arms = [as_part(one) for one in found]
    files = write_reports(found, out, report)
    document = PersonDocument(
        provenance=Provenance("person", choices={"study": str(study)}),
        arms=arms,
        failed=failed,
        files=[str(path) for path in files],
    )
    if out is not None:
        files.append(save(document, out, "person"))
    troubled = len(failed) + sum(bool(arm.missing) for arm in arms)
    return finish(document, as_text(document), json=json, failed=troubled)


def arms_of(
    folders: list[Path], study: Path, subject: str | None, side: str | None
) -> "tuple[list[PersonTrials], Settings]":
    """Read the study file; give the arms that were asked for.

    Raises:
        SelfmotionError: the study file names no static trial, or there is no such arm.
    """
    from selfmotion.studies.study_file import find_trials, load_study_file
    from selfmotion.studies.trial_run import plan_people

    settings = load_study_file(study)
    if not settings.static:
        raise RangeError(f"{study}: names no static trial; a person needs marker files")
    return chosen(plan_people(find_trials(settings, folders)), subject, side), settings


def analyse(
    plans: "list[PersonTrials]", settings: "Settings", threads: int, tell: Callable[[str], None]
) -> "tuple[list[OnePerson], list[Missing]]":
    """Run all methods on each arm; give also those that failed, with the reason."""
    from selfmotion.studies.one_person import analyse_one
    from selfmotion.studies.people import load_person

    found: list[OnePerson] = []
    failed: list[Missing] = []
    for i, plan in enumerate(plans):
        name = f"{plan.subject} {plan.side}"
        lead = name if len(plans) == 1 else f"{name} ({i + 1} of {len(plans)} arms)"

        def on_stage(sentence: str, lead: str = lead) -> None:
            tell(f"{lead}: {sentence}")

        try:
            person = load_person(plan, settings, on_stage=on_stage)
            found.append(analyse_one(person, threads=threads, on_stage=on_stage))
        except SelfmotionError as error:
            failed.append(Missing(what=name, status=str(error)))
    return found, failed


def chosen(
    plans: "Sequence[PersonTrials]", subject: str | None, side: str | None
) -> "list[PersonTrials]":
    """Give the arms that were asked for.

    Raises:
        RangeError: there are none.
    """
    kept = [p for p in plans if subject in (None, p.subject) and side in (None, p.side)]
    if not kept:
        known = ", ".join(f"{p.subject} {p.side}" for p in plans)
        asked = " ".join(word for word in (subject, side) if word)
        raise RangeError(f"{asked}: no such arm in the recordings; there are {known}")
    return kept


def write_reports(found: list["OnePerson"], out: Path | None, report: Path | None) -> list[Path]:
    """Write reports and tables."""
    from selfmotion.report.person_page import write_person_report

    files = []
    if report is not None and found:
        files.append(write_person_report(report, found[0]))
    for one in found if out is not None else ():
        assert out is not None
        stem = f"{one.person.subject}_{one.person.side}"
        files.append(write_person_report(out / f"{stem}.html", one))
        for name in ("capture", "shares", "surfaces", "plans", "postures"):
            table = getattr(one, name)
            files.append(write_whole(out / f"{stem}_{name}.csv", table.to_csv(index=False)))
    return files


def as_part(one: "OnePerson") -> ArmOfPerson:
    """Put one arm into the document."""
    from selfmotion.studies.donders_postures import LAW_JOINTS

    law, weights, change = one.law, one.weights, one.change
    volumes = {}
    for name, space in (("used", one.reach), ("splint", one.splinted)):
        if space is not None:
            volumes |= {"free": space.regions["free"].volume}
            volumes |= {name: space.regions["limited"].volume}
    return ArmOfPerson(
        subject=one.person.subject,
        side=one.person.side,
        movements=len(one.person.movements),
        lengths_m=dict(one.person.person.lengths),
        joints=list(one.person.person.arm.joints),
        weights=[] if weights is None else numbers(weights.weights),
        weights_status="not computed" if weights is None else str(weights.status),
        law_joints=[] if law is None else list(LAW_JOINTS),
        stiffness=[] if law is None else numbers(law.stiffness),
        rest=[] if law is None else numbers(law.rest),
        thickness_deg=None if law is None else law.thickness_deg,
        ranges={k: (r.low, r.high) for k, r in one.ranges.items()},
        volume_m3=volumes,
        plans=plan_errors(one),
        postures=posture_errors(one),
        splint=None
        if change is None
        else SplintEffect(
            path_kept=change.reached,
            compensation=list(change.compensation),
            range_before=numbers(change.excursion_before),
            range_after=numbers(change.excursion_after),
            weights_before=[] if change.before is None else numbers(change.before.weights),
            weights_after=[] if change.after is None else numbers(change.after.weights),
        ),
        missing=[Missing(what=what, status=why) for what, why in one.missing],
        status="all parts computed" if not one.missing else f"{len(one.missing)} missing",
    )


def plan_errors(one: "OnePerson") -> list[PlanError]:
    """Average the plans of each task and model."""
    from selfmotion.studies.people_means import means_by

    if not len(one.plans):
        return []
    columns = ["apart_mm", "posture_error_deg", "swivel_error_deg"]
    means = means_by(one.plans, ["task", "model"], columns)
    return [
        PlanError(task=task, model=model, path_mm=a, posture_deg=b, swivel_deg=c)
        for task, model, a, b, c in means.itertuples(index=False, name=None)
    ]


def posture_errors(one: "OnePerson") -> list[PostureError]:
    """Average the sizes of the errors of each task and moment."""
    from selfmotion.studies.one_person import sizes_of_errors
    from selfmotion.studies.people_means import means_by

    if not len(one.postures):
        return []
    means = means_by(
        sizes_of_errors(one.postures), ["task", "moment"], ["natural_deg", "effort", "bounded"]
    )
    return [
        PostureError(task=task, moment=moment, natural_deg=a, effort_deg=b, bounded_deg=c)
        for task, moment, a, b, c in means.itertuples(index=False, name=None)
    ]


def as_text(document: PersonDocument) -> str:
    """Write it as a person reads it."""
    lines = []
    for arm in document.arms:
        lines.append(f"{arm.subject}, {arm.side} arm: {arm.movements} movements, {arm.status}")
        lines.append(f"  weights: {arm.weights_status}")
        known = [(w, j) for w, j in zip(arm.weights, arm.joints, strict=False) if w is not None]
        if known:
            order = ", ".join(f"{j.replace('_', ' ')} {w:.2f}" for w, j in sorted(known)[::-1])
            lines.append(f"  spared most to least: {order}")
        if arm.thickness_deg is not None:
            lines.append(f"  one law of posture holds within {arm.thickness_deg:.1f} deg")
        volumes = ", ".join(f"{k} {1e3 * (v or 0):.0f}" for k, v in arm.volume_m3.items())
        lines.append(f"  workspace (litres): {volumes}")
        if arm.splint is not None:
            kept = arm.splint.path_kept
            named = ", ".join(j.replace("_", " ") for j in arm.splint.compensation) or "nothing"
            lines.append(
                f"  splinted elbow: {0 if kept is None else kept:.0%} of the paths kept; "
                f"moving more: {named}"
            )
        lines += [f"  missing: {m.what}: {m.status}" for m in arm.missing]
    lines += [f"failed: {f.what}: {f.status}" for f in document.failed]
    lines += [f"wrote {name}" for name in document.files]
    return "\n".join(lines)
