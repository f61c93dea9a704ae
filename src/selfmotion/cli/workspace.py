"""`selfmotion workspace`: where the hand can reach, and what limits take away."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.body import NO_BODY, BodyName, body_choice, body_of
from selfmotion.cli.ik import threads_for
from selfmotion.cli.models import Limits, with_typed_limits
from selfmotion.cli.options import Jobs, Json, Out, Report, Seed
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers, save
from selfmotion.cli.subject import Subject, arms_of, read_subject
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.workspace import Workspace

# Heights of slices (m above the model's origin) where none are named.
HEIGHTS = (-0.4, -0.2, 0.0, 0.2, 0.4)
# Recorded positions that are held against the workspace: at most so many, evenly chosen.
MOST_RECORDED = 5000


class Regions(Part, frozen=True, kw_only=True):
    """A number of the free arm, of the limited arm, and of what the limits take away."""

    free: Number = None
    limited: Number = None
    lost: Number = None


class SliceAreas(Part, frozen=True, kw_only=True):
    """Areas (m²) of a slice 20 mm thick at a height (m), with standard errors."""

    z: float
    area_m2: Regions
    stderr_m2: Regions


class Recorded(Part, frozen=True, kw_only=True):
    """Recorded hand positions against the workspace.

    `inside_percent` of the points are reached; the worst of the others lies `farthest_mm` away.
    """

    points: int
    inside_percent: Regions
    farthest_mm: Regions


class WorkspaceDocument(Document, frozen=True, tag="selfmotion/workspace/1", kw_only=True):
    """Volumes (m³) with standard errors; null what was not asked for. Limits in radians."""

    arm: str
    subject: str
    joints: list[str]
    free_limits: list[list[Number]]
    limited_limits: list[list[Number]] | None
    volume_m3: Regions
    stderr_m3: Regions
    hull_volume_m3: Regions
    slices: list[SliceAreas]
    recording: Recorded | None
    status: str


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


def document_of(
    space: "Workspace", name: str, arms: "tuple[Arm, Arm | None]", person: Subject
) -> WorkspaceDocument:
    """Give the document; `name` is what the workspace calls free."""
    free, limited = arms
    names = {"free": name, "limited": "limited", "lost": "lost"}
    regions = space.regions
    hull = {names[key]: space.hull_volume(key) for key in regions if key != "lost"}
    volume = {names[key]: r.volume for key, r in regions.items()}
    error = {names[key]: r.standard_error for key, r in regions.items()}
    slices = []
    for part in space.slices:
        area = {names[key]: part.area(key) for key in part.regions}
        slices.append(
            SliceAreas(
                z=part.height,
                area_m2=Regions(**{key: a for key, (a, _) in area.items()}),
                stderr_m2=Regions(**{key: e for key, (_, e) in area.items()}),
            )
        )
    return WorkspaceDocument(
        provenance=space.provenance,
        arm=free.name,
        subject=person.name,
        joints=list(free.joints),
        free_limits=ranges_of(free),
        limited_limits=None if limited is None else ranges_of(limited),
        volume_m3=Regions(**volume),
        stderr_m3=Regions(**error),
        hull_volume_m3=Regions(**hull),
        slices=slices,
        recording=None,
        status=space.summary() if name == "free" else "the limited arm alone",
    )


def ranges_of(arm: "Arm") -> list[list[Number]]:
    """Give lower and upper limit of each joint (rad)."""
    import numpy as np

    return numbers(np.stack([arm.lower, arm.upper], axis=1))


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


def recorded_of(space: "Workspace", name: str, path: Path) -> Recorded:
    """Hold recorded positions against the arms of a workspace.

    Raises:
        FileFormatError: the recordings hold neither hand positions nor angles of this arm.
    """
    import numpy as np

    from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
    from selfmotion.methods.reaching.ik_tasks import HandRows

    points = recorded_points(space.arm, path)
    inside, farthest = {}, {}
    arms = {name: space.arm}
    if space.limited_arm is not None:
        arms["limited"] = space.limited_arm
    for key, arm in arms.items():
        task = HandRows(arm, ("x", "y", "z"))
        found = solve_ik(task, points, options=IkOptions(position_tolerance=1e-5))
        inside[key] = 100.0 * float(found.solved.mean())
        farthest[key] = 1e3 * float(np.where(found.solved, 0.0, found.position_error).max())
    return Recorded(
        points=len(points), inside_percent=Regions(**inside), farthest_mm=Regions(**farthest)
    )


def recorded_points(arm: "Arm", path: Path) -> "np.ndarray":
    """Give recorded hand positions (K, 3) in the ground, gaps left out."""
    import numpy as np

    from selfmotion.kinematics.forward import forward_kinematics
    from selfmotion.motion.files import load

    parts = []
    for recording in load(path):
        if recording.x is not None and recording.x.shape[1] == 3:
            x = recording.x
        elif recording.q is not None and set(arm.joints) <= set(recording.joints):
            order = [recording.joints.index(joint) for joint in arm.joints]
            q = recording.q[:, order]
            whole = np.isfinite(q).all(axis=1)
            x = forward_kinematics(arm.chain, q[whole], arm.tip("hand"))[:, :3, 3]
        else:
            raise FileFormatError(
                f"{recording.name}: holds {', '.join(recording.held)}; hand positions x, y, z, or "
                f"the angles of {arm.name} are needed"
            )
        parts.append(x[np.isfinite(x).all(axis=1)])
    points = np.concatenate(parts)
    if not len(points):
        raise FileFormatError(f"{path}: no hand position without gap")
    step = -(-len(points) // MOST_RECORDED)
    return points[::step]


def save_tables(space: "Workspace", folder: Path) -> list[Path]:
    """Write workspace.csv (volumes) and slices.csv."""
    tables = {"workspace.csv": space.to_frame(), "slices.csv": space.slices_frame()}
    return [write_whole(folder / name, t.to_csv(index=False)) for name, t in tables.items()]


def as_text(document: WorkspaceDocument) -> str:
    """Write the workspace as a person reads it, in litres."""
    lines = [f"arm {document.arm}" + (f", {document.subject}" if document.subject else "")]
    for key in ("free", "limited", "lost"):
        value = getattr(document.volume_m3, key)
        if value is None:
            continue
        error, hull = getattr(document.stderr_m3, key), getattr(document.hull_volume_m3, key)
        around = "" if hull is None else f"; hull {1e3 * hull:.1f}"
        lines.append(f"{key:8} {1e3 * value:7.2f} ± {1e3 * (error or 0.0):.2f} litres{around}")
    for part in document.slices:
        areas = ", ".join(
            f"{key} {1e4 * value:.0f}"
            for key in ("free", "limited", "lost")
            if (value := getattr(part.area_m2, key)) is not None
        )
        lines.append(f"slice z = {1e3 * part.z:+.0f} mm: {areas} cm²")
    if document.recording is not None:
        r = document.recording
        inside = (
            r.inside_percent.limited if r.inside_percent.free is None else r.inside_percent.free
        )
        lines.append(f"{inside:.1f} % of {r.points} recorded positions are inside")
    return "\n".join([*lines, document.status])
