"""The synthetic part of [Li2022] on an arm with muscles: Figs 3 to 6, timing, Table IV.

DOI 10.1109/TNSRE.2022.3198400. Figs 7 to 9 compare with five recorded people; that is the work of
the predictors, on recordings. What the paper leaves open and what is assumed here: the poses of
`li2022_poses`; the pose of Figs 4 and 6, "in front of the human", is the one within `IN_FRONT` of
straight ahead of the shoulder whose self-motion range is nearest to the paper's 74.3 degrees.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.swivel import arm_swivel_angle, swivel_angle
from selfmotion.methods.effort.curve import DRAWN_GAP, EffortCurve
from selfmotion.methods.effort.posture_result import NaturalPosture
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.provenance import Provenance
from selfmotion.redundancy.manifold import SelfMotionManifold
from selfmotion.studies.li2022_poses import (
    SPACING,
    cup_manifolds,
    from_straight_ahead,
    hybrid_errors,
    natural_postures,
    published_seconds,
    widest,
)
from selfmotion.studies.published import Ours, Published, as_text, beside

FIG_4_RANGE = np.deg2rad(74.3)
IN_FRONT = np.deg2rad(45.0)
# Poses at most, evenly among all, that say how Fig 4 varies with the pose.
FIG_4_POSES = 40
OTHER_ARM = "same kind: another arm"
OTHER_MACHINE = "same kind: another machine"

NUMBERS = (
    Published("fig3", "Fig 3", "displacement of the shoulder centre at 180 deg elevation: forward, "
              "up, right", (-6.8, 5.7, 5.7), "cm"),
    Published("poses", "Section IV-A", "vertical-cup poses on a 5 cm grid with a swivel range "
              "over 40 deg", (114,)),
    Published("fig4_range", "Fig 4", "range of self-motion of the example pose", (74.3,), "deg"),
    Published("fig4", "Fig 4", "swivel angle with the shoulder fixed against moving: mean, SD",
              (2.16, 1.02), "deg"),
    Published("eq12", "eq. 12", "elbow displacement by it, at most", (0.77,), "cm"),
    Published("ik_time", "Section IV-B", "hybrid inverse kinematics, a posture: mean, SD",
              (1.7, 0.2), "ms"),
    Published("search_time", "Section IV-B", "two-phase search, a pose: mean, SD", (794.0, 89.0),
              "s"),
    Published("error", "Table IV", "replication error on people: mean, SD", (3.73, 3.27), "deg",
              "needs recorded people: --recordings DIR --study FILE.toml"),
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
        published: poses on which the paper's own search runs too, evenly among those.
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
        hybrid: Fig 5: per pose, errors of starts and refined postures, and ψ_S - ψ_H (see
            `li2022_poses.hybrid_errors`).
        curves: Fig 6: effort along the example pose's feasible intervals.
        example: the natural posture of that pose.
        postures: one row a pose (see `li2022_poses.natural_postures`).
        timing: the times of section IV-B beside ours.
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
    timing: pd.DataFrame
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
    example = _example(manifolds)
    manifolds = _some(manifolds, s.most)
    postures = natural_postures(finder, manifolds)
    shoulder, swivel = shoulder_displacement(model.arm), swivel_disagreement(example)
    hybrid = hybrid_errors(model.arm, manifolds)
    searched = published_seconds(model, _some(manifolds, s.published))
    ours = (
        _poses_counted(n_found),
        _of_shoulder(shoulder),
        *_of_swivel(swivel, widest(example), _some(manifolds, FIG_4_POSES)),
        *_times(hybrid, searched),
    )
    choices = {"model": model.arm.name, "convention": model.convention, "spacing": s.spacing}
    return Reproduction(
        beside(NUMBERS, ours),
        shoulder,
        swivel,
        hybrid,
        tuple(finder.curves(example, gap=DRAWN_GAP)),
        finder.find(example.T_hand),
        postures,
        _timing(hybrid, searched, postures),
        pd.DataFrame(TABLE_IV, columns=["study", "replication error (deg)", "assumption"]),
        Provenance("reproduce li2022", choices=choices),
    )


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


def _example(manifolds: list[SelfMotionManifold]) -> SelfMotionManifold:
    """Choose the pose of Figs 4 and 6; where none is in front, among all."""
    ahead = [m for m in manifolds if from_straight_ahead(m) < IN_FRONT] or manifolds
    return min(ahead, key=lambda m: abs(widest(m) - FIG_4_RANGE))


def _some(manifolds: list[SelfMotionManifold], most: int | None) -> list[SelfMotionManifold]:
    """Take so many, evenly; None: all."""
    if most is None or most >= len(manifolds):
        return manifolds
    return [manifolds[i] for i in np.linspace(0, len(manifolds) - 1, most).astype(int)]


def _poses_counted(n_poses: int) -> Ours:
    note = "here on the whole grid; the paper's orientation of the cup and joint limits differ"
    return Ours("poses", (float(n_poses),), OTHER_ARM, note)


def _of_shoulder(shoulder: pd.DataFrame) -> Ours:
    last = 100.0 * shoulder[["forward", "up", "right"]].iloc[-1].to_numpy()
    note = (
        "the paper's arm is scaled to a person; a right shoulder's centre moves inwards, so that "
        "the last printed number lacks its minus"
    )
    return Ours("fig3", tuple(float(v) for v in last), OTHER_ARM, note)


def _of_swivel(
    swivel: pd.DataFrame, example_range: float, others: list[SelfMotionManifold]
) -> tuple[Ours, ...]:
    off = np.abs(swivel["difference_deg"].to_numpy())
    elbow = swivel["elbow_m"].to_numpy()
    means = [np.abs(swivel_disagreement(m)["difference_deg"]).mean() for m in others]
    low, middle, high = np.percentile(means, (25.0, 50.0, 75.0))
    note = (
        f"of one pose; over {len(means)} poses the mean is {middle:.2g} deg (median; quartiles "
        f"{low:.2g} to {high:.2g})"
    )
    chosen = "the pose in front of the shoulder that comes nearest to it"
    return (
        Ours("fig4_range", (float(np.rad2deg(example_range)),), OTHER_ARM, chosen),
        Ours("fig4", (float(off.mean()), float(off.std())), OTHER_ARM, note),
        Ours("eq12", (100.0 * float(elbow.max()),), OTHER_ARM, "of the same pose"),
    )


def _times(hybrid: pd.DataFrame, searched: np.ndarray) -> tuple[Ours, ...]:
    ik = hybrid["milliseconds"].to_numpy(dtype=float)
    return (
        Ours("ik_time", _mean_and_spread(ik), OTHER_MACHINE, "one core"),
        Ours("search_time", _mean_and_spread(searched), OTHER_MACHINE, _same_search(len(searched))),
    )


def _timing(hybrid: pd.DataFrame, searched: np.ndarray, postures: pd.DataFrame) -> pd.DataFrame:
    """Give the timing table: what, published, ours, how many were timed, a word."""
    printed = {n.key: f"{n.values[0]:g} ± {n.values[1]:g} {n.unit}" for n in NUMBERS[-3:-1]}
    milliseconds = postures["milliseconds"].to_numpy(dtype=float)
    rows = (
        ("hybrid inverse kinematics, a posture", printed["ik_time"], "ms",
         hybrid["milliseconds"].to_numpy(dtype=float), "the paper: a laptop, AMD R7 3750H"),
        ("two-phase search, a pose", printed["search_time"], "s", searched,
         _same_search(len(searched))),
        ("search of this library, a pose", "–", "ms", milliseconds, "certain to 1e-3 of effort"),
    )  # fmt: skip
    return pd.DataFrame(
        [
            {
                "what": what,
                "published": published,
                "mean ± SD": f"{' ± '.join(as_text(_mean_and_spread(v)).split(', '))} {unit}",
                "median": f"{as_text((float(np.median(v)) if len(v) else float('nan'),))} {unit}",
                "poses timed": len(v),
                "note": note,
            }
            for what, published, unit, v, note in rows
        ]
    )


def _same_search(poses: int) -> str:
    return f"the same search with this library's effort; {poses} poses"


def _mean_and_spread(values: np.ndarray) -> tuple[float, float]:
    mean = float(values.mean()) if len(values) else float("nan")
    return mean, float(values.std(ddof=1)) if len(values) > 1 else float("nan")
