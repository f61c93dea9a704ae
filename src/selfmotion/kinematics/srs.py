"""Closed-form postures of the spherical-revolute-spherical relative of a 7-DoF arm.

Implements the analytical part of [Li2022] Table II (doi 10.1109/TNSRE.2022.3198400). The relative
has the arm's upper arm, forearm and axes at its home posture, but a shoulder centre that does not
move and wrist axes that meet in one point. Deviation: Table I makes all axes perpendicular; here
they keep the directions that they have in the arm, since a rotation is split over three axes of
any directions in closed form just as well, and the start of the refinement is then closer.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numba import njit

from selfmotion.errors import ModelError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import frames_and_jacobian, tip_positions
from selfmotion.spatial import rotation_about

# A hand pose and a swivel angle have this many postures: two each by elbow, shoulder and wrist.
N_BRANCHES = 8
# Branches whose elbow angle is so far (rad) beyond the elbow's limits are left out (NaN).
ELBOW_MARGIN = 0.8
# Rotation error (rad) up to which a shoulder is taken to be of one of the two known kinds.
_SHOULDER_TOLERANCE = 0.35


class SrsArrays(NamedTuple):
    """The relative as arrays for the kernel; all directions in ground axes at the home posture."""

    shoulder: np.ndarray  # (3,) centre
    upper_arm: np.ndarray  # (3,) shoulder to elbow
    forearm: np.ndarray  # (3,) elbow to wrist
    axes: np.ndarray  # (7, 3) of the relative's seven angles
    hand_rotation: np.ndarray  # (3, 3) R_ground_hand at home
    wrist_in_hand: np.ndarray  # (3,) wrist centre in the hand frame
    down: np.ndarray  # (3,)
    sideways: np.ndarray  # (3,) stands in for `down` where the line shoulder-wrist is vertical
    mapping: np.ndarray  # (7, 7) K of eq. 6: coordinates of the arm from angles of the relative
    home: np.ndarray  # (7,) coordinates of the arm at home
    elbow_range: np.ndarray  # (2,) angles of the elbow that are worth a posture


@dataclass(frozen=True, eq=False)
class SrsRelative:
    """The relative of an arm with seven free coordinates.

    Attributes:
        arm: the arm.
        arrays: the relative, for the kernel.
    """

    arm: Arm
    arrays: SrsArrays

    @classmethod
    def of(cls, arm: Arm) -> "SrsRelative":
        """Derive the relative from an arm's landmarks and from its axes at home.

        The first three coordinates must turn the shoulder, either one after the other or, as in
        MoBL-ARMS, as plane of elevation, elevation and rotation, where the plane is turned back
        after the elevation; the fourth the elbow; the last three the forearm and the wrist.

        Raises:
            ModelError: the arm has not seven coordinates, or a shoulder of another kind.
        """
        if arm.n_joints != 7:
            raise ModelError(f"{arm.name}: {arm.n_joints} free coordinates; a swivel needs 7")
        home = np.clip(np.zeros(7), arm.lower, arm.upper)
        tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
        S, E, W = tip_positions(arm.chain, home, tips)[0]
        T, J = frames_and_jacobian(arm.chain, home, arm.tip("hand"))
        shoulder_axes, mapping = _shoulder(arm, home, J[0, 3:, :3])
        axes = np.ascontiguousarray(np.vstack([shoulder_axes, J[0, 3:, 3:].T]))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        R, p = np.ascontiguousarray(T[0, :3, :3]), T[0, :3, 3]
        elbow = np.array([arm.lower[3], arm.upper[3]]) - home[3] + [-ELBOW_MARGIN, ELBOW_MARGIN]
        arrays = (S, E - S, W - E, axes, R, R.T @ (W - p), -arm.up, arm.forward)
        every = (*arrays, mapping, home, elbow)
        return cls(arm, SrsArrays(*(np.ascontiguousarray(a) for a in every)))

    def with_shoulder(self, centre: Float[np.ndarray, "3"]) -> "SrsRelative":
        """Give the same relative with its shoulder elsewhere, as where a raised girdle puts it."""
        return replace(self, arrays=self.arrays._replace(shoulder=np.array(centre)))

    def postures(
        self, T_hand: Float[np.ndarray, "4 4"], swivel: Float[np.ndarray, " swivels"]
    ) -> tuple[Float[np.ndarray, "swivels 8 7"], Float[np.ndarray, "swivels 8"]]:
        """Give the postures of the relative in coordinates of the arm ([Li2022] eq. 6).

        Args:
            T_hand: hand pose in the ground.
            swivel: angles (rad), as `swivel_angle` defines them.

        Returns:
            Postures (rad), every angle brought into the turn around the middle of its limits,
            and by how much (in units of sines) the pose is out of the relative's reach: 0 where
            it is reached exactly, infinite (and the posture NaN) on branches left out because of
            the elbow's limits.
        """
        middle = 0.5 * (self.arm.lower + self.arm.upper)
        return srs_postures(
            self.arrays,
            np.ascontiguousarray(T_hand, dtype=np.float64),
            np.ascontiguousarray(swivel, dtype=np.float64),
            middle,
        )


def _shoulder(arm: Arm, home: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the shoulder's three axes (3, 3) by row, and the mapping K of eq. 6."""
    tip = arm.tip("elbow")
    quarter = home.copy()
    quarter[1] += np.pi / 2
    _, J = frames_and_jacobian(arm.chain, quarter, tip)
    serial = columns.T.copy()
    a2 = columns[:, 1] / np.linalg.norm(columns[:, 1])
    # Turned back after elevation: the plane's velocity is (I - R(a2, 90°)) a1.
    turned = rotation_about(a2, np.pi / 2)
    a1, *_ = np.linalg.lstsq(np.eye(3) - turned, J[0, 3:, 0], rcond=1e-9)
    planar = np.vstack([a1, columns[:, 1], columns[:, 2]])
    back = np.eye(7)
    back[2, 0] = 1.0
    errors = []
    for axes, mapping in ((serial, np.eye(7)), (planar, back)):
        errors.append((_shoulder_error(arm, home, axes, mapping), axes, mapping))
    error, axes, mapping = min(errors, key=lambda e: e[0])
    if not error < _SHOULDER_TOLERANCE:
        raise ModelError(
            f"{arm.name}: the first three coordinates do not turn the shoulder about three axes "
            f"(rotation error {error:.2f} rad)"
        )
    return axes, mapping


def _shoulder_error(arm: Arm, home: np.ndarray, axes: np.ndarray, mapping: np.ndarray) -> float:
    """Give the greatest rotation error (rad) of three axes against the arm, at some postures."""
    if np.linalg.norm(axes, axis=1).min() < 1e-6:
        return np.inf
    tip = arm.tip("elbow")
    R_home = frames_and_jacobian(arm.chain, home, tip)[0][0, :3, :3]
    worst = 0.0
    for shares in ((0.3, 0.3, 0.3), (0.7, 0.6, 0.4), (0.5, 0.8, 0.7)):
        q = home.copy()
        q[:3] = arm.lower[:3] + np.array(shares) * (arm.upper[:3] - arm.lower[:3])
        angles = np.linalg.solve(mapping, q - home)
        R = frames_and_jacobian(arm.chain, q, tip)[0][0, :3, :3]
        model = R_home
        for axis, angle in zip(axes[::-1], angles[2::-1], strict=True):
            model = rotation_about(axis, float(angle)) @ model
        cosine = 0.5 * (np.trace(model.T @ R) - 1.0)
        worst = max(worst, float(np.arccos(np.clip(cosine, -1.0, 1.0))))
    return worst


@njit(cache=True)
def _turn(axis, angle, v):
    """Rotate v about a unit axis."""
    c, s = np.cos(angle), np.sin(angle)
    d = (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]) * (1.0 - c)
    return np.array(
        (
            c * v[0] + s * (axis[1] * v[2] - axis[2] * v[1]) + d * axis[0],
            c * v[1] + s * (axis[2] * v[0] - axis[0] * v[2]) + d * axis[1],
            c * v[2] + s * (axis[0] * v[1] - axis[1] * v[0]) + d * axis[2],
        )
    )


@njit(cache=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _crossed(a, b):
    return np.array(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )


@njit(cache=True)
def _two_angles(axis, u, v, wanted):
    """Solve ``u . Rot(axis, x) v = wanted``: two angles, and by how far it is out of reach."""
    along = _dot(axis, u) * _dot(axis, v)
    a = _dot(u, v) - along
    b = _dot(u, _crossed(axis, v))
    size = np.sqrt(a * a + b * b)
    ratio = (wanted - along) / max(size, 1e-300)
    out = max(abs(ratio) - 1.0, 0.0)
    middle = np.arctan2(b, a)
    half = np.arccos(min(max(ratio, -1.0), 1.0))
    return middle + half, middle - half, out


@njit(cache=True)
def _angle_between(axis, u, v):
    """Give the angle about `axis` that takes the part of u square to it onto that of v."""
    c = _dot(u, v) - _dot(axis, u) * _dot(axis, v)
    s = _dot(axis, _crossed(u, v))
    return np.arctan2(s, c)


@njit(cache=True)
def _three_angles(R, a1, a2, a3, out):
    """Split R over three axes: out (2,3) holds both solutions; gives how far out of reach."""
    x, y, beyond = _two_angles(a2, a1, a3, _dot(a1, R @ a3))
    for i in range(2):
        t2 = x if i == 0 else y
        out[i, 1] = t2
        out[i, 0] = _angle_between(a1, _turn(a2, t2, a3), R @ a3)
        out[i, 2] = -_angle_between(a3, _turn(a2, -t2, a1), R.T @ a1)
    return beyond


@njit(cache=True)
def _frame(u, v):
    """Give a rotation with first column along u and second in the plane of u and v."""
    F = np.empty((3, 3))
    e = u / np.sqrt(_dot(u, u))
    w = v - _dot(v, e) * e
    size = np.sqrt(_dot(w, w))
    if size < 1e-12:  # a straight arm: any plane will do
        w = _crossed(e, np.array((e[1], e[2], -e[0])))
        size = np.sqrt(_dot(w, w))
    f = w / size
    F[:, 0] = e
    F[:, 1] = f
    F[:, 2] = _crossed(e, f)
    return F


@njit(cache=True)
def _rotation(axis, angle):
    R = np.empty((3, 3))
    for i in range(3):
        e = np.zeros(3)
        e[i] = 1.0
        R[:, i] = _turn(axis, angle, e)
    return R


@njit(cache=True)
def srs_postures(s, T_hand, swivel, middle):
    """Give postures (P,8,7) and how far out of reach they are (P,8), for P swivel angles."""
    n = swivel.shape[0]
    q = np.empty((n, 8, 7))
    out = np.empty((n, 8))
    R_hand = np.ascontiguousarray(T_hand[:3, :3])
    W = T_hand[:3, 3] + R_hand @ s.wrist_in_hand
    SW = W - s.shoulder
    D = np.sqrt(_dot(SW, SW))
    along = SW / D
    down = s.down - _dot(s.down, along) * along
    if _dot(down, down) < 1e-18:
        down = s.sideways - _dot(s.sideways, along) * along
    down = down / np.sqrt(_dot(down, down))
    side = _crossed(down, along)
    du2, df2 = _dot(s.upper_arm, s.upper_arm), _dot(s.forearm, s.forearm)
    # |u + Rot(a4) f|^2 = D^2
    x4, y4, far = _two_angles(s.axes[3], s.upper_arm, s.forearm, 0.5 * (D * D - du2 - df2))
    R_back = np.ascontiguousarray(s.hand_rotation.T)
    shoulder, wrist = np.empty((2, 3)), np.empty((2, 3))
    for k in range(n):
        c, r = np.cos(swivel[k]), np.sin(swivel[k])
        outwards = c * down + r * side
        i = 0
        for elbow in range(2):
            t4 = x4 if elbow == 0 else y4
            t4 -= 2.0 * np.pi * np.round(t4 / (2.0 * np.pi))
            if not s.elbow_range[0] <= t4 <= s.elbow_range[1]:
                q[k, i : i + 4] = np.nan
                out[k, i : i + 4] = np.inf
                i += 4
                continue
            reach = s.upper_arm + _turn(s.axes[3], t4, s.forearm)
            length = np.sqrt(_dot(reach, reach))
            part = _dot(s.upper_arm, reach) / max(length, 1e-12)
            rise = np.sqrt(max(du2 - part * part, 0.0))
            R_S = _frame(along, part * along + rise * outwards) @ _frame(reach, s.upper_arm).T
            R_S = np.ascontiguousarray(R_S)
            R_F = _rotation(s.axes[3], -t4) @ np.ascontiguousarray(R_S.T) @ R_hand @ R_back
            one = _three_angles(R_S, s.axes[0], s.axes[1], s.axes[2], shoulder)
            two = _three_angles(R_F, s.axes[4], s.axes[5], s.axes[6], wrist)
            for a in range(2):
                for b in range(2):
                    out[k, i] = max(far, max(one, two))
                    for j in range(7):
                        v = s.home[j]
                        for m in range(3):
                            v += s.mapping[j, m] * shoulder[a, m]
                            v += s.mapping[j, 4 + m] * wrist[b, m]
                        v += s.mapping[j, 3] * t4
                        turns = np.round((v - middle[j]) / (2.0 * np.pi))
                        q[k, i, j] = v - 2.0 * np.pi * turns
                    i += 1
    return q, out
