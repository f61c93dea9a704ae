"""The unbounded variable of the published scheme: a joint angle that cannot pass its limits.

[DeBoon] eqs 10, 11 and 13. `ik_kernels.published_batch` writes the same out for each step, since
numba's cache does not notice a change in a function that another file calls.
"""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.kinematics.arm import Arm


def saturated_posture(
    arm: Arm, unbounded: ArrayLike
) -> tuple[Float[np.ndarray, "samples coords"], Float[np.ndarray, "samples coords"]]:
    """Give joint angles, and their slopes, at values of the unbounded variable.

    Args:
        arm: with finite limits.
        unbounded: v of eq. 10, one for all joints (K) or one each (K, n); a pure number.

    Returns:
        Angles ζ(v) of eq. 11 (rad), and dζ/dv, the diagonal of eq. 13 (rad).

    >>> from selfmotion import load_arm
    >>> angles, slopes = saturated_posture(load_arm("upper_limb"), [0.0, 1.0])
    >>> np.rad2deg(angles[:, 5]).round(1)  # elbow flexion: the middle, and half way to a limit
    array([ 83.2, 117. ])
    """
    v = np.asarray(unbounded, dtype=float)
    v = v[:, None] if v.ndim == 1 else v
    width, middle = (arm.upper - arm.lower) / np.pi, arm.middle()
    return width * np.arctan(v) + middle, width / (1.0 + v * v)
