"""The option --map-to of `selfmotion workspace`: hand positions mapped to another's workspace."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from selfmotion.cli.output import Number, Part, Vector, numbers
from selfmotion.errors import RangeError
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.workspace_mapping import WorkspaceMapping

MapTo: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--map-to", metavar="OTHER.toml", help="Map hand positions onto this person's workspace."
    ),
]
MapPoints: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--map-points", metavar="FILE.csv", help="Hand positions for --map-to: x, y, z (m)."
    ),
]
Envelope = Literal["outermost", "unbroken"]
MapEnvelope: TypeAlias = Annotated[
    Envelope,
    typer.Option(
        "--envelope", help="For --map-to: with hollows, or only as far as all is reached."
    ),
]


class MappedPoint(Part, frozen=True, kw_only=True):
    """A hand position and its image (m).

    `share` of the way from the centre to the envelope is the same for both; above 1 is outside.
    All but the point is null in a row with a gap.
    `short_mm` is how far the other person stays short of the image; 0: it is reached.
    """

    point: Vector
    image: Vector
    share: Number
    short_mm: Number


class Mapping(Part, frozen=True, kw_only=True):
    """Hand positions mapped onto another person's workspace.

    `filled` is the part of either envelope that is reached.
    """

    to: str
    envelope: str
    centres: list[Vector]
    volumes_m3: list[Number]
    filled: list[Number]
    points: list[MappedPoint]
    status: str


@dataclass(frozen=True, eq=False)
class Mapped:
    """Points, images, shares and how far images are out of reach (m); NaN in rows with gaps."""

    mapping: "WorkspaceMapping"
    to: str
    points: "np.ndarray"
    images: "np.ndarray"
    share: "np.ndarray"
    short: "np.ndarray"

    @property
    def gaps(self) -> int:
        """Number of rows without an image, since a coordinate is missing."""
        import numpy as np

        return int(np.isnan(self.share).sum())

    def to_frame(self) -> "pd.DataFrame":
        """Give the table of mapped.csv (m, mm)."""
        import pandas as pd

        columns = dict(zip(("x", "y", "z"), self.points.T, strict=True))
        columns |= dict(zip(("image_x", "image_y", "image_z"), self.images.T, strict=True))
        return pd.DataFrame(columns | {"share": self.share, "short_mm": 1e3 * self.short})


def mapped_points(
    arm: "Arm", other: Path | None, points: Path | None, *, envelope: Envelope, default_arm: str
) -> Mapped | None:
    """Map the points of a file from an arm onto the arm of another person.

    Args:
        arm: whose hand positions these are.
        other: TOML of the other person; their limited arm counts.
        points: CSV with x, y, z (m).
        envelope: kind of envelope.
        default_arm: the other person's arm where their file names none.

    Returns:
        None where nothing is asked for.

    Raises:
        SelfmotionError: one of the two files is missing or wrong.
    """
    import numpy as np

    from selfmotion.cli.subject import read_subject
    from selfmotion.cli.subject_arms import Typed, person_arms
    from selfmotion.cli.tables import read_rows
    from selfmotion.cli.workspace_recording import require_metres
    from selfmotion.methods.reach_clouds import out_of_reach
    from selfmotion.methods.workspace_mapping import workspace_mapping

    if other is None and points is None:
        return None
    if other is None:
        raise RangeError(f"--map-points {points}: name the other person with --map-to OTHER.toml")
    if points is None:
        raise RangeError(f"--map-to {other}: name the hand positions with --map-points FILE.csv")
    person = person_arms(read_subject(other), other, Typed(default_arm))
    rows = read_rows(points, ("x", "y", "z"))
    x, good = rows.array(("x", "y", "z")), rows.good
    require_metres(str(points), x)
    target = person.limited or person.free
    mapping = workspace_mapping(arm, target, kind=envelope)
    images, share, short = (
        np.full(x.shape, np.nan),
        np.full(len(x), np.nan),
        np.full(len(x), np.nan),
    )
    images[good], share[good] = mapping.map_points(x[good]), mapping.source.gauge(x[good])
    short[good] = out_of_reach(target, images[good])
    return Mapped(mapping, person.name or other.name, x, images, share, short)


def mapping_part(found: Mapped, envelope: str) -> Mapping:
    """Give the part of the document."""
    mapping = found.mapping
    numbers_of = (numbers(found.share), numbers(1e3 * found.short))
    rows = zip(found.points, found.images, *numbers_of, strict=True)
    known = len(found.short) - found.gaps
    missed = int((found.short > 0).sum())
    return Mapping(
        to=found.to,
        envelope=envelope,
        centres=[numbers(mapping.source.centre), numbers(mapping.target.centre)],
        volumes_m3=[mapping.source.volume, mapping.target.volume],
        filled=list(mapping.fill),
        points=[
            MappedPoint(point=numbers(x), image=numbers(y), share=share, short_mm=short)
            for x, y, share, short in rows
        ],
        status=f"{mapping.summary()} {known - missed} of {known} images are reached."
        + (f" Rows with gaps: {found.gaps}." if found.gaps else ""),
    )


def save_mapped(found: Mapped, folder: Path) -> Path:
    """Write mapped.csv."""
    return write_whole(folder / "mapped.csv", found.to_frame().to_csv(index=False))
