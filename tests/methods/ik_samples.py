"""Random and moving arms with known IK weights, written independently of the library."""

import numpy as np


def pseudo_inverse(J, w):
    """J# = W⁻¹Jᵀ(JW⁻¹Jᵀ)⁻¹ of Jacobians (K, m, n), eq. 4."""
    right = np.swapaxes(J, 1, 2) / np.asarray(w)[:, None]
    return right @ np.linalg.inv(J @ right)


def projector(J, w):
    """N = I - J#J (K, n, n)."""
    return np.eye(J.shape[2]) - pseudo_inverse(J, w) @ J


def random_arm(rng, w, *, samples, rows=3, noise=0.0, projected=True):
    """Example 1 of the paper: q̇ = J#J q₀ + v, all normal; v projected or not."""
    n = len(w)
    J = rng.standard_normal((samples, rows, n))
    q0, v = rng.standard_normal((2, samples, n, 1))
    P = pseudo_inverse(J, w) @ J
    v = noise * v
    if projected:
        v = v - P @ v
    return (P @ q0 + v)[..., 0], J


def two_joints(gain=3.0):
    """Example 2 of the paper with v = (-q₁, 0) per second, unprojected."""
    J, w, q = np.ones((1, 1, 2)), np.array([1.0, 0.01]), np.array([0.5, 0.5])
    inverse = pseudo_inverse(J, w)[0, :, 0]
    postures, velocities = [], []
    for k in range(60):
        goal = 1.0 if k < 20 else 1.5 if k < 30 else 0.5
        velocity = inverse * gain * (goal - q.sum()) + np.array([-q[0], 0.0])
        postures.append(q)
        velocities.append(velocity)
        q = q + 0.1 * velocity
    return np.array(postures), np.array(velocities), np.ones((60, 1, 2))


def reach_jacobian(q):
    """Jacobian (K, 2, 3) of a planar three-link arm."""
    angle = np.cumsum(q, axis=1)
    lengths = np.array([0.3, 0.25, 0.2])
    columns = [
        np.stack(
            [
                -(lengths[i:] * np.sin(angle[:, i:])).sum(axis=1),
                (lengths[i:] * np.cos(angle[:, i:])).sum(axis=1),
            ],
            axis=1,
        )
        for i in range(3)
    ]
    return np.stack(columns, axis=2)


def planar_reaches(rng, w, *, trials, samples=40, noise=0.1):
    """Smooth reaches of the planar arm; each trial has one null-space bump of random size."""
    speed = np.sin(np.linspace(0.0, np.pi, samples)) ** 2
    sets = []
    for _ in range(trials):
        q = np.array([0.3, 0.9, 0.7]) + 0.2 * rng.standard_normal(3)
        goal = rng.standard_normal(2) * 0.3
        bump = noise * rng.standard_normal(3)
        postures, velocities, jacobians = [], [], []
        for s in speed:
            J = reach_jacobian(q[None])
            inverse = pseudo_inverse(J, w)[0]
            velocity = inverse @ (goal * s) + s * (bump - inverse @ (J[0] @ bump))
            postures.append(q)
            velocities.append(velocity)
            jacobians.append(J[0])
            q = q + 0.02 * velocity
        sets.append((np.array(postures), np.array(velocities), np.array(jacobians)))
    return sets
