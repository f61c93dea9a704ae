import mujoco
import numpy as np
import pytest

from selfmotion.errors import ModelError, UnknownNameError
from selfmotion.kinematics.dynamics import gravity_torque
from selfmotion.kinematics.mujoco_chain import chain_from_mujoco
from selfmotion.muscles.mujoco_bridge import load_myo_sim, muscles_from_mujoco

STEP = 1e-6

ARM = """
<mujoco>
  <worldbody>
    <site name="origin" pos="0 0 0.1"/>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" range="-90 90"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="2"/>
      <body name="lower" pos="0.3 0 0">
        <joint name="elbow" axis="0 1 0" range="-90 90"/>
        <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" mass="1"/>
        <site name="end" pos="0.05 0 0.02"/>
      </body>
    </body>
  </worldbody>
  <tendon><spatial name="t"><site site="origin"/><site site="end"/></spatial></tendon>
  <actuator>{}</actuator>
</mujoco>
"""
MUSCLE = '<muscle name="m" tendon="t" force="100" lengthrange="0.2 0.5" range="0.75 1.05"/>'


def test_moment_arms_are_minus_the_total_derivative_of_length(muscle_arm):
    q = muscle_arm.arm.random_postures(25, np.random.default_rng(0))
    arms = muscle_arm.geometry.moment_arms(q)
    for j in range(7):
        step = np.zeros(7)
        step[j] = STEP
        ahead, behind = (muscle_arm.geometry.lengths(q + s) for s in (step, -step))
        # Through the coupling: elevation moves the whole girdle. No path jumps at these postures.
        assert arms[:, :, j] == pytest.approx(-(ahead - behind) / (2 * STEP), abs=2e-7)


def test_forces_are_those_of_the_compiled_model(muscle_arm):
    model = muscle_arm.geometry.model
    q = muscle_arm.arm.random_postures(3, np.random.default_rng(1))
    lengths = muscle_arm.geometry.lengths(q)
    active = muscle_arm.forces.full_activation(lengths)
    passive = muscle_arm.forces.passive(lengths)
    data = mujoco.MjData(model)
    for k in range(3):
        data.qpos[model.jnt_qposadr[muscle_arm.geometry.joint_ids]] = (
            muscle_arm.arm.chain.coupling.value(q[k : k + 1])[0]
        )
        data.act[:] = 1.0
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        assert data.actuator_length == pytest.approx(lengths[k], abs=1e-12)
        assert -data.actuator_force == pytest.approx(active[k] + passive[k], abs=1e-8)


def test_gravity_torque_is_that_of_the_compiled_model(muscle_arm):
    arm, geometry = muscle_arm.arm, muscle_arm.geometry
    model = geometry.model
    q = arm.random_postures(3, np.random.default_rng(2))
    data = mujoco.MjData(model)
    for k in range(3):
        data.qpos[model.jnt_qposadr[geometry.joint_ids]] = arm.chain.coupling.value(q[k : k + 1])[0]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        C = arm.chain.coupling.derivative(q[k : k + 1])[0]
        bias = data.qfrc_bias[model.jnt_dofadr[geometry.joint_ids]]
        assert gravity_torque(arm, q[k])[0] == pytest.approx(C.T @ bias, abs=1e-10)


def test_a_muscle_of_a_small_model_pulls_as_worked_by_hand():
    model = mujoco.MjSpec.from_string(ARM.format(MUSCLE)).compile()
    chain = chain_from_mujoco(model, tip="lower").chain
    muscles, geometry, _ = muscles_from_mujoco(model, chain)
    # Path from (0, 0, 0.1) to (0.35, 0, 0.02) at zero.
    length = np.hypot(0.35, 0.08)
    found, arms = geometry.lengths_and_moment_arms(np.zeros((1, 2)))
    assert found[0, 0] == pytest.approx(length)
    # Torque about +y of the unit pull from the end towards the origin: (r x u)_y = z ux - x uz.
    u = np.array([-0.35, 0.0, 0.08]) / length
    assert arms[0, 0] == pytest.approx(
        [0.02 * u[0] - 0.35 * u[2], 0.02 * u[0] - 0.05 * u[2]], abs=1e-12
    )
    assert muscles.fibre[0] == pytest.approx(1.0) and muscles.tendon[0] == pytest.approx(-0.55)


def test_models_without_usable_muscles_are_refused():
    motor = '<motor name="a" joint="elbow"/>'
    model = mujoco.MjSpec.from_string(ARM.format(motor)).compile()
    chain = chain_from_mujoco(model, tip="lower").chain
    with pytest.raises(ModelError, match="no muscles among its 1 actuators"):
        muscles_from_mujoco(model, chain)
    direct = '<muscle name="m" joint="elbow" force="10" lengthrange="0 1"/>'
    model = mujoco.MjSpec.from_string(ARM.format(direct)).compile()
    with pytest.raises(ModelError, match="'m' does not pull on a tendon"):
        muscles_from_mujoco(model, chain_from_mujoco(model, tip="lower").chain)
    other = mujoco.MjSpec.from_string(ARM.replace('"elbow"', '"knee"').format(MUSCLE)).compile()
    with pytest.raises(UnknownNameError, match="unknown joint 'elbow'"):
        muscles_from_mujoco(other, chain)
    with pytest.raises(ModelError, match="myo-sim has no model"):
        load_myo_sim("octopus")
