"""Gravity torque and joint-space inertia matrix of an arm, for the free coordinates."""

import functools

import numpy as np
from jaxtyping import Float
from numba import njit
from numpy.typing import ArrayLike

from selfmotion.arrays import freeze
from selfmotion.kinematics import kernels
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, REVOLUTE


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
    z = arm.chain.z_frames
    frames = kernels.body_frames(
        z.parent, z.joint_type, z.rotations, z.translations, arm.chain.coupling.value(samples)
    )
    torque = np.empty((len(samples), len(arm.chain.names)))
    com = _in_z_frames(arm)[0]
    _gravity(z.parent, z.joint_type, *frames, arm.mass, com, arm.gravity, torque)
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
    com, inertia = _in_z_frames(arm)
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


@functools.lru_cache(maxsize=16)
def _in_z_frames(arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Give centres of mass and inertias in the axes of the chain's z-frames."""
    to_body = arm.chain.z_frames.to_body
    com = np.einsum("Nij,Nj->Ni", to_body, arm.com)
    inertia = to_body @ arm.inertia @ np.swapaxes(to_body, 1, 2)
    return freeze(np.ascontiguousarray(com)), freeze(np.ascontiguousarray(inertia))


@njit(cache=True)
def _gravity(parent, joint_type, R, p, mass, com, gravity, torque):
    """Fill torque (K,N): for each joint, minus the power of gravity on all that it carries."""
    n_samples, n_joints = torque.shape
    carried = np.empty((n_joints, 4))  # mass, and mass times centre in the ground
    for k in range(n_samples):
        for i in range(n_joints):
            carried[i, 0] = mass[i]
            for a in range(3):
                centre = p[k, i, a]
                for b in range(3):
                    centre += R[k, i, a, b] * com[i, b]
                carried[i, 1 + a] = mass[i] * centre
        for i in range(n_joints - 1, -1, -1):
            m = carried[i, 0]
            z0, z1, z2 = R[k, i, 0, 2], R[k, i, 1, 2], R[k, i, 2, 2]
            if joint_type[i] == REVOLUTE:
                d0 = carried[i, 1] - m * p[k, i, 0]
                d1 = carried[i, 2] - m * p[k, i, 1]
                d2 = carried[i, 3] - m * p[k, i, 2]
                torque[k, i] = -(
                    gravity[0] * (z1 * d2 - z2 * d1)
                    + gravity[1] * (z2 * d0 - z0 * d2)
                    + gravity[2] * (z0 * d1 - z1 * d0)
                )
            else:
                torque[k, i] = -m * (gravity[0] * z0 + gravity[1] * z1 + gravity[2] * z2)
            if parent[i] != GROUND:
                for a in range(4):
                    carried[parent[i], a] += carried[i, a]
