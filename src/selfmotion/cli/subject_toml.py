"""Write a person as TOML, as `selfmotion workspace --out` does: to be edited and used again."""

import json
import math
from typing import TYPE_CHECKING

from selfmotion.cli.subject_arms import PersonArms

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.body_frame import BodyFrame
    from selfmotion.kinematics.body_shapes import BodyShapes, Shape
    from selfmotion.methods.reaching.regions import NamedRegion

# Digits after the point of angles (degrees) and lengths (mm, cm).
DIGITS = 4


def subject_toml(person: PersonArms) -> str:
    """Give the text of a person's file: read again, it makes the same arms, body and regions."""
    from selfmotion.kinematics.body_frame import BodyFrame

    arm = person.free
    base = arm.name.removesuffix(" (mirrored)")
    frame = BodyFrame.of(arm, person.stature)
    lines = [f"name = {_text(person.name)}", f"side = {_text(person.side)}"]
    lines.append(f"arm = {_text(base)}")
    if base in ("upper_limb", "upper_limb_anatomical"):
        lines += ["", "[lengths_mm]"]
        names = ("clavicle", "upper_arm", "forearm", "hand")
        for name, length in zip(("clavicle", "upper_arm", "forearm", "palm"), names, strict=True):
            lines.append(f"{name} = {_number(1e3 * arm.lengths[length])}")
    lines += ["", "[ranges]  # degrees, without impairments"]
    lines += [f"{j} = {_span(arm.lower[i], arm.upper[i])}" for i, j in enumerate(arm.joints)]
    if person.limited is not None:
        lines += ["", "[impairments]  # degrees"]
        low, high = person.limited.lower, person.limited.upper
        changed = (low != arm.lower) | (high != arm.upper)
        lines += [f"{j} = {_span(low[i], high[i])}" for i, j in enumerate(arm.joints) if changed[i]]
    lines += ["", "[body]", f"posture = {_text(person.posture)}"]
    lines.append(f"stature_cm = {_number(1e2 * frame.stature)}")
    if person.body is not None:
        lines += _without(person, person.body)
        for name, shape in person.body.shapes.items():
            lines += ["", f"[body.shapes.{_text(name)}]", *_shape(shape, frame)]
    for region in person.regions:
        lines += ["", f"[regions.{_text(region.name)}]", *_region(region, frame)]
    return "\n".join(lines) + "\n"


def _without(person: PersonArms, body: "BodyShapes") -> list[str]:
    """Name the usual shapes that the person's body does not have."""
    from selfmotion.kinematics.body_shapes import POSTURES, BodyShapes

    usual = [
        BodyShapes.of(person.free, posture, stature=person.stature).shapes
        for posture in POSTURES
        if posture == person.posture
    ]
    missing = [name for shapes in usual for name in shapes if name not in body.shapes]
    return [f"without = [{', '.join(map(_text, missing))}]"] if missing else []


def _shape(shape: "Shape", frame: "BodyFrame") -> list[str]:
    from selfmotion.kinematics.solid_shapes import Box, Capsule

    def at(place: "np.ndarray") -> str:
        return _numbers(1e2 * frame.coordinates(place[None])[0])

    if isinstance(shape, Capsule):
        ends = [f"start_cm = {at(shape.start)}", f"end_cm = {at(shape.end)}"]
        return ['kind = "capsule"', *ends, f"radius_cm = {_number(1e2 * shape.radius)}"]
    kind = "box" if isinstance(shape, Box) else "ellipsoid"
    half = f"half_cm = {_numbers(1e2 * shape.half)}"
    return [f'kind = "{kind}"', f"centre_cm = {at(shape.centre)}", half]


def _region(region: "NamedRegion", frame: "BodyFrame") -> list[str]:
    lines = [f"title = {_text(region.title)}"]
    for name in ("outwards", "forward", "up"):
        low, high = getattr(region, name)
        if math.isfinite(low) or math.isfinite(high):
            scale = 1e2 * frame.stature
            lines.append(f"{name}_cm = [{_number(scale * low)}, {_number(scale * high)}]")
    return lines if region.way == "any" else [*lines, f'way = "{region.way}"']


def _text(words: str) -> str:
    """Quote a text: JSON's way is TOML's, but for characters that JSON writes in two halves."""
    return json.dumps(words, ensure_ascii=False).replace("\x7f", "\\u007f")


def _span(low: float, high: float) -> str:
    return f"[{_number(math.degrees(low))}, {_number(math.degrees(high))}]"


def _numbers(values: "np.ndarray") -> str:
    return f"[{', '.join(_number(float(v)) for v in values)}]"


def _number(value: float) -> str:
    if not math.isfinite(value):
        return "inf" if value > 0 else "-inf"
    return repr(round(float(value), DIGITS) + 0.0)  # no minus before a zero
