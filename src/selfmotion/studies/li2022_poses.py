"""The vertical-cup poses of [Li2022] section IV-A, and what is computed for each of them.

DOI 10.1109/TNSRE.2022.3198400: the poses of a grid whose self-motion is wide, their natural
postures, Fig 5 (errors of the hybrid inverse kinematics) and the times of section IV-B. Assumed:
a vertical cup is held with the hand's x axis upwards and with the fingers' line (minus the hand's
y axis) level, half way between forward and across the body.
"""

import time
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.arrays import Transform
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.srs import SrsRelative
from selfmotion.methods.hybrid_ik import hybrid_ik
from selfmotion.methods.natural_posture import PostureFinder, SearchOptions
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.redundancy.manifold import SelfMotionManifold
from selfmotion.redundancy.refine import refine

# Poses count whose swivel angle may range over more than this (section IV-A).
LEAST_RANGE = np.deg2rad(40.0)
SPACING = 0.05  # m, of the grid of hand positions
# Direction of the fingers, from forward towards across the body (rad): an assumption.
FINGERS_ACROSS = np.deg2rad(45.0)


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
    points = home_points(arm)
    reach = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    count = int(reach / spacing)
    steps = spacing * np.arange(-count, count + 1)
    a, b, c = (part.ravel() for part in np.meshgrid(steps, steps, steps, indexing="ij"))
    far = np.sqrt(a**2 + b**2 + c**2)
    # Behind the shoulder no cup is held, and nearer than this the elbow is shut.
    kept = (a >= 0) & (far > 0.25 * reach) & (far < 1.05 * reach)
    axes = np.stack([arm.forward, np.cross(arm.up, arm.forward), arm.up])
    out = []
    for offset in np.stack([a, b, c], axis=1)[kept] @ axes:
        found = finder.manifolds.find(cup_pose(arm, points[0] + offset), nearest=False)
        if found.intervals and widest(found) > LEAST_RANGE:
            out.append(found)
    return out


def home_points(arm: Arm) -> Float[np.ndarray, "3 3"]:
    """Give shoulder, elbow and wrist (m) of the arm at home."""
    home = np.clip(np.zeros(7), arm.lower, arm.upper)
    return tip_positions(arm.chain, home, [arm.tip(k) for k in ("shoulder", "elbow", "wrist")])[0]


def widest(manifold: SelfMotionManifold) -> float:
    """Give the width of the widest feasible interval of swivel angle (rad)."""
    return max(high - low for low, high in manifold.swivel_intervals)


def from_straight_ahead(manifold: SelfMotionManifold) -> float:
    """Give the angle (rad) between straight ahead and the line from the shoulder to the hand."""
    place = _place(manifold)
    return float(np.arccos(place["y"] / np.linalg.norm(list(place.values()))))


def natural_postures(
    finder: PostureFinder, manifolds: Sequence[SelfMotionManifold]
) -> pd.DataFrame:
    """Give the posture of least effort of each pose, one row a pose.

    Columns: x, y, z of the hand from the shoulder at home (to the right, forward, up; m),
    range_deg, swivel_deg, effort, minima, jumps, status, milliseconds.
    """
    rows = []
    for manifold in _warmed_up(lambda m: finder.find(m.T_hand), manifolds):
        start = time.perf_counter()
        found = finder.find(manifold.T_hand)
        spent = 1e3 * (time.perf_counter() - start)
        rows.append(
            {
                **_place(manifold),
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


def hybrid_errors(arm: Arm, manifolds: Sequence[SelfMotionManifold]) -> pd.DataFrame:
    """Give Fig 5: how the hybrid inverse kinematics does, one row a pose.

    Columns: x, y, z as in `natural_postures`; uncertainty_deg and uncertainty_sd, mean and spread
    of ψ_S - ψ_H; start_m and start_rad, mean errors of the closed form's postures, refined_m and
    refined_rad, greatest ones after refinement; milliseconds a posture.
    """
    relative = SrsRelative.of(arm)
    rows = []
    for manifold in _warmed_up(lambda m: hybrid_ik(arm, m.T_hand, relative=relative), manifolds):
        start = time.perf_counter()
        found = hybrid_ik(arm, manifold.T_hand, relative=relative)
        spent = 1e3 * (time.perf_counter() - start)
        inside = found.feasible
        if not inside.any():
            continue
        off = np.rad2deg(found.uncertainty[inside])
        begun = found.start_error[inside].mean(axis=0)
        ended = refine(arm, found.q[inside], manifold.T_hand, max_iterations=0)
        rows.append(
            {
                **_place(manifold),
                "uncertainty_deg": off.mean(),
                "uncertainty_sd": off.std(),
                "start_m": begun[0],
                "start_rad": begun[1],
                "refined_m": ended.position_error.max(),
                "refined_rad": ended.rotation_error.max(),
                "milliseconds": spent / len(found.q),
            }
        )
    return pd.DataFrame(rows)


def published_seconds(
    model: MusculoskeletalArm, manifolds: Sequence[SelfMotionManifold]
) -> Float[np.ndarray, " poses"]:
    """Give the seconds that the paper's search takes for each pose, with this library's effort."""
    finder = PostureFinder.of(model, search=SearchOptions(search="paper"))
    spent = []
    for manifold in _warmed_up(lambda m: finder.find(m.T_hand), manifolds):
        start = time.perf_counter()
        finder.find(manifold.T_hand)
        spent.append(time.perf_counter() - start)
    return np.array(spent)


def _warmed_up(
    run: Callable[[SelfMotionManifold], object], manifolds: Sequence[SelfMotionManifold]
) -> Sequence[SelfMotionManifold]:
    """Run the first once, so that loading compiled code is not timed; give them all."""
    if manifolds:
        run(manifolds[0])
    return manifolds


def _place(manifold: SelfMotionManifold) -> dict[str, float]:
    arm = manifold.arm
    offset = manifold.T_hand[:3, 3] - home_points(arm)[0]
    axes = np.stack([np.cross(arm.forward, arm.up), arm.forward, arm.up])
    return dict(zip("xyz", (axes @ offset).tolist(), strict=True))
