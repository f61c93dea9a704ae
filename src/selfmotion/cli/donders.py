"""`selfmotion donders`: the elasticity of a person's joints, from postures alone."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from selfmotion.cli.models import load_any_arm
from selfmotion.cli.options import Jobs, Json, Out, Quiet, Report, StudyFile
from selfmotion.cli.output import (
    Contract,
    Document,
    Matrix,
    Number,
    Part,
    Vector,
    finish,
    numbers,
    save,
)
from selfmotion.cli.recordings import AngleUnit, TaskName
from selfmotion.cli.tables import ANGLE_UNITS, QUATERNION, read_rows, with_unit_quaternions
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.methods.donders import JointElasticity
    from selfmotion.methods.elasticity.orientations import Form
    from selfmotion.methods.elasticity.surface import DondersSurface
    from selfmotion.redundancy.task import Task

TURN_VECTOR = ("rx", "ry", "rz")
MATRIX = tuple(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
# Names of arrays in an .npz, and the form of the postures in them.
ARRAYS: "dict[str, Form]" = {
    "q": "angles",
    "angles": "angles",
    "quaternions": "quaternions",
    "matrices": "matrices",
    "rotation_vectors": "rotation vectors",
}


class Errors(Part, frozen=True, kw_only=True):
    """Standard errors; null where the data determine nothing."""

    stiffness: Matrix
    rest: Vector


class Surface(Part, frozen=True, kw_only=True):
    """The quadratic Donders surface of the hand's rotation vectors: torsion over the others."""

    terms: list[str]
    coefficients: Vector
    stderr: Vector
    thickness_deg: Number


class DondersDocument(Document, frozen=True, tag="selfmotion/donders/1", kw_only=True):
    """The joint law: stiffness (N m/rad, its trace set to 4) and rest posture (rad).

    `thickness_deg` is the standard deviation of postures beside the law's surface, along the
    self-motion. `surface` is null for arms other than the wrist.
    """

    arm: str
    joints: list[str]
    stiffness: Matrix
    rest: Vector
    stderr: Errors
    surface: Surface | None
    thickness_deg: Number
    postures: int
    form: str
    prior: str | None
    sentences: list[str]
    status: str
    failed: bool


CONTRACT = Contract(DondersDocument, ("donders", "examples/wrist_postures.csv", "--json"))


@dataclass(frozen=True, eq=False)
class Postures:
    """Postures of a file: (K, ...) in one of the forms, and the trial of each if known."""

    values: "np.ndarray"
    form: "Form"
    trials: tuple[str, ...] | None = None


def donders(
    postures: Annotated[
        list[Path],
        typer.Argument(
            metavar="POSTURES|DIR",
            help=".csv with columns of joint angles, qx to qw, rx to rz, or r11 to r33; .npz with "
            "q, quaternions, rotation_vectors or matrices. With --study: folders of recordings.",
        ),
    ],
    arm: Annotated[str, typer.Option("--arm", metavar="NAME|FILE", help="The arm.")] = "wrist",
    task: TaskName = None,
    prior: Annotated[
        Path | None,
        typer.Option(
            "--prior",
            metavar="FILE.toml",
            help="What is known beforehand: stiffness, rest, and their _sd.",
        ),
    ] = None,
    axis: Annotated[
        str | None,
        typer.Option(
            "--axis",
            metavar="X,Y,Z",
            help="Orientations of another segment than the hand: its long axis in its own frame. "
            "Only the quadratic surface is fitted.",
        ),
    ] = None,
    angle_unit: AngleUnit = None,
    study: StudyFile = None,
    effort: Annotated[
        bool,
        typer.Option("--effort/--no-effort", help="With --study: least muscle effort beside it."),
    ] = True,
    jobs: Jobs = 1,
    quiet: Quiet = False,
    json: Json = False,
    out: Out = None,
    report: Report = None,
) -> int:
    """Fit the elasticity of a person's joints to postures."""
    if study is not None:
        if angle_unit is not None:
            raise RangeError("--angle-unit: belongs to one file of postures; a study has markers")
        from selfmotion.cli.donders_people import PeopleChoices, analyse_people

        choices = PeopleChoices(study, effort, jobs, quiet, out, report, json)
        return analyse_people(postures, choices)
    file = one_file(postures, report)
    if axis is not None:
        from selfmotion.cli.donders_surface import fit_segment, typed_axis

        if prior is not None:
            raise RangeError("--prior: belongs to the law of an arm; --axis fits a surface only")
        direction = typed_axis(axis)
        given = read_postures(file, (), angle_unit)
        return fit_segment(file, (given.values, given.form), direction, json=json, out=out)
    return fit_file(file, (arm, task, prior), angle_unit=angle_unit, json=json, out=out)


def one_file(postures: list[Path], report: Path | None) -> Path:
    """Give the one file that is meant without --study.

    Raises:
        RangeError: there are several, it is a folder, or a report was asked for.
    """
    if report is not None:
        raise RangeError("--report: comes with --study only; a single fit is text or --json")
    if len(postures) != 1:
        raise RangeError(f"{len(postures)} files of postures: one at a time, or --study FILE.toml")
    if postures[0].is_dir():
        raise RangeError(f"{postures[0]}: a folder of recordings needs --study FILE.toml")
    return postures[0]


def fit_file(
    postures: Path,
    model_of: tuple[str, str | None, Path | None],
    *,
    angle_unit: Literal["rad", "deg"] | None,
    json: bool,
    out: Path | None,
) -> int:
    """Fit the law to the postures of one file; `model_of`: arm, task, prior."""
    from selfmotion.cli.prior import read_prior
    from selfmotion.methods.donders import fit_elasticity
    from selfmotion.redundancy.task import task_for

    arm, task, prior = model_of
    model = load_any_arm(arm)
    goal = task_for(model, task)
    given = read_postures(postures, model.joints, angle_unit)
    known = None if prior is None else read_prior(prior, model.n_joints)
    found = fit_elasticity(
        given.values, task=goal, form=given.form, prior=known, trials=given.trials
    )
    document = DondersDocument(
        provenance=provenance_of(found, postures, prior),
        arm=model.name,
        joints=list(found.joints),
        stiffness=numbers(found.stiffness),
        rest=numbers(found.rest),
        stderr=Errors(stiffness=numbers(found.stiffness_stderr), rest=numbers(found.rest_stderr)),
        surface=surface_record(surface_of(given, goal)),
        thickness_deg=found.thickness_deg,
        postures=len(given.values),
        form=given.form,
        prior=None if known is None else known.source,
        sentences=list(found.sentences),
        status=found.status.sentence,
        failed=not found.status.ok,
    )
    written = [] if out is None else [save(document, out, "donders"), *save_law(found, out)]
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=int(document.failed))


def read_postures(
    path: Path, joints: tuple[str, ...], angle_unit: Literal["rad", "deg"] | None = None
) -> Postures:
    """Read postures in whichever form the file holds.

    Raises:
        SelfmotionError: one line that names file, row or array, value and what is allowed.
    """
    found = _read_any_form(path, joints, angle_unit)
    if angle_unit is not None and found.form in ("quaternions", "matrices"):
        raise RangeError(f"--angle-unit {angle_unit}: {path} holds {found.form}, which have none")
    return found


def _read_any_form(
    path: Path, joints: tuple[str, ...], angle_unit: Literal["rad", "deg"] | None
) -> Postures:
    if path.suffix.lower() == ".npz":
        found = _from_arrays(path)
        scale = ANGLE_UNITS[f"_{angle_unit or 'rad'}"]
        return found if scale == 1.0 else replace(found, values=scale * found.values)
    import numpy as np

    groups = (joints, QUATERNION, TURN_VECTOR, MATRIX)
    rows = read_rows(path, (), groups, angle_unit=angle_unit)
    there = [group for group in groups if group and rows.has(group)]
    if len(there) != 1:
        raise FileFormatError(
            f"{path}: {len(there)} forms of posture in it; one is needed: columns "
            f"{', '.join(joints) + '; ' if joints else ''}qx to qw; rx, ry, rz; or r11 to r33 "
            f"(there are: {', '.join(rows.table.header)})"
        )
    if there[0] == QUATERNION:
        rows = with_unit_quaternions(rows)
    for problem in rows.problems:
        if problem:
            raise FileFormatError(problem)
    values = rows.array(there[0])
    forms: tuple[Form, ...] = ("angles", "quaternions", "rotation vectors", "matrices")
    form = forms[groups.index(there[0])]
    shaped = values.reshape(-1, 3, 3) if form == "matrices" else np.ascontiguousarray(values)
    return Postures(shaped, form, rows.labels("trial"))


def _from_arrays(path: Path) -> Postures:
    """Read an .npz."""
    import zipfile

    import numpy as np

    try:
        with np.load(path, allow_pickle=False) as held:
            arrays = {name: held[name] for name in held.files}
    except (ValueError, zipfile.BadZipFile, EOFError, KeyError) as error:
        raise FileFormatError(f"{path}: no .npz of arrays ({error})") from None
    names = [name for name in ARRAYS if name in arrays]
    if len(names) != 1:
        raise FileFormatError(
            f"{path}: one of {', '.join(ARRAYS)} is needed (there are: {', '.join(arrays)})"
        )
    values = arrays[names[0]]
    bad = np.argwhere(~np.isfinite(values)) if values.dtype.kind in "fiu" else []
    if len(bad):
        place = ", ".join(map(str, bad[0].tolist()))
        raise FileFormatError(f"{path}: {names[0]}[{place}] is no finite number")
    trials = arrays.get("trial")
    return Postures(
        values, ARRAYS[names[0]], None if trials is None else tuple(map(str, trials.tolist()))
    )


def surface_of(given: Postures, task: "Task") -> "DondersSurface | None":
    """Fit the quadratic surface to the orientations of the wrist's hand."""
    from selfmotion.kinematics.forward import forward_kinematics
    from selfmotion.methods.elasticity.orientations import wrist_angles
    from selfmotion.methods.elasticity.surface import fit_surface
    from selfmotion.methods.passive.tasks import arm_of
    from selfmotion.spatial import log_rotation

    arm = arm_of(task)
    if arm.joints != ("pronation", "flexion", "deviation"):
        return None
    q = wrist_angles(given.values, given.form)
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    return fit_surface(log_rotation(T[:, :3, :3]))


def surface_record(surface: "DondersSurface | None") -> Surface | None:
    """Give the keys of a `Surface`."""
    if surface is None:
        return None
    from selfmotion.methods.elasticity.surface import TERMS

    return Surface(
        terms=list(TERMS),
        coefficients=numbers(surface.coefficients),
        stderr=numbers(surface.stderr),
        thickness_deg=surface.thickness_deg,
    )


def provenance_of(found: "JointElasticity", postures: Path, prior: Path | None) -> Provenance:
    """Say where the results come from."""
    from selfmotion.provenance import hash_file

    files = {"postures": postures, "prior": prior}
    inputs = {name: hash_file(path) for name, path in files.items() if path is not None}
    return Provenance("fit_elasticity", inputs=inputs, choices=found.provenance.choices)


def save_law(found: "JointElasticity", folder: Path) -> list[Path]:
    """Write donders.csv and, if the fit is sound, law.toml for `selfmotion plan --law`."""
    table = found.to_frame().to_csv(index=False)
    written = [write_whole(folder / "donders.csv", table)]
    if found.status:
        rows = ",\n".join(f"  {row}" for row in found.stiffness.tolist())
        law = f"stiffness = [\n{rows},\n]\nrest = {found.rest.tolist()}\n"
        written.append(write_whole(folder / "law.toml", law))
    return written


def as_text(document: DondersDocument) -> str:
    """Write the law as a person reads it."""
    from math import degrees

    width = max(len(joint) for joint in document.joints)
    lines = [f"{document.postures} postures ({document.form}); {document.status}"]
    lines.append(f"{'joint':{width}}  stiffness (N m/rad), rest (deg), each with standard error")
    for i, joint in enumerate(document.joints):
        cells = [(document.stiffness[i][i], document.stderr.stiffness[i][i])]
        rest, error = document.rest[i], document.stderr.rest[i]
        cells.append((degrees(rest or 0.0), None if error is None else degrees(error)))
        lines.append(f"{joint:{width}}  " + "   ".join(_with_error(*cell) for cell in cells))
    lines += document.sentences
    lines.append(f"thickness {document.thickness_deg or 0.0:.2f} deg")
    return "\n".join(lines)


def _with_error(value: float | None, error: float | None) -> str:
    known = "?" if error is None else f"{error:.2g}"
    return f"{value or 0.0:7.3f} ± {known:6}"
