"""The options --lengths, --mass and --strength: the default arm with muscles at a person's size."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from selfmotion.errors import FileFormatError, ModelError, RangeError, unknown_name

if TYPE_CHECKING:
    from selfmotion.muscles.geometry import MusculoskeletalArm

SCALED = "myoarm"
# What `lengths_mm` of a subject file may hold; a palm ends at its centre and so sizes no hand.
SEGMENTS = ("clavicle", "upper_arm", "forearm", "hand")
UNUSED = ("palm",)

Lengths: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--lengths",
        metavar="SEGMENT=M,...|FILE.toml",
        help="Segment lengths of the person (m), as in upper_arm=0.31,forearm=0.25,hand=0.085, "
        "or a subject file with lengths_mm; others stay as in myoarm.",
    ),
]
Strength: TypeAlias = Annotated[
    Literal["constant", "area", "mass"],
    typer.Option("--strength", help="How muscle forces follow --lengths and --mass."),
]
Mass: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--mass",
        metavar="KG",
        help="Body mass of the person: upper arm, forearm and hand weigh 2.63, 1.50 and 0.585 % "
        "of it; left out: as in myoarm, by the cubes of --lengths.",
    ),
]


@dataclass(frozen=True)
class PersonChoices:
    """The size of a person as typed: segment lengths (m), body mass (kg), rule of strength."""

    lengths: tuple[tuple[str, float], ...] = ()
    mass: float | None = None
    strength: str = "area"


def segment_lengths_of(text: str | None) -> tuple[tuple[str, float], ...]:
    """Read --lengths: segments and lengths (m), in the order of `SEGMENTS`.

    Raises:
        RangeError: a word is not segment=metres, or a segment stands twice.
        UnknownNameError: there is no such segment.
        FileFormatError: the file is no TOML, or its lengths are no numbers.
    """
    if text is None:
        return ()
    found = _from_file(Path(text)) if text.lower().endswith(".toml") else _from_words(text)
    return tuple((name, found[name]) for name in SEGMENTS if name in found)


def load_person(model: str, convention: str | None, person: PersonChoices) -> "MusculoskeletalArm":
    """Load an arm with muscles, at the size of a person where lengths or a mass are given.

    Raises:
        SelfmotionError: names the file or the length and what is wrong with it.
    """
    from selfmotion.cli.models import load_muscles

    if not person.lengths and person.mass is None:
        return load_muscles(model, convention)
    if model != SCALED:
        option = "--lengths" if person.lengths else "--mass"
        raise ModelError(
            f"{option}: {SCALED} alone is scaled here, not {model}; scale an .osim with OpenSim's "
            "Scale Tool"
        )
    from selfmotion.arms.person_with_muscles import PersonSize, myoarm_of_person

    size = PersonSize(dict(person.lengths), None, person.strength, person.mass)
    return myoarm_of_person(size, convention=convention or "plain")


def _from_words(text: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for word in text.split(","):
        name, equals, number = (part.strip() for part in word.partition("="))
        try:
            length = float(number)
        except ValueError:
            length = math.nan
        if not (equals and math.isfinite(length)):
            raise RangeError(
                f"--lengths {word.strip()!r}: write segment=metres, as in upper_arm=0.31"
            )
        if name not in SEGMENTS:
            raise unknown_name("segment", name, SEGMENTS)
        if name in found:
            raise RangeError(f"--lengths: {name} stands twice")
        found[name] = length
    return found


def _from_file(path: Path) -> dict[str, float]:
    try:
        fields = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML: {error}") from None
    table = fields.get("lengths_mm")
    if not isinstance(table, dict) or not set(table) & set(SEGMENTS):
        raise FileFormatError(f"{path}: a table lengths_mm with {', '.join(SEGMENTS)} is expected")
    found = {}
    for name, value in table.items():
        if name in UNUSED:
            continue
        if name not in SEGMENTS:
            raise FileFormatError(f"{path}: {unknown_name('segment', name, SEGMENTS)}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise FileFormatError(f"{path}: lengths_mm.{name} = {value!r}: a number is expected")
        found[name] = 1e-3 * float(value)
    return found
