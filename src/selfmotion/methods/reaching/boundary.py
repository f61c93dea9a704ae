"""Which joint limits bound which part of a workspace.

On the boundary the hand cannot go on along the outward normal u. To first order it would, by
``u · J_j`` for each unit by which the limit of joint j gave way: these are the multipliers of the
limits in the nearest-point problem ``min |x(q) - p|²`` over the box of limits, divided by the
distance. A joint away from its limits has none. Where all are (almost) zero the arm is stretched
out and its length bounds the reach; where the boundary is the surface of the body, the body does.

Points are drawn evenly from a thin layer outside, and each is taken to the boundary by inverse
kinematics: so they stand for equal areas, but for the layer's thickness over the radius of
curvature (a few percent).
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int

from selfmotion.arrays import freeze, require_between
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.kinematics.forward import frames_and_jacobian
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.screen import ReachScreen, reach_options
from selfmotion.methods.reaching.volumes import PlacedBox, shifted_points

if TYPE_CHECKING:
    import pandas as pd

# Thickness of the layer outside the boundary, and what counts as on it (m).
LAYER, ON_BOUNDARY = 0.02, 1e-4
# A joint this near to its limit (rad or m) is at it.
AT_LIMIT = 1e-9
# The hand moves less than this (m per rad) along the normal: the joint takes no part there.
NO_GAIN = 0.01
# A free joint that still gains more (m per rad) was stopped before the nearest point.
UNSETTLED = 0.02
# What bounds where no joint does.
LENGTH, BODY = -1, -2
NAMES = {LENGTH: "length of the arm", BODY: "own body"}


@dataclass(frozen=True, eq=False)
class BoundaryLimits:
    """Points of a workspace's boundary, each standing for the same area, and what bounds there.

    Attributes:
        arm: whose limits.
        points: (B, 3) m.
        normals: (B, 3) unit vectors outwards; NaN where the body bounds.
        gains: (B, n) by how much the hand would go on along the normal for each unit by which the
            limit gave way (m/rad or m/m); above 0 at an upper limit, below 0 at a lower one, 0
            where the joint is not at a limit.
        main: (B,) joint with the largest gain; `LENGTH` or `BODY` where none has any.
        unsettled: share of the points drawn that were left out, since inverse kinematics stopped
            before the nearest point.
    """

    arm: Arm
    points: Float[np.ndarray, "boundary 3"]
    normals: Float[np.ndarray, "boundary 3"]
    gains: Float[np.ndarray, "boundary coords"]
    main: Int[np.ndarray, " boundary"]
    unsettled: float

    def limit_names(self) -> list[tuple[int, int]]:
        """Give (joint, side) of what bounds somewhere, the largest share first.

        The side is 1 for an upper limit, -1 for a lower one, 0 for length and body.
        """
        found, counts = np.unique(
            np.stack([self.main, self.side], axis=1), axis=0, return_counts=True
        )
        order = np.argsort(-counts, kind="stable")
        return [(int(found[i, 0]), int(found[i, 1])) for i in order]

    @property
    def side(self) -> Int[np.ndarray, " boundary"]:
        """Which limit of the main joint: 1 the upper one, -1 the lower one, 0 none."""
        joint = np.maximum(self.main, 0)
        gain = self.gains[np.arange(len(self.main)), joint]
        return np.where(self.main >= 0, np.sign(gain), 0).astype(np.int64)

    def chosen(self, joint: int, side: int) -> np.ndarray:
        """Tell at which points this limit is the main one."""
        return (self.main == joint) & (self.side == side)

    def among(self, chosen: Bool[np.ndarray, " boundary"]) -> "BoundaryLimits":
        """Give some of the points (a mask), as those near a plane."""
        return replace(
            self,
            points=freeze(self.points[chosen]),
            normals=freeze(self.normals[chosen]),
            gains=freeze(self.gains[chosen]),
            main=freeze(self.main[chosen]),
        )

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a limit: share of the boundary, and what a degree would gain."""
        import pandas as pd

        n = max(len(self.main), 1)
        rows = []
        for joint, side in self.limit_names():
            at = self.chosen(joint, side)
            share = float(at.sum()) / n
            row: dict[str, object] = {
                "bounded_by": NAMES[joint] if joint < 0 else self.arm.joints[joint],
                "limit": {1: "upper", -1: "lower", 0: ""}[side],
                "at_deg": np.nan,
                "share_percent": 100.0 * share,
                "standard_error_percent": 100.0 * np.sqrt(share * (1.0 - share) / n),
                "takes_part_percent": 100.0 * share,
                "mm_per_degree": np.nan,
            }
            if joint >= 0:
                limits = self.arm.upper if side > 0 else self.arm.lower
                part = side * self.gains[:, joint] > NO_GAIN
                gain = np.abs(self.gains[at, joint])
                row["at_deg"] = float(np.rad2deg(limits[joint]))
                row["takes_part_percent"] = 100.0 * float(part.sum()) / n
                row["mm_per_degree"] = 1e3 * np.deg2rad(float(np.median(gain)))
            rows.append(row)
        return pd.DataFrame(rows)


def boundary_limits(
    screen: ReachScreen,
    *,
    body: BodyShapes | None = None,
    box: PlacedBox | None = None,
    n_points: int = 16384,
    rng: np.random.Generator | None = None,
) -> BoundaryLimits:
    """Find which joint limits bound the workspace of an arm, and where.

    Args:
        screen: of the arm; one that has decided many points before is faster.
        body: shapes that were cut out, whose surface is boundary, too.
        box: where to look; left out: all around.
        n_points: points spread over the box; a few percent of them lie near the boundary.
        rng: moves the points; left out: ``np.random.default_rng(0)``.

    Raises:
        RangeError: fewer than 64 points.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.methods.reaching.ik_tasks import HandRows
        >>> from selfmotion.methods.reaching.screen import reach_screen
        >>> arm = load_arm("upper_limb").with_limits({"elbow_flexion": (1.12, 1.99)})
        >>> screen = reach_screen(HandRows(arm, ("x", "y", "z")), n_points=256)
        >>> found = boundary_limits(screen, n_points=2048)
        >>> arm.joints[found.limit_names()[0][0]]
        'elbow_flexion'
    """
    require_between("n_points", n_points, 64, 10**8)
    draw = np.random.default_rng(0) if rng is None else rng
    where = box or PlacedBox.between(screen.low - LAYER, screen.high + LAYER)
    points = where.at(shifted_points(n_points, 1, draw)[0])
    points = points[screen.at_least(points) <= LAYER]
    depth = np.full(len(points), -np.inf) if body is None else -body.distance(points)
    points, depth = points[depth <= LAYER], depth[depth <= LAYER]
    found = solve_ik(screen.task, points, options=reach_options(), seeds=screen.seeds)
    skin = found.solved & (depth > 0)
    near = ~found.solved & (found.position_error > ON_BOUNDARY) & (found.position_error <= LAYER)
    T, J = frames_and_jacobian(
        screen.task.arm.chain, found.q[near], screen.task.arm.tip(screen.task.landmark)
    )
    edge = T[:, :3, 3]
    normals = points[near] - edge
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    gains, settled = _gains(
        screen.task.arm, found.q[near], np.einsum("ki,kij->kj", normals, J[:, :3])
    )
    kept = settled.copy()
    if body is not None:
        kept &= ~body.inside(edge)
    main = np.abs(gains).argmax(axis=1)
    main[np.abs(gains).max(axis=1) < NO_GAIN] = LENGTH
    n_skin, n = int(skin.sum()), screen.task.arm.n_joints
    unknown = np.full((n_skin, 3), np.nan)
    return BoundaryLimits(
        screen.task.arm,
        freeze(np.concatenate([edge[kept], points[skin]])),
        freeze(np.concatenate([normals[kept], unknown])),
        freeze(np.concatenate([gains[kept], np.zeros((n_skin, n))])),
        freeze(np.concatenate([main[kept], np.full(n_skin, BODY)])),
        float(1.0 - settled.mean()) if len(settled) else 0.0,
    )


def _gains(
    arm: Arm, q: Float[np.ndarray, "samples coords"], slope: Float[np.ndarray, "samples coords"]
) -> tuple[Float[np.ndarray, "samples coords"], np.ndarray]:
    """Give the gains of joints at their limits, and which postures are nearest points."""
    upper = (q >= arm.upper - AT_LIMIT) & (slope > 0)
    lower = (q <= arm.lower + AT_LIMIT) & (slope < 0)
    held = upper | lower
    left = np.abs(np.where(held, 0.0, slope)).max(axis=1, initial=0.0)
    return np.where(held, slope, 0.0), left <= UNSETTLED
