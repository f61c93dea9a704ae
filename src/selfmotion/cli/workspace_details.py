"""What `selfmotion workspace --details` adds to the document."""

from typing import TYPE_CHECKING

import msgspec

from selfmotion.cli.output import numbers
from selfmotion.cli.workspace_document import BoundedBy, Details, NamedVolume, Regained, Regions

if TYPE_CHECKING:
    from selfmotion.methods.reaching.details import WorkspaceDetails
    from selfmotion.methods.reaching.regions import RegionReach


def details_of(found: "WorkspaceDetails", name: str) -> Details:
    """Give the part of the document; `name` is what the workspace calls free."""
    names = {"free": name, "limited": "limited", "lost": "lost"}
    boundary = {}
    for key, limits in found.boundary.items():
        rows = limits.to_frame().to_dict("records")
        boundary[names[key]] = [
            msgspec.convert({k: _plain(v) for k, v in row.items()}, BoundedBy) for row in rows
        ]
    regained = [
        Regained(
            joint=joint,
            percent=numbers([100.0 * share.part])[0],
            standard_error_percent=numbers([100.0 * share.standard_error])[0],
            volume_m3=share.volume,
        )
        for joint, share in found.regained.items()
    ]
    entering = {names[k]: numbers([100.0 * s.part])[0] for k, s in found.enters_body.items()}
    return Details(
        regions=[_named_volume(r, names) for r in found.regions],
        boundary=boundary,
        regained=regained,
        enters_body_percent=Regions(**entering),
    )


def _named_volume(reach: "RegionReach", names: dict[str, str]) -> NamedVolume:
    return NamedVolume(
        name=reach.region.name,
        title=reach.region.title,
        space_m3=reach.space if reach.region.bounded else None,
        volume_m3=Regions(**{names[k]: r.volume for k, r in reach.sets.items()}),
        stderr_m3=Regions(**{names[k]: r.standard_error for k, r in reach.sets.items()}),
    )


def _plain(value: object) -> object:
    return numbers([value])[0] if isinstance(value, float) else value
