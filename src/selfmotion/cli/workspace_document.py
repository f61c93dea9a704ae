"""The document of `selfmotion workspace`: its types, how it is filled, and what a person reads."""

from typing import TYPE_CHECKING

from selfmotion.cli.output import Document, Number, Part, numbers
from selfmotion.cli.subject import Subject

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.workspace import Workspace


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
