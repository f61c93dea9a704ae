"""Write maps for other programs: legacy VTK (a volume) and PLY (the points reached).

VTK's STRUCTURED_POINTS open in ParaView, 3D Slicer and MeshLab's kin; PLY in nearly every viewer
of points. Both are binary; lengths are metres. What is not reached is NaN in the volume (and 0 in
its field ``reached``) and left out of the PLY.
"""

from pathlib import Path

import numpy as np

from selfmotion.methods.reaching.map_result import WorkspaceMaps
from selfmotion.writing import write_whole


def write_vtk(path: str | Path, maps: WorkspaceMaps) -> Path:
    """Write maps as a legacy VTK file of structured points; give its path.

    Args:
        path: the file, by custom ``.vtk``.
        maps: what is written: the field ``reached`` (0 or 1) and each map.
    """
    grid = maps.grid
    head = [
        "# vtk DataFile Version 3.0",
        f"selfmotion workspace of {maps.arm.name}, metres"[:255],
        "BINARY",
        "DATASET STRUCTURED_POINTS",
        "DIMENSIONS " + " ".join(map(str, grid.shape)),
        "ORIGIN " + " ".join(f"{value:.17g}" for value in grid.origin),
        "SPACING " + " ".join([f"{grid.spacing:.17g}"] * 3),
        f"POINT_DATA {len(maps.reached)}",
    ]
    parts = ["\n".join(head).encode("ascii", "replace") + b"\n"]
    for name, value in _fields(maps).items():
        parts.append(f"SCALARS {name} double 1\nLOOKUP_TABLE default\n".encode("ascii"))
        parts.append(value.astype(">f8").tobytes() + b"\n")
    return write_whole(path, b"".join(parts))


def write_ply(path: str | Path, maps: WorkspaceMaps) -> Path:
    """Write the points reached, with the maps as properties, as a binary PLY; give its path.

    Args:
        path: the file, by custom ``.ply``.
        maps: what is written.
    """
    rows = maps.reached
    columns = dict(zip(("x", "y", "z"), maps.grid.points[rows].T, strict=True))
    columns |= {name: value[rows] for name, value in maps.values.items()}
    head = ["ply", "format binary_little_endian 1.0", f"comment selfmotion {maps.arm.name}, metres"]
    head += [f"element vertex {int(rows.sum())}"]
    head += [f"property double {name}" for name in columns] + ["end_header"]
    table = np.stack(list(columns.values()), axis=1).astype("<f8")
    return write_whole(path, "\n".join(head).encode("ascii", "replace") + b"\n" + table.tobytes())


def _fields(maps: WorkspaceMaps) -> dict[str, np.ndarray]:
    return {"reached": maps.reached.astype(np.float64), **maps.values}
