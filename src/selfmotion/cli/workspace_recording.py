"""The option --recording of `selfmotion workspace`: recorded hand positions against the arms."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.output import Number, Part, numbers
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.reach_clouds import CloudReach
    from selfmotion.methods.workspace import Workspace

# Recorded positions that are held against the workspace: at most so many, evenly chosen.
MOST_RECORDED = 5000
# No hand is so far from the origin of its ground (m): millimetres taken for metres are.
FARTHEST = 20.0


class Regions(Part, frozen=True, kw_only=True):
    """A number of the free arm, of the limited arm, and of what the limits take away."""

    free: Number = None
    limited: Number = None
    lost: Number = None


class Cloud(Part, frozen=True, kw_only=True):
    """One recording against one arm: shares in %, distances in mm.

    Outside: how far the hand stays short. Depth: how far inside the boundary, over by the spacing
    of the boundary's known points at most. Used: the part of the workspace within 50 mm of the
    recording. In front, above, outwards: of the shoulder.
    """

    recording: str
    workspace: str
    points: int
    inside_percent: Number
    outside_median_mm: Number
    outside_most_mm: Number
    depth_median_mm: Number
    in_body_percent: Number
    used_percent: Number
    used_error_percent: Number
    in_front_percent: Number
    above_percent: Number
    outwards_percent: Number


class Recorded(Part, frozen=True, kw_only=True):
    """Recorded hand positions against the workspace.

    `inside_percent` of the points are reached; the worst of the others lies `farthest_mm` away.
    """

    points: int
    inside_percent: Regions
    farthest_mm: Regions
    clouds: list[Cloud]


def clouds_of(space: "Workspace", name: str, path: Path) -> "dict[str, tuple[CloudReach, ...]]":
    """Hold recorded positions against the arms of a workspace; `name` is what it calls free.

    Raises:
        FileFormatError: the recordings hold neither hand positions nor angles of this arm.
    """
    from selfmotion.methods.reach_clouds import compare_clouds

    clouds = recorded_clouds(space.arm, path)
    out = {name: compare_clouds(space, clouds)}
    if space.limited_arm is not None:
        out["limited"] = compare_clouds(space, clouds, region="limited")
    return out


def recorded_part(clouds: "Mapping[str, tuple[CloudReach, ...]]") -> Recorded:
    """Give the part of the document."""
    import msgspec
    import numpy as np

    inside, farthest, rows, count = {}, {}, [], 0
    for limits, found in clouds.items():
        distance = np.concatenate([cloud.distance for cloud in found])
        count = len(distance)
        inside[limits] = 100.0 * float((distance <= 0).mean())
        farthest[limits] = 1e3 * float(max(distance.max(), 0.0))
        for cloud in found:
            row = {**cloud.row(), "workspace": limits}
            plain = {k: numbers([v])[0] if isinstance(v, float) else v for k, v in row.items()}
            rows.append(msgspec.convert(plain, Cloud))
    return Recorded(
        points=count,
        inside_percent=Regions(**inside),
        farthest_mm=Regions(**farthest),
        clouds=rows,
    )


def save_clouds(clouds: "Mapping[str, tuple[CloudReach, ...]]", folder: Path) -> Path:
    """Write recordings.csv: a row a recording and arm."""
    import pandas as pd

    rows = [{**c.row(), "workspace": name} for name, found in clouds.items() for c in found]
    return write_whole(folder / "recordings.csv", pd.DataFrame(rows).to_csv(index=False))


def recorded_clouds(arm: "Arm", path: Path) -> "dict[str, np.ndarray]":
    """Give recorded hand positions (K, 3) in the ground by recording, gaps left out.

    Args:
        arm: for recordings that hold joint angles.
        path: a file, or a folder of them.

    Raises:
        FileFormatError: a file holds neither hand positions nor angles of this arm, or only gaps.
    """
    import numpy as np

    from selfmotion.kinematics.forward import forward_kinematics
    from selfmotion.motion.files import load

    parts: dict[str, np.ndarray] = {}
    files = sorted(file for file in path.iterdir() if file.is_file()) if path.is_dir() else [path]
    plain = {file: x for file in files if (x := plain_positions(file)) is not None}
    parts |= {file.stem: x for file, x in plain.items()}
    others = [file for file in files if file not in plain]
    for recording in (recording for file in others for recording in load(file)):
        if recording.x is not None and recording.x.shape[1] == 3:
            x = recording.x
        elif recording.q is not None and set(arm.joints) <= set(recording.joints):
            order = [recording.joints.index(joint) for joint in arm.joints]
            q = recording.q[:, order]
            whole = np.isfinite(q).all(axis=1)
            x = forward_kinematics(arm.chain, q[whole], arm.tip("hand"))[:, :3, 3]
        else:
            raise FileFormatError(
                f"{recording.name}: holds {', '.join(recording.held)}; hand positions x, y, z, or "
                f"the angles of {arm.name} are needed"
            )
        x = x[np.isfinite(x).all(axis=1)]
        if len(x):
            name = (
                recording.name if recording.name not in parts else f"{recording.name} {len(parts)}"
            )
            parts[name] = x
    if not parts:
        raise FileFormatError(f"{path}: no hand position without gap")
    for name, x in parts.items():
        require_metres(f"{path}: {name}" if path.is_dir() else str(path), x)
    step = -(-sum(map(len, parts.values())) // MOST_RECORDED)
    return {name: x[::step] for name, x in parts.items()}


def require_metres(where: str, x: "np.ndarray") -> None:
    """Refuse positions (K, 3) that no hand has in metres; `where` names what holds them.

    Raises:
        RangeError: one is farther from the ground's origin than any hand.
    """
    import numpy as np

    far = float(np.nanmax(np.abs(x), initial=0.0))
    if far > FARTHEST:
        raise RangeError(
            f"{where}: a hand position of {far:.6g} m; allowed is up to {FARTHEST:g} m; columns in "
            "millimetres are named x_mm, y_mm, z_mm"
        )


def plain_positions(file: Path) -> "np.ndarray | None":
    """Give the positions (K, 3) of a CSV with the columns x, y, z (m); None: it is no such file.

    Raises:
        FileFormatError: it is one, and a cell is wrong.
    """
    from selfmotion.cli.tables import read_rows

    if file.suffix.lower() != ".csv" or not file.is_file():
        return None
    with file.open(encoding="utf-8-sig", errors="replace") as stream:
        names = {word.strip().removesuffix("_mm") for word in stream.readline().split(",")}
    if not {"x", "y", "z"} <= names:
        return None
    rows = read_rows(file, ("x", "y", "z"))
    return rows.array(("x", "y", "z"))[rows.good]
