"""The swivel angle: where the elbow is on its circle about the line from shoulder to wrist.

Implements [Li2022] eqs 4 and 5 (doi 10.1109/TNSRE.2022.3198400). Deviation: the printed form,
a sign times an arc cosine, gives 0 for an elbow straight above the line, where the sign function
is 0; the arc tangent of two arguments used here gives 180 degrees and is exact near 0 too.
"""

import numpy as np
from jaxtyping import Float
from numba import njit
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import ShapeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.spatial import unit

# Sine of an angle below which a plane through two directions is not determined.
COLLINEAR = 1e-9


def swivel_angle(
    shoulder: ArrayLike, elbow: ArrayLike, wrist: ArrayLike, *, down: ArrayLike
) -> Float[np.ndarray, " samples"]:
    """Give the angle between the arm's plane and the vertical plane through shoulder and wrist.

    Args:
        shoulder: (3,) or (K, 3) shoulder centre (m); for arms whose shoulder centre moves, take
            it at zero elevation ([Li2022] eq. 5).
        elbow: (K, 3) elbow centre (m).
        wrist: (K, 3) wrist centre (m).
        down: (3,) direction of gravity.

    Returns:
        (K,) angle (rad) in (-pi, pi]: 0 with the elbow below the line from shoulder to wrist,
        positive with the elbow to the right of a hand that is in front. NaN where shoulder,
        elbow and wrist lie on one line, or that line is vertical: the angle does not exist.

    Raises:
        ShapeError: the points have different numbers of samples.
        NotFiniteError: a point holds NaN or infinite values.

    Example:
        >>> swivel_angle([0, 0, 0], [0.2, 0.2, 0], [0, 0.4, 0], down=[0, 0, -1]).round(4).tolist()
        [1.5708]
    """
    S, E, W = (
        _points(n, v) for n, v in (("shoulder", shoulder), ("elbow", elbow), ("wrist", wrist))
    )
    lengths = {len(a) for a in (S, E, W)} - {1}
    if len(lengths) > 1:
        raise ShapeError(f"shoulder, elbow and wrist have {len(S)}, {len(E)} and {len(W)} samples")
    g = unit("down", down)
    out = np.empty(max(len(S), len(E), len(W)))
    _angles(np.ascontiguousarray(S), np.ascontiguousarray(E), np.ascontiguousarray(W), g, out)
    return out


def arm_swivel_angle(arm: Arm, q: ArrayLike) -> Float[np.ndarray, " samples"]:
    """Give the swivel angle (rad) of an arm's landmarks for postures q, (n,) or (K, n).

    The shoulder centre is taken at q = 0, brought inside the joint limits ([Li2022] eq. 5).
    """
    tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
    home = np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)
    shoulder = tip_positions(arm.chain, home, tips[:1])[0, 0]
    points = tip_positions(arm.chain, q, tips)
    return swivel_angle(shoulder, points[:, 1], points[:, 2], down=-arm.up)


def _points(name: str, value: ArrayLike) -> Float[np.ndarray, "samples 3"]:
    array = np.atleast_2d(as_float_array(name, value))
    require_shape(name, array, (None, 3))
    require_finite(name, array)
    return array


@njit(cache=True)
def _angles(shoulder, elbow, wrist, down, out):
    """Fill out (K,): [Li2022] eq. 5 with an arc tangent; NaN where there is no plane."""
    d0, d1, d2 = down[0], down[1], down[2]
    for k in range(out.shape[0]):
        S = shoulder[k if shoulder.shape[0] > 1 else 0]
        E = elbow[k if elbow.shape[0] > 1 else 0]
        W = wrist[k if wrist.shape[0] > 1 else 0]
        w0, w1, w2 = W[0] - S[0], W[1] - S[1], W[2] - S[2]
        e0, e1, e2 = E[0] - S[0], E[1] - S[1], E[2] - S[2]
        a0, a1, a2 = w1 * e2 - w2 * e1, w2 * e0 - w0 * e2, w0 * e1 - w1 * e0
        v0, v1, v2 = w1 * d2 - w2 * d1, w2 * d0 - w0 * d2, w0 * d1 - w1 * d0
        length = np.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
        reach = length * np.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
        plane_arm = np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
        plane_vertical = np.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
        if plane_arm <= COLLINEAR * reach or plane_vertical <= COLLINEAR * length:
            out[k] = np.nan
            continue
        # Both normals are square to the line, so the angle between them has its sine along it.
        sine = length * (a0 * d0 + a1 * d1 + a2 * d2)
        out[k] = np.arctan2(sine, a0 * v0 + a1 * v1 + a2 * v2)
