"""The hand pose nearest to one that cannot be reached inside the joint limits.

What counts as near: the square of the distance, plus the square of the turn times `METRES_A_RAD`.
SciPy's bounded least squares (trust region, reflective) start from several postures; the least of
their minima is given. It is the least found, not a certified one.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares

from selfmotion.arrays import Transform
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import frames_and_jacobian
from selfmotion.spatial import log_rotation

# A radian of rotation counts as much as so many metres: about a hand's length.
METRES_A_RAD = 0.2
N_STARTS = 5
# From a hand so near (m, rad) Newton steps reach the pose, or show that they cannot.
REACHED = 1e-4
_MARGIN = 1e-9  # the solver wants to start strictly inside the limits (rad)


@dataclass(frozen=True, eq=False)
class NearestPosture:
    """The posture inside the joint limits whose hand is nearest to a pose.

    Attributes:
        q: (n,) posture (rad).
        distance: of the hand from the pose (m).
        turn: of the hand from the pose (rad).
    """

    q: Float[np.ndarray, " coords"]
    distance: float
    turn: float

    @property
    def reached(self) -> bool:
        """Whether the pose is reached after all, or all but so."""
        return max(self.distance, self.turn) < REACHED

    @property
    def sentence(self) -> str:
        """Say how far it is."""
        return (
            f"the nearest hand pose found is {1e3 * self.distance:.1f} mm and "
            f"{np.rad2deg(self.turn):.1f} deg away"
        )


def nearest_posture(
    arm: Arm, T_hand: Transform, starts: Float[np.ndarray, "starts coords"]
) -> NearestPosture:
    """Find the posture inside the joint limits whose hand is nearest to a pose.

    Args:
        arm: the arm.
        T_hand: (4, 4) pose of the hand in the ground.
        starts: postures (rad), brought inside the limits; the `N_STARTS` with the nearest hand
            are searched from, and the middle of the limits.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import srs7
        >>> arm = srs7()
        >>> far = np.eye(4)
        >>> far[2, 3] = -2.0
        >>> found = nearest_posture(arm, far, arm.middle()[None])
        >>> found.reached
        False
    """
    inside = np.clip(np.vstack([starts, arm.middle()]), arm.lower + _MARGIN, arm.upper - _MARGIN)
    cost = np.array([float(_residual(q, arm, T_hand) @ _residual(q, arm, T_hand)) for q in inside])
    best, least = inside[-1], np.inf
    for i in [*np.argsort(cost)[:N_STARTS], len(inside) - 1]:
        found = least_squares(
            _residual,
            inside[i],
            _slope,  # pyright: ignore[reportArgumentType]
            bounds=(arm.lower, arm.upper),
            args=(arm, T_hand),
            xtol=1e-9,
            ftol=1e-9,
            gtol=1e-9,
            max_nfev=60,
        )
        if found.cost < least:
            best, least = np.clip(found.x, arm.lower, arm.upper), found.cost
        if least < 1e-2 * (REACHED * METRES_A_RAD) ** 2:
            break
    off = _residual(best, arm, T_hand)
    distance, turn = np.linalg.norm(off[:3]), np.linalg.norm(off[3:]) / METRES_A_RAD
    return NearestPosture(best, float(distance), float(turn))


def _residual(q: np.ndarray, arm: Arm, T_hand: np.ndarray) -> np.ndarray:
    """Give what is left to the pose: m, and rotation in the hand's axes, as m."""
    T = frames_and_jacobian(arm.chain, q, arm.tip("hand"))[0][0]
    turn = log_rotation(T_hand[:3, :3].T @ T[:3, :3])
    return np.concatenate([T[:3, 3] - T_hand[:3, 3], METRES_A_RAD * turn])


def _slope(q: np.ndarray, arm: Arm, T_hand: np.ndarray) -> np.ndarray:
    T, J = frames_and_jacobian(arm.chain, q, arm.tip("hand"))
    R = T_hand[:3, :3].T @ T[0, :3, :3]
    # d log(R) = J_l(log R)^-1 w, with w the angular velocity in the axes of the goal.
    angular = _left_inverse(log_rotation(R)) @ T_hand[:3, :3].T @ J[0, 3:]
    return np.vstack([J[0, :3], METRES_A_RAD * angular])


def _left_inverse(v: np.ndarray) -> np.ndarray:
    """Give the inverse of the left Jacobian of the rotation group at a rotation vector."""
    angle = float(np.linalg.norm(v))
    S = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    if angle < 1e-4:
        return np.eye(3) - 0.5 * S + S @ S / 12.0
    half = 0.5 * angle
    return np.eye(3) - 0.5 * S + (1.0 - half / np.tan(half)) / angle**2 * (S @ S)
