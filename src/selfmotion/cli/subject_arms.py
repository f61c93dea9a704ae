"""A person's arms, body and regions, from the TOML file and what was typed beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from selfmotion.cli.body import NO_BODY
from selfmotion.cli.models import Limits, load_any_arm, with_typed_limits
from selfmotion.cli.subject import BodyTable, RegionTable, Subject, set_in
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError, unknown_name

if TYPE_CHECKING:
    from selfmotion.capture.ranges import JointRange
    from selfmotion.kinematics.arm import Arm
    from selfmotion.kinematics.body_frame import BodyFrame
    from selfmotion.kinematics.body_shapes import BodyShapes, Shape
    from selfmotion.methods.reaching.regions import NamedRegion
    from selfmotion.motion.recording import Recording

Side: TypeAlias = Literal["right", "left"]
RangeFiles: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--ranges",
        metavar="[JOINT=]FILE",
        help="Recording in which one joint is moved as far as it goes: its limits, as with "
        "--limit; repeatable.",
    ),
]
SideName: TypeAlias = Annotated[
    Side | None, typer.Option("--side", help="Which arm; left out: the subject's, or right.")
]
__all__ = ["Limits", "PersonArms", "RangeFiles", "SideName", "Typed", "person_arms"]


@dataclass(frozen=True)
class Typed:
    """What the command line says of the person, beside the file.

    Attributes:
        arm: where the file names none.
        side: stronger than the file's.
        limits: of --limit.
        ranges: of --ranges.
        body: stronger than the file's.
    """

    arm: str
    side: Side | None = None
    limits: tuple[str, ...] = ()
    ranges: tuple[str, ...] = ()
    body: str | None = None


@dataclass(frozen=True, eq=False)
class PersonArms:
    """A person, ready to be computed with.

    Attributes:
        name: for reports.
        side: of the arm.
        free: the arm without impairments.
        limited: the arm with them; None where there are none.
        measured: what was read from recordings, with what it limits: "free" or "limited".
        body: what is no space for the hand; None: nothing.
        posture: of that body, or "none".
        regions: named places.
        stature: m; None: from the arm's lengths.
    """

    name: str
    side: Side
    free: "Arm"
    limited: "Arm | None"
    measured: "tuple[tuple[str, JointRange], ...]"
    body: "BodyShapes | None"
    posture: str
    regions: "tuple[NamedRegion, ...]"
    stature: float | None


def person_arms(subject: Subject, path: Path | None, typed: Typed) -> PersonArms:
    """Build the arms, body and regions of a person.

    Raises:
        SelfmotionError: an arm, joint, length or limit is not allowed; names the file it is in.
    """
    side = typed.side or subject.side
    folder = Path() if path is None else path.parent
    arm = _arm(subject, typed.arm, side, path)
    for table in ("ranges", "impairments"):
        for joint in getattr(subject, table):
            with set_in(path, f"{table}.{joint}"):
                arm.chain.index(joint)
    free_measured = _measured(subject.recordings.ranges, folder, arm, (path, "ranges"))
    free = arm.with_limits(_radians(subject.ranges)).with_limits(_limits(free_measured))
    measured = _measured(subject.recordings.impairments, folder, arm, (path, "impairments"))
    body = subject.body or BodyTable(posture=NO_BODY)
    shapes = _body(body, typed.body, free, path)
    with set_in(path, "regions"):
        regions = _regions(subject.regions, free, body)
    measured += _typed_ranges(typed.ranges, arm)
    free = _widened(free, measured)
    limited = free.with_limits(_radians(subject.impairments)).with_limits(_limits(measured))
    limited = with_typed_limits(limited, list(typed.limits))
    changed = bool(typed.limits or subject.impairments or measured)
    kinds = [("free", r) for r in free_measured] + [("limited", r) for r in measured]
    stature = None if body.stature_cm is None else 1e-2 * body.stature_cm
    return PersonArms(
        subject.name,
        side,
        free,
        limited if changed else None,
        tuple(kinds),
        shapes,
        typed.body or body.posture,
        regions,
        stature,
    )


def _arm(subject: Subject, name: str, side: Side, path: Path | None) -> "Arm":
    """Build the arm of the person's lengths and side."""
    from selfmotion.kinematics.mirror import mirror

    name = subject.arm or name
    with set_in(path, "arm"):
        arm = _of_lengths(subject, name)
    if subject.adult_ranges:
        from selfmotion.capture.scaling import with_adult_ranges

        with set_in(path, "adult_ranges"):
            if arm.name != "upper_limb_anatomical":
                raise RangeError(
                    f"adult_ranges: known for upper_limb_anatomical only, and the arm is {arm.name}"
                )
            arm = with_adult_ranges(arm)
    return mirror(arm) if side == "left" else arm


def _of_lengths(subject: Subject, name: str) -> "Arm":
    """Build the right arm of that name with the person's lengths, if they are told."""
    if subject.lengths_mm is None:
        return load_any_arm(name)
    from selfmotion.arms import upper_limb, upper_limb_anatomical

    builders = {"upper_limb": upper_limb, "upper_limb_anatomical": upper_limb_anatomical}
    if name not in builders:
        raise unknown_name("arm with lengths_mm", name, tuple(builders))
    mm = subject.lengths_mm
    return builders[name]([1e-3 * v for v in (mm.clavicle, mm.upper_arm, mm.forearm, mm.palm)])


def _measured(
    files: Mapping[str, Sequence[str]], folder: Path, arm: "Arm", place: tuple[Path | None, str]
) -> "tuple[JointRange, ...]":
    """Read the ranges that recordings, named beside the TOML file, hold."""
    from selfmotion.capture.ranges import joint_range
    from selfmotion.motion.files import load

    out = []
    for joint, names in files.items():
        with set_in(place[0], f"recordings.{place[1]}.{joint}"):
            arm.chain.index(joint)
            recordings = [r for name in names for r in load(folder / name)]
            for recording in recordings:
                _require_joint(recording, joint, arm)
            out.append(joint_range(joint, recordings))
    return tuple(out)


def _require_joint(recording: "Recording", joint: str, arm: "Arm") -> None:
    """Refuse a recording of one joint of the arm that is named for another one."""
    known = [name for name in recording.joints if name in arm.joints]
    if known and joint not in known:
        raise RangeError(f"{recording.name}: holds {', '.join(known)}, and no {joint}")


def _typed_ranges(texts: Sequence[str], arm: "Arm") -> "tuple[JointRange, ...]":
    """Read the recordings of --ranges, each with or without the name of its joint."""
    from selfmotion.capture.ranges import joint_moved, joint_range
    from selfmotion.motion.files import load

    by_joint: dict[str, list] = {}
    for text in texts:
        joint, equals, name = text.partition("=")
        if not equals or Path(text).exists():
            joint, name = "", text
        else:
            arm.chain.index(joint)
        if not Path(name).is_file():
            raise FileFormatError(f"--ranges {text!r}: there is no file {name!r}")
        for recording in load(name):
            moved = joint or joint_moved(recording, arm)
            _require_joint(recording, moved, arm)
            by_joint.setdefault(moved, []).append(recording)
    return tuple(joint_range(joint, found) for joint, found in by_joint.items())


def _widened(free: "Arm", measured: "Sequence[JointRange]") -> "Arm":
    """Give the free arm, made to hold what the impaired person was seen to do."""
    ranges = {}
    for r in measured:
        j = free.chain.index(r.joint)
        ranges[r.joint] = (min(float(free.lower[j]), r.low), max(float(free.upper[j]), r.high))
    return free.with_limits(ranges)


def _limits(measured: "Sequence[JointRange]") -> dict[str, tuple[float, float]]:
    return {r.joint: (r.low, r.high) for r in measured}


def _radians(table: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    from math import radians

    return {joint: (radians(low), radians(high)) for joint, (low, high) in table.items()}


def _body(body: BodyTable, typed: str | None, arm: "Arm", path: Path | None) -> "BodyShapes | None":
    """Give the body of the person, with the shapes that the file changes.

    Without a posture there are the file's own shapes alone, as a chair's; ``--body none`` drops
    them, too.
    """
    posture = typed or body.posture
    if typed == NO_BODY or (posture == NO_BODY and not body.shapes):
        return None
    from selfmotion.kinematics.body_frame import BodyFrame
    from selfmotion.kinematics.body_shapes import POSTURES, BodyShapes

    stature = None if body.stature_cm is None else 1e-2 * body.stature_cm
    shapes = BodyShapes({})
    for known in POSTURES:
        if known == posture:
            shapes = BodyShapes.of(arm, known, stature=stature)
    with set_in(path, "body.without"):
        shapes = shapes.without(*body.without)
    frame = BodyFrame.of(arm, stature)
    for name, table in body.shapes.items():
        with set_in(path, f"body.shapes.{name}"):
            try:
                shapes = shapes.with_shape(name, _shape(table, frame))
            except SelfmotionError as error:
                raise RangeError(f"body.shapes.{name}: {error}") from None
    return shapes


def _shape(table: object, frame: "BodyFrame") -> "Shape":
    """Place a shape of the file in the arm's ground."""
    import numpy as np

    from selfmotion.arrays import require_finite
    from selfmotion.cli.subject import BoxCm, CapsuleCm, EllipsoidCm
    from selfmotion.kinematics.solid_shapes import Box, Capsule, Ellipsoid

    def at(place: tuple[float, float, float]) -> np.ndarray:
        require_finite("place", np.array(place))
        return frame.points([1e-2 * np.array(place)])[0]

    if isinstance(table, CapsuleCm):
        return Capsule(at(table.start_cm), at(table.end_cm), 1e-2 * table.radius_cm)
    assert isinstance(table, EllipsoidCm | BoxCm)
    kind = Ellipsoid if isinstance(table, EllipsoidCm) else Box
    return kind(at(table.centre_cm), 1e-2 * np.array(table.half_cm), frame.axes)


def _regions(
    tables: Mapping[str, RegionTable], arm: "Arm", body: BodyTable
) -> "tuple[NamedRegion, ...]":
    """Give the named regions: the usual ones, with those of the file added or in their place."""
    from selfmotion.kinematics.body_frame import stature_of
    from selfmotion.methods.reaching.regions import REGIONS, NamedRegion

    stature_cm = 1e2 * stature_of(arm) if body.stature_cm is None else body.stature_cm
    regions = {region.name: region for region in REGIONS}
    for name, table in tables.items():
        spans = [table.outwards_cm, table.forward_cm, table.up_cm]
        out, ahead, up = [(low / stature_cm, high / stature_cm) for low, high in spans]
        title = table.title or name.replace("_", " ")
        made = NamedRegion(name, title, out, ahead, up, table.way)
        usual = regions.get(name)
        regions[name] = made if table.title or usual is None else replace(made, title=usual.title)
    return tuple(regions.values())
