"""A stretch of a self-motion manifold inside the joint limits: its nodes and what lies between.

Between nodes the curve is a cubic that fits both ends and their tangents, brought onto the hand
pose where an exact posture is asked for.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.redundancy import limit_kernels, pose_kernels
from selfmotion.redundancy.pose_kernels import PathArrays
from selfmotion.redundancy.refine import refine

# How far a posture (K, n) is outside excluded bodies (m); negative inside ([Li2022] eq. 1, the
# set written as the letter aleph).
Clearance = Callable[[Float[np.ndarray, "samples coords"]], Float[np.ndarray, " samples"]]


@dataclass(frozen=True, eq=False)
class FeasibleInterval:
    """A stretch of the manifold inside the joint limits.

    Attributes:
        arm: the arm.
        T_hand: the hand pose.
        q: (P, 7) nodes along the curve, ends included (rad).
        tangents: (P, 7) unit tangents.
        arc: (P,) length along the curve (rad, norm over coordinates).
        swivel: (P,) swivel angle (rad), without jumps of a turn.
        ends: what ends it on either side, as "elbow_flexion upper"; "closed" for a whole loop.
        path: the joints that carry the hand, for the kernels.
    """

    arm: Arm
    T_hand: Transform
    q: Float[np.ndarray, "nodes 7"]
    tangents: Float[np.ndarray, "nodes 7"]
    arc: Float[np.ndarray, " nodes"]
    swivel: Float[np.ndarray, " nodes"]
    ends: tuple[str, str]
    path: PathArrays

    @property
    def length(self) -> float:
        """Length along the curve (rad, norm over coordinates)."""
        return float(self.arc[-1] - self.arc[0])

    @property
    def swivel_range(self) -> tuple[float, float]:
        """Least and greatest swivel angle (rad)."""
        return float(np.nanmin(self.swivel)), float(np.nanmax(self.swivel))

    def at(self, arc: ArrayLike) -> Float[np.ndarray, "samples 7"]:
        """Give the postures at places along the curve, exactly on the hand pose."""
        return self.at_with_tangent(arc)[0]

    def at_with_tangent(
        self, arc: ArrayLike
    ) -> tuple[Float[np.ndarray, "samples 7"], Float[np.ndarray, "samples 7"]]:
        """Give postures (rad) and unit tangents (rad/rad) at places along the curve."""
        s = np.clip(np.atleast_1d(np.asarray(arc, dtype=np.float64)), self.arc[0], self.arc[-1])
        q, t = hermite(self.arc, self.q, self.tangents, s)
        wanted, guess = (q * t).sum(axis=1), q.copy()
        good = pose_kernels.correct_many(self.path, q, t, wanted, self.T_hand)
        if not good.all():  # beside a singular posture, where the tangent turns within a step
            q[~good] = refine(self.arm, guess[~good], self.T_hand).q
        return np.minimum(np.maximum(q, self.arm.lower), self.arm.upper), t

    def swivel_near(self, arc: ArrayLike) -> Float[np.ndarray, " samples"]:
        """Give the swivel angle (rad) at places along the curve, by lines between nodes."""
        return np.interp(np.asarray(arc, dtype=np.float64), self.arc, self.swivel)

    def swivel_at(self, q: Float[np.ndarray, "samples 7"]) -> Float[np.ndarray, " samples"]:
        """Give the swivel angle (rad) of postures of this interval, in line with its nodes."""
        raw = arm_swivel(self.arm, q)
        nearest = np.argmin(np.linalg.norm(self.q[None, :, :] - q[:, None, :], axis=2), axis=1)
        near = self.swivel[nearest]
        return raw + 2 * np.pi * np.round((near - raw) / (2 * np.pi))


def hermite(
    arc: np.ndarray, nodes: np.ndarray, tangents: np.ndarray, s: np.ndarray
) -> tuple[Float[np.ndarray, "samples 7"], Float[np.ndarray, "samples 7"]]:
    """Give points and unit tangents (K, 7) between nodes, by cubics that fit both."""
    q, t = np.empty((len(s), nodes.shape[1])), np.empty((len(s), nodes.shape[1]))
    a, n, d, x = (np.ascontiguousarray(part) for part in (arc, nodes, tangents, s))
    limit_kernels.between_nodes(a, n, d, x, q, t)
    return q, t


def arm_swivel(arm: Arm, q: Float[np.ndarray, "samples 7"]) -> Float[np.ndarray, " samples"]:
    """Give the swivel angle (rad), the shoulder centre taken at home ([Li2022] eq. 5)."""
    home = np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)
    tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
    points = tip_positions(arm.chain, np.vstack([home, q]), tips)
    return swivel_angle(points[0, 0], points[1:, 1], points[1:, 2], down=-arm.up)


def unwrapped(angle: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    """Take out jumps of a turn (rad), passing over entries that are NaN."""
    out = angle.copy()
    known = np.flatnonzero(~np.isnan(angle))
    out[known] = np.unwrap(angle[known])
    return out


def clear_parts(piece: FeasibleInterval, clearance: Clearance) -> list[FeasibleInterval]:
    """Cut an interval where the arm enters an excluded body."""
    places = np.unique(
        np.concatenate([piece.arc, np.linspace(piece.arc[0], piece.arc[-1], 8 * len(piece.arc))])
    )
    free = clearance(piece.at(places)) >= 0
    if free.all():
        return [piece]
    edges = np.flatnonzero(free[1:] != free[:-1])
    cuts = [places[0]]
    for i in edges:
        low, high = places[i], places[i + 1]
        while high - low > 1e-10:
            middle = 0.5 * (low + high)
            if bool(clearance(piece.at(middle))[0] >= 0) == bool(free[i]):
                low = middle
            else:
                high = middle
        cuts.append(low if free[i] else high)
    cuts.append(places[-1])
    parts = []
    for i in range(len(cuts) - 1):
        if bool(free[edges[i - 1] + 1] if i > 0 else free[0]):
            ends = (
                piece.ends[0] if i == 0 else "body",
                piece.ends[1] if i == len(edges) else "body",
            )
            parts.append(_part(piece, cuts[i], cuts[i + 1], ends))
    return parts


def _part(
    piece: FeasibleInterval, low: float, high: float, ends: tuple[str, str]
) -> FeasibleInterval:
    inner = piece.arc[(piece.arc > low) & (piece.arc < high)]
    arc = np.concatenate([[low], inner, [high]])
    q = piece.at(arc)
    _, tangents = hermite(piece.arc, piece.q, piece.tangents, arc)
    return FeasibleInterval(
        piece.arm, piece.T_hand, q, tangents, arc - low, piece.swivel_at(q), ends, piece.path
    )
