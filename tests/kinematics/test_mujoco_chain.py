"""Chains taken from MuJoCo models, against MuJoCo's own kinematics on the model they come from."""

import mujoco
import numpy as np
import pytest

from selfmotion.errors import ModelError, UnknownNameError
from selfmotion.kinematics.arm import LANDMARKS, Arm
from selfmotion.kinematics.dynamics import gravity_torque, inertia_matrix
from selfmotion.kinematics.forward import frames_and_jacobian
from selfmotion.kinematics.mujoco_chain import MujocoChain, chain_from_mujoco

# Two joints in one body, anchors off the origin, a slide, fixed bodies on and beside the way,
# a default position that is not zero, a branch with a joint of its own.
HARD = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body pos="0 0 1" euler="0.3 0.2 -0.4">
      <body name="base" pos="0.1 0 0">
        <joint name="first" axis="1 2 3" pos="0.03 -0.02 0.05" range="-1 1" limited="true"/>
        <joint name="second" axis="0 1 0" pos="-0.04 0.01 0.02" ref="0.3"/>
        <geom type="capsule" fromto="0 0 0 0.2 0.1 0" size="0.03"/>
        <body name="plate" pos="0.2 0 0.05" euler="0.5 0 0">
          <geom type="box" size="0.05 0.02 0.03" pos="0.01 0.02 0"/>
          <body name="rail" pos="0 0.1 0">
            <joint name="slide" type="slide" axis="0 0.6 0.8" ref="-0.05" pos="0.1 0.1 0.1"/>
            <geom type="sphere" size="0.04" pos="0 0 0.1"/>
            <body name="finger" pos="0 0 0.1">
              <joint name="knuckle" axis="1 0 0" pos="0 0.01 0" ref="0.2"/>
              <geom type="box" size="0.01 0.02 0.05" pos="0 0 0.05"/>
            </body>
            <body name="end" pos="0.05 0 0.2" quat="0.9 0.1 0.3 -0.2">
              <joint name="last" axis="0 0 1" pos="0 0 0.02"/>
              <geom type="ellipsoid" size="0.02 0.03 0.06" pos="0.02 0 0.05"/>
              <site name="tool" pos="0 0.02 0.1" euler="0 0.7 0"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality>{equality}</equality>
</mujoco>
"""
QUADRATIC = '<joint joint1="second" joint2="first" polycoef="0.1 0.5 -0.4 0.2 0"/>'
LINEAR = '<joint joint1="last" joint2="first" polycoef="0.1 -0.7 0 0 0"/>'
CHAINED = '<joint joint1="last" joint2="second" polycoef="0.05 2 0.3 0 0"/>'


def hard(*equalities: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(HARD.format(equality="".join(equalities)))


def check(taken: MujocoChain, tip_name: str, n_samples: int = 4) -> None:
    """Compare frames, Jacobian, gravity torque and inertia with the whole model's."""
    model, data = taken.model, mujoco.MjData(taken.model)
    tip = taken.tip(tip_name)
    arm = Arm(
        "taken",
        taken.chain,
        dict.fromkeys(LANDMARKS, tip),
        {},
        np.array([s.mass for s in taken.segments]),
        np.array([s.com for s in taken.segments]),
        np.array([s.inertia for s in taken.segments]),
        gravity=np.array(model.opt.gravity),
    )
    q = np.random.default_rng(2).uniform(-0.8, 0.8, (n_samples, taken.chain.n_coordinates))
    T, J = frames_and_jacobian(taken.chain, q, tip)
    torque, M = gravity_torque(arm, q), inertia_matrix(arm, q)
    for k in range(n_samples):
        data.qpos[:] = taken.qpos(q[k])[0]
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        equality = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        assert abs(data.efc_pos[equality]).max(initial=0.0) < 1e-13
        is_site = tip_name in [model.site(i).name for i in range(model.nsite)]
        frame = data.site(tip_name) if is_site else data.body(tip_name)
        np.testing.assert_allclose(T[k, :3, :3].ravel(), frame.xmat, rtol=0, atol=1e-10)
        np.testing.assert_allclose(T[k, :3, 3], frame.xpos, rtol=0, atol=1e-10)
        D = taken.velocity_map(q[k])[0]
        full = np.zeros((6, model.nv))
        body = model.site(tip_name).bodyid[0] if is_site else model.body(tip_name).id
        mujoco.mj_jac(model, data, full[:3], full[3:], T[k, :3, 3], body)
        np.testing.assert_allclose(J[k], full @ D, rtol=0, atol=1e-10)
        np.testing.assert_allclose(torque[k], D.T @ data.qfrc_bias, rtol=0, atol=1e-10)
        whole = np.zeros((model.nv, model.nv))
        for row, unit in zip(whole, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        whole -= np.diag(model.dof_armature)
        np.testing.assert_allclose(M[k], D.T @ whole @ D, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "equalities", [(), (LINEAR,), (QUADRATIC,), (QUADRATIC, LINEAR), (QUADRATIC, CHAINED)]
)
def test_anchors_slides_fixed_bodies_and_couplings(equalities):
    taken = chain_from_mujoco(hard(*equalities))
    assert taken.chain.names == ("first", "second", "slide", "last")
    assert taken.chain.n_coordinates == 4 - len(equalities)
    check(taken, "tool")


def test_coupling_derivative_by_finite_differences():
    taken = chain_from_mujoco(hard(QUADRATIC, CHAINED))
    q = np.random.default_rng(4).uniform(-1, 1, (5, taken.chain.n_coordinates))
    coupling, h = taken.chain.coupling, 1e-6
    assert len(coupling.curves) == 2
    for i in range(q.shape[1]):
        step = h * np.eye(q.shape[1])[i]
        slope = (coupling.value(q + step) - coupling.value(q - step)) / (2 * h)
        np.testing.assert_allclose(coupling.derivative(q)[:, :, i], slope, rtol=0, atol=1e-8)


def test_joints_can_be_held():
    taken = chain_from_mujoco(hard(), held={"slide": 0.07, "knuckle": 0.5})
    assert taken.chain.names == ("first", "second", "last")
    check(taken, "tool")


def test_followers_of_a_held_joint_are_held_where_the_coupling_puts_them():
    taken = chain_from_mujoco(hard(QUADRATIC), held={"first": 0.4})
    assert taken.chain.names == ("slide", "last")
    second = taken.model.joint("second").qposadr[0]
    expected = 0.3 + 0.1 + 0.5 * 0.4 - 0.4 * 0.4**2 + 0.2 * 0.4**3
    assert taken.rest[second] == pytest.approx(expected, abs=1e-15)
    check(taken, "tool")


def test_a_joint_set_by_a_constant_does_not_move():
    taken = chain_from_mujoco(hard('<joint joint1="second" polycoef="0.2 0 0 0 0"/>'))
    assert "second" not in taken.chain.names
    check(taken, "tool")


def test_tip_may_be_any_body_and_ends_the_chain_there():
    taken = chain_from_mujoco(hard(), tip="rail")
    assert taken.chain.names == ("first", "second", "slide")
    check(taken, "rail")
    check(taken, "finger")


def test_limits_and_what_stands_for_none():
    chain = chain_from_mujoco(hard()).chain
    np.testing.assert_allclose(chain.lower, [-1, -2 * np.pi, -1.0, -2 * np.pi])
    np.testing.assert_allclose(chain.upper, [1, 2 * np.pi, 1.0, 2 * np.pi])


def test_names_can_be_changed():
    chain = chain_from_mujoco(hard(LINEAR), names={"first": "elbow", "last": "wrist"}).chain
    assert chain.names == ("elbow", "second", "slide", "wrist")
    assert chain.coordinates == ("elbow", "second", "slide")


BALL = '<body name="b"><joint name="j" type="{kind}"/><geom size="0.1"/></body>'
LOOP = """
<mujoco><worldbody>
  <body name="a"><joint name="one" axis="0 0 1"/><geom size="0.1"/>
    <body name="b" pos="1 0 0"><joint name="two" axis="0 0 1"/><geom size="0.1"/></body></body>
</worldbody><equality><connect body1="b" body2="world" anchor="0 0 0"/></equality></mujoco>
"""


@pytest.mark.parametrize("kind", ["ball", "free"])
def test_ball_and_free_joints_are_refused(kind):
    xml = f"<mujoco><worldbody>{BALL.format(kind=kind)}</worldbody></mujoco>"
    with pytest.raises(ModelError, match=f"joint 'j' is a {kind} joint") as caught:
        chain_from_mujoco(mujoco.MjModel.from_xml_string(xml))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("equalities", "sentence"),
    [
        ((LINEAR, CHAINED), "'last' follows two others"),
        ((QUADRATIC, '<joint joint1="first" joint2="second"/>'), "follows itself"),
    ],
)
def test_contradicting_couplings_are_refused(equalities, sentence):
    with pytest.raises(ModelError, match=sentence):
        chain_from_mujoco(hard(*equalities))


def test_closed_loops_are_refused():
    with pytest.raises(ModelError, match="closes a loop"):
        chain_from_mujoco(mujoco.MjModel.from_xml_string(LOOP))


def test_unknown_tips_and_joints_are_named():
    with pytest.raises(UnknownNameError, match="unknown body or site 'tol'; did you mean 'tool'"):
        chain_from_mujoco(hard(), tip="tol")
    with pytest.raises(UnknownNameError, match="unknown joint 'elbow'"):
        chain_from_mujoco(hard(), held={"elbow": 0.0})


def test_a_body_that_nothing_moves_is_no_chain():
    xml = '<mujoco><worldbody><body name="b"><geom size="0.1"/></body></worldbody></mujoco>'
    with pytest.raises(ModelError, match="no joint moves 'b'"):
        chain_from_mujoco(mujoco.MjModel.from_xml_string(xml))
