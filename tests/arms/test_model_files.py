"""Arms from MJCF and URDF files, from myo-sim, and the registry of arms."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import ModelChoices, arm_names, load_arm, read_model, srs7
from selfmotion.errors import FileFormatError, ModelError, RangeError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from tests.kinematics.test_mujoco_chain import HARD, QUADRATIC, check

MEMIKRR = Path(__file__).parents[3].joinpath("shared", "data", "memikrr")
SIMPLE = MEMIKRR / "x_arm_musculoskeletal_simplified_joints_aligned_lql_noJointOffset.urdf"
FULL = MEMIKRR / "x_arm_musculoskeletal_lql.urdf"

URDF = """
<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="nowhere.stl"/></geometry></visual></link>
  <link name="lower"/>
  <link name="tool"/>
  <link name="cap"/>
  <joint name="shoulder_joint" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1.5" effort="1" velocity="1"/></joint>
  <joint name="follower" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
    <mimic joint="shoulder_joint" multiplier="-2" offset="0.1"/></joint>
  <joint name="locked" type="revolute"><parent link="lower"/><child link="tool"/>
    <origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>
    <limit lower="0.5" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="turn" type="continuous"><parent link="tool"/><child link="cap"/>
    <origin xyz="0.1 0 0"/><axis xyz="1 0 0"/></joint>
</robot>
"""


def written(tmp_path: Path, name: str, text: str) -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


class TestUrdf:
    def test_mimic_fixed_limits_and_massless_links(self, tmp_path):
        arm = load_arm(written(tmp_path, "two.urdf", URDF))
        assert arm.joints == ("shoulder_joint", "turn")
        assert arm.chain.names == ("shoulder_joint", "follower", "turn")
        np.testing.assert_allclose(arm.lower, [-1, -2 * np.pi])
        np.testing.assert_allclose(arm.upper, [1.5, 2 * np.pi])
        for a in (-0.7, 0.0, 1.1):
            # Links 0.3, 0.2, 0.1 at angles a, a + (0.1 - 2a), that + 0.5.
            angles = np.cumsum([a, 0.1 - 2 * a, 0.5])
            x = np.array([0.3, 0.2, 0.1]) @ np.stack([np.cos(angles), np.sin(angles)], axis=1)
            T = forward_kinematics(arm.chain, [a, 0.4], arm.tip("hand"))[0]
            np.testing.assert_allclose(T[:3, 3], [*x, 0.5], atol=1e-12)

    def test_masses_are_the_file_s_and_nothing_else(self, tmp_path):
        arm = read_model(written(tmp_path, "two.urdf", URDF))
        np.testing.assert_allclose(arm.mass, [2, 0, 0], rtol=1e-12)
        np.testing.assert_allclose(arm.com[0], [0.1, 0, 0], atol=1e-12)
        np.testing.assert_allclose(arm.inertia[0], np.diag([0.01, 0.02, 0.02]), atol=1e-12)
        assert not arm.inertia[1:].any()

    def test_up_sets_gravity_and_directions(self, tmp_path):
        arm = read_model(written(tmp_path, "two.urdf", URDF), ModelChoices(up=(0, 1, 0)))
        np.testing.assert_allclose(arm.gravity, [0, -9.81, 0])
        np.testing.assert_allclose(arm.up, [0, 1, 0])
        np.testing.assert_allclose(arm.forward, [1, 0, 0])

    def test_landmarks_by_name_by_choice_and_by_default(self, tmp_path):
        path = written(tmp_path, "two.urdf", URDF)
        arm = read_model(path, ModelChoices(tip="tool", landmarks={"elbow": "lower"}))
        at_zero = {
            key: forward_kinematics(arm.chain, [0.0], tip)[0, :3, 3].round(6).tolist()
            for key, tip in arm.landmarks.items()
        }
        assert at_zero["shoulder"] == [0, 0, 0.5]
        assert at_zero["elbow"] == [0.3, 0, 0.5]
        assert at_zero["hand"][0] == pytest.approx(0.3 + 0.2 * np.cos(0.1), abs=1e-6)


class TestMjcf:
    def test_hard_model(self, tmp_path):
        arm = load_arm(written(tmp_path, "hard.xml", HARD.format(equality=QUADRATIC)))
        assert arm.name == "hard"
        assert arm.joints == ("first", "slide", "last")
        np.testing.assert_allclose(arm.up, [0, 0, 1])
        q = arm.random_postures(20, np.random.default_rng(0))
        assert np.isfinite(geometric_jacobian(arm.chain, q, arm.tip("hand"))).all()

    def test_forward_must_not_be_up(self, tmp_path):
        path = written(tmp_path, "hard.xml", HARD.format(equality=""))
        with pytest.raises(RangeError, match="must point across up"):
            read_model(path, ModelChoices(forward=(0, 0, 1)))


class TestBadFiles:
    @pytest.mark.parametrize(
        ("name", "text", "sentence"),
        [
            ("a.xml", "<mujoco><worldbody>", "not well-formed"),
            ("a.xml", "<html/>", "the root element is <html>"),
            ("a.xml", "<mujoco><nonsense/></mujoco>", "nonsense"),
            ("a.urdf", '<robot name="r"><joint name="j" type="revolute"/></robot>', "a.urdf"),
        ],
    )
    def test_one_line_names_the_file(self, tmp_path, name, text, sentence):
        with pytest.raises(FileFormatError) as caught:
            load_arm(written(tmp_path, name, text))
        message = str(caught.value)
        assert sentence in message and name in message and "\n" not in message

    def test_missing_files_and_other_formats(self, tmp_path):
        with pytest.raises(FileFormatError, match="there is no such file"):
            load_arm(tmp_path / "none.xml")
        with pytest.raises(FileFormatError, match="an arm is read from"):
            load_arm(tmp_path / "none.step")

    def test_a_mimic_of_nothing(self, tmp_path):
        text = URDF.replace('mimic joint="shoulder_joint"', 'mimic joint="nobody"')
        with pytest.raises((FileFormatError, ModelError)) as caught:
            load_arm(written(tmp_path, "a.urdf", text))
        assert "\n" not in str(caught.value)


class TestRegistry:
    def test_every_name_loads_and_stands_within_its_limits(self):
        for name in arm_names():
            arm = load_arm(name)
            assert arm.name == name
            assert arm.source
            assert (arm.lower < arm.upper).all()
            assert set(arm.landmarks) >= {"shoulder", "elbow", "wrist", "hand"}
            assert arm.mass.sum() > 0
            assert abs(np.dot(arm.up, arm.forward)) < 1e-9

    def test_unknown_names_are_answered_with_the_nearest(self):
        with pytest.raises(UnknownNameError, match="unknown arm 'wirst'; did you mean 'wrist'"):
            load_arm("wirst")


class TestMyoarm:
    def test_whole_model_in_mujoco(self):
        from selfmotion.kinematics.mujoco_chain import chain_from_mujoco
        from selfmotion.muscles.mujoco_bridge import load_myo_sim

        taken = chain_from_mujoco(load_myo_sim(), tip="capitate_r")
        check(taken, "capitate_r")
        check(taken, "3proxph_r")

    def test_coordinates_girdle_and_directions(self):
        arm = load_arm("myoarm")
        assert arm.joints == (
            "elv_angle",
            "shoulder_elv",
            "shoulder_rot",
            "elbow_flexion",
            "pro_sup",
            "deviation",
            "flexion",
        )
        assert len(arm.chain.names) == 18
        T = {k: forward_kinematics(arm.chain, np.zeros(7), t)[0] for k, t in arm.landmarks.items()}
        right = np.cross(arm.forward, arm.up)
        # Axes of the hand at zero: forward, up, right; the arm hangs.
        axes = np.stack([arm.forward, arm.up, right], axis=1)
        np.testing.assert_allclose(T["hand"][:3, :3], axes, atol=1e-9)
        heights = [T[k][:3, 3] @ arm.up for k in ("shoulder", "elbow", "wrist", "hand")]
        assert (np.diff(heights) < 0).all()
        assert T["shoulder"][:3, 3] @ right > 0.1
        # The glenohumeral centre rises when the arm does (FACTS: the girdle follows).
        raised = forward_kinematics(arm.chain, 2.0 * np.eye(7)[1], arm.tip("shoulder"))[0, :3, 3]
        assert raised @ arm.up > heights[0] + 0.01

    def test_hand_and_wrist_are_fixed_to_each_other(self):
        arm = load_arm("myoarm")
        q = arm.random_postures(10, np.random.default_rng(1))
        wrist, hand = (forward_kinematics(arm.chain, q, arm.tip(k)) for k in ("wrist", "hand"))
        between = np.linalg.norm(hand[:, :3, 3] - wrist[:, :3, 3], axis=1)
        np.testing.assert_allclose(between, between[0], rtol=1e-12)
        np.testing.assert_allclose(wrist[:, :3, :3], hand[:, :3, :3], atol=1e-12)


@pytest.mark.skipif(not MEMIKRR.exists(), reason="the reference data of Li 2022 is not here")
class TestMemikrr:
    def test_srs7_is_the_authors_simplified_arm(self):
        urdf = read_model(SIMPLE, ModelChoices(tip="wrist", up=(0, 1, 0)))
        origins = dict(zip(urdf.chain.names, urdf.chain.offsets[:, :3, 3], strict=True))
        shoulder = origins["upperarm1ToThorax"]
        upper, fore = (-origins[name][1] for name in ("ulnaToUpperarm3", "proximal_row2radius"))
        arm = srs7([upper, fore], shoulder=shoulder)
        q = arm.random_postures(20, np.random.default_rng(0))
        other = np.column_stack([np.zeros(20), q])  # the first joint turns the thorax
        np.testing.assert_allclose(
            forward_kinematics(arm.chain, q, arm.tip("hand")),
            forward_kinematics(urdf.chain, other, urdf.tip("hand")),
            atol=1e-12,
        )

    def test_feasible_postures_reach_their_poses(self):
        from scipy.spatial.transform import Rotation

        urdf = read_model(FULL, ModelChoices(tip="wrist_hand", up=(0, 1, 0)))
        assert len(urdf.joints) == 21
        rows = np.loadtxt(MEMIKRR / "feasible_postures_001_060.txt", max_rows=200)
        poses = np.loadtxt(MEMIKRR / "wrist_poses_001_060.txt")
        target = poses[rows[:, 0].astype(int)]
        T = forward_kinematics(urdf.chain, rows[:, 2:], urdf.tip("hand"))
        assert abs(T[:, :3, 3] - target[:, 5:8]).max() < 1e-3
        turn = Rotation.from_matrix(T[:, :3, :3]).inv() * Rotation.from_quat(target[:, 1:5])
        assert turn.magnitude().max() < 1e-2


def test_model_without_any_name_is_refused_and_named(tmp_path):
    file = tmp_path / "nameless.xml"
    file.write_text(
        '<mujoco><worldbody><body><joint type="hinge" axis="0 1 0"/>'
        '<geom type="sphere" size=".1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(ModelError, match=r"nameless.xml: no site or body has a name"):
        read_model(file)
