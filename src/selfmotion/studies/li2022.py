"""The synthetic part of [Li2022] on an arm with muscles: Figs 3 to 6, timing, Table IV.

DOI 10.1109/TNSRE.2022.3198400. Figs 7 to 9 compare with five recorded people; that is the work of
the predictors, on recordings. What the paper leaves open and what is assumed here: a vertical cup
is held with the hand's x axis upwards and with the fingers' line (minus the hand's y axis) level,
half way between forward and across the body; the pose of Figs 4 and 6 is the one of the grid whose
self-motion range is nearest to the paper's 74.3 degrees.
"""

import time
from dataclasses import dataclass

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.arrays import Transform
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.swivel import arm_swivel_angle, swivel_angle
from selfmotion.methods.effort.curve import EffortCurve
from selfmotion.methods.effort.posture_result import NaturalPosture
from selfmotion.methods.hybrid_ik import HybridPostures, hybrid_ik
from selfmotion.methods.natural_posture import PostureFinder, SearchOptions
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.provenance import Provenance
from selfmotion.redundancy.manifold import SelfMotionManifold
from selfmotion.studies.published import KIND, Ours, Published, beside

# Poses count whose swivel angle may range over more than this (section IV-A).
LEAST_RANGE = np.deg2rad(40.0)
SPACING = 0.05  # m, of the grid of hand positions
# Direction of the fingers, from forward towards across the body (rad): an assumption.
FINGERS_ACROSS = np.deg2rad(45.0)
FIG_4_RANGE = np.deg2rad(74.3)

NUMBERS = (
    Published("fig3", "Fig 3", "displacement of the shoulder centre at 180 deg elevation: forward, "
              "up, right", (-6.8, 5.7, 5.7), "cm"),
    Published("poses", "Section IV-A", "vertical-cup poses on a 5 cm grid with a swivel range "
              "over 40 deg", (114,)),
    Published("fig4_range", "Fig 4", "range of self-motion of the example pose", (74.3,), "deg"),
    Published("fig4", "Fig 4", "swivel angle with the shoulder fixed against moving: mean, SD",
              (2.16, 1.02), "deg"),
    Published("eq12", "eq. 12", "elbow displacement by it, at most", (0.77,), "cm"),
    Published("ik_time", "Section IV-B", "hybrid inverse kinematics, a posture", (1.7,), "ms"),
    Published("search_time", "Section IV-B", "two-phase search, a pose", (794.0,), "s"),
    Published("error", "Table IV", "replication error on people: mean, SD", (3.73, 3.27), "deg"),
)  # fmt: skip

# [Li2022] Table IV, as printed: errors (deg) that other studies report on their own people.
TABLE_IV = (
    ("This work", "3.73 ± 3.27", "muscle effort of a high-fidelity arm"),
    ("Li et al. 2015", "< 5 (73 % of trials), > 10 (3 %)", "5 kinematic and dynamic criteria"),
    ("Kim et al. 2012", "< 5", "greatest manipulability towards the mouth"),
    ("Wu et al. 2016", "3.94 to 17.06", "shoulder, elbow, wrist and mouth in one plane"),
    ("Zanchettin et al. 2013", "< 9", "regression of swivel angle on hand pose"),
)


@dataclass(frozen=True)
class Size:
    """How much is computed.

    Attributes:
        spacing: of the grid (m); the paper's is 0.05.
        most: poses taken at most, evenly among those found; None: all.
        published: poses on which the paper's own search runs too.
    """

    spacing: float = SPACING
    most: int | None = None
    published: int = 3


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The paper's synthetic analysis, computed again.

    Attributes:
        table: each published number beside ours.
        shoulder: Fig 3: elevation (deg) and displacement forward, up, right (m).
        swivel: Fig 4: shoulder elevation (deg), swivel with fixed and with moving centre (deg).
        hybrid: Fig 5: per pose, errors of starts and refined postures, and ψ_S - ψ_H (deg).
        curves: Fig 6: effort along the example pose's feasible intervals.
        example: the natural posture of that pose.
        postures: one row a pose: where, range, swivel, effort, minima, status, milliseconds.
        table_iv: the paper's Table IV.
        provenance: where it comes from.
    """

    table: pd.DataFrame
    shoulder: pd.DataFrame
    swivel: pd.DataFrame
    hybrid: pd.DataFrame
    curves: tuple[EffortCurve, ...]
    example: NaturalPosture
    postures: pd.DataFrame
    table_iv: pd.DataFrame
    provenance: Provenance


def reproduce(model: MusculoskeletalArm, *, size: Size | None = None) -> Reproduction:
    """Compute Figs 3 to 6 and the timing table on an arm with muscles.

    Args:
        model: the default arm, or a user's own.
        size: how much is computed; left out: as much as the paper.

    Raises:
        RangeError: no pose of the grid has a range of swivel angle over 40 degrees.
    """
    s = size or Size()
    finder = PostureFinder.of(model)
    manifolds = cup_manifolds(finder, spacing=s.spacing)
    if not manifolds:
        raise RangeError(f"spacing = {s.spacing:g} m: no pose of the grid has a range over 40 deg")
    n_found = len(manifolds)
    if s.most is not None and s.most < n_found:
        some = np.unique(np.linspace(0, n_found - 1, s.most).astype(int))
        manifolds = [manifolds[i] for i in some]
    gap = [abs(widest(m) - FIG_4_RANGE) for m in manifolds]
    example = manifolds[int(np.argmin(gap))]
    postures = _postures(finder, manifolds)
    shoulder, swivel = shoulder_displacement(model.arm), swivel_disagreement(example)
    hybrid, ik_ms = _hybrid(model.arm, manifolds)
    search_s = _published_seconds(model, manifolds[: s.published])
    ours = _ours(n_found, shoulder, swivel, widest(example), ik_ms, search_s)
    choices = {"model": model.arm.name, "convention": model.convention, "spacing": s.spacing}
    return Reproduction(
        beside(NUMBERS, ours),
        shoulder,
        swivel,
        hybrid,
        tuple(finder.curves(example)),
        finder.find(example.T_hand),
        postures,
        pd.DataFrame(TABLE_IV, columns=["study", "replication error (deg)", "assumption"]),
        Provenance("reproduce li2022", choices=choices),
    )


def cup_pose(
    arm: Arm, position: Float[np.ndarray, "3"], across: float = FINGERS_ACROSS
) -> Transform:
    """Give the hand pose that holds a vertical cup at a place.

    Args:
        arm: whose up and forward it is about.
        position: of the hand's frame in the ground (m).
        across: direction of the fingers, from forward towards across the body (rad).
    """
    across_body = np.cross(arm.up, arm.forward)  # to the left of a person: across for a right arm
    fingers = np.cos(across) * arm.forward + np.sin(across) * across_body
    T = np.eye(4)
    T[:3, 0], T[:3, 1] = arm.up, -fingers
    T[:3, 2] = np.cross(T[:3, 0], T[:3, 1])
    T[:3, 3] = position
    return T


def cup_manifolds(finder: PostureFinder, *, spacing: float = SPACING) -> list[SelfMotionManifold]:
    """Give manifolds of the vertical-cup poses of a grid that have a wide range of swivel angle.

    The grid is centred on the shoulder at home and reaches as far as the arm is long.
    """
    arm = finder.model.arm
    home = np.clip(np.zeros(7), arm.lower, arm.upper)
    tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
    points = tip_positions(arm.chain, home, tips)[0]
    reach = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    count = int(reach / spacing)
    steps = spacing * np.arange(-count, count + 1)
    axes = (arm.forward, np.cross(arm.up, arm.forward), arm.up)
    out = []
    for a in steps:
        for b in steps:
            for c in steps:
                offset = a * axes[0] + b * axes[1] + c * axes[2]
                # Behind the shoulder no cup is held, and nearer than this the elbow is shut.
                if a < 0 or not 0.25 * reach < np.linalg.norm(offset) < 1.05 * reach:
                    continue
                pose = cup_pose(arm, points[0] + offset)
                found = finder.manifolds.find(pose, nearest=False)
                if found.intervals and widest(found) > LEAST_RANGE:
                    out.append(found)
    return out


def widest(manifold: SelfMotionManifold) -> float:
    """Give the width of the widest feasible interval of swivel angle (rad)."""
    return max(high - low for low, high in manifold.swivel_intervals)


def shoulder_displacement(arm: Arm, count: int = 181) -> pd.DataFrame:
    """Give where the shoulder centre goes with elevation, from home (Fig 3)."""
    home = np.clip(np.zeros(7), arm.lower, arm.upper)
    q = np.repeat(home[None], count, axis=0)
    q[:, 1] = np.linspace(arm.lower[1], arm.upper[1], count)
    S = tip_positions(arm.chain, np.vstack([home, q]), [arm.tip("shoulder")])[:, 0]
    moved = S[1:] - S[0]
    right = np.cross(arm.forward, arm.up)
    columns = {"elevation_deg": np.rad2deg(q[:, 1])}
    columns |= {
        k: moved @ d for k, d in (("forward", arm.forward), ("up", arm.up), ("right", right))
    }
    return pd.DataFrame(columns)


def swivel_disagreement(manifold: SelfMotionManifold, count: int = 100) -> pd.DataFrame:
    """Give swivel angles with the shoulder centre fixed at home and where it is (Fig 4)."""
    arm = manifold.arm
    interval = max(manifold.intervals, key=lambda i: i.swivel_range[1] - i.swivel_range[0])
    q = interval.at(np.linspace(0.0, interval.arc[-1], count))
    tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
    points = tip_positions(arm.chain, q, tips)
    moving = swivel_angle(points[:, 0], points[:, 1], points[:, 2], down=-arm.up)
    fixed = arm_swivel_angle(arm, q)
    off = (fixed - moving + np.pi) % (2 * np.pi) - np.pi
    axis = points[:, 2] - points[:, 0]
    lever = np.cross(points[:, 1] - points[:, 0], axis) / np.linalg.norm(axis, axis=1)[:, None]
    return pd.DataFrame(
        {
            "elevation_deg": np.rad2deg(q[:, 1]),
            "fixed_deg": np.rad2deg(interval.swivel_at(q)),
            "moving_deg": np.rad2deg(interval.swivel_at(q) - off),
            "difference_deg": np.rad2deg(off),
            "elbow_m": np.abs(off) * np.linalg.norm(lever, axis=1),  # eq. 12
        }
    )


def _postures(finder: PostureFinder, manifolds: list[SelfMotionManifold]) -> pd.DataFrame:
    rows = []
    for manifold in manifolds:
        start = time.perf_counter()
        found = finder.find(manifold.T_hand)
        spent = 1e3 * (time.perf_counter() - start)
        x, y, z = manifold.T_hand[:3, 3]
        rows.append(
            {
                "x": x,
                "y": y,
                "z": z,
                "range_deg": np.rad2deg(widest(manifold)),
                "swivel_deg": np.rad2deg(found.swivel),
                "effort": found.effort,
                "minima": len(found.minima),
                "jumps": len(found.jumps),
                "status": str(found.status),
                "milliseconds": spent,
            }
        )
    return pd.DataFrame(rows)


def _hybrid(arm: Arm, manifolds: list[SelfMotionManifold]) -> tuple[pd.DataFrame, float]:
    """Give Fig 5, and milliseconds a posture."""
    rows, spent, made = [], 0.0, 0
    for manifold in manifolds:
        start = time.perf_counter()
        found: HybridPostures = hybrid_ik(arm, manifold.T_hand)
        spent += time.perf_counter() - start
        made += max(len(found.q), 1)
        inside = found.feasible
        if not inside.any():
            continue
        off = np.rad2deg(found.uncertainty[inside])
        x, y, z = manifold.T_hand[:3, 3]
        row = {"x": x, "y": y, "z": z, "uncertainty_deg": off.mean(), "uncertainty_sd": off.std()}
        row |= dict(
            zip(("start_m", "start_rad"), found.start_error[inside].mean(axis=0), strict=True)
        )
        rows.append(row)
    return pd.DataFrame(rows), 1e3 * spent / max(made, 1)


def _published_seconds(model: MusculoskeletalArm, manifolds: list[SelfMotionManifold]) -> float:
    """Give seconds a pose of the paper's search, with this library's effort."""
    if not manifolds:
        return float("nan")
    finder = PostureFinder.of(model, search=SearchOptions(search="paper"))
    start = time.perf_counter()
    for manifold in manifolds:
        finder.find(manifold.T_hand)
    return (time.perf_counter() - start) / len(manifolds)


def _ours(
    n_poses: int,
    shoulder: pd.DataFrame,
    swivel: pd.DataFrame,
    example_range: float,
    ik_ms: float,
    search_s: float,
) -> tuple[Ours, ...]:
    last = 100.0 * shoulder[["forward", "up", "right"]].iloc[-1].to_numpy()
    off = np.abs(swivel["difference_deg"].to_numpy())
    elbow = swivel["elbow_m"].to_numpy()
    scaled = "another arm: the paper's is scaled to a person"
    return (
        Ours("fig3", tuple(float(v) for v in last), KIND, scaled),
        Ours("poses", (float(n_poses),), KIND, "limits, orientation and grid of the paper differ"),
        Ours("fig4_range", (float(np.rad2deg(example_range)),), KIND, "the pose chosen for it"),
        Ours("fig4", (float(off.mean()), float(off.std())), KIND, scaled),
        Ours("eq12", (100.0 * float(elbow.max()),), KIND, scaled),
        Ours("ik_time", (ik_ms,), KIND, "on this machine"),
        Ours("search_time", (search_s,), KIND, "the same search with this library's effort"),
    )
