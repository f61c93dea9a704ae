"""Tables and numbers of the report on a workspace, and whose report it is."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion.capture.ranges import JointRange
from selfmotion.capture.scaling import ADULT_RANGES_DEG
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_frame import stature_of
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.reaching.boundary import BoundaryLimits
from selfmotion.methods.reaching.regions import RegionReach
from selfmotion.methods.reaching.volumes import Region
from selfmotion.methods.workspace import Workspace
from selfmotion.report.workspace_words import bound_title, is_anatomical, joined, joint_title

# Joints of the printed model that count their angles as clinics do; the others do not.
PRINTED_AS_CLINIC = ("shoulder_flexion", "elbow_flexion", "wrist_flexion")
# Limits that bound less than this (%) are left out of the table; the document holds all.
LEAST_SHOWN = 0.5
# Parts thousands; it does not break the line.
THIN_SPACE = "\u202f"


@dataclass(frozen=True, eq=False)
class PagePerson:
    """Whose page it is.

    Attributes:
        name: empty for nobody in particular.
        side: of the arm.
        body: what was cut out: seated, standing or none.
        measured: ranges from recordings, with the arm ("free", "limited") that they limit.
        shapes: the body that was cut out; None where none was.
        alone: whether only the limited arm was looked at.
        stature: m; None: from the arm's lengths.
        arm_outside: whether places count only where the arm keeps out of the body, too.
    """

    name: str
    side: str
    body: str = "none"
    measured: tuple[tuple[str, JointRange], ...] = ()
    shapes: BodyShapes | None = None
    alone: bool = False
    stature: float | None = None
    arm_outside: bool = False

    @property
    def cut_out(self) -> bool:
        """Whether the inside of some shapes was left out of the reach."""
        return self.shapes is not None


def body_words(person: PagePerson) -> str:
    """Say what was cut out: seated or standing, or the shapes of the person's file alone."""
    if not person.cut_out:
        return "not cut out"
    return person.body if person.body != "none" else "shapes of the person's file"


def person_frame(space: Workspace, person: PagePerson) -> pd.DataFrame:
    """Give a table of who it is: side, lengths, stature and body."""
    arm = space.arm
    rows = [("arm", f"{person.side}, model {arm.name}")]
    rows += [(k.replace("_", " "), f"{1e3 * v:.0f} mm") for k, v in arm.lengths.items()]
    body = body_words(person) + ("; its inside does not count" if person.cut_out else "")
    stature = f"{1e2 * stature_of(arm):.0f} cm" + (" (from the arm)" if arm.lengths else "")
    if person.stature is not None:
        stature = f"{1e2 * person.stature:.0f} cm"
    rows += [("stature", stature), ("body", body)]
    return pd.DataFrame(rows, columns=pd.Index(["person", person.name or "–"]))


def norms_of(arm: Arm) -> dict[str, tuple[float, float]]:
    """Give the norms (degrees) of the joints that count their angles as clinics do."""
    if is_anatomical(arm):
        return {j: span for j, span in ADULT_RANGES_DEG.items() if j in arm.joints}
    if arm.name.startswith("upper_limb"):
        return {joint: ADULT_RANGES_DEG[joint] for joint in PRINTED_AS_CLINIC}
    return {}


def ranges_frame(
    arm: Arm, limited: Arm | None, norms: dict[str, tuple[float, float]]
) -> pd.DataFrame:
    """Give a table, one row a joint: ranges and norms as "low to high" (degrees)."""
    rows = []
    for i, joint in enumerate(arm.joints):
        first = "range" if limited is None else "free"
        row = {"joint": joint_title(arm, joint), first: _span(arm, i)}
        if limited is not None:
            same = limited.lower[i] == arm.lower[i] and limited.upper[i] == arm.upper[i]
            row["limited"] = "as free" if same else _span(limited, i)
            row["lost (degrees)"] = _lost_degrees(arm, limited, i)
        if norms:
            low, high = norms.get(joint, (np.nan, np.nan))
            row["healthy adults"] = f"{_degrees(low)} to {_degrees(high)}" if low == low else "–"
        rows.append(row)
    return pd.DataFrame(rows)


def measured_frame(arm: Arm, person: PagePerson) -> pd.DataFrame:
    """Give a table of ranges from recordings (degrees)."""
    return pd.DataFrame(
        [
            {
                "joint": joint_title(arm, r.joint),
                "arm": kind,
                "from": np.degrees(r.low),
                "to": np.degrees(r.high),
                "repeats": r.repeats,
                "scatter of repeats": np.degrees(r.scatter),
                "recordings": ", ".join(Path(source).name for source in r.sources),
            }
            for kind, r in person.measured
        ]
    )


def volume_frame(space: Workspace, person: PagePerson) -> pd.DataFrame:
    """Give a table of volumes with errors, shares and hulls."""
    free = space.regions["free"]
    rows = []
    for name, region in space.regions.items():
        hull = "–"
        if name != "lost" and np.isfinite(space.hull_volume(name)):
            hull = f"{1e6 * space.hull_volume(name):,.0f}".replace(",", THIN_SPACE)
        rows.append(
            {
                "": set_title(name, person),
                "volume (cm³)": cm3(region.volume, region.standard_error),
                "share": "100 %" if region is free else percent(region, free),
                "hull (cm³)": hull,
            }
        )
    return pd.DataFrame(rows)


def regions_frame(regions: Sequence[RegionReach]) -> pd.DataFrame:
    """Give a table, one row a place: what the free arm reaches, what is kept and lost."""
    rows = []
    for reach in regions:
        free = reach.sets["free"]
        whole = reach.region.bounded and reach.space > 0
        first = "free arm (cm³)" if "lost" in reach.sets else "reached (cm³)"
        row = {
            "place": reach.region.title,
            first: cm3(free.volume, free.standard_error),
            "of the place": f"{100.0 * free.volume / reach.space:.0f} %" if whole else "–",
        }
        for name, title in (("limited", "kept"), ("lost", "lost")):
            if name in reach.sets:
                there = reach.sets[name]
                row[f"{title} (cm³)"] = cm3(there.volume, there.standard_error)
        rows.append(row)
    return pd.DataFrame(rows)


def boundary_frame(limits: BoundaryLimits) -> pd.DataFrame:
    """Give a table of the movements whose limits bound a workspace."""
    frame = limits.to_frame()
    names = [
        bound_title(limits.arm, joint, side).capitalize() for joint, side in limits.limit_names()
    ]
    table = pd.DataFrame(
        {
            "stopped by the limit of": names,
            "at (degrees)": frame["at_deg"],
            "share (%)": [
                f"{a:.0f} ± {b:.0f}"
                for a, b in zip(
                    frame["share_percent"], frame["standard_error_percent"], strict=True
                )
            ],
            "takes part in (%)": [f"{a:.0f}" for a in frame["takes_part_percent"]],
            "gain (mm per degree)": frame["mm_per_degree"],
        }
    )
    return table.loc[frame["share_percent"].to_numpy() >= LEAST_SHOWN]


def set_title(name: str, person: PagePerson) -> str:
    """Give what a set of the workspace is called on the page."""
    if person.alone and name == "free":
        return "With the limits"
    return {"free": "Free arm", "limited": "With the limits", "lost": "Lost"}[name]


def cm3(volume: float, error: float) -> str:
    """Write a volume (m³) with its standard error in cm³, to two digits of the error.

    Example:
        >>> cm3(0.9801923, 0.001513).replace(THIN_SPACE, " ")
        '980 200 ± 1 500'
    """
    value, scatter = 1e6 * volume, 1e6 * error
    digits = 1 - int(np.floor(np.log10(scatter))) if scatter > 0 else 0
    digits = min(digits, 0)
    text = f"{round(value, digits):,.0f} ± {round(scatter, digits):,.0f}"
    return text.replace(",", THIN_SPACE)


def percent(part: Region, whole: Region) -> str:
    """Give a share with its standard error, from the ratio of each shift."""
    ratio = 100.0 * part.volumes / whole.volumes
    return f"{ratio.mean():.1f} ± {ratio.std(ddof=1) / np.sqrt(len(ratio)):.1f} %"


def _span(arm: Arm, i: int) -> str:
    return f"{_degrees(np.degrees(arm.lower[i]))} to {_degrees(np.degrees(arm.upper[i]))}"


def _degrees(value: float) -> str:
    return f"{round(float(value), 1) + 0.0:g}".replace("-", "−")


def _lost_degrees(arm: Arm, limited: Arm, i: int) -> str:
    low = np.degrees(limited.lower[i] - arm.lower[i])
    high = np.degrees(arm.upper[i] - limited.upper[i])
    parts = []
    if low > 0:
        parts.append(f"{_degrees(low)} at the lower end")
    if high > 0:
        parts.append(f"{_degrees(high)} at the upper end")
    return joined(parts) if parts else "–"
