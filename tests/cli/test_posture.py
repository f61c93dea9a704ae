from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.kinematics.forward import forward_kinematics
from tests.cli.golden import ROOT
from tests.cli.running import Capture, answered, refused, written

POSES = ROOT / "examples" / "poses.csv"
HEADER = "id,qx,qy,qz,qw,x,y,z\n"
GOOD = POSES.read_text(encoding="utf-8").splitlines()[3]


@pytest.fixture(scope="module")
def arm():
    return load_arm("myoarm")


def test_postures_hold_the_hand_poses_inside_the_limits(arm, capsys: Capture) -> None:
    found = answered(capsys, "posture", POSES)
    rows = np.loadtxt(POSES, delimiter=",", skiprows=1)
    for pose, row in zip(found["poses"], rows, strict=True):
        q = np.array([pose["q"][name] for name in arm.joints])
        T = forward_kinematics(arm.chain, q, arm.tip("hand"))[0]
        np.testing.assert_allclose(T[:3, 3], row[5:], atol=1e-8)
        assert ((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all()
        assert any(
            low - 1e-9 <= pose["swivel"] <= high + 1e-9 for low, high in pose["feasible_swivel"]
        )
        assert pose["minima"][0]["effort"] == pytest.approx(pose["effort"], rel=1e-9)


def test_rows_that_fail_say_why_and_the_others_are_computed(
    tmp_path: Path, capsys: Capture
) -> None:
    text = HEADER + GOOD + "\n8,0,0,0,2,0,0,0\n9,0,0,0,1,nan,0,0\n10,0,0,0,1,9,0,0\n"
    file = written(tmp_path / "p.csv", text)
    found = answered(capsys, "posture", file, code=1)["poses"]
    assert [pose["failed"] for pose in found] == [False, True, True, True]
    assert [pose["id"] for pose in found] == [3, 8, 9, 10]
    assert "row 3, columns qx to qw: a quaternion of length 2" in found[1]["status"]
    assert "row 4, column x: 'nan' is no finite number" in found[2]["status"]
    assert "out of reach: the nearest hand pose found is" in found[3]["status"]
    assert found[3]["swivel"] is None
    assert set(found[3]["q"].values()) == {None}


def test_a_frame_turns_and_moves_the_poses(arm, tmp_path: Path, capsys: Capture) -> None:
    """The same pose written in axes forward, up, right from the shoulder gives the same answer."""
    from scipy.spatial.transform import Rotation

    row = np.array([float(cell) for cell in GOOD.split(",")])
    home = np.clip(np.zeros(7), arm.lower, arm.upper)
    shoulder = forward_kinematics(arm.chain, home, arm.tip("shoulder"))[0, :3, 3]
    R = np.stack([arm.forward, arm.up, np.cross(arm.forward, arm.up)])
    turned = (Rotation.from_matrix(R) * Rotation.from_quat(row[1:5])).as_quat()
    moved = R @ (row[5:] - shoulder)
    cells = ",".join(repr(float(v)) for v in (*turned, *moved))
    file = written(tmp_path / "p.csv", HEADER + f"3,{cells}\n")
    there = answered(capsys, "posture", file, "--frame", "forward,up,right@shoulder")
    here = answered(capsys, "posture", written(tmp_path / "h.csv", HEADER + GOOD + "\n"))
    # The file has nine digits; the search stops within a thousandth of the least effort.
    assert there["poses"][0]["swivel"] == pytest.approx(here["poses"][0]["swivel"], abs=1e-4)


def test_a_body_keeps_the_arm_out(arm, tmp_path: Path, capsys: Capture) -> None:
    from scipy.spatial.transform import Rotation

    from selfmotion.kinematics.body_shapes import BodyShapes

    thorax = BodyShapes.of(arm).shapes["thorax"]
    q = arm.random_postures(4000, np.random.default_rng(7))
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    deepest = T[int(np.argmin(thorax.distance(T[:, :3, 3])))]
    cells = [*Rotation.from_matrix(deepest[:3, :3]).as_quat(), *deepest[:3, 3]]
    file = written(
        tmp_path / "p.csv", HEADER + GOOD + "\n9," + ",".join(repr(float(v)) for v in cells) + "\n"
    )
    before = answered(capsys, "posture", file)
    after = answered(capsys, "posture", file, "--body", "seated", code=1)
    assert [pose["failed"] for pose in before["poses"]] == [False, False]
    assert [pose["failed"] for pose in after["poses"]] == [False, True]
    assert after["poses"][1]["status"] == "every posture meets an excluded body"
    assert after["provenance"]["choices"]["body"] == "seated"
    assert "body" not in before["provenance"]["choices"]


def test_results_are_written_and_an_interrupted_run_goes_on(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path / "p.csv", HEADER + GOOD + "\n")
    page = tmp_path / "report.html"
    first = answered(capsys, "posture", file, "--out", tmp_path / "out", "--report", page)
    text = page.read_text(encoding="utf-8")
    assert "Pose 3" in text and text.count("<svg") == 3
    for words in ("muscle effort Σa²", "coordinate (deg)", "activation (no unit)", "in degrees"):
        assert words in text
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "posture.json", "posture.csv", "posture.journal.jsonl"
    }  # fmt: skip

    def not_again(payload: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr("selfmotion.cli.posture.find_one", not_again)
    again = answered(capsys, "posture", file, "--out", tmp_path / "out", "--resume")
    assert again["poses"] == first["poses"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (HEADER + "1,0,0,0,2,0,0,0\n", "row 2, columns qx to qw: a quaternion of length 2"),
        (HEADER + "1,0,0,0,1,nan,0,0\n", "row 2, column x: 'nan' is no finite number"),
        ("id,qx,qy,qz,qw,x,y\n1,0,0,0,1,0,0\n", "no column z"),
        ("1 0 0 0 1 0 0\n", "row 1 has 7 cells: 8 are needed"),
    ],
)
def test_bad_files_are_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    file = written(tmp_path / "p.csv", text)
    line = refused(capsys, "posture", file)
    assert reason in line
    assert str(file) in line


def test_a_file_that_is_not_there_is_named(tmp_path: Path, capsys: Capture) -> None:
    assert "nowhere.csv: cannot be opened" in refused(capsys, "posture", tmp_path / "nowhere.csv")


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--frame", "forward,up"), "--frame 'forward,up': allowed are model, or three of"),
        (("--frame", "forward,up,left"), "no right-handed frame"),
        (("--frame", "model@knee"), "unknown landmark 'knee'"),
        (("--resume",), "--resume: name the folder"),
        (("--model", "arm.stl"), "arm.stl: expected myoarm, an .osim or an .xml"),
        (("--hand-load", "-1"), "hand_load = -1: allowed is 0 to 200"),
        (("--jobs", "0"), "jobs = 0: allowed is 1 and above"),
        (("--robot", "nowhere.urdf"), "nowhere.urdf"),
        (("--hold", "trunk=0"), "--hold 'trunk=0': name the robot too, with --robot FILE.urdf"),
    ],
)
def test_bad_options_are_one_line(capsys: Capture, options: tuple[str, ...], reason: str) -> None:
    assert reason in refused(capsys, "posture", POSES, *options)


def test_a_model_without_muscles_is_refused(tmp_path: Path, capsys: Capture) -> None:
    body = '<body name="b{0}"><joint name="j{0}" axis="{1}"/><geom size=".1"/>{2}</body>'
    inner = ""
    for i in range(7):
        inner = body.format(i, "1 0 0" if i % 2 else "0 1 0", inner)
    file = written(tmp_path / "arm.xml", f"<mujoco><worldbody>{inner}</worldbody></mujoco>")
    assert "arm.xml: the model has no muscles" in refused(capsys, "posture", POSES, "--model", file)


def test_a_robot_takes_the_natural_swivel_angle(
    arm, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot that is the human arm itself takes the swivel angle, and so the very posture."""
    monkeypatch.setattr("selfmotion.cli.robot.read_robot", lambda path, model, held: arm)
    file = written(tmp_path / "p.csv", HEADER + GOOD + "\n")
    pose = answered(capsys, "posture", file, "--robot", "itself.urdf")["poses"][0]
    assert pose["robot"]["status"] == "natural swivel angle"
    assert pose["robot"]["swivel"] == pytest.approx(pose["swivel"], abs=1e-8)
    T = forward_kinematics(arm.chain, pose["robot"]["q"], arm.tip("hand"))[0]
    np.testing.assert_allclose(T[:3, 3], [float(v) for v in GOOD.split(",")[5:]], atol=1e-8)


ROBOT = """
<robot name="arm">
  <link name="base"/> <link name="trunk"/>
  <joint name="trunk_turn" type="revolute"> <parent link="base"/> <child link="trunk"/>
    <axis xyz="0 0 1"/> <limit lower="-1" upper="1" effort="1" velocity="1"/> </joint>
  {joints}
</robot>
"""
JOINT = """
  <link name="{name}"> <inertial> <mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/> </inertial> </link>
  <joint name="j_{name}" type="revolute"> <parent link="{parent}"/> <child link="{name}"/>
    <origin xyz="{at}"/> <axis xyz="{axis}"/>
    <limit lower="-3.1" upper="3.1" effort="1" velocity="1"/> </joint>
"""


def urdf_of_lengths(shoulder: np.ndarray, upper_arm: float, forearm: float) -> str:
    """Write a robot of seven joints (S-R-S) under a turning trunk, its shoulder somewhere."""
    parts, parent = [], "trunk"
    places = [
        shoulder,
        [0, 0, 0],
        [0, 0, 0],
        [0, 0, -upper_arm],
        [0, 0, -forearm],
        *2 * [[0, 0, 0]],
    ]
    axes = ["0 0 1", "1 0 0", "0 0 1", "1 0 0", "0 0 1", "1 0 0", "0 1 0"]
    names = ["s1", "s2", "upper_arm", "forearm", "wrist1", "wrist2", "hand"]
    for name, place, axis in zip(names, places, axes, strict=True):
        at = " ".join(f"{v:.12g}" for v in place)
        parts.append(JOINT.format(name=name, parent=parent, at=at, axis=axis))
        parent = name
    return ROBOT.format(joints="".join(parts))


def test_a_robot_of_other_lengths_holds_the_pose_with_the_natural_swivel_angle(
    arm, tmp_path: Path, capsys: Capture
) -> None:
    pin = pytest.importorskip("pinocchio", reason="needs pinocchio, to ask what the robot does")
    home = np.clip(np.zeros(7), arm.lower, arm.upper)
    shoulder = forward_kinematics(arm.chain, home, arm.tip("shoulder"))[0, :3, 3]
    robot = written(tmp_path / "robot.urdf", urdf_of_lengths(shoulder, 0.36, 0.33))
    file = written(tmp_path / "p.csv", HEADER + GOOD + "\n")
    options = ("--robot", robot, "--hold", "trunk_turn=0")
    found = answered(capsys, "posture", file, *options)
    pose = found["poses"][0]
    assert pose["robot"]["status"] == "natural swivel angle"
    model = pin.buildModelFromUrdf(str(robot))
    data, q = model.createData(), pin.neutral(model)
    for name, angle in zip(found["robot_joints"], pose["robot"]["q"], strict=True):
        q[model.joints[model.getJointId(name)].idx_q] = angle
    pin.framesForwardKinematics(model, data, q)
    hand = pin.SE3ToXYZQUAT(data.oMf[model.getFrameId("hand")])
    row = np.array([float(cell) for cell in GOOD.split(",")])
    np.testing.assert_allclose(hand[:3], row[5:], atol=1e-8)
    assert abs(hand[3:] @ row[1:5]) == pytest.approx(1.0, abs=1e-8)
    E, W = (data.oMi[model.getJointId(f"j_{name}")].translation for name in ("forearm", "wrist1"))
    line = (W - shoulder) / np.linalg.norm(W - shoulder)
    out, down = (v - line * (line @ v) for v in (E - shoulder, np.array([0.0, 0.0, -1.0])))
    swivel = np.arctan2(np.cross(out, down) @ line, out @ down)
    assert np.cos(swivel - pose["swivel"]) == pytest.approx(1.0, abs=1e-12)


def test_a_robot_with_a_trunk_joint_is_told_to_hold_it(tmp_path: Path, capsys: Capture) -> None:
    robot = written(tmp_path / "robot.urdf", urdf_of_lengths(np.zeros(3), 0.3, 0.3))
    line = refused(capsys, "posture", POSES, "--robot", robot)
    assert "8 joints move (trunk_turn, j_s1," in line and "--hold JOINT=DEGREES" in line
    line = refused(capsys, "posture", POSES, "--robot", robot, "--hold", "trunk_turn")
    assert "--hold 'trunk_turn': write each joint once" in line
    line = refused(capsys, "posture", POSES, "--robot", robot, "--hold", "knee=0")
    assert "unknown joint 'knee'" in line
