"""Which marker is what: how a laboratory's marker set stands for the segments of an arm.

Names may hold ``{S}`` for the letter of the recorded side (R or L) and ``{O}`` for the other one,
so that one protocol serves both arms.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from selfmotion.errors import FileFormatError, UnknownNameError, unknown_name
from selfmotion.motion.labels import Frame
from selfmotion.motion.markers import MarkerSet, without_prefix_of

CLUSTERS = ("trunk", "shoulder", "upper_arm", "forearm", "hand")
LANDMARKS = (
    "sternum",
    "acromion",
    "lateral_epicondyle",
    "medial_epicondyle",
    "radial_styloid",
    "ulnar_styloid",
    "knuckle",
)
SIDES = {"right": "R", "left": "L"}


@dataclass(frozen=True)
class Protocol:
    """The markers of one laboratory.

    Attributes:
        name: of the marker set.
        clusters: segment (`CLUSTERS`) to the names of its markers, at least three each.
        landmarks: landmark (`LANDMARKS`) to the name of its marker; the bony ones are needed in
            the static trial only. `acromion` is any marker above the shoulder joint.
        lateral: two markers, left and right, whose line points across the trunk at rest.
        frame: axes of the laboratory.
        sternoclavicular: of the recorded side, from the sternal marker: outwards, forward, up (m).
        shoulder: the shoulder centre from the acromial marker: outwards, forward, up (m); where
            the search for the functional centre starts from.
        shoulder_deviation: standard deviation of that (m).
        knuckle_radial: how far the knuckle's marker lies to the radial side of the hand's axis, the
            third metacarpal (m).
        limb_deviation: standard deviation of the functional centres of elbow and wrist from the
            middle between their bony landmarks (m).
        sides: arms that carry the markers.
    """

    name: str
    clusters: Mapping[str, tuple[str, ...]]
    landmarks: Mapping[str, str]
    lateral: tuple[str, str]
    frame: Frame = Frame()
    sternoclavicular: tuple[float, float, float] = (0.02, -0.01, 0.0)
    shoulder: tuple[float, float, float] = (-0.03, -0.015, -0.05)
    shoulder_deviation: float = 0.03
    knuckle_radial: float = 0.0
    limb_deviation: float = 0.02
    sides: tuple[str, ...] = ("right", "left")

    def __post_init__(self) -> None:
        """Check that every cluster and landmark is named."""
        for kind, known, given in (
            ("cluster", CLUSTERS, self.clusters),
            ("landmark", LANDMARKS, self.landmarks),
        ):
            for name in given:
                if name not in known:
                    raise unknown_name(kind, name, known)
            missing = [name for name in known if name not in given]
            if missing:
                raise FileFormatError(
                    f"marker protocol {self.name}: no {kind} {', '.join(missing)}"
                )

    def markers(self) -> set[str]:
        """Give the names of all markers."""
        clustered = {name for group in self.clusters.values() for name in group}
        return clustered | {*self.landmarks.values(), *self.lateral}

    def select(self, markers: MarkerSet) -> MarkerSet:
        """Keep the markers of the protocol, in its frame where the file tells none.

        Raises:
            UnknownNameError: none of them is there.
            RangeError: those of two people are.
        """
        wanted = self.markers()
        seen = without_prefix_of(markers, wanted)
        kept = [name for name in seen.names if name in wanted]
        if not kept:
            raise UnknownNameError(
                f"{markers.name}: none of the markers of protocol {self.name} "
                f"({', '.join(sorted(wanted)[:6])}, ...); there are "
                f"{', '.join(seen.names[:6])}, ..."
            )
        known = seen if seen.frame.known else replace(seen, frame=self.frame)
        return known.select(kept)

    def for_side(self, side: str) -> "Protocol":
        """Fill in the letters of a side.

        Raises:
            UnknownNameError: the side is neither right nor left, or carries no markers.

        Example:
            >>> REACHING.for_side("left").landmarks["acromion"]
            'LGTH'
        """
        if side not in SIDES:
            raise unknown_name("side", side, tuple(SIDES))
        if side not in self.sides:
            raise unknown_name(f"side of marker protocol {self.name}", side, self.sides)
        letter = SIDES[side]
        other = "L" if letter == "R" else "R"

        def fill(name: str) -> str:
            return name.replace("{S}", letter).replace("{O}", other)

        return replace(
            self,
            clusters={k: tuple(fill(m) for m in v) for k, v in self.clusters.items()},
            landmarks={k: fill(v) for k, v in self.landmarks.items()},
        )


def _four(stem: str) -> tuple[str, ...]:
    return tuple(f"{{S}}{stem}{i}" for i in (1, 2, 3, 4))


# Four-marker clusters on acromion, upper arm, forearm and hand (after Freitas & Scholz 2009, doi
# 10.1016/j.humov.2009.01.003). The trunk is the sternum and the acromial cluster of the other
# side, which rests: that of the recorded side moves with the scapula.
REACHING = Protocol(
    name="reaching",
    clusters={
        "trunk": ("STRN", "{O}SHO1", "{O}SHO2", "{O}SHO3", "{O}SHO4"),
        "shoulder": _four("SHO"),
        "upper_arm": _four("UAR"),
        "forearm": _four("LAR"),
        "hand": _four("HAN"),
    },
    landmarks={
        "sternum": "STRN",
        "acromion": "{S}GTH",
        "lateral_epicondyle": "{S}LEP",
        "medial_epicondyle": "{S}MEP",
        "radial_styloid": "{S}SPR",
        "ulnar_styloid": "{S}SPU",
        "knuckle": "{S}FB",
    },
    lateral=("LSHO3", "RSHO3"),
    # The knuckle is that of the index finger, about a finger's breadth beside the third.
    knuckle_radial=0.02,
)
PROTOCOLS = {"reaching": REACHING}
# Those of other laboratories stand beside this file, one TOML each.
FOLDER = Path(__file__).parent / "protocols"


def protocol_names() -> tuple[str, ...]:
    """List the protocols that come with the library.

    Example:
        >>> "reaching" in protocol_names()
        True
    """
    return (*PROTOCOLS, *sorted(path.stem for path in FOLDER.glob("*.toml")))


def load_protocol(name: str | Path) -> Protocol:
    """Give a marker protocol by name, or read one from a TOML file.

    The file has the tables ``[clusters]`` and ``[landmarks]``, the key ``lateral = [LEFT, RIGHT]``
    and, where they differ from the defaults, ``frame = {up = "z", forward = "y"}``,
    ``sternoclavicular``, ``shoulder``, ``shoulder_deviation``, ``limb_deviation`` and
    ``knuckle_radial`` (m), ``sides``, and a table ``[lacking]``: landmark to the reason why the
    laboratory has no marker for it, which is then said.

    Raises:
        UnknownNameError: no protocol of that name.
        FileFormatError: the file cannot be read, or lacks something.

    Example:
        >>> load_protocol("reaching").landmarks["sternum"]
        'STRN'
    """
    if str(name) in PROTOCOLS:
        return PROTOCOLS[str(name)]
    path = Path(name)
    if path.suffix.lower() != ".toml":
        if str(name) not in protocol_names():
            raise unknown_name("marker protocol", str(name), (*protocol_names(), "FILE.toml"))
        path = FOLDER / f"{name}.toml"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML ({error})") from None
    return _from_table(path, table)


def _from_table(path: Path, table: dict) -> Protocol:
    known = {*Protocol.__dataclass_fields__, "lacking"}
    for key in table:
        if key not in known:
            raise unknown_name(f"key of {path}", key, tuple(sorted(known)))
    lacking = table.get("lacking")
    if isinstance(lacking, dict) and lacking:
        why = "; ".join(f"{name} ({reason})" for name, reason in lacking.items())
        raise FileFormatError(f"marker protocol {path.stem}: no landmark {why}")
    try:
        values = {k: v for k, v in table.items() if k != "lacking"}
        if "sides" in table:
            values["sides"] = tuple(map(str, table["sides"]))
        values["name"] = str(table.get("name", path.stem))
        values["clusters"] = {k: tuple(map(str, v)) for k, v in table["clusters"].items()}
        values["landmarks"] = {k: str(v) for k, v in table["landmarks"].items()}
        left, right = table["lateral"]
        values["lateral"] = (str(left), str(right))
        values["frame"] = Frame(**table.get("frame", {}))
        for key in ("sternoclavicular", "shoulder"):
            if key in table:
                out, forward, up = map(float, table[key])
                values[key] = (out, forward, up)
        return Protocol(**values)
    except (KeyError, TypeError, AttributeError) as error:
        raise FileFormatError(
            f"{path}: marker protocol: {error!r} is missing or no table"
        ) from None
    except ValueError as error:
        raise FileFormatError(f"{path}: marker protocol: {error}") from None
