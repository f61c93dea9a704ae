"""Muscle effort against MuJoCo's own forces and inverse dynamics, shared out by SciPy's SLSQP."""

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize

from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.muscles.static_optimization import EffortOptions, muscle_effort


def strength_and_torque(model, q, qd, qdd, options):
    """Give what MuJoCo says: torque of each muscle at activation 1 (M, n), torque asked for."""
    arm, g = model.arm, model.geometry
    m, d, dofs = g.model, mujoco.MjData(g.model), g.model.jnt_dofadr[g.joint_ids]
    C = arm.chain.coupling.derivative(q[None])[0]  # constant: no more terms with velocity
    d.qpos[m.jnt_qposadr[g.joint_ids]] = arm.chain.coupling.value(q[None])[0]
    d.qvel[dofs] = C @ qd
    mujoco.mj_fwdPosition(m, d)
    mujoco.mj_fwdVelocity(m, d)
    moment = np.zeros((m.nu, m.nv))
    sparse = (d.actuator_moment.ravel(), d.moment_rownnz, d.moment_rowadr)
    mujoco.mju_sparse2dense(moment, *sparse, d.moment_colind.ravel())
    forces = []
    for activation in (0.0, 1.0):
        d.act[:] = activation
        mujoco.mj_fwdActuation(m, d)
        forces.append(d.actuator_force[g.actuators].copy())
    arms = moment[g.actuators][:, dofs] @ C
    d.qacc[:] = 0.0
    d.qacc[dofs] = C @ qdd
    bias = np.zeros(m.nv)
    mujoco.mj_rne(m, d, 1, bias)
    torque = C.T @ bias[dofs]
    tip = arm.tip("hand")
    point = forward_kinematics(arm.chain, q[None], tip)[0, :3, 3]
    J, Jdot = np.zeros((3, m.nv)), np.zeros((3, m.nv))
    body = m.jnt_bodyid[g.joint_ids[tip.joint]]
    mujoco.mj_jac(m, d, J, None, point, body)
    mujoco.mj_jacDot(m, d, Jdot, None, point, body)
    held = J[:, dofs] @ C @ qdd + Jdot[:, dofs] @ C @ qd - m.opt.gravity
    torque += options.hand_load * (J[:, dofs] @ C).T @ held
    if "passive" in options.loads:
        torque -= arms.T @ forces[0]
    return (forces[1] - forces[0])[:, None] * arms, torque


def least_effort(strength, torque, options):
    """Give the least sum of powers by SLSQP, and how much of the torque its answer misses."""
    p, count = options.exponent, len(strength)
    found = minimize(
        lambda a: (a**p).sum(),
        np.full(count, 0.2),
        jac=lambda a: p * a ** (p - 1),
        bounds=[(options.lower, 1.0)] * count,
        constraints={
            "type": "eq",
            "fun": lambda a: strength.T @ a - torque,
            "jac": lambda a: strength.T,
        },
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 600},
    )
    return found.fun, np.abs(strength.T @ found.x - torque).max()


@pytest.mark.parametrize(
    ("options", "moving"),
    [
        (EffortOptions(), False),
        (EffortOptions(lower=0.01, exponent=3.0), False),
        (EffortOptions(loads=("gravity", "passive"), hand_load=0.5), False),
        (EffortOptions(hand_load=1.0), True),
    ],
)
def test_effort_is_that_of_mujoco_and_slsqp(muscle_arm, options, moving):
    rng = np.random.default_rng(77)
    checked = 0
    for q in muscle_arm.arm.random_postures(4, rng):
        qd, qdd = moving * rng.normal(size=7), 3.0 * moving * rng.normal(size=7)
        ours = muscle_effort(muscle_arm, q, velocity=[qd], acceleration=[qdd], options=options)
        strength, torque = strength_and_torque(muscle_arm, q, qd, qdd, options)
        np.testing.assert_allclose(ours.torque[0], torque, atol=1e-6)
        if ours.status[0]:  # what nothing holds is tested with the solver
            effort, missing = least_effort(strength, torque, options)
            assert missing < 1e-6
            assert ours.effort[0] == pytest.approx(effort, rel=1e-4)
            checked += 1
    assert checked > 0
