"""The least-squares part of fitting a joint law to postures: residuals, Jacobian, iterations.

For each posture q with Jacobian J, null basis Z and task Hessians Q_a = Zᵀ∇²x_a Z, and e = q - q*:

    f = ZᵀKe,   λ = (JJᵀ)⁻¹J K e,   D = Zᵀ K Z - Σ λ_a Q_a,   δ = D⁻¹ f,

so that δ is, to first order, how far the posture lies from the law's Donders surface along the
self-motion. J, Z and Q do not depend on what is fitted, and K, Kq* enter f, λ and D linearly.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.methods.elasticity.posture import null_basis, task_hessian
from selfmotion.redundancy.task import Task

# A change of every parameter by less than this share of its size ends the iteration.
TOLERANCE = 1e-12
# Noise widths beyond which a posture's pull no longer grows (99 % efficient on normal noise).
HUBER = 2.0
# Curvature of the energy, as a share of the median, below which a posture counts as past a fold.
FLAT = 0.02
# Residual below which the law counts as exact and needs no weights (rad).
EXACT = 1e-10


@dataclass(frozen=True, eq=False)
class PostureGeometry:
    """What the task says about each posture; the same for every law.

    Attributes:
        q: (K, n) postures (rad).
        Z: (K, n, r) orthonormal basis of the self-motion.
        P: (K, m, n) (JJᵀ)⁻¹J.
        Q: (K, m, r, r) second derivatives of the task within the self-motion.
        C: (K, m, n, r) second derivatives of the task times Z.
    """

    q: Float[np.ndarray, "samples joints"]
    Z: Float[np.ndarray, "samples joints free"]
    P: Float[np.ndarray, "samples rows joints"]
    Q: Float[np.ndarray, "samples rows free free"]
    C: Float[np.ndarray, "samples rows joints free"]

    @classmethod
    def of(cls, task: Task, q: Float[np.ndarray, "samples joints"]) -> "PostureGeometry":
        """Compute it."""
        J = task.jacobian(q)
        Z = null_basis(J)
        P = np.linalg.solve(J @ np.swapaxes(J, 1, 2), J)
        C = task_hessian(task, q) @ Z[:, None]
        return cls(q, Z, P, np.swapaxes(Z, 1, 2)[:, None] @ C, C)


@dataclass(frozen=True, eq=False)
class Residuals:
    """Distances to the surface and how they change.

    Attributes:
        delta: (K, r) distance along the self-motion (rad).
        by_stiffness: (K, r, n(n+1)/2) derivative by the entries of K, lower triangle row by row.
        by_rest: (K, r, n) derivative by q*.
        D: (K, r, r) curvature of the energy in the self-motion.
        spread: (K, r, r) covariance of delta for unit noise in every joint.
    """

    delta: Float[np.ndarray, "samples free"]
    by_stiffness: Float[np.ndarray, "samples free entries"]
    by_rest: Float[np.ndarray, "samples free joints"]
    D: Float[np.ndarray, "samples free free"]
    spread: Float[np.ndarray, "samples free free"]


def entries(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Give row and column of the entries of a symmetric matrix, lower triangle row by row."""
    return np.tril_indices(n)


def symmetric(values: np.ndarray, n: int) -> Float[np.ndarray, "joints joints"]:
    """Give the symmetric matrix of its lower triangle."""
    K = np.zeros((n, n))
    rows, columns = entries(n)
    K[rows, columns] = values
    K[columns, rows] = values
    return K


def residuals(geometry: PostureGeometry, K: np.ndarray, rest: np.ndarray) -> Residuals:
    """Give distances and derivatives for a law."""
    g = geometry
    n = len(rest)
    e = g.q - rest
    Zt = np.swapaxes(g.Z, 1, 2)
    ZtK, PK = Zt @ K, g.P @ K
    f = np.einsum("kri,ki->kr", ZtK, e)
    lam = np.einsum("kai,ki->ka", PK, e)
    D = ZtK @ g.Z - np.einsum("ka,kars->krs", lam, g.Q)
    inverse = np.linalg.inv(D)  # r by r, one or a few
    delta = np.einsum("krs,ks->kr", inverse, f)
    Qd = np.einsum("kars,ks->kar", g.Q, delta)
    Zd = np.einsum("kis,ks->ki", g.Z, delta)
    # df - dD delta, for a change of one entry of K (both of its places) and of q*.
    rows, columns = entries(n)
    twice = (rows != columns).astype(float)
    away = e - Zd
    df = Zt[:, :, rows] * away[:, None, columns] + twice * Zt[:, :, columns] * away[:, None, rows]
    dlam = g.P[:, :, rows] * e[:, None, columns] + twice * g.P[:, :, columns] * e[:, None, rows]
    by_stiffness = inverse @ (df + np.swapaxes(Qd, 1, 2) @ dlam)
    by_rest = -inverse @ (ZtK + np.swapaxes(Qd, 1, 2) @ PK)
    # Noise in q moves delta by D⁻¹ Zᵀ H, H = K - Σ λ ∇²x.
    HZ = K @ g.Z - np.einsum("ka,kair->kir", lam, g.C)
    shift = HZ @ np.swapaxes(inverse, 1, 2)
    return Residuals(delta, by_stiffness, by_rest, D, np.swapaxes(shift, 1, 2) @ shift)


def linear_start(geometry: PostureGeometry) -> tuple[np.ndarray, np.ndarray] | None:
    """Give K (with K₀₀ = 1) and q* from ZᵀKq = Zᵀh, linear in K and h = Kq*.

    Exact without noise. None where the postures do not determine it, or K is not positive
    definite (noise draws K₀₀ of the least stiff joint towards zero).
    """
    g = geometry
    n = g.q.shape[1]
    rows, columns = entries(n)
    twice = (rows != columns).astype(float)
    Zt = np.swapaxes(g.Z, 1, 2)
    by_K = Zt[:, :, rows] * g.q[:, None, columns] + twice * Zt[:, :, columns] * g.q[:, None, rows]
    A = np.concatenate([by_K, -Zt], axis=2).reshape(-1, len(rows) + n)
    found, _, rank, _ = np.linalg.lstsq(A[:, 1:], -A[:, 0], rcond=1e-12)
    if rank < A.shape[1] - 1:
        return None
    K = symmetric(np.concatenate([[1.0], found[: len(rows) - 1]]), n)
    if np.linalg.eigvalsh(K)[0] <= 1e-6 * np.trace(K):
        return None
    return K, np.linalg.solve(K, found[len(rows) - 1 :])


def whitening(spread: np.ndarray) -> Float[np.ndarray, "samples free free"]:
    """Give S with S spread Sᵀ = I for each sample."""
    L = np.linalg.cholesky(spread)
    return np.linalg.solve(L, np.broadcast_to(np.eye(L.shape[1]), L.shape))


def past_fold(found: Residuals) -> Bool[np.ndarray, " samples"]:
    """Mark postures where the energy does not clearly curve upward in the self-motion."""
    least = np.linalg.eigvalsh(found.D)[:, 0]
    return least <= FLAT * np.median(np.abs(least))


def huber_weights(whitened: np.ndarray) -> tuple[np.ndarray, float]:
    """Give Huber's weights (K,) of whitened distances (K, r), and the noise they imply (rad)."""
    scale = float(np.median(np.abs(whitened)) / 0.6745)
    if scale < EXACT:
        return np.ones(len(whitened)), scale
    length = np.sqrt((whitened**2).mean(axis=1))
    return np.minimum(1.0, HUBER * scale / np.maximum(length, 1e-300)), scale
