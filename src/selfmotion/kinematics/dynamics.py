"""Gravity torque and joint-space inertia matrix of an arm, for the free coordinates."""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.kinematics import kernels
from selfmotion.kinematics.arm import Arm


def gravity_torque(arm: Arm, q: ArrayLike) -> Float[np.ndarray, "samples coords"]:
    """Give the torque that holds the arm still against gravity.

    Args:
        arm: with masses and centres of mass.
        q: (n,) or (K, n) free coordinates (rad or m).

    Returns:
        (K, n) torques (N m; N for slides): the derivative of potential energy, g(q) in
        ``torque = A(q) qdd + b(q, qd) + g(q)`` ([Li2022] eq. 1).

    Raises:
        ShapeError: q does not fit the arm.
        NotFiniteError: q holds NaN or infinite values.

    Example:
        >>> from selfmotion.arms import planar
        >>> arm = planar([0.3, 0.25])
        >>> gravity_torque(arm, [0.0, 0.0]).shape
        (1, 2)
    """
    samples = arm.chain.as_samples(q)
    torque = _run(arm, samples, np.empty((0, 0, 0)))
    if arm.chain.coupling.is_identity:
        return torque
    return np.einsum("kN,kNn->kn", torque, arm.chain.coupling.derivative(samples))


def inertia_matrix(arm: Arm, q: ArrayLike) -> Float[np.ndarray, "samples coords coords"]:
    """Give the joint-space inertia matrix A(q) (kg m²), symmetric, (K, n, n).

    Raises:
        ShapeError: q does not fit the arm.
        NotFiniteError: q holds NaN or infinite values.
    """
    samples = arm.chain.as_samples(q)
    n_joints = len(arm.chain.names)
    M = np.zeros((len(samples), n_joints, n_joints))
    _run(arm, samples, M)
    if arm.chain.coupling.is_identity:
        return M
    C = arm.chain.coupling.derivative(samples)
    return np.swapaxes(C, 1, 2) @ M @ C


def potential_energy(arm: Arm, q: ArrayLike) -> Float[np.ndarray, " samples"]:
    """Give the potential energy of gravity (J), zero at the ground frame's origin."""
    from selfmotion.kinematics.forward import body_frames

    T = body_frames(arm.chain, q)
    centres = np.einsum("kNij,Nj->kNi", T[..., :3, :3], arm.com) + T[..., :3, 3]
    return -np.einsum("N,kNi,i->k", arm.mass, centres, arm.gravity)


def _run(arm: Arm, samples: np.ndarray, M: np.ndarray) -> np.ndarray:
    """Run the kernel with masses and inertias turned into the chain's z-frames."""
    z = arm.chain.z_frames
    com = np.einsum("Nij,Nj->Ni", z.to_body, arm.com)
    inertia = np.ascontiguousarray(z.to_body @ arm.inertia @ np.swapaxes(z.to_body, 1, 2))
    return kernels.gravity_and_inertia(
        z.parent,
        z.joint_type,
        z.rotations,
        z.translations,
        arm.chain.coupling.value(samples),
        arm.mass,
        com,
        inertia,
        arm.gravity,
        M,
    )
