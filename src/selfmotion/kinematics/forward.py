"""Forward kinematics and geometric Jacobian of any chain, one posture or many.

Every function takes q as (n,) or (K, n) and returns arrays with a leading sample dimension.
"""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import require_shape
from selfmotion.kinematics import kernels
from selfmotion.kinematics.chain import GROUND, Chain, Tip
from selfmotion.kinematics.serial_path import joints_to
from selfmotion.kinematics.threads import share
from selfmotion.kinematics.tip_kernel import TipPath, tip_frames

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
    return _tip(chain, chain.joint_values(q), tip, np.empty((0, 6, 0)))


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
    chain: Chain, q: ArrayLike, tip: Tip, *, threads: int = 1
) -> tuple[Float[np.ndarray, "samples 4 4"], Float[np.ndarray, "samples 6 coords"]]:
    """Give both, in one pass: frames (K, 4, 4) and Jacobians (K, 6, n) of a tip.

    Memory sets the pace of many samples (560 bytes each for nine joints): some ten thousand at a
    time stay in the caches, and threads share the rest.
    """
    samples = chain.as_samples(q)
    values = chain.coupling.value(samples)
    J = np.zeros((len(samples), 6, len(chain.names)))
    T = _tip(chain, values, tip, J, threads)
    if not chain.coupling.is_identity:
        J = J @ chain.coupling.derivative(samples)
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


def _tip(
    chain: Chain, values: np.ndarray, tip: Tip, jacobian: np.ndarray, threads: int = 1
) -> np.ndarray:
    """Give frames of a tip, which may be fixed to the ground; fill its Jacobian unless empty."""
    require_shape("tip.transform", tip.transform, (4, 4))
    if tip.joint == GROUND:
        return np.repeat(tip.transform[None], len(values), axis=0)
    z, path = chain.z_frames, np.array(joints_to(chain, tip))
    left = z.to_body[tip.joint]
    R, p = np.ascontiguousarray(left @ tip.transform[:3, :3]), left @ tip.transform[:3, 3]
    model = TipPath(path, z.joint_type, z.rotations, z.translations, R, p)
    T = np.empty((len(values), 4, 4))

    def work(a: int, b: int) -> None:
        tip_frames(model, values[a:b], T[a:b], jacobian[a:b])

    share(work, len(values), threads, least=SAMPLES_PER_THREAD)
    return T
