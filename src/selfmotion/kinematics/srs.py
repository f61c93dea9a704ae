"""Closed-form postures of the spherical-revolute-spherical relative of a 7-DoF arm.

Implements the analytical part of [Li2022] Table II (doi 10.1109/TNSRE.2022.3198400). The relative
has the arm's upper arm, forearm and axes at its home posture, but a shoulder centre that does not
move and wrist axes that meet in one point. Deviation: Table I makes all axes perpendicular; here
they keep the directions that they have in the arm, since a rotation is split over three axes of
any directions in closed form just as well, and the start of the refinement is then closer.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.errors import ModelError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import frames_and_jacobian, tip_positions
from selfmotion.kinematics.srs_kernels import SrsArrays, srs_postures
from selfmotion.spatial import rotation_about

# A hand pose and a swivel angle have this many postures: two each by elbow, shoulder and wrist.
N_BRANCHES = 8
# Branches whose elbow angle is so far (rad) beyond the elbow's limits are left out (NaN).
ELBOW_MARGIN = 0.8
# Rotation error (rad) up to which a shoulder is taken to be of one of the two known kinds.
_SHOULDER_TOLERANCE = 0.35


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
