"""The quadratic Donders surface of recorded orientations, with its thickness.

Rotation vectors r of the hand (or forearm, or upper arm) lie near a surface on which one component,
the torsion, is a quadratic function of the two others (Campolo et al., Exp. Brain Res. 201:561,
2010): ``r_t = c0 + c1 r_a + c2 r_b + c3 r_a² + c4 r_a r_b + c5 r_b²``. The thickness is the
standard deviation of what remains, in degrees.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError

if TYPE_CHECKING:
    import pandas as pd

TERMS = ("1", "a", "b", "a²", "ab", "b²")
# Condition number of the scaled terms beyond which the orientations do not span a surface.
LARGEST_CONDITION = 1e6


@dataclass(frozen=True, eq=False)
class DondersSurface:
    """A quadratic surface through rotation vectors.

    Attributes:
        coefficients: (6,) of 1, a, b, a², ab, b² (rad, 1, 1, 1/rad, 1/rad, 1/rad).
        stderr: (6,) standard errors.
        residual: (K,) torsion beside the surface (rad).
        torsion_axis: component (0, 1, 2) that is the function; a and b are the others in order.
    """

    coefficients: Float[np.ndarray, " terms"]
    stderr: Float[np.ndarray, " terms"]
    residual: Float[np.ndarray, " samples"]
    torsion_axis: int

    @property
    def thickness_deg(self) -> float:
        """Standard deviation of the torsion beside the surface (degrees)."""
        spare = len(self.residual) - len(TERMS)
        return float(np.degrees(np.sqrt((self.residual**2).sum() / spare)))

    def torsion(self, a: ArrayLike, b: ArrayLike) -> np.ndarray:
        """Give the torsion of the surface at the two other components (all rad)."""
        a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
        return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=-1) @ self.coefficients

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a term: value and standard error."""
        import pandas as pd

        return pd.DataFrame({"term": TERMS, "value": self.coefficients, "stderr": self.stderr})


def fit_surface(rotation_vectors: ArrayLike, *, torsion_axis: int = 0) -> DondersSurface:
    """Fit a quadratic Donders surface to orientations.

    Args:
        rotation_vectors: (K, 3) (rad).
        torsion_axis: the component along the segment: 0 for the wrist of [Tommasino2017].

    Returns:
        The surface with standard errors and thickness.

    Raises:
        ShapeError: fewer than 10 orientations, or not three components.
        NotFiniteError: a value is not finite.
        RangeError: the orientations lie on a line, so that no surface is determined.

    Example:
        >>> a, b = np.meshgrid(np.linspace(-0.3, 0.3, 5), np.linspace(-0.2, 0.2, 5))
        >>> r = np.stack([0.1 + 0.2 * a * b, a, b], axis=-1).reshape(-1, 3)
        >>> fit_surface(r).coefficients.round(6).tolist()
        [0.1, 0.0, 0.0, 0.0, 0.2, 0.0]
    """
    r = as_float_array("rotation_vectors", rotation_vectors, ndim=2)
    require_shape("rotation_vectors", r, (None, 3))
    require_finite("rotation_vectors", r)
    if torsion_axis not in (0, 1, 2):
        raise RangeError(f"torsion_axis = {torsion_axis}: allowed are 0, 1, 2")
    if len(r) < len(TERMS) + 4:
        raise ShapeError(f"rotation_vectors: {len(r)} samples; at least {len(TERMS) + 4} needed")
    a, b = np.delete(r, torsion_axis, axis=1).T
    A = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)
    size = np.linalg.norm(A, axis=0)
    if not (size > 0.0).all() or np.linalg.cond(A / size) > LARGEST_CONDITION:
        raise RangeError(
            "rotation_vectors: they lie along one line; a surface needs two directions"
        )
    Q, R = np.linalg.qr(A / size)
    found = np.linalg.solve(R, Q.T @ r[:, torsion_axis])
    residual = r[:, torsion_axis] - A @ (found / size)
    root = np.linalg.solve(R, np.eye(len(TERMS)))
    variance = (residual**2).sum() / (len(r) - len(TERMS))
    stderr = np.sqrt(variance * (root**2).sum(axis=1)) / size
    clean = np.where(np.abs(found) < 1e-15, 0.0, found)  # no minus zero in tables
    return DondersSurface(clean / size, stderr, residual, torsion_axis)
