"""Joint angles of the wrist from orientations of the hand, in any of the usual forms."""

from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.motion.orientations import (
    matrices_from_quaternions,
    matrices_from_vectors,
    nearest_rotations,
)

Form = Literal["angles", "rotation vectors", "quaternions", "matrices"]
FORMS: tuple[Form, ...] = ("angles", "rotation vectors", "quaternions", "matrices")
# Distance of the flexion from a right angle below which pronation and deviation are not told (rad).
GIMBAL = 1e-3


def wrist_angles(orientations: ArrayLike, form: Form) -> Float[np.ndarray, "samples 3"]:
    """Give pronation, flexion and deviation of the wrist of [Tommasino2017] eq. 6 (rad).

    Solves R = exp(-x̂ q_PS) exp(ẑ q_FE) exp(ŷ q_RUD) for hand orientations R in the ground.

    Args:
        orientations: (K, 3) rotation vectors (rad), (K, 4) quaternions x, y, z, w, or (K, 3, 3)
            matrices; (K, 3) angles pass as they are. What is off by the digits of a file is
            replaced by the nearest rotation.
        form: which of them.

    Raises:
        ShapeError: the shape is not that of the form.
        NotFiniteError: a value is not finite.
        RangeError: the form is not known, a matrix is no rotation, a quaternion has no unit
            length, a rotation vector is above one turn, or the flexion is a right angle.

    Example:
        >>> wrist_angles([[-0.3, 0.0, 0.0]], "rotation vectors").round(6).tolist()
        [[0.3, 0.0, 0.0]]
    """
    if form not in FORMS:
        raise RangeError(f"form = {form!r}: allowed are {', '.join(FORMS)}")
    array = as_float_array("orientations", orientations)
    width = {"angles": (None, 3), "rotation vectors": (None, 3), "quaternions": (None, 4)}
    require_shape("orientations", array, width.get(form, (None, 3, 3)))
    require_finite("orientations", array)
    if form == "angles":
        return array
    R = _matrices(array, form)
    # First row of exp(-x p) exp(z f) exp(y r): (cos f cos r, -sin f, cos f sin r).
    sine = np.clip(-R[:, 0, 1], -1.0, 1.0)
    close = np.abs(sine) > np.cos(GIMBAL)
    if close.any():
        i = int(np.argmax(close))
        raise RangeError(
            f"orientations[{i}]: flexion is a right angle, where pronation and deviation turn "
            "about the same axis"
        )
    flexion = np.arcsin(sine)
    deviation = np.arctan2(R[:, 0, 2], R[:, 0, 0])
    pronation = np.arctan2(-R[:, 2, 1], R[:, 1, 1])
    return np.stack([pronation, flexion, deviation], axis=1)


def _matrices(array: np.ndarray, form: Form) -> np.ndarray:
    """Give (K, 3, 3) by the checks of recorded orientations; what is a gap there is refused."""
    if form == "rotation vectors":
        return matrices_from_vectors(array)
    if form == "matrices":
        return nearest_rotations(array)
    zero = ~array.any(axis=1)
    if zero.any():
        raise RangeError(f"orientations[{int(np.argmax(zero))}]: a quaternion of length 0, not 1")
    return matrices_from_quaternions(array)
