"""Body coordinates: outwards, forward and up from the middle between the shoulders.

Outwards is towards the side of the arm: right for a right arm, left for a left one. So a place
"in front of the opposite shoulder" has the same coordinates for both.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_between, require_finite, require_shape
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.spatial import unit

STATURE = 1.75
# Upper arm and forearm together, joint centre to joint centre, as a share of the stature: de Leva
# P (1996), doi 10.1016/0021-9290(95)00178-6, men.
ARM_SHARE = (281.7 + 268.9) / 1741
# Height of the shoulders as a share of the stature (Drillis and Contini 1966).
SHOULDER = 0.818
# Estimate: shoulder centre beside the middle, for arms whose ground starts at the shoulder.
SHOULDER_ASIDE = 0.100
# A shoulder nearer to the ground's middle plane than this share is no shoulder beside a trunk.
LEAST_ASIDE = 0.050


@dataclass(frozen=True, eq=False)
class BodyFrame:
    """Where the trunk is.

    Attributes:
        middle: (3,) middle between the shoulders in the arm's ground (m).
        axes: (3, 3) columns are the person's right, forward and up.
        side: 1 for a right arm, -1 for a left one.
        stature: m.
        shoulder: (3,) centre of the arm's shoulder at the posture of zeros (m).
    """

    middle: Float[np.ndarray, "3"]
    axes: Float[np.ndarray, "3 3"]
    side: float
    stature: float
    shoulder: Float[np.ndarray, "3"]

    @classmethod
    def of(cls, arm: Arm, stature: float | None = None) -> "BodyFrame":
        """Place the trunk beside an arm.

        The middle plane is that of the ground's origin, as for `mirror`; where the shoulder lies
        in it, the arm counts as a right one and the middle is put at its left.

        Args:
            arm: whose shoulder, taken at the posture of zeros, and directions place the trunk.
            stature: m; left out: from the arm's lengths, or 1.75 m where it has none.

        Raises:
            RangeError: stature outside 0.5 to 2.5 m.

        Example:
            >>> from selfmotion.arms import load_arm
            >>> frame = BodyFrame.of(load_arm("upper_limb"))
            >>> frame.coordinates([[0.188, 0.3, 0.1]]).round(3).tolist()
            [[0.188, 0.3, 0.1]]
        """
        height = stature_of(arm) if stature is None else stature
        require_between("stature", height, 0.5, 2.5)
        up = unit("up", arm.up)
        right = unit("forward x up", np.cross(arm.forward, up))
        axes = np.column_stack([right, np.cross(up, right), up])
        home = np.clip(np.zeros((1, arm.n_joints)), arm.lower, arm.upper)
        shoulder = tip_positions(arm.chain, home, [arm.tip("shoulder")])[0, 0]
        aside = float(shoulder @ right)
        if abs(aside) < LEAST_ASIDE * height:
            aside = SHOULDER_ASIDE * height
        return cls(shoulder - aside * right, axes, 1.0 if aside > 0 else -1.0, height, shoulder)

    @property
    def outward_axes(self) -> Float[np.ndarray, "3 3"]:
        """Directions outwards, forward and up in the ground, as columns."""
        return self.axes * np.array([self.side, 1.0, 1.0])

    def coordinates(self, points: ArrayLike) -> Float[np.ndarray, "points 3"]:
        """Give outwards, forward and up (m) of points (K, 3) in the ground."""
        return (_points(points) - self.middle) @ self.outward_axes

    def points(self, coordinates: ArrayLike) -> Float[np.ndarray, "points 3"]:
        """Give points (K, 3) in the ground (m) from outwards, forward and up."""
        return self.middle + _points(coordinates) @ self.outward_axes.T


def stature_of(arm: Arm) -> float:
    """Give the stature (m) that goes with an arm's upper arm and forearm; 1.75 m without them."""
    parts = [arm.lengths.get(name) for name in ("upper_arm", "forearm")]
    if parts[0] is None or parts[1] is None:
        return STATURE
    return float(parts[0] + parts[1]) / ARM_SHARE


def _points(points: ArrayLike) -> np.ndarray:
    array = as_float_array("points", points, ndim=2)
    require_shape("points", array, (None, 3))
    require_finite("points", array)
    return array
