"""A person as TOML: side, lengths, ranges, impairments, recordings of ranges, body and regions.

The types below are the format; `docs/subject.schema.json` is made of them (`subject_schema`).
"""

import inspect
import math
import tomllib
import typing
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import msgspec
from msgspec import Meta

from selfmotion.cli.output import Part
from selfmotion.errors import FileFormatError, SelfmotionError, unknown_name

SEGMENTS = ("clavicle", "upper_arm", "forearm", "palm")
SHORTEST_MM, LONGEST_MM = 1.0, 2000.0
TURN_DEG = 360.0
OPEN = math.inf
Span: TypeAlias = tuple[float, float]
Triple: TypeAlias = tuple[float, float, float]
Length: TypeAlias = Annotated[float, Meta(ge=SHORTEST_MM, le=LONGEST_MM)]


class LengthsMm(Part, frozen=True, kw_only=True):
    """Lengths between the centres of rotation (mm); the palm from the wrist to its centre."""

    clavicle: Length
    upper_arm: Length
    forearm: Length
    palm: Length


class RangeRecordings(Part, frozen=True, kw_only=True):
    """Files in which one joint is moved as far as it goes, by joint; beside the TOML file."""

    ranges: dict[str, list[str]] = {}
    impairments: dict[str, list[str]] = {}


class CapsuleCm(Part, frozen=True, tag="capsule", tag_field="kind", kw_only=True):
    """All within a radius of a segment; places are outwards, forward, up of the mid-shoulder."""

    start_cm: Triple
    end_cm: Triple
    radius_cm: float


class EllipsoidCm(Part, frozen=True, tag="ellipsoid", tag_field="kind", kw_only=True):
    """An ellipsoid with its axes along the body's; half axes outwards, forward, up."""

    centre_cm: Triple
    half_cm: Triple


class BoxCm(Part, frozen=True, tag="box", tag_field="kind", kw_only=True):
    """A box with its edges along the body's; half edges outwards, forward, up."""

    centre_cm: Triple
    half_cm: Triple


ShapeCm: TypeAlias = CapsuleCm | EllipsoidCm | BoxCm
KINDS = {"capsule": CapsuleCm, "ellipsoid": EllipsoidCm, "box": BoxCm}


class BodyTable(Part, frozen=True, kw_only=True):
    """The body that is no space for the hand; `shapes` adds to it or replaces, by name."""

    posture: Literal["none", "seated", "standing"] = "seated"
    stature_cm: Annotated[float, Meta(ge=50.0, le=250.0)] | None = None
    without: list[str] = []
    shapes: dict[str, ShapeCm] = {}


class RegionTable(Part, frozen=True, kw_only=True):
    """A place, from and to (cm) outwards, forward and up of the mid-shoulder; inf for open."""

    title: str = ""
    outwards_cm: Span = (-OPEN, OPEN)
    forward_cm: Span = (-OPEN, OPEN)
    up_cm: Span = (-OPEN, OPEN)
    way: Literal["any", "over", "under"] = "any"


class Subject(Part, frozen=True, kw_only=True):
    """A person. Ranges are [low, high] in degrees, by joint: free, and with the impairments."""

    name: str = ""
    side: Literal["right", "left"] = "right"
    arm: str | None = None
    adult_ranges: bool = False
    lengths_mm: LengthsMm | None = None
    ranges: dict[str, Span] = {}
    impairments: dict[str, Span] = {}
    recordings: RangeRecordings = RangeRecordings()
    body: BodyTable | None = None
    regions: dict[str, RegionTable] = {}


class _BadField(Exception):
    """A field that is not allowed: where it stands, and what is wrong."""


def read_subject(path: Path) -> Subject:
    """Read a person.

    Args:
        path: TOML; every key is optional. ``docs/formats.md`` shows one.

    Raises:
        FileFormatError: the file is no TOML, or a field is unknown or not allowed; one line that
            names the file and, as far as it can be told, the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
        fields = tomllib.loads(text)
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML: {error}") from None
    try:
        subject = _converted("", fields, Subject)
        _check_ranges("ranges", subject.ranges)
        _check_ranges("impairments", subject.impairments)
        _check_regions(subject.regions)
    except _BadField as bad:
        where, reason = bad.args
        raise FileFormatError(f"{_place(path, text, where)}: {reason}") from None
    return subject


@contextmanager
def set_in(path: Path | None, where: str) -> Iterator[None]:
    """Let what goes wrong inside name the file, and the line in which a field is set.

    Args:
        path: of the file; None: there is none, and errors stay as they are.
        where: field, as in ``body.without``.

    Raises:
        FileFormatError: in the place of any error of ours that does not name the file already.
    """
    try:
        yield
    except SelfmotionError as error:
        if path is None or str(path) in str(error):
            raise
        text = path.read_text(encoding="utf-8")
        raise FileFormatError(f"{_place(path, text, where)}: {error}") from None


def subject_schema() -> bytes:
    """Give the JSON Schema of the format."""
    tree = msgspec.json.schema(Subject)
    for definition in tree["$defs"].values():
        definition["description"] = inspect.cleandoc(definition.get("description", ""))
        for entry in definition["properties"].values():
            if entry.get("default") == [None, None]:
                del entry["default"]  # JSON has no word for an open side
    tree = {"$schema": "https://json-schema.org/draft/2020-12/schema", **tree}
    return msgspec.json.format(msgspec.json.encode(tree)) + b"\n"


def line_of(text: str, where: str) -> int | None:
    r"""Give the line in which a field of a TOML text is set, None where it cannot be told.

    Example:
        >>> line_of("name = 'a'\n[ranges]\nelbow = [1, 0]\n", "ranges.elbow")
        3
    """
    table = ""
    nearest = None
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.strip()
        if line.startswith("["):
            table = found = _bare(line.strip("[] \t").split("]")[0])
        else:
            key = _bare(line.partition("=")[0])
            if not key or key.startswith("#"):
                continue
            found = f"{table}.{key}" if table else key
        if found == where:
            return number
        if where.startswith(f"{found}."):
            nearest = number
    return nearest


def _bare(key: str) -> str:
    """Give a key without quotes and without spaces round its dots."""
    return ".".join(part.strip().strip("\"'") for part in key.split("."))


def _place(path: Path, text: str, where: str) -> str:
    line = line_of(text, where)
    return str(path) if line is None else f"{path}, line {line}"


def _converted(where: str, value: object, kind: Any) -> Any:
    """Turn what TOML holds into one of the types above; every error names its field."""
    origin = typing.get_origin(kind)
    if origin is dict:
        if not isinstance(value, dict):
            raise _BadField(where, f"{where}: a table is expected")
        inner = typing.get_args(kind)[1]
        return {key: _converted(f"{where}.{key}", v, inner) for key, v in value.items()}
    if kind == ShapeCm:
        kind = _shape_kind(where, value)
        value = {key: v for key, v in typing.cast(dict, value).items() if key != "kind"}
    if kind == Span and where.split(".")[0] in ("ranges", "impairments"):
        return _span(where, value)
    structs = [k for k in (kind, *typing.get_args(kind)) if _is_struct(k)]
    if structs:
        return _converted_struct(where, value, structs[0])
    try:
        return msgspec.convert(value, kind, strict=True)
    except msgspec.ValidationError as error:
        reason = str(error).partition(" - at ")[0].replace("`", "")
        words = typing.get_args(kind) if typing.get_origin(kind) is Literal else ()
        if words and isinstance(value, str):
            reason = f"allowed is {', '.join(words)}"
        raise _BadField(where, f"{where} = {value!r}: {reason}") from None


def _converted_struct(where: str, value: object, kind: type[Part]) -> Part:
    names = kind.__struct_fields__
    if not isinstance(value, dict) or (kind is LengthsMm and set(value) < set(SEGMENTS)):
        raise _BadField(where, f"{where}: a table with {', '.join(names)} is expected")
    hints = typing.get_type_hints(kind, include_extras=True)
    for key in value:
        if key not in names:
            what = f"field {key!r} of {where}" if where else f"field {key!r}"
            reason = str(unknown_name("field", key, names)).replace(f"field {key!r}", what, 1)
            raise _BadField(f"{where}.{key}".strip("."), reason)
    if kind is LengthsMm:
        for key, length in value.items():
            _check_length(f"{where}.{key}", length)
    made = {k: _converted(f"{where}.{k}".strip("."), v, hints[k]) for k, v in value.items()}
    try:
        return kind(**made)
    except TypeError as error:
        raise _BadField(where, f"{where}: {error}") from None


def _shape_kind(where: str, value: object) -> type[Part]:
    kind = value.get("kind") if isinstance(value, dict) else None
    if not isinstance(kind, str) or kind not in KINDS:
        reason = str(unknown_name("kind", str(kind), tuple(KINDS)))
        raise _BadField(where, f"{where}: {reason}")
    return KINDS[kind]


def _is_struct(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Part)


def _check_length(where: str, value: object) -> None:
    number = _number(where, value)
    if not SHORTEST_MM <= number <= LONGEST_MM:
        allowed = f"allowed is {SHORTEST_MM:g} to {LONGEST_MM:g} mm"
        raise _BadField(where, f"{where} = {number:g}: {allowed}")


def _span(where: str, value: object) -> Span:
    if not isinstance(value, list) or len(value) != 2:
        raise _BadField(where, f"{where} = {value!r}: [low, high] in degrees is expected")
    return _number(where, value[0]), _number(where, value[1])


def _check_ranges(name: str, table: dict[str, Span]) -> None:
    for joint, (low, high) in table.items():
        where = f"{name}.{joint}"
        if not -TURN_DEG <= low <= high <= TURN_DEG:
            raise _BadField(
                where,
                f"{where} = [{low:g}, {high:g}]: allowed is low up to high, from -360 to 360 deg",
            )


def _check_regions(tables: dict[str, RegionTable]) -> None:
    for name, table in tables.items():
        for side in ("outwards_cm", "forward_cm", "up_cm"):
            low, high = getattr(table, side)
            if not low < high:
                where = f"regions.{name}.{side}"
                raise _BadField(
                    where, f"{where} = [{low:g}, {high:g}]: the second must be above the first"
                )


def _number(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _BadField(where, f"{where} = {value!r}: a number is expected")
    return float(value)
