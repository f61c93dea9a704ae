"""The document of `selfmotion workspace`: its types, how it is filled, and what a person reads."""

import math
from typing import TYPE_CHECKING

from selfmotion.cli.output import Document, Number, Part, numbers
from selfmotion.cli.subject_arms import PersonArms
from selfmotion.cli.workspace_held import Circle, Held
from selfmotion.cli.workspace_mapping import Mapping
from selfmotion.cli.workspace_maps import Maps
from selfmotion.cli.workspace_recording import Recorded, Regions

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.workspace import Workspace


# Limits of the boundary that the text tells; the document holds all of them.
MOST_TOLD = 4


class SliceAreas(Part, frozen=True, kw_only=True):
    """Areas (m²) of a slice 20 mm thick at a height (m), with standard errors."""

    z: float
    area_m2: Regions
    stderr_m2: Regions


class MeasuredRange(Part, frozen=True, kw_only=True):
    """The range (rad) of a joint as recorded, and the scatter (rad) of its repeats at an end.

    `limits` says whose range it became: that of the free or of the limited arm.
    """

    joint: str
    limits: str
    low: float
    high: float
    repeats: int
    scatter: Number
    sources: list[str]


class NamedVolume(Part, frozen=True, kw_only=True):
    """What is reached of a named region; `space_m3`: the region without the body, null if open."""

    name: str
    title: str
    space_m3: Number
    volume_m3: Regions
    stderr_m3: Regions


class BoundedBy(Part, frozen=True, kw_only=True):
    """A limit and the share of the boundary where it is the one that counts most.

    `limit` is lower or upper, or empty for the length of the arm and the own body. By a degree
    that the limit gave way the boundary would move `mm_per_degree` there (median).
    """

    bounded_by: str
    limit: str
    at_deg: Number
    share_percent: Number
    standard_error_percent: Number
    takes_part_percent: Number
    mm_per_degree: Number


class Regained(Part, frozen=True, kw_only=True):
    """The part of the lost region that comes back if this joint alone had its free range."""

    joint: str
    percent: Number
    standard_error_percent: Number
    volume_m3: Number


class Details(Part, frozen=True, kw_only=True):
    """What --details adds.

    `enters_body_percent`: the part of the volume for which no posture was found that keeps upper
    arm and forearm out of thorax and head; null without a body.
    """

    regions: list[NamedVolume]
    boundary: dict[str, list[BoundedBy]]
    regained: list[Regained]
    enters_body_percent: Regions


class WorkspaceDocument(Document, frozen=True, tag="selfmotion/workspace/1", kw_only=True):
    """Volumes (m³) with standard errors; null what was not asked for. Limits in radians.

    The hull does not respect the body: it also counts what the body, and hollows, take.
    `taken_off_percent` is what --arm-outside took off what the hand reaches: places for which no
    posture was found whose upper arm and forearm keep out of the body.
    """

    arm: str
    side: str
    subject: str
    joints: list[str]
    free_limits: list[list[Number]]
    limited_limits: list[list[Number]] | None
    measured_ranges: list[MeasuredRange]
    volume_m3: Regions
    stderr_m3: Regions
    hull_volume_m3: Regions
    slices: list[SliceAreas]
    recording: Recorded | None
    details: Details | None
    maps: Maps | None = None
    held: list[Held] = []
    circles: list[Circle] = []
    mapping: Mapping | None = None
    taken_off_percent: Regions | None = None
    status: str


def taken_off(hand: "Workspace", arm: "Workspace", name: str) -> Regions:
    """Give the share (%) that is lost if the arm, too, keeps out of the body.

    Args:
        hand: where the hand keeps out.
        arm: the same, where upper arm and forearm do.
        name: what the workspace calls free.
    """
    names = {"free": name, "limited": "limited"}
    shares = {}
    for key in hand.regions:
        if key != "lost":
            whole = hand.regions[key].volume
            left = arm.regions[key].volume
            shares[names[key]] = 100.0 * (1.0 - left / whole) if whole else None
    return Regions(**shares)


def document_of(
    space: "Workspace",
    name: str,
    person: PersonArms,
    details: Details | None = None,
    taken: Regions | None = None,
) -> WorkspaceDocument:
    """Give the document; `name` is what the workspace calls free."""
    free, limited = person.free, person.limited
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
        side=person.side,
        subject=person.name,
        joints=list(free.joints),
        free_limits=ranges_of(free),
        limited_limits=None if limited is None else ranges_of(limited),
        measured_ranges=[
            MeasuredRange(
                joint=r.joint,
                limits=kind,
                low=r.low,
                high=r.high,
                repeats=r.repeats,
                scatter=numbers([r.scatter])[0],
                sources=list(r.sources),
            )
            for kind, r in person.measured
        ],
        volume_m3=Regions(**volume),
        stderr_m3=Regions(**error),
        hull_volume_m3=Regions(**hull),
        slices=slices,
        recording=None,
        details=details,
        taken_off_percent=taken,
        status=space.summary()
        if name == "free"
        else "The arm with its limits alone; --compare adds the free arm, and what is lost.",
    )


def ranges_of(arm: "Arm") -> list[list[Number]]:
    """Give lower and upper limit of each joint (rad)."""
    import numpy as np

    return numbers(np.stack([arm.lower, arm.upper], axis=1))


def as_text(document: WorkspaceDocument) -> str:
    """Write the workspace as a person reads it, in litres."""
    lines = [f"arm {document.arm}" + (f", {document.subject}" if document.subject else "")]
    for key in ("free", "limited", "lost"):
        value = getattr(document.volume_m3, key)
        if value is None:
            continue
        error, hull = getattr(document.stderr_m3, key), getattr(document.hull_volume_m3, key)
        if hull is None or not math.isfinite(hull):
            around = ""
        else:
            around = f"; hull {1e3 * hull:.1f}"
        lines.append(f"{key:8} {1e3 * value:7.2f} ± {1e3 * (error or 0.0):.2f} litres{around}")
    for part in document.slices:
        areas = ", ".join(
            f"{key} {1e4 * value:.0f}"
            for key in ("free", "limited", "lost")
            if (value := getattr(part.area_m2, key)) is not None
        )
        lines.append(f"slice z = {1e3 * part.z:+.0f} mm: {areas} cm²")
    taken = document.taken_off_percent
    for key in ("free", "limited"):
        if taken is not None and (share := getattr(taken, key)) is not None:
            lines.append(f"{key}: {share:.1f} % taken off, no posture clear of the body")
    if document.details is not None:
        lines += details_text(document.details)
    if document.recording is not None:
        r = document.recording
        inside = (
            r.inside_percent.limited if r.inside_percent.free is None else r.inside_percent.free
        )
        lines.append(f"{inside:.1f} % of {r.points} recorded positions are inside")
    return "\n".join([*lines, document.status])


def region_text(region: NamedVolume) -> str:
    """Say how much of a named region is reached: of the free arm's part, or of the region."""
    free, limited = region.volume_m3.free, region.volume_m3.limited
    if free is not None and limited is not None:
        if not free:
            return "nothing, nor does the free arm reach it"
        return f"{100.0 * limited / free:.0f} % of what the free arm reaches"
    reached = (limited if free is None else free) or 0.0
    whole = f", {100.0 * reached / region.space_m3:.0f} % of it" if region.space_m3 else ""
    return f"{1e3 * reached:.1f} litres{whole}"


def details_text(details: Details) -> list[str]:
    """Write regions, boundary and what each joint would give back, one line each."""
    lines = []
    for r in details.regions:
        lines.append(f"{r.title}: {region_text(r)}")
    for name, rows in details.boundary.items():
        for row in rows[:MOST_TOLD]:
            limit = "" if not row.limit else f", {row.limit} limit {row.at_deg:.1f}°"
            lines.append(f"{name} boundary: {row.share_percent:.0f} % by {row.bounded_by}{limit}")
    for r in details.regained:
        lines.append(f"{r.joint} alone would give back {r.percent or 0.0:.0f} % of what is lost")
    return lines
