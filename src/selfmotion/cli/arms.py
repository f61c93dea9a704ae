"""`selfmotion arms`: the arms that commands take, with their joints, limits and sources."""

from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.options import Json
from selfmotion.cli.output import Contract, Document, Number, Part, finish
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm


class JointRange(Part, frozen=True):
    """One joint, in the order of q; radians (metres for slides)."""

    joint: str
    lower: Number
    upper: Number


class ArmEntry(Part, frozen=True):
    """One arm."""

    name: str
    task: str
    joints: list[JointRange]
    lengths_m: dict[str, float]
    source: str


class ArmsDocument(Document, frozen=True, tag="selfmotion/arms/1", kw_only=True):
    """The arms asked for."""

    arms: list[ArmEntry]


CONTRACT = Contract(ArmsDocument, ("arms", "wrist", "exoskeleton", "--json"))


def arms(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME|FILE", help="Arms or model files; left out: all by name."),
    ] = None,
    json: Json = False,
) -> int:
    """List the arms with their joints, limits and sources."""
    from selfmotion.arms import arm_names, load_arm

    entries = [entry(load_arm(name)) for name in names or arm_names()]
    document = ArmsDocument(provenance=Provenance("arms"), arms=entries)
    return finish(document, "\n\n".join(as_text(e) for e in entries), json=json)


def entry(arm: "Arm") -> ArmEntry:
    """Describe an arm."""
    ranges = zip(arm.joints, arm.lower.tolist(), arm.upper.tolist(), strict=True)
    return ArmEntry(
        name=arm.name,
        task=arm.task,
        joints=[JointRange(joint=j, lower=low, upper=high) for j, low, high in ranges],
        lengths_m=dict(arm.lengths),
        source=arm.source,
    )


def as_text(arm: ArmEntry) -> str:
    """Write an arm as a person reads it, ranges in degrees."""
    from math import degrees

    width = max(len(j.joint) for j in arm.joints)
    lines = [f"{arm.name}  (task: {arm.task})", f"  {arm.source}"]
    for j in arm.joints:
        low, high = (degrees(v) if v is not None else float("nan") for v in (j.lower, j.upper))
        lines.append(f"  {j.joint:{width}}  {low:8.1f} to {high:7.1f} deg")
    if arm.lengths_m:
        lengths = ", ".join(f"{name} {1e3 * v:.0f}" for name, v in arm.lengths_m.items())
        lines.append(f"  lengths (mm): {lengths}")
    return "\n".join(lines)
