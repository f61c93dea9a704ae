"""The weighted pseudo-inverse of a Jacobian and the projector onto its null space.

One formula joins the papers: ``J# = W⁻¹Jᵀ(JW⁻¹Jᵀ)⁻¹`` is [Khoramshahi2022] eq. 4,
[Tommasino2017] eq. 3 and, with ``W = D⁻²``, the undamped update of [DeBoon] eq. 15. It stands
here and nowhere else.

It is computed from the singular values of ``S J L⁻ᵀ`` with ``W = L Lᵀ`` and S the row scale, so
that a loss of rank is seen and reported instead of divided by; where J has full rank this is the
formula above.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError

# Singular values below this share of the largest count as zero.
RANK_TOLERANCE = 1e-10


@dataclass(frozen=True, eq=False)
class Projection:
    """A weighted pseudo-inverse with its null space, for each sample.

    Attributes:
        inverse: (K, n, m) J#, damped if damping was asked for.
        null: (K, n, n) N = I - J#J of the undamped J#: a projector whatever the damping.
        rank: (K,) rank of J; less than m where the posture is singular.
        singular_values: (K, min(m, n)) of the scaled and weighted Jacobian, largest first.
    """

    inverse: Float[np.ndarray, "samples joints rows"]
    null: Float[np.ndarray, "samples joints joints"]
    rank: Int[np.ndarray, " samples"]
    singular_values: Float[np.ndarray, "samples values"]


def project(
    jacobian: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    damping: float = 0.0,
    row_scale: ArrayLike | None = None,
) -> Projection:
    """Give the weighted pseudo-inverse J# and the null-space projector N of Jacobians.

    ``J# x`` is the joint velocity that creates the task velocity x with the least ``q' W q``
    ([Khoramshahi2022] eqs 4 and 5); N takes any joint velocity to its part that does not move
    the task (eq. 3).

    Args:
        jacobian: (m, n) or (K, m, n).
        weights: W as (n,) diagonal, (n, n) full, or (K, n, n) dependent on posture (the inertia
            matrix, say); left out: the identity.
        damping: μ ≥ 0 in ``J# = W⁻¹Jᵀ(JW⁻¹Jᵀ + μI)⁻¹``, in units of the scaled rows squared over
            those of W.
        row_scale: (m,) positive factors that bring rows of different units (m and rad) to one
            scale before rank and damping are judged. Without damping, J# does not depend on it.

    Returns:
        The projection; a posture in which J loses rank has `rank` below m, and its J# serves the
        task directions that remain.

    Raises:
        ShapeError: the arrays do not fit each other.
        NotFiniteError: an array holds NaN or infinite values.
        RangeError: W is not symmetric positive definite, or damping or a scale is not allowed.

    Example:
        Two sliding joints along one line ([Khoramshahi2022] eq. 14):

        >>> p = project([[1.0, 1.0]], [1.0, 1 / 9])
        >>> p.inverse[0, :, 0].round(3).tolist()
        [0.1, 0.9]
    """
    J = as_float_array("jacobian", jacobian)
    J = J[None] if J.ndim == 2 else J
    require_shape("jacobian", J, (None, None, None))
    require_finite("jacobian", J)
    n_rows, n = J.shape[1:]
    if not 0.0 <= damping < np.inf:
        raise RangeError(f"damping = {damping:g}: allowed is 0 and above, and finite")
    scale = _row_scale(row_scale, n_rows)
    right = _inverse_root(weights, J)  # L⁻ᵀ
    U, s, Vt = np.linalg.svd((scale[:, None] * J) @ right, full_matrices=False)
    kept = s > RANK_TOLERANCE * s[:, :1]
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(kept, s / (s * s + damping), 0.0)
    RV = right @ np.swapaxes(Vt, 1, 2)
    inverse = (RV * gain[:, None, :]) @ np.swapaxes(U, 1, 2) * scale
    # N = I - L⁻ᵀ V_r V_rᵀ Lᵀ; its right factor V_rᵀLᵀ is solved for, not inverted.
    left = np.linalg.solve(np.swapaxes(right, 1, 2), np.swapaxes(Vt, 1, 2) * kept[:, None, :])
    null = np.eye(n) - RV @ np.swapaxes(left, 1, 2)
    return Projection(inverse, null, kept.sum(axis=1), s)


def split_velocity(
    jacobian: ArrayLike, velocity: ArrayLike, weights: ArrayLike | None = None
) -> tuple[Float[np.ndarray, "samples joints"], Float[np.ndarray, "samples joints"]]:
    """Split joint velocities (K, n) into task part J#Jq' and null-space part Nq'.

    [Khoramshahi2022] eqs 7 to 12; the two parts add up to the velocity.

    Raises:
        ShapeError: the arrays do not fit each other.
        NotFiniteError: an array holds NaN or infinite values.
        RangeError: W is not symmetric positive definite.
    """
    qd = np.atleast_2d(as_float_array("velocity", velocity))
    require_finite("velocity", qd)
    p = project(jacobian, weights)
    require_shape("velocity", qd, (None, p.null.shape[-1]))
    if len(p.null) not in (1, len(qd)):
        raise ShapeError(f"velocity has {len(qd)} samples, jacobian {len(p.null)}")
    null = np.einsum("kij,kj->ki", np.broadcast_to(p.null, (len(qd), *p.null.shape[1:])), qd)
    return qd - null, null


def _row_scale(row_scale: ArrayLike | None, n_rows: int) -> np.ndarray:
    if row_scale is None:
        return np.ones(n_rows)
    scale = as_float_array("row_scale", row_scale)
    require_shape("row_scale", scale, (n_rows,))
    if not (np.isfinite(scale).all() and (scale > 0).all()):
        raise RangeError(f"row_scale = {scale.tolist()}: every factor must be positive and finite")
    return scale


def _inverse_root(weights: ArrayLike | None, J: np.ndarray) -> np.ndarray:
    """Give L⁻ᵀ (K or 1, n, n) with W = L Lᵀ."""
    n_samples, _, n = J.shape
    if weights is None:
        return np.eye(n)[None]
    W = as_float_array("weights", weights)
    require_finite("weights", W)
    if W.shape == (n,):
        if not (W > 0).all():
            i = int(np.argmin(W))
            raise RangeError(f"weights[{i}] = {W[i]:g}: every weight must be above 0")
        return np.diag(1.0 / np.sqrt(W))[None]
    W = W[None] if W.ndim == 2 else W
    if W.shape not in ((1, n, n), (n_samples, n, n)):
        raise ShapeError(
            f"weights have shape {np.shape(weights)}; expected ({n},), ({n}, {n}) or "
            f"({n_samples}, {n}, {n})"
        )
    if not np.allclose(W, np.swapaxes(W, 1, 2), rtol=1e-9, atol=1e-12 * np.abs(W).max()):
        raise RangeError("weights: the matrix W must be symmetric")
    try:
        L = np.linalg.cholesky(W)
    except np.linalg.LinAlgError:
        smallest = float(np.linalg.eigvalsh(W).min())
        raise RangeError(
            f"weights: the matrix W must be positive definite; its smallest eigenvalue is "
            f"{smallest:g}"
        ) from None
    return np.swapaxes(np.linalg.solve(L, np.broadcast_to(np.eye(n), L.shape)), 1, 2)
