"""The option --map of `selfmotion workspace`: maps over the reachable grid, as a batch."""

import functools
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from selfmotion.cli.batches import BatchChoices, fingerprint, run_items
from selfmotion.cli.output import Number, Part, numbers
from selfmotion.errors import RangeError
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.batch import Item
    from selfmotion.kinematics.arm import Arm
    from selfmotion.kinematics.body_shapes import BodyShapes
    from selfmotion.methods.workspace_maps import Mapper, WorkspaceMaps

MapNames: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--map",
        metavar="NAME,NAME",
        help="Maps of the arm (the limited one, if any): margin, manipulability, effort.",
    ),
]
MapStep: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--map-step",
        metavar="M",
        help="Spacing of the maps' grid; left out: 0.05 m, with effort 0.1 m.",
    ),
]
STEP, EFFORT_STEP = 0.05, 0.1
# Points of one item of a batch.
ITEM_POINTS, EFFORT_POINTS = 4000, 8


class MapNumbers(Part, frozen=True, kw_only=True):
    """A map over the points reached; `best_at` is where it is best (m).

    Units: margin is the share of half range that every joint can keep from its limits,
    manipulability in m³, effort the sum of squared activations.
    """

    name: str
    median: Number
    best: Number
    best_at: list[Number]


class Maps(Part, frozen=True, kw_only=True):
    """Maps over a grid; the values are in maps.vtk, maps.ply and maps.csv (--out).

    `failed` points of the grid have no value since something went wrong there.
    """

    limits: str
    step_m: float
    shape: list[int]
    points: int
    reached: int
    failed: int
    maps: list[MapNumbers]


@dataclass(frozen=True, eq=False)
class MapChoices:
    """What --map and its companions say.

    Attributes:
        names: as typed.
        step: spacing (m), or None.
        model: name or file of the arm, for its muscles.
        batch: where the items run.
    """

    names: str
    step: float | None
    model: str
    batch: BatchChoices


@dataclass(frozen=True, eq=False)
class MapItem:
    """Points of the grid that are looked at together.

    Attributes:
        arm: fields of the arm.
        model: name of the arm with muscles, or nothing.
        maps: which maps.
        points: (K, 3) m.
    """

    arm: dict[str, Any]
    model: str
    maps: tuple[str, ...]
    points: "np.ndarray"


def maps_of(
    arm: "Arm", body: "BodyShapes | None", choices: MapChoices
) -> "tuple[WorkspaceMaps, int]":
    """Compute maps of an arm; gives also the number of points that failed.

    Raises:
        SelfmotionError: a map is unknown, or the arm has no muscles for effort, or nothing is
            reached.
    """
    import numpy as np

    from selfmotion.methods.workspace_maps import assemble

    names = tuple(dict.fromkeys(word.strip() for word in choices.names.split(",") if word.strip()))
    mapper = mapper_of(arm, choices.model if "effort" in names else "", names)
    step = choices.step
    if step is None:
        step = EFFORT_STEP if "effort" in names else STEP
    grid = mapper.grid(step)
    points = grid.points
    rows = np.arange(len(points)) if body is None else np.flatnonzero(~body.inside(points))
    # Effort takes long: the other maps say first which points are reached.
    kinds = [(tuple(n for n in mapper.maps if n != "effort") or ("margin",), ITEM_POINTS, "maps")]
    if "effort" in names:
        kinds.append((("effort",), EFFORT_POINTS, "effort"))
    values = {name: np.full(len(points), np.nan) for name in mapper.maps}
    q = np.full((len(points), arm.n_joints), np.nan)
    reached, failed = np.zeros(len(points), dtype=np.bool_), 0
    for kind, size, label in kinds:
        parts = np.array_split(rows, max(1, -(-len(rows) // size)))
        items = items_of(arm, choices.model if label == "effort" else "", kind, points, parts)
        batch = replace(choices.batch, name=f"workspace-{label}")
        for part, outcome in zip(parts, run_items(solve_item, items, batch), strict=True):
            if outcome.result is None:
                failed += len(part)
                continue
            found = outcome.result
            if label == "maps":
                reached[part], q[part] = found["reached"], _numbers(found["q"])
            for name in mapper.maps:
                if name in found["values"]:
                    values[name][part] = _numbers(found["values"][name])
        rows = np.flatnonzero(reached)
    whole = np.arange(len(points))
    return assemble(mapper, grid, [(whole, reached, q, values)]), failed


def mapper_of(arm: "Arm", model: str, names: tuple[str, ...]) -> "Mapper":
    """Prepare an arm, with muscles where a model is named.

    Raises:
        SelfmotionError: a map is unknown, or the model has no muscles.
    """
    from selfmotion.methods.workspace_maps import Mapper

    if not model:
        return Mapper.of(arm, names)
    Mapper.of(arm, [name for name in names if name != "effort"] or ["margin"])
    if model != "myoarm" and Path(model).suffix.lower() not in (".osim", ".xml"):
        raise RangeError(
            f"--map effort: {model} has no muscles; allowed is --arm myoarm, FILE.osim or FILE.xml"
        )
    return Mapper.of(replace(_muscles(model), arm=arm), names)


@functools.cache
def _muscles(model: str) -> Any:
    from selfmotion.cli.models import load_muscles

    return load_muscles(model, None)


def items_of(
    arm: "Arm", model: str, maps: tuple[str, ...], points: "np.ndarray", parts: "list[np.ndarray]"
) -> "list[Item]":
    """Give the items of a batch: parts of the grid."""
    from selfmotion.batch import Item
    from selfmotion.provenance import hash_arrays

    plain = arm_fields(arm)
    same = fingerprint(maps, model, arm.name, hash_arrays(arm.lower, arm.upper, arm.chain.offsets))
    return [
        Item(
            f"{','.join(maps)} {number}",
            MapItem(plain, model, maps, points[part]),
            fingerprint(same, hash_arrays(points[part])),
        )
        for number, part in enumerate(parts)
    ]


def arm_fields(arm: "Arm") -> dict[str, Any]:
    """Give the fields of an arm so that they can be sent to another process."""
    out = {}
    for f in fields(arm):
        value = getattr(arm, f.name)
        out[f.name] = dict(value) if f.name in ("landmarks", "lengths") else value
    return out


def solve_item(item: MapItem) -> dict[str, Any]:
    """Compute maps at some points; gives what JSON can hold."""
    from selfmotion.kinematics.arm import Arm

    mapper = mapper_of(Arm(**item.arm), item.model, item.maps)
    reached, q, values = mapper.at(item.points)
    return {
        "reached": reached.tolist(),
        "q": numbers(q),
        "values": {name: numbers(value) for name, value in values.items()},
    }


def maps_part(found: "WorkspaceMaps", limits: str, failed: int) -> Maps:
    """Give the part of the document."""
    import numpy as np

    points, parts = found.grid.points, []
    for name, value in found.values.items():
        known = np.isfinite(value)
        best = None
        if known.any():
            best = int(np.nanargmin(value) if name == "effort" else np.nanargmax(value))
        parts.append(
            MapNumbers(
                name=name,
                median=None if best is None else float(np.nanmedian(value)),
                best=None if best is None else float(value[best]),
                best_at=[] if best is None else numbers(points[best]),
            )
        )
    return Maps(
        limits=limits,
        step_m=found.grid.spacing,
        shape=list(found.grid.shape),
        points=len(found.reached),
        reached=int(found.reached.sum()),
        failed=failed,
        maps=parts,
    )


def save_maps(found: "WorkspaceMaps", folder: Path) -> list[Path]:
    """Write maps.vtk, maps.ply and maps.csv."""
    from selfmotion.methods.reaching.map_files import write_ply, write_vtk

    return [
        write_vtk(folder / "maps.vtk", found),
        write_ply(folder / "maps.ply", found),
        write_whole(folder / "maps.csv", found.to_frame().to_csv(index=False)),
    ]


def _numbers(values: object) -> "np.ndarray":
    import numpy as np

    return np.array(values, dtype=np.float64)  # None becomes NaN
