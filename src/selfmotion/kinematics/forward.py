"""Forward kinematics and geometric Jacobian of any chain, one posture or many.

Every function takes q as (n,) or (K, n) and returns arrays with a leading sample dimension.
"""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import freeze, require_fillable, require_finite, require_shape
from selfmotion.kinematics import kernels
from selfmotion.kinematics.chain import GROUND, Chain, Tip
from selfmotion.kinematics.threads import share
from selfmotion.kinematics.tip_kernel import tip_frames, tip_path

# Samples below which a second thread costs more than it saves.
SAMPLES_PER_THREAD = 5_000


def forward_kinematics(chain: Chain, q: ArrayLike, tip: Tip) -> Float[np.ndarray, "samples 4 4"]:
    """Give the frame of a tip in the ground, for each posture.

    Args:
        chain: the joints.
        q: (n,) or (K, n) free coordinates (rad or m).
        tip: the frame wanted.

    Returns:
        (K, 4, 4) transforms ``T_ground_tip`` (m).

    Raises:
        ShapeError: q does not fit the chain.
        NotFiniteError: q holds NaN or infinite values.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import planar
        >>> arm = planar([0.3, 0.25])
        >>> T = forward_kinematics(arm.chain, [np.pi / 2, -np.pi / 2], arm.tip("hand"))
        >>> T[0, :2, 3].round(3).tolist()
        [0.25, 0.3]
    """
    samples = chain.shaped(q)
    T = np.empty((len(samples), 4, 4))
    _fill(chain, samples, tip, T, np.empty((len(samples), 6, 0)))
    return T


def geometric_jacobian(
    chain: Chain, q: ArrayLike, tip: Tip
) -> Float[np.ndarray, "samples 6 coords"]:
    """Give the Jacobian of a tip with respect to the free coordinates.

    Rows are the linear velocity of the tip's origin (m/s per rad/s) and the angular velocity of
    its frame (rad/s per rad/s), both in ground axes.

    Raises:
        ShapeError: q does not fit the chain.
        NotFiniteError: q holds NaN or infinite values.
    """
    return frames_and_jacobian(chain, q, tip)[1]


def frames_and_jacobian(
    chain: Chain,
    q: ArrayLike,
    tip: Tip,
    *,
    threads: int = 1,
    out: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[Float[np.ndarray, "samples 4 4"], Float[np.ndarray, "samples 6 coords"]]:
    """Give both, in one pass: frames (K, 4, 4) and Jacobians (K, 6, n) of a tip.

    Memory sets the pace of many samples (560 bytes each for nine joints): some ten thousand at a
    time stay in the caches, and threads share the rest.

    Args:
        chain: the joints.
        q: (n,) or (K, n) free coordinates (rad or m).
        tip: the frame wanted.
        threads: how many threads share the samples.
        out: frames (K, 4, 4) and Jacobians (K, 6, n) to fill, in C order; memory that is used
            again spares the time that a system takes to hand out new pages.

    Raises:
        ShapeError: q does not fit the chain, or out does not fit q.
        NotFiniteError: q holds NaN or infinite values.
        RangeError: fewer than one thread.
    """
    samples = chain.shaped(q)
    K, n = samples.shape
    if out is None:
        out = np.empty((K, 4, 4)), np.empty((K, 6, n))
    T, J = out
    require_fillable("out[0]", T, (K, 4, 4))
    require_fillable("out[1]", J, (K, 6, n))
    if chain.coupling.is_identity:
        _fill(chain, samples, tip, T, J, threads)
    else:
        of_joints = np.empty((K, 6, len(chain.names)))
        _fill(chain, samples, tip, T, of_joints, threads)
        np.matmul(of_joints, chain.coupling.derivative(samples), out=J)
    return T, J


def body_frames(chain: Chain, q: ArrayLike) -> Float[np.ndarray, "samples all_joints 4 4"]:
    """Give the frames of all bodies in the ground, (K, N, 4, 4)."""
    z = chain.z_frames
    R, p = kernels.body_frames(
        z.parent, z.joint_type, z.rotations, z.translations, chain.joint_values(q)
    )
    T = np.zeros((*p.shape[:2], 4, 4))
    T[..., :3, :3] = R @ z.to_body
    T[..., :3, 3] = p
    T[..., 3, 3] = 1.0
    return T


def tip_positions(
    chain: Chain, q: ArrayLike, tips: list[Tip]
) -> Float[np.ndarray, "samples tips 3"]:
    """Give the positions (m) of several tips, for drawing and for markers."""
    frames = body_frames(chain, q)
    out = np.empty((len(frames), len(tips), 3))
    for i, tip in enumerate(tips):
        point = tip.transform[:3, 3]
        if tip.joint == GROUND:
            out[:, i] = point
        else:
            body = frames[:, tip.joint]
            out[:, i] = body[:, :3, :3] @ point + body[:, :3, 3]
    return out


def _fill(
    chain: Chain,
    samples: np.ndarray,
    tip: Tip,
    T: np.ndarray,
    jacobian: np.ndarray,
    threads: int = 1,
) -> None:
    """Fill frames of a tip, which may be fixed to the ground, and its Jacobian by all joints.

    A Jacobian without columns is none.

    Raises:
        NotFiniteError: a sample holds NaN or infinite values.
    """
    require_shape("tip.transform", tip.transform, (4, 4))
    if tip.joint == GROUND:
        require_finite("q", samples)
        T[:], jacobian[:] = tip.transform, 0.0
        return
    path = tip_path(chain, tip)
    # Always read-only: the kernel would be compiled once more for arrays that are not.
    values = freeze(chain.coupling.value(samples).view())
    frames, columns = T.reshape(-1, 16), jacobian.reshape(len(T), 6 * jacobian.shape[2])
    suspects = []

    def work(a: int, b: int) -> None:
        part = values[a:b]
        suspects.append(tip_frames(path, part, part.reshape(-1), frames[a:b], columns[a:b]))

    share(work, len(values), threads, least=SAMPLES_PER_THREAD)
    if any(suspects):
        require_finite("q", samples)
