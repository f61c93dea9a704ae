"""`selfmotion workspace`: where the hand can reach, and what limits take away."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.batches import BatchChoices
from selfmotion.cli.body import BodyChoice, body_choice
from selfmotion.cli.models import Limits
from selfmotion.cli.options import (
    Jobs,
    Json,
    Out,
    Quiet,
    Report,
    Resume,
    Scheduler,
    Seed,
    threads_for,
)
from selfmotion.cli.output import Contract, finish, save
from selfmotion.cli.subject import Subject, read_subject
from selfmotion.cli.subject_arms import PersonArms, RangeFiles, SideName, Typed, person_arms
from selfmotion.cli.subject_toml import subject_toml
from selfmotion.cli.workspace_details import details_of
from selfmotion.cli.workspace_document import WorkspaceDocument, as_text, document_of, taken_off
from selfmotion.cli.workspace_extras import ExtraChoices, Extras, extras_of
from selfmotion.cli.workspace_held import CircleText, HeldChoices, HoldText
from selfmotion.cli.workspace_mapping import MapEnvelope, MapPoints, MapTo
from selfmotion.cli.workspace_maps import MapNames, MapStep
from selfmotion.errors import RangeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.methods.workspace import Workspace

# Heights of slices (m above the model's origin) where none are named.
HEIGHTS = (-0.4, -0.2, 0.0, 0.2, 0.4)


CONTRACT = Contract(
    WorkspaceDocument,
    (
        "workspace", "--limit", "elbow_flexion=64.2:114", "--compare", "--points", "256",
        "--shifts", "2", "--slice", "0", "--json",
    ),
)  # fmt: skip


def workspace(
    arm: Annotated[str, typer.Option("--arm", metavar="NAME|FILE", help="The arm.")] = "upper_limb",
    subject: Annotated[
        Path | None,
        typer.Option("--subject", metavar="FILE.toml", help="Lengths, ranges, impairments, body."),
    ] = None,
    side: SideName = None,
    limit: Limits = None,
    ranges: RangeFiles = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Also the free arm, and what the limits take away.")
    ] = False,
    recording: Annotated[
        Path | None,
        typer.Option(
            "--recording",
            metavar="FILE|DIR",
            help="Compare recorded hand positions: how deep inside, how far outside.",
        ),
    ] = None,
    slices: Annotated[
        list[float] | None,
        typer.Option("--slice", metavar="Z", help="Height of a slice (m); repeatable."),
    ] = None,
    points: Annotated[
        int,
        typer.Option(
            "--points", metavar="N", help="Points of one shift; more make errors smaller."
        ),
    ] = 8192,
    shifts: Annotated[
        int,
        typer.Option(
            "--shifts", metavar="N", help="Independent shifts that give the standard error."
        ),
    ] = 8,
    body: BodyChoice = None,
    arm_outside: Annotated[
        bool,
        typer.Option(
            "--arm-outside",
            help="Count a place only where a posture was found whose upper arm and forearm keep "
            "out of the body, too.",
        ),
    ] = False,
    maps: MapNames = None,
    map_step: MapStep = None,
    hold: HoldText = None,
    circle: CircleText = None,
    map_to: MapTo = None,
    map_points: MapPoints = None,
    envelope: MapEnvelope = "outermost",
    details: Annotated[
        bool,
        typer.Option("--details", help="Also named regions and what bounds; on with --report."),
    ] = False,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    quiet: Quiet = False,
    seed: Seed = 0,
) -> int:
    """Find where the hand can reach, and what limits take away."""
    import numpy as np

    from selfmotion.methods.workspace import WorkspaceOptions
    from selfmotion.methods.workspace import workspace as find_workspace

    extra = ExtraChoices(
        arm,
        (maps, map_step),
        HeldChoices.of(hold, circle),
        recording,
        (map_to, map_points),
        envelope,
        BatchChoices("workspace", out, jobs, scheduler, resume, quiet),
        seed,
    )
    if report is not None and report.is_dir():
        raise RangeError(f"--report {report}: a folder stands where the file should go")
    typed = Typed(arm, side, tuple(limit or ()), tuple(ranges or ()), body)
    person = person_arms(Subject() if subject is None else read_subject(subject), subject, typed)
    if compare and person.limited is None:
        raise RangeError(
            "--compare: name the limits with --limit or --ranges, or impairments in --subject"
        )
    if arm_outside and person.body is None:
        raise RangeError("--arm-outside: name the body with --body, or in --subject")
    options = WorkspaceOptions(n_points=points, shifts=shifts, threads=threads_for(jobs))
    # Without --compare the limited arm alone is looked at, under its own name.
    alone = None if compare else person.limited
    space = find_workspace(
        alone or person.free,
        limited=person.limited if compare else None,
        heights=list(HEIGHTS) if slices is None else slices,
        blocked=None if person.body is None else person.body.inside,
        options=options,
        rng=np.random.default_rng(seed),
    )
    taken = None
    if arm_outside and person.body is not None:
        from selfmotion.methods.reaching.clear_arm import clear_of_body

        space, hand = clear_of_body(space, person.body), space
        taken = taken_off(hand, space, "free" if alone is None else "limited")
    space = replace(space, provenance=provenance_of(space, (seed, person.posture), subject))
    name = "free" if alone is None else "limited"
    found = None
    if details or report is not None:
        from selfmotion.methods.reaching.details import workspace_details

        chosen = (person.regions, person.body, person.stature)
        draw = np.random.default_rng(seed)
        found = workspace_details(space, *chosen, arm_outside=arm_outside, rng=draw)
    told = None if found is None else details_of(found, name)
    document = document_of(space, name, person, told, taken)
    extras = extras_of(space, name, person, extra)
    document = with_extras(document, extras)
    written = [] if out is None else save_all(document, space, person, out)
    if out is not None:
        written += extras.save(out)
    if report is not None and found is not None:
        from selfmotion.report.workspace_page import write_workspace_report
        from selfmotion.report.workspace_tables import PagePerson

        shown = PagePerson(
            person.name,
            person.side,
            person.posture,
            person.measured,
            person.body,
            alone is not None,
            person.stature,
            arm_outside,
        )
        written.append(
            write_workspace_report(report, space, shown, found, more=extras.sections(space))
        )
    lines = [as_text(document), *extras.text(), *(f"wrote {path}" for path in written)]
    return finish(document, "\n".join(lines), json=json, failed=extras.items_failed)


def with_extras(document: WorkspaceDocument, extras: Extras) -> WorkspaceDocument:
    """Add maps, reach with the hand held, recordings and a mapping to the document."""
    import msgspec

    return msgspec.structs.replace(document, **extras.parts())


def provenance_of(space: "Workspace", chosen: tuple[int, str], subject: Path | None) -> Provenance:
    """Add seed, body and subject to where a workspace comes from."""
    from selfmotion.provenance import hash_file

    files = {} if subject is None else {"subject": hash_file(subject)}
    seed, body = chosen
    return replace(
        space.provenance,
        seed=seed,
        inputs={**space.provenance.inputs, **files},
        choices={**space.provenance.choices, **body_choice(body)},
    )


def save_all(
    document: WorkspaceDocument, space: "Workspace", person: PersonArms, folder: Path
) -> list[Path]:
    """Write workspace.json, workspace.csv (volumes), slices.csv and subject.toml."""
    tables = {"workspace.csv": space.to_frame(), "slices.csv": space.slices_frame()}
    return [
        save(document, folder, "workspace"),
        *(write_whole(folder / name, t.to_csv(index=False)) for name, t in tables.items()),
        write_whole(folder / "subject.toml", subject_toml(person)),
    ]
