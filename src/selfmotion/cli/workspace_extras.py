"""What `selfmotion workspace` can add: maps, reach with the hand held, recordings, a mapping."""

from collections.abc import Mapping as MappingOf
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from selfmotion.cli.batches import BatchChoices
from selfmotion.cli.subject_arms import PersonArms
from selfmotion.cli.workspace_held import (
    HeldChoices,
    circle_part,
    circle_reaches,
    held_part,
    held_reaches,
    save_held,
)
from selfmotion.cli.workspace_mapping import (
    Envelope,
    Mapped,
    mapped_points,
    mapping_part,
    save_mapped,
)
from selfmotion.cli.workspace_maps import MapChoices, maps_of, maps_part, save_maps
from selfmotion.cli.workspace_recording import clouds_of, recorded_part, save_clouds
from selfmotion.errors import FileFormatError, RangeError

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.hand_circle import CircleReach
    from selfmotion.methods.hand_constraints import HeldReach
    from selfmotion.methods.reach_clouds import CloudReach
    from selfmotion.methods.workspace import Workspace
    from selfmotion.methods.workspace_maps import WorkspaceMaps
    from selfmotion.report.html import Section


@dataclass(frozen=True, eq=False)
class ExtraChoices:
    """What the options say.

    Attributes:
        model: name or file of the arm.
        maps: names of maps, and spacing of their grid (m).
        held: rows held, and a circle.
        recording: file or folder, or None.
        map_to: the other person's file, and that of the points.
        envelope: kind of envelope for the mapping.
        batch: where maps are computed.
        seed: of what is drawn at random.
    """

    model: str
    maps: tuple[str | None, float | None]
    held: HeldChoices
    recording: Path | None
    map_to: tuple[Path | None, Path | None]
    envelope: Envelope
    batch: BatchChoices
    seed: int

    def __post_init__(self) -> None:
        """Check that nothing was typed in vain."""
        if self.maps[0] is None and self.maps[1] is not None:
            raise RangeError(f"--map-step {self.maps[1]:g}: name the maps with --map")
        if self.maps[0] is None and self.batch.resume:
            raise RangeError("--resume: only maps take so long; name them with --map")
        if self.maps[0] is None and self.batch.scheduler is not None:
            raise RangeError("--scheduler: only maps are shared out; name them with --map")
        if self.map_to == (None, None) and self.envelope != "outermost":
            raise RangeError(f"--envelope {self.envelope}: name the other person with --map-to")
        # Before the workspace is computed, which takes a while.
        for path in (self.recording, *(self.map_to if None not in self.map_to else ())):
            if path is not None and not path.exists():
                raise FileFormatError(f"{path}: no such file")


@dataclass(frozen=True, eq=False)
class Extras:
    """What was found; empty where it was not asked for.

    Attributes:
        limits: name of the arm that maps and mapping belong to: free or limited.
        maps: or None.
        failed: grid points without a value since something went wrong.
        held: limits to what is reached with rows held.
        circles: limits to arcs of the circle.
        clouds: limits to recordings against the workspace.
        mapped: or None.
        envelope: kind of envelope of the mapping.
    """

    limits: str
    maps: "WorkspaceMaps | None" = None
    failed: int = 0
    held: "MappingOf[str, HeldReach]" = field(default_factory=dict)
    circles: "MappingOf[str, CircleReach]" = field(default_factory=dict)
    clouds: "MappingOf[str, tuple[CloudReach, ...]]" = field(default_factory=dict)
    mapped: Mapped | None = None
    envelope: Envelope = "outermost"

    @property
    def items_failed(self) -> int:
        """Number of grid points and of rows to be mapped that have no result."""
        return self.failed + (0 if self.mapped is None else self.mapped.gaps)

    def parts(self) -> dict[str, Any]:
        """Give the parts of the document by key."""
        maps, mapped = self.maps, self.mapped
        return {
            "recording": recorded_part(self.clouds) if self.clouds else None,
            "maps": None if maps is None else maps_part(maps, self.limits, self.failed),
            "held": [held_part(name, found) for name, found in self.held.items()],
            "circles": [circle_part(name, found) for name, found in self.circles.items()],
            "mapping": None if mapped is None else mapping_part(mapped, self.envelope),
        }

    def save(self, folder: Path) -> list[Path]:
        """Write the files that belong to what was asked for."""
        paths = save_held(self.held, self.circles, folder)
        if self.clouds:
            paths.append(save_clouds(self.clouds, folder))
        if self.maps is not None:
            paths += save_maps(self.maps, folder)
        if self.mapped is not None:
            paths.append(save_mapped(self.mapped, folder))
        return paths

    def sections(self, space: "Workspace") -> "list[Section]":
        """Give the sections of the report."""
        from selfmotion.report.workspace_maps_page import (
            circle_section,
            clouds_section,
            held_section,
            mapping_section,
            maps_section,
        )

        out = [clouds_section(space, clouds) for clouds in self.clouds.values()]
        if self.maps is not None:
            out.append(maps_section(self.maps, self.limits))
        if self.held:
            out.append(held_section(self.held))
        if self.circles:
            out.append(circle_section(self.circles))
        if self.mapped is not None:
            out.append(mapping_section(self.mapped.mapping, self.mapped.to_frame()))
        return out

    def text(self) -> list[str]:
        """Give the lines that a person reads."""
        lines = [] if self.maps is None else [self.maps.summary()]
        if self.failed:
            lines.append(f"{self.failed} grid points could not be computed")
        lines += [f"{name}: {found.summary()}" for name, found in self.held.items()]
        lines += [f"{name}: {found.summary()}" for name, found in self.circles.items()]
        if self.mapped is not None:
            lines.append(mapping_part(self.mapped, self.envelope).status)
        return lines


def extras_of(space: "Workspace", name: str, person: PersonArms, choices: ExtraChoices) -> Extras:
    """Compute what was asked for; `name` is what the workspace calls free.

    Raises:
        SelfmotionError: something asked for is impossible, or a file is wrong.
    """
    arms: dict[str, Arm] = {name: space.arm}
    if space.limited_arm is not None:
        arms["limited"] = space.limited_arm
    limits = "limited" if "limited" in arms else name
    maps, failed = None, 0
    if choices.maps[0] is not None:
        wanted = MapChoices(choices.maps[0], choices.maps[1], choices.model, choices.batch)
        maps, failed = maps_of(arms[limits], person.body, wanted)
    return Extras(
        limits,
        maps,
        failed,
        held_reaches(space, arms, choices.held, choices.seed),
        circle_reaches(arms, choices.held),
        {} if choices.recording is None else clouds_of(space, name, choices.recording),
        mapped_points(
            arms[limits],
            *choices.map_to,
            envelope=choices.envelope,
            default_arm=choices.model,
        ),
        choices.envelope,
    )
