"""Rotations and rigid transforms in three dimensions, batched over leading dimensions.

A transform ``T_a_b`` is a 4x4 matrix that takes coordinates in frame b to frame a. Conversions
between rotation matrices, quaternions (x, y, z, w) and rotation vectors are SciPy's.
"""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, as_float_array
from selfmotion.errors import RangeError


def skew(v: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Give the matrix that crosses with v: ``skew(v) @ u == cross(v, u)``."""
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def rotation_about(axis: ArrayLike, angle: float) -> Float[np.ndarray, "3 3"]:
    """Rotate by `angle` (rad) about `axis` (3,), which need not have unit length."""
    from scipy.spatial.transform import Rotation

    a = unit("axis", axis)
    return Rotation.from_rotvec(angle * a).as_matrix()


def unit(name: str, vector: ArrayLike) -> np.ndarray:
    """Scale a vector to unit length.

    Raises:
        RangeError: the vector is (nearly) zero, so that it has no direction.
    """
    v = as_float_array(name, vector, ndim=1)
    length = float(np.linalg.norm(v))
    if not length > 1e-12:
        raise RangeError(f"{name} = {v.tolist()}: a direction needs a length above 1e-12")
    return v / length


def transform(rotation: ArrayLike | None = None, translation: ArrayLike | None = None) -> Transform:
    """Build a 4x4 transform from a 3x3 rotation (default: none) and a translation (m)."""
    out = np.eye(4)
    if rotation is not None:
        out[:3, :3] = rotation
    if translation is not None:
        out[:3, 3] = translation
    return out


def invert(T: Float[np.ndarray, "*batch 4 4"]) -> Float[np.ndarray, "*batch 4 4"]:
    """Invert rigid transforms."""
    out = np.zeros_like(T)
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    out[..., :3, :3] = Rt
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", Rt, T[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def log_rotation(R: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 3"]:
    """Give the rotation vector (rad, length up to pi) of rotation matrices."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec().reshape(R.shape[:-1])


def exp_rotation(r: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Give the rotation matrices of rotation vectors (rad)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(r.reshape(-1, 3)).as_matrix().reshape(*r.shape, 3)


def rotation_taking_z_to(axis: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """Give a rotation whose third column is `axis` (unit).

    It is the shortest from z, or, for an axis that points below, half a turn about x and then the
    shortest from -z: the shortest from z loses its digits near -z.
    """
    below = axis[2] < 0.0
    a = -axis if below else axis
    v = skew(np.cross([0.0, 0.0, 1.0], a))
    R = np.eye(3) + v + v @ v / (1.0 + a[2])
    return R * np.array([1.0, -1.0, -1.0]) if below else R
