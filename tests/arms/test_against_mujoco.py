"""Every arm against MuJoCo on the same chain: frames, Jacobians, gravity torque, inertia."""

import numpy as np
import pytest
from numpy.typing import ArrayLike

from selfmotion.kinematics.chain import GROUND
from selfmotion.kinematics.dynamics import gravity_torque, inertia_matrix, potential_energy
from selfmotion.kinematics.forward import (
    body_frames,
    forward_kinematics,
    frames_and_jacobian,
    geometric_jacobian,
    tip_positions,
)
from tests.arms.mujoco_oracle import NAMES, Oracle, arm_called


def equal(actual: ArrayLike, expected: ArrayLike, message: str = "") -> None:
    a, b = np.asarray(actual), np.asarray(expected)
    np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-10, err_msg=message)


@pytest.fixture(params=NAMES, scope="module")
def case(request: pytest.FixtureRequest):
    arm = arm_called(request.param)
    q = arm.random_postures(6, np.random.default_rng(11))
    return arm, q, Oracle.of(arm)


def test_frames_and_jacobians_of_all_landmarks(case):
    arm, q, oracle = case
    for name, tip in arm.landmarks.items():
        T, J = frames_and_jacobian(arm.chain, q, tip)
        for k in range(len(q)):
            oracle.set(q[k])
            equal(T[k], oracle.frame(tip), name)
            if tip.joint == GROUND:
                assert not J[k].any()
            else:
                equal(J[k], oracle.jacobian(tip, q[k]), name)


def test_gravity_torque_and_inertia_matrix(case):
    arm, q, oracle = case
    torque, M = gravity_torque(arm, q), inertia_matrix(arm, q)
    for k in range(len(q)):
        oracle.set(q[k])
        equal(torque[k], oracle.gravity(q[k]))
        equal(M[k], oracle.inertia(q[k]))


def test_body_frames_and_tip_positions(case):
    arm, q, oracle = case
    frames = body_frames(arm.chain, q)
    tips = list(arm.landmarks.values())
    points = tip_positions(arm.chain, q, tips)
    for k in range(len(q)):
        oracle.set(q[k])
        R = oracle.data.xmat[1:].reshape(-1, 3, 3)
        equal(frames[k, :, :3, :3], R)
        equal(frames[k, :, :3, 3], oracle.data.xpos[1:])
        expected = [oracle.frame(tip)[:3, 3] for tip in tips]
        equal(points[k], expected)


def test_gravity_torque_is_the_slope_of_potential_energy(case):
    arm, q, _ = case
    h = 1e-5
    slope = np.empty_like(q)
    for i in range(arm.n_joints):
        step = h * np.eye(arm.n_joints)[i]
        slope[:, i] = potential_energy(arm, q + step) - potential_energy(arm, q - step)
    np.testing.assert_allclose(gravity_torque(arm, q), slope / (2 * h), rtol=0, atol=2e-8)


def test_inertia_matrix_is_symmetric_and_not_negative(case):
    arm, q, _ = case
    M = inertia_matrix(arm, q)
    np.testing.assert_allclose(M, np.swapaxes(M, 1, 2), rtol=0, atol=1e-14)
    assert np.linalg.eigvalsh(M).min() > -1e-12


def test_one_posture_is_the_first_of_many(case):
    arm, q, _ = case
    tip = arm.tip("hand")
    one = forward_kinematics(arm.chain, q[0], tip)
    assert one.shape == (1, 4, 4)
    assert np.array_equal(one[0], forward_kinematics(arm.chain, q, tip)[0])
    assert geometric_jacobian(arm.chain, q[0], tip).shape == (1, 6, arm.n_joints)
