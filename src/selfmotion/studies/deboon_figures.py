"""Each figure and table of [DeBoon] beside what is computed here, and how the two differ."""

import numpy as np
import pandas as pd

from selfmotion.studies.deboon import DeBoonStudy, DeviceResult


def counterparts(made: DeBoonStudy) -> pd.DataFrame:
    """Give a table, one row a figure or table of the paper: what it shows, ours, the difference.

    Args:
        made: the study.
    """
    regions = made.workspace.regions
    kept = 100.0 * regions["limited"].volume / regions["free"].volume
    hulls = [100.0 * _excess(made, name) for name in ("free", "limited")]
    rows = [
        (
            "Table 3",
            "ranges of nine joints, free and splinted",
            "first table",
            "the same; three upper limits of the wrist are lost in the text and assumed",
        ),
        (
            "Fig. 5",
            "recorded ranges of motion",
            "none",
            "recordings not public; workspace --ranges reads such recordings",
        ),
        (
            "Fig. 6",
            "hulls, free and splinted, in space",
            "hulls in space",
            f"splinted inside free in both; ours keeps {kept:.0f} % of the volume; hulls are "
            f"{hulls[0]:.1f} % (free) and {hulls[1]:.1f} % (splinted) above the sets",
        ),
        ("Fig. 7", "slice at z = 0, over-the-shoulder box", "island, slice z = 0", _island(made)),
        (
            "Figs 8, 9",
            "slices 100 mm apart, hulls of points, cut-outs",
            f"{len(made.workspace.slices)} slices",
            "ours are the sets reached, not hulls, which overstate a hollow slice; cut-outs are "
            "shapes of our own, since the paper gives no sizes",
        ),
    ]
    for device, figures in zip(made.devices, (("10", "11"), ("12", "13")), strict=True):
        rows += _device_rows(device, figures)
    return pd.DataFrame(rows, columns=pd.Index(["in the paper", "shows", "here", "difference"]))


def _excess(made: DeBoonStudy, name: str) -> float:
    """Give by how much the hull is larger than the set."""
    return made.workspace.hull_volume(name) / made.workspace.regions[name].volume - 1.0


def _island(made: DeBoonStudy) -> str:
    island = made.places.island
    if island is None:
        return "no slice at this height was computed"
    free, limited = (1e4 * island.area(name) for name in ("free", "limited"))
    text = f"reached over the shoulder only: {free:.0f} cm² free, {limited:.0f} cm² splinted"
    return f"{text}; with the printed ranges nearly all is reached the other way, too"


def _device_rows(device: DeviceResult, figures: tuple[str, str]) -> list[tuple[str, ...]]:
    """Give the rows of a scenario: its circles and its joints."""
    number = device.scenario.number
    shares, elbows = [], []
    for elbow in ("free", "splinted"):
        arcs = {r: a for (name, r), a in device.arcs.items() if name == elbow}
        part = [100 * sum(a.last - a.first for a in found) / (2 * np.pi) for found in arcs.values()]
        shares.append(f"{elbow} {', '.join(f'{share:.0f}' for share in part)} %")
        index = [a.path.task.arm.chain.index("elbow_flexion") for f in arcs.values() for a in f]
        angles = [
            a.path.q[:, i] for (i, a) in zip(index, sum(map(list, arcs.values()), []), strict=True)
        ]
        if angles:
            flexion = np.rad2deg(np.concatenate(angles))
            elbows.append(f"{elbow} {flexion.min():.0f} to {flexion.max():.0f}°")
    radii = ", ".join(f"{1e3 * r:.0f}" for r in sorted({r for _, r in device.arcs}))
    circles = (
        f"Fig. {figures[0]}",
        f"scenario {number}: circles of three radii",
        "arcs",
        f"feasible share of the circles of {radii} mm: {'; '.join(shares)}; the place of the "
        "sternal notch is not given",
    )
    joints = (
        f"Fig. {figures[1]}",
        f"scenario {number}: elbow and wrist along the circle",
        "joints along the arcs",
        f"elbow {'; '.join(elbows)}; the self-motion is so wide that other joints follow the cost "
        "chosen",
    )
    return [circles, joints]
