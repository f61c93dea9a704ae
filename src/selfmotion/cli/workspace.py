"""`selfmotion workspace`: where the hand can reach, and what limits take away."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.body import NO_BODY, BodyName, body_choice, body_of
from selfmotion.cli.ik import threads_for
from selfmotion.cli.models import Limits, with_typed_limits
from selfmotion.cli.options import Jobs, Json, Out, Report, Seed
from selfmotion.cli.output import Contract, finish, save
from selfmotion.cli.subject import Subject, arms_of, read_subject
from selfmotion.cli.workspace_document import WorkspaceDocument, as_text, document_of
from selfmotion.cli.workspace_recording import recorded_of
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
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
        typer.Option("--subject", metavar="FILE.toml", help="Lengths, ranges, impairments."),
    ] = None,
    limit: Limits = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Also the free arm, and what the limits take away.")
    ] = False,
    recording: Annotated[
        Path | None,
        typer.Option("--recording", metavar="FILE", help="Hold recorded hand positions against."),
    ] = None,
    slices: Annotated[
        list[float] | None,
        typer.Option("--slice", metavar="Z", help="Height of a slice (m); repeatable."),
    ] = None,
    points: Annotated[
        int, typer.Option("--points", help="Points of one shift; more make errors smaller.")
    ] = 8192,
    shifts: Annotated[
        int, typer.Option("--shifts", help="Independent shifts that give the standard error.")
    ] = 8,
    body: BodyName = NO_BODY,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Jobs = 1,
    seed: Seed = 0,
) -> int:
    """Find where the hand can reach, and what limits take away."""
    import numpy as np

    from selfmotion.methods.workspace import WorkspaceOptions
    from selfmotion.methods.workspace import workspace as find_workspace

    person = Subject() if subject is None else read_subject(subject)
    free, limited = person_arms(person, subject, arm, limit)
    if compare and limited is None:
        raise RangeError("--compare: name the limits with --limit, or impairments in --subject")
    options = WorkspaceOptions(n_points=points, shifts=shifts, threads=threads_for(jobs))
    heights = list(HEIGHTS) if slices is None else slices
    # Without --compare the limited arm alone is looked at, under its own name.
    alone = None if compare else limited
    shapes = body_of(body, free)
    space = find_workspace(
        alone or free,
        limited=limited if compare else None,
        heights=heights,
        blocked=None if shapes is None else shapes.inside,
        options=options,
        rng=np.random.default_rng(seed),
    )
    name = "free" if alone is None else "limited"
    document = document_of(space, name, (free, limited), person)
    document = replace_provenance(document, space, (seed, body), subject)
    if recording is not None:
        import msgspec

        recorded = recorded_of(space, name, recording)
        document = msgspec.structs.replace(document, recording=recorded)
    written = [] if out is None else [save(document, out, "workspace"), *save_tables(space, out)]
    if report is not None:
        from selfmotion.report.workspace_page import write_workspace_report

        written.append(write_workspace_report(report, space, person.name))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json)


def person_arms(
    person: Subject, path: Path | None, name: str, limit: list[str] | None
) -> "tuple[Arm, Arm | None]":
    """Give the free arm and, if there are any limits, the limited one.

    Raises:
        SelfmotionError: an arm, joint or limit is not allowed; names the file it stands in.
    """
    try:
        free, limited = arms_of(person, name)
    except (RangeError, ValueError) as error:
        if path is None:
            raise
        raise FileFormatError(f"{path}: {error}") from None
    limited = with_typed_limits(limited, limit)
    return free, limited if limit or person.impairments else None


def replace_provenance(
    document: WorkspaceDocument,
    space: "Workspace",
    chosen: tuple[int, str],
    subject: Path | None,
) -> WorkspaceDocument:
    """Add seed, body and subject to where the result comes from."""
    import msgspec

    from selfmotion.provenance import hash_file

    files = {} if subject is None else {"subject": hash_file(subject)}
    seed, body = chosen
    provenance: Provenance = replace(
        space.provenance,
        seed=seed,
        inputs={**space.provenance.inputs, **files},
        choices={**space.provenance.choices, **body_choice(body)},
    )
    return msgspec.structs.replace(document, provenance=provenance)


def save_tables(space: "Workspace", folder: Path) -> list[Path]:
    """Write workspace.csv (volumes) and slices.csv."""
    tables = {"workspace.csv": space.to_frame(), "slices.csv": space.slices_frame()}
    return [write_whole(folder / name, t.to_csv(index=False)) for name, t in tables.items()]
