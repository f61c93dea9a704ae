"""The options --hold and --circle of `selfmotion workspace`: reach with the hand held."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from selfmotion.cli.output import Part
from selfmotion.errors import RangeError, unknown_name
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from collections.abc import Mapping

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.hand_circle import CircleReach, DeviceCircle
    from selfmotion.methods.hand_constraints import HeldReach
    from selfmotion.methods.workspace import Workspace

HoldText: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--hold",
        metavar="ROW=VALUE,...",
        help="Hold x, y, z (m) or rot_x, rot_y, rot_z (degrees), as in x=0.15,rot_y=0.",
    ),
]
CircleText: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--circle",
        metavar="PLANE:X,Y,Z:R",
        help="A device's circle in yz, xz or xy, centre and radius in m: yz:0.15,0.36,-0.16:0.27.",
    ),
]
ROWS = ("x", "y", "z", "rot_x", "rot_y", "rot_z")


class Held(Part, frozen=True, kw_only=True):
    """What an arm reaches while rows of the hand are held (m, rad).

    `size` is in `unit` (m³, m² in a plane, m on a line); `by_position` is what it reaches there
    with its orientation free.
    """

    limits: str
    held: dict[str, float]
    unit: str
    size: float
    stderr: float
    by_position: float
    status: str


class ArcItem(Part, frozen=True, kw_only=True):
    """A feasible arc of a circle: from and to (rad), and whether the hand can follow it."""

    first: float
    last: float
    without_jump: bool
    status: str


class Circle(Part, frozen=True, kw_only=True):
    """Feasible arcs of a device's circle, for one arm; `share` of the circle is feasible."""

    limits: str
    plane: str
    centre: list[float]
    radius: float
    held: dict[str, float]
    share: float
    arcs: list[ArcItem]
    status: str


@dataclass(frozen=True, eq=False)
class HeldChoices:
    """What --hold and --circle say.

    Attributes:
        held: row to value (m, rad); empty where there is no --hold.
        circle: or None.
    """

    held: "Mapping[str, float]"
    circle: "DeviceCircle | None"

    @classmethod
    def of(cls, hold: str | None, circle: str | None) -> "HeldChoices":
        """Read the two texts.

        Raises:
            SelfmotionError: a text is not of its form, or the two contradict each other.
        """
        held = {} if hold is None else held_of(hold)
        for row in held:
            if circle is not None and not row.startswith("rot"):
                raise RangeError(f"--hold {row} with --circle: the circle holds x, y and z")
        return cls(held, None if circle is None else circle_of(circle))


def held_of(text: str) -> dict[str, float]:
    """Read ``x=0.15,rot_y=0``: metres and degrees to metres and radians.

    Raises:
        RangeError: the text is not of that form, or a row stands twice.
        UnknownNameError: there is no such row.

    Example:
        >>> held_of("x=0.15,rot_y=180")
        {'x': 0.15, 'rot_y': 3.141592653589793}
    """
    from math import radians

    out: dict[str, float] = {}
    for word in text.split(","):
        name, equals, value = (part.strip() for part in word.partition("="))
        if name and name not in ROWS:
            raise unknown_name("--hold row", name, ROWS)
        number = _number(value)
        if not (name and equals) or number is None:
            raise RangeError(f"--hold {text!r}: write row=value,row=value, as in x=0.15,rot_y=0")
        if name in out:
            raise RangeError(f"--hold {text!r}: {name} stands twice")
        out[name] = radians(number) if name.startswith("rot") else number
    return out


def circle_of(text: str) -> "DeviceCircle":
    """Read ``yz:0.15,0.36,-0.16:0.27``.

    Raises:
        RangeError: the text is not of that form, or a value is not allowed.
    """
    from selfmotion.methods.hand_circle import DeviceCircle

    parts = text.split(":")
    place = [_number(word) for word in parts[1].split(",")] if len(parts) == 3 else []
    known = [value for value in (*place, _number(parts[-1])) if value is not None]
    if len(parts) != 3 or len(place) != 3 or len(known) != 4:
        raise RangeError(
            f"--circle {text!r}: write plane:x,y,z:radius in metres, as in yz:0.15,0.36,-0.16:0.27"
        )
    return DeviceCircle(parts[0].strip(), (known[0], known[1], known[2]), known[3])


def held_reaches(
    space: "Workspace", arms: "Mapping[str, Arm]", choices: HeldChoices, seed: int
) -> "dict[str, HeldReach]":
    """Find what each arm reaches with the rows held; nothing without --hold, or with a circle."""
    import numpy as np

    from selfmotion.methods.hand_constraints import held_reach

    if not choices.held or choices.circle is not None:
        return {}
    return {
        name: held_reach(
            arm,
            choices.held,
            blocked=space.blocked,
            options=space.options,
            rng=np.random.default_rng(seed),
        )
        for name, arm in arms.items()
    }


def circle_reaches(arms: "Mapping[str, Arm]", choices: HeldChoices) -> "dict[str, CircleReach]":
    """Find the arcs of the circle for each arm; nothing without --circle."""
    from selfmotion.methods.hand_circle import circle_reach

    if choices.circle is None:
        return {}
    return {name: circle_reach(arm, choices.circle, choices.held) for name, arm in arms.items()}


def held_part(limits: str, found: "HeldReach") -> Held:
    """Give the part of the document."""
    return Held(
        limits=limits,
        held=dict(found.held),
        unit=found.unit,
        size=found.region.volume,
        stderr=found.region.standard_error,
        by_position=found.by_position.volume,
        status=found.summary(),
    )


def circle_part(limits: str, found: "CircleReach") -> Circle:
    """Give the part of the document."""
    return Circle(
        limits=limits,
        plane=found.circle.plane,
        centre=list(found.circle.centre),
        radius=found.circle.radius,
        held=dict(found.held),
        share=found.share,
        arcs=[
            ArcItem(
                first=float(arc.first),
                last=float(arc.last),
                without_jump=arc.path.status.ok,
                status=arc.path.status.sentence,
            )
            for arc in found.arcs
        ],
        status=found.summary(),
    )


def save_held(
    held: "Mapping[str, HeldReach]", circles: "Mapping[str, CircleReach]", folder: Path
) -> list[Path]:
    """Write held_NAME.csv (points and postures) and circle_NAME.csv (joints along the arcs)."""
    tables = {f"held_{name}.csv": found.to_frame() for name, found in held.items()}
    tables |= {f"circle_{name}.csv": found.trajectories() for name, found in circles.items()}
    return [write_whole(folder / name, t.to_csv(index=False)) for name, t in tables.items()]


def _number(text: str) -> float | None:
    from math import isfinite

    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None
