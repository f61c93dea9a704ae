"""The quadratic Donders surface of any segment's orientations: upper arm, forearm, hand.

As :mod:`selfmotion.methods.elasticity.surface`, for a segment whose long axis is any direction and
whose reference posture is any rotation: rotation vectors are taken from the reference, in the
segment's frame there, and their component along the long axis (the torsion) is a quadratic
function of the two others. Rotation vectors are no coordinates of the whole rotation group: beyond
half a turn from the reference they alias, so that the reference is the mean orientation by default.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError
from selfmotion.methods.elasticity.surface import DondersSurface, fit_surface
from selfmotion.spatial import log_rotation, rotation_taking_z_to, unit

# Departure from a rotation matrix that is put down to rounding.
ROUNDING = 1e-6
# Distance from half a turn below which a rotation vector has no sure direction (rad).
ALIAS = 0.1
# Entry of the mean matrix's determinant below which orientations have no mean.
SCATTERED = 1e-3


@dataclass(frozen=True, eq=False)
class OrientationSurface:
    """A quadratic surface through the orientations of a segment.

    Attributes:
        surface: torsion over the two other components of the rotation vectors.
        reference: (3, 3) orientation from which rotation vectors are taken.
        frame: (3, 3) columns: long axis, and the two directions a and b, in the segment's frame.
    """

    surface: DondersSurface
    reference: Float[np.ndarray, "3 3"]
    frame: Float[np.ndarray, "3 3"]

    @property
    def thickness_deg(self) -> float:
        """Standard deviation of the torsion beside the surface (degrees)."""
        return self.surface.thickness_deg

    def components(
        self, rotations: Float[np.ndarray, "samples 3 3"]
    ) -> Float[np.ndarray, "samples 3"]:
        """Give torsion, a and b (rad) of orientations."""
        return log_rotation(self.reference.T @ rotations) @ self.frame

    def residual(
        self, rotations: Float[np.ndarray, "samples 3 3"]
    ) -> Float[np.ndarray, " samples"]:
        """Give how far orientations lie beside the surface: torsion minus the surface's (rad)."""
        torsion, a, b = self.components(rotations).T
        return torsion - self.surface.torsion(a, b)


def fit_orientation_surface(
    rotations: ArrayLike, *, axis: ArrayLike, reference: ArrayLike | None = None
) -> OrientationSurface:
    """Fit a quadratic Donders surface to the orientations of a segment.

    Args:
        rotations: (K, 3, 3) orientations of the segment in the body that it is seen from.
        axis: (3,) its long axis, in its own frame.
        reference: (3, 3) orientation from which rotation vectors are taken; left out: the mean.

    Returns:
        The surface with its thickness.

    Raises:
        ShapeError: fewer than 10 orientations, or not (K, 3, 3).
        NotFiniteError: a value is not finite.
        RangeError: a matrix is no rotation, lies half a turn from the reference, or the
            orientations lie on a line, so that no surface is determined.

    Example:
        >>> from scipy.spatial.transform import Rotation
        >>> a, b = (g.ravel() for g in np.meshgrid(np.linspace(-0.3, 0.3, 5),
        ...                                        np.linspace(-0.2, 0.2, 5)))
        >>> turns = Rotation.from_rotvec(np.stack([a, b, 0.3 * a * b], axis=1)).as_matrix()
        >>> found = fit_orientation_surface(turns, axis=[0, 0, 1], reference=np.eye(3))
        >>> round(found.thickness_deg, 6)
        0.0
    """
    R = as_float_array("rotations", rotations, ndim=3)
    require_shape("rotations", R, (None, 3, 3))
    require_finite("rotations", R)
    _refuse_no_rotation("rotations", R)
    middle = mean_rotation(R) if reference is None else as_float_array("reference", reference)
    require_shape("reference", middle, (3, 3))
    _refuse_no_rotation("reference", middle[None])
    long = unit("axis", axis)
    # z of this frame is the long axis; in order: long axis, a, b.
    frame = rotation_taking_z_to(long)[:, [2, 0, 1]]
    vectors = log_rotation(middle.T @ R)
    angle = np.linalg.norm(vectors, axis=1)
    if angle.size and angle.max() > np.pi - ALIAS:
        i = int(np.argmax(angle))
        raise RangeError(
            f"rotations[{i}]: {np.degrees(angle[i]):.0f} degrees from the reference; rotation "
            f"vectors need less than {np.degrees(np.pi - ALIAS):.0f}"
        )
    return OrientationSurface(fit_surface(vectors @ frame), middle, frame)


def mean_rotation(rotations: Float[np.ndarray, "samples 3 3"]) -> Float[np.ndarray, "3 3"]:
    """Give the rotation nearest to the mean of the matrices (chordal mean).

    Raises:
        RangeError: they are scattered over all orientations, so that there is none.
    """
    U, s, Vt = np.linalg.svd(rotations.mean(axis=0))
    if s[1] < SCATTERED:
        raise RangeError("rotations: scattered over all orientations; give a reference")
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    return U @ Vt


def _refuse_no_rotation(name: str, R: np.ndarray) -> None:
    off = np.abs(R.mT @ R - np.eye(3)).max(axis=(1, 2), initial=0.0)
    off = np.maximum(off, np.abs(np.linalg.det(R) - 1.0))
    if off.size and not off.max() < ROUNDING:
        i = int(np.argmax(off))
        raise RangeError(f"{name}[{i}]: no rotation matrix (it is off by {off[i]:.2g})")
