"""Joint angles of the wrist from orientations of the hand, in any of the usual forms."""

from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError

Form = Literal["angles", "rotation vectors", "quaternions", "matrices"]
FORMS: tuple[Form, ...] = ("angles", "rotation vectors", "quaternions", "matrices")
# Departure from a rotation matrix or a unit quaternion that is put down to rounding.
ROUNDING = 1e-3
# Distance of the flexion from a right angle below which pronation and deviation are not told (rad).
GIMBAL = 1e-3


def wrist_angles(orientations: ArrayLike, form: Form) -> Float[np.ndarray, "samples 3"]:
    """Give pronation, flexion and deviation of the wrist of [Tommasino2017] eq. 6 (rad).

    Solves R = exp(-x̂ q_PS) exp(ẑ q_FE) exp(ŷ q_RUD) for hand orientations R in the ground.

    Args:
        orientations: (K, 3) rotation vectors (rad), (K, 4) quaternions x, y, z, w, or (K, 3, 3)
            matrices; (K, 3) angles pass as they are.
        form: which of them.

    Raises:
        ShapeError: the shape is not that of the form.
        NotFiniteError: a value is not finite.
        RangeError: the form is not known, a matrix is no rotation, a quaternion has no unit
            length, or the flexion is a right angle.

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
    if form == "rotation vectors":
        return Rotation.from_rotvec(array).as_matrix()
    if form == "quaternions":
        length = np.linalg.norm(array, axis=1)
        off = np.abs(length - 1.0)
        if not (off < ROUNDING).all():
            i = int(np.argmax(off))
            raise RangeError(f"orientations[{i}]: a quaternion of length {length[i]:g}, not 1")
        return Rotation.from_quat(array).as_matrix()
    off = np.abs(np.swapaxes(array, 1, 2) @ array - np.eye(3)).max(axis=(1, 2))
    off = np.maximum(off, np.abs(np.linalg.det(array) - 1.0))
    if not (off < ROUNDING).all():
        i = int(np.argmax(off))
        raise RangeError(f"orientations[{i}]: no rotation matrix (it is off by {off[i]:.2g})")
    return array
