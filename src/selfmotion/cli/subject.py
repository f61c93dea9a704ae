"""The option --subject of `selfmotion workspace`: a person's lengths and ranges, as TOML."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from selfmotion.errors import FileFormatError, SelfmotionError, unknown_name

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm

FIELDS = ("name", "arm", "lengths_mm", "ranges", "impairments")
SEGMENTS = ("clavicle", "upper_arm", "forearm", "palm")
LONGEST_MM = 2000.0
TURN_DEG = 360.0


@dataclass(frozen=True)
class Subject:
    """A person.

    Attributes:
        name: for the report.
        arm: name or file of the arm; none: as the command line says.
        lengths: (clavicle, upper arm, forearm, palm) in m; none: as the arm has them.
        ranges: joint to (low, high) of the free arm (rad).
        impairments: joint to (low, high) of the limited arm (rad).
    """

    name: str = ""
    arm: str | None = None
    lengths: tuple[float, ...] | None = None
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    impairments: dict[str, tuple[float, float]] = field(default_factory=dict)


def read_subject(path: Path) -> Subject:
    """Read a person.

    Args:
        path: TOML with, all optional, ``name``, ``arm``, a table ``lengths_mm`` (clavicle,
            upper_arm, forearm, palm), and tables ``ranges`` and ``impairments`` of
            ``joint = [low, high]`` in degrees.

    Raises:
        FileFormatError: the file is no TOML, or a field is unknown or not allowed.
    """
    try:
        fields = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML: {error}") from None
    try:
        for name in fields:
            if name not in FIELDS:
                raise unknown_name("field", name, FIELDS)
        return Subject(
            _text(fields, "name") or "",
            _text(fields, "arm"),
            _lengths(fields.get("lengths_mm")),
            _ranges("ranges", fields.get("ranges", {})),
            _ranges("impairments", fields.get("impairments", {})),
        )
    except SelfmotionError as error:
        raise FileFormatError(f"{path}: {error}") from None


def arms_of(subject: Subject, name: str) -> "tuple[Arm, Arm]":
    """Build the free arm of a person, and the one with the impairments.

    Raises:
        SelfmotionError: an arm, joint or length is not allowed.
    """
    from selfmotion.cli.models import load_any_arm

    name = subject.arm or name
    if subject.lengths is None:
        arm = load_any_arm(name)
    else:
        from selfmotion.arms import upper_limb, upper_limb_anatomical

        builders = {"upper_limb": upper_limb, "upper_limb_anatomical": upper_limb_anatomical}
        if name not in builders:
            raise unknown_name("arm with lengths_mm", name, tuple(builders))
        arm = builders[name](subject.lengths)
    free = arm.with_limits(subject.ranges)
    return free, free.with_limits(subject.impairments)


def _text(fields: dict[str, Any], name: str) -> str | None:
    value = fields.get(name)
    if value is not None and not isinstance(value, str):
        raise FileFormatError(f"{name} = {value!r}: a text is expected")
    return value


def _lengths(table: object) -> tuple[float, ...] | None:
    if table is None:
        return None
    if not isinstance(table, dict) or set(table) != set(SEGMENTS):
        raise FileFormatError(f"lengths_mm: a table with {', '.join(SEGMENTS)} is expected")
    for name in SEGMENTS:
        value = _number(f"lengths_mm.{name}", table[name])
        if not 0.0 < value <= LONGEST_MM:
            raise FileFormatError(
                f"lengths_mm.{name} = {value:g}: allowed is above 0 to {LONGEST_MM:g} mm"
            )
    return tuple(1e-3 * float(table[name]) for name in SEGMENTS)


def _ranges(field_name: str, table: object) -> dict[str, tuple[float, float]]:
    from math import radians

    if not isinstance(table, dict):
        raise FileFormatError(f"{field_name}: a table of joint = [low, high] is expected")
    out = {}
    for joint, span in table.items():
        where = f"{field_name}.{joint}"
        if not isinstance(span, list) or len(span) != 2:
            raise FileFormatError(f"{where} = {span!r}: [low, high] in degrees is expected")
        low, high = (_number(where, value) for value in span)
        if not -TURN_DEG <= low <= high <= TURN_DEG:
            raise FileFormatError(
                f"{where} = [{low:g}, {high:g}]: allowed is low up to high, from -360 to 360 deg"
            )
        out[joint] = (radians(low), radians(high))
    return out


def _number(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FileFormatError(f"{where} = {value!r}: a number is expected")
    return float(value)
