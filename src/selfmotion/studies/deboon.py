"""The three scenarios of [DeBoon], with the elbow free and in the splint.

J Biomech Eng, sections 4.2 to 4.5. The recordings behind figs 5 to 13 are not public: what is
compared is what the text and Table 3 print; the rest is our computation of the same pictures.

Deviations: scenarios 2 and 3 hold x, y, z and ψ (eqs 19 and 22 leave x, or y, and ψ free); the
device's centres are given from the sternal notch, the model's origin is the right
sternoclavicular joint, and the offset between them, which is not given, is a parameter.
"""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.arms import load_arm
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.methods.constrained_path import Arc, device_circle
from selfmotion.methods.reaching.feasible_arcs import feasible_arcs
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.workspace import Workspace, WorkspaceOptions, workspace
from selfmotion.studies.deboon_body import BodyPlaces, body_places

# Section 4.2: the splint's range of the elbow (64.2 to 114 degrees, in rad) and the lengths (m).
SPLINT = {"elbow_flexion": (np.deg2rad(64.2), np.deg2rad(114.0))}
LENGTHS = (("clavicle", 0.188), ("humerus", 0.286), ("forearm", 0.259), ("wrist to palm", 0.074))
RADII = (0.270, 0.330, 0.375)  # m, sections 4.4 and 4.5
HEIGHTS = tuple(step / 10 for step in range(-6, 7))  # m, 13 slices
# Table 3, degrees; the last three upper limits are not in the text at hand.
TABLE_3 = (
    (-14.1, 13.4),
    (-6.4, 12.2),
    (-21.3, 180.0),
    (0.4, 160.7),
    (-68.0, 133.0),
    (15.8, 150.7),
    (-27.9, None),
    (-72.1, None),
    (-5.0, None),
)
ELBOWS = ("free", "splinted")


@dataclass(frozen=True)
class DeviceScenario:
    """A device that leads the palm round a circle.

    Attributes:
        number: 2 or 3.
        plane: "yz" (sagittal) or "xz" (coronal).
        centre: of the circle from the sternal notch (m), on the plane of the device.
    """

    number: int
    plane: str
    centre: tuple[float, float, float]


SCENARIO_2 = DeviceScenario(2, "yz", (0.150, 0.360, -0.160))
SCENARIO_3 = DeviceScenario(3, "xz", (0.160, 0.400, -0.160))


@dataclass(frozen=True, eq=False)
class DeviceResult:
    """Feasible arcs of one scenario: (elbow, radius) to arcs."""

    scenario: DeviceScenario
    arcs: dict[tuple[str, float], tuple[Arc, ...]]

    def to_frame(self) -> pd.DataFrame:
        """Give a table: one row an arc, angles in degrees."""
        rows = []
        for (elbow, radius), arcs in self.arcs.items():
            for arc in arcs:
                flexion = np.rad2deg(arc.path.q[:, arc.path.task.arm.chain.index("elbow_flexion")])
                rows.append(
                    {
                        "scenario": self.scenario.number,
                        "elbow": elbow,
                        "radius_mm": 1e3 * radius,
                        "from_deg": np.rad2deg(arc.first),
                        "to_deg": np.rad2deg(arc.last),
                        "elbow_from_deg": flexion.min(),
                        "elbow_to_deg": flexion.max(),
                        "followed": arc.path.status.sentence,
                    }
                )
        return pd.DataFrame(rows)


@dataclass(frozen=True, eq=False)
class DeBoonStudy:
    """All of it: workspace, the body in it, device scenarios, printed numbers beside ours."""

    workspace: Workspace
    devices: tuple[DeviceResult, ...]
    numbers: pd.DataFrame
    places: BodyPlaces

    def summary(self) -> str:
        """Say what was found, and what cannot be compared."""
        return (
            f"{self.workspace.summary()} The recordings of the paper are not public, so that its "
            "measured curves cannot be compared with ours."
        )


@dataclass(frozen=True)
class StudySize:
    """How much is computed: options of the workspace, samples round a circle, slices."""

    options: WorkspaceOptions = field(default_factory=WorkspaceOptions)
    n_samples: int = 120
    heights: tuple[float, ...] = HEIGHTS


def deboon_study(
    *,
    size: StudySize | None = None,
    notch: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rng: np.random.Generator | None = None,
) -> DeBoonStudy:
    """Compute the three scenarios.

    Args:
        size: how much is computed.
        notch: sternal notch from the right sternoclavicular joint (m); not given in the paper.
        rng: of the workspace's points.
    """
    n = size or StudySize()
    free = load_arm("upper_limb")
    splinted = free.with_limits(SPLINT)
    space = workspace(free, limited=splinted, heights=n.heights, options=n.options, rng=rng)
    devices = tuple(
        device_scenario(scenario, free, splinted, n_samples=n.n_samples, notch=notch)
        for scenario in (SCENARIO_2, SCENARIO_3)
    )
    draw = np.random.default_rng(0) if rng is None else rng
    places = body_places(space, rng=draw)
    return DeBoonStudy(space, devices, printed_numbers(free, splinted), places)


def device_scenario(
    scenario: DeviceScenario,
    free: Arm,
    splinted: Arm,
    *,
    n_samples: int = 120,
    notch: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> DeviceResult:
    """Find the feasible arcs of one scenario for both elbows and all radii."""
    centre = np.add(scenario.centre, notch)
    arcs = {}
    for elbow, arm in zip(ELBOWS, (free, splinted), strict=True):
        task = HandRows(arm, ("x", "y", "z", "rot_y"))
        for radius in RADII:

            def path(angles: np.ndarray, r: float = radius) -> np.ndarray:
                points = device_circle(centre, r, scenario.plane, angles)
                return np.concatenate([points, np.zeros((len(points), 1))], axis=1)

            arcs[elbow, radius] = feasible_arcs(task, path, n_samples=n_samples)
    return DeviceResult(scenario, arcs)


def printed_numbers(free: Arm, splinted: Arm) -> pd.DataFrame:
    """Put the link lengths of section 4.2 and Table 3 beside those of the arm."""
    rows = []
    names = ("shoulder", "elbow", "wrist", "hand")
    joints = tip_positions(free.chain, free.middle(), [free.tip(name) for name in names])[0]
    lengths = np.linalg.norm(np.diff(joints, axis=0, prepend=np.zeros((1, 3))), axis=1)
    for (name, printed), ours in zip(LENGTHS, lengths, strict=True):
        rows.append(_beside("section 4.2", f"length of {name}", "mm", 1e3 * printed, 1e3 * ours))
    for (low, high), joint, mine in zip(TABLE_3, free.joints, _degrees(free), strict=True):
        rows.append(_beside("Table 3", f"{joint}, lower limit", "deg", low, mine[0]))
        rows.append(_beside("Table 3", f"{joint}, upper limit", "deg", high, mine[1]))
    splint = _degrees(splinted)[free.chain.index("elbow_flexion")]
    rows.append(_beside("Table 3", "splinted elbow, lower limit", "deg", 64.2, splint[0]))
    rows.append(_beside("Table 3", "splinted elbow, upper limit", "deg", 114.0, splint[1]))
    return pd.DataFrame(rows)


def _beside(
    where: str, quantity: str, unit: str, published: float | None, ours: float
) -> dict[str, object]:
    note = "" if published is not None else "not in the text at hand; assumed (Boone & Azen 1979)"
    value = np.nan if published is None else published
    return {
        "where": where,
        "quantity": quantity,
        "unit": unit,
        "published": value,
        "ours": float(ours),
        "note": note,
    }


def _degrees(arm: Arm) -> Float[np.ndarray, "coords 2"]:
    return np.rad2deg(np.stack([arm.lower, arm.upper], axis=1))
