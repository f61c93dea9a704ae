import json
from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.kinematics.forward import forward_kinematics
from tests.cli.golden import ROOT
from tests.cli.running import Capture, answered, refused, written

TARGETS = ROOT / "examples" / "targets.csv"
SPLINT = ("--limit", "elbow_flexion=64.2:114")


@pytest.mark.parametrize("task", ["position", "pose"])
def test_the_hand_comes_to_the_targets_inside_the_limits(task: str, capsys: Capture) -> None:
    found = answered(capsys, "ik", TARGETS, "--task", task, *SPLINT)
    arm = load_arm("upper_limb")
    assert found["joints"] == list(arm.joints)
    rows = np.loadtxt(TARGETS, delimiter=",", skiprows=1)
    q = np.array([t["q"] for t in found["targets"]])
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    np.testing.assert_allclose(T[:, :3, 3], rows[:, 1:4], atol=1e-5)
    assert {t["status"] for t in found["targets"]} == {"solved"}
    elbow = np.degrees(q[:, found["joints"].index("elbow_flexion")])
    assert ((elbow >= 64.2 - 1e-7) & (elbow <= 114 + 1e-7)).all()


def test_rows_hold_what_they_name(tmp_path: Path, capsys: Capture) -> None:
    file = written(tmp_path / "t.csv", "x,y,z_mm,rot_y_deg\n0.3,0.3,-100,-30\n")
    found = answered(capsys, "ik", file, "--task", "rows=x,y,z,rot_y")
    assert found["rows"] == ["x", "y", "z", "rot_y"]
    arm = load_arm("upper_limb")
    T = forward_kinematics(arm.chain, found["targets"][0]["q"], arm.tip("hand"))[0]
    np.testing.assert_allclose(T[:3, 3], [0.3, 0.3, -0.1], atol=1e-5)
    assert np.degrees(np.arcsin(-T[2, 0])) == pytest.approx(-30.0, abs=1e-2)


def test_targets_that_fail_say_why_and_the_others_are_computed(
    tmp_path: Path, capsys: Capture
) -> None:
    file = written(tmp_path / "t.csv", "id,x,y,z\na,0.3,0.3,-0.1\nb,3,0,0\nc,nan,0,0\n")
    found = answered(capsys, "ik", file, code=1)["targets"]
    assert [t["failed"] for t in found] == [False, True, True]
    assert found[1]["status"].startswith("not reached: ")
    assert found[1]["error_mm"] > 2000
    assert "row 4, column x: 'nan' is no finite number" in found[2]["status"]
    assert found[2]["q"] is None


def test_a_frame_turns_the_targets(tmp_path: Path, capsys: Capture) -> None:
    here = written(tmp_path / "h.csv", "x,y,z\n0.3,0.2,-0.1\n")
    there = written(tmp_path / "t.csv", "x,y,z\n0.2,-0.1,0.3\n")
    found = [
        answered(capsys, "ik", here)["targets"][0]["q"],
        answered(capsys, "ik", there, "--frame", "forward,up,right")["targets"][0]["q"],
    ]
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)


def test_weights_make_a_joint_move_less(tmp_path: Path, capsys: Capture) -> None:
    arm = load_arm("planar")
    n = arm.n_joints
    file = written(tmp_path / "t.csv", "x,y\n0.2,0.3\n")
    document = {"joints": list(arm.joints), "weights": [1.0] * (n - 1) + [1e4]}
    json_file = written(tmp_path / "w.json", json.dumps(document))
    words = ("ik", file, "--arm", "planar", "--task", "rows=x,y", "--weights")
    ones = answered(capsys, *words, ",".join("1" * n))["targets"][0]["q"]
    stiff = answered(capsys, *words, json_file)["targets"][0]["q"]
    assert ones != pytest.approx(stiff, abs=1e-3)


def test_results_are_written_and_an_interrupted_run_goes_on(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = answered(capsys, "ik", TARGETS, "--out", tmp_path / "out")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"ik.json", "ik.csv", "ik.journal.jsonl"}

    def not_again(payload: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr("selfmotion.cli.ik.solve_part", not_again)
    again = answered(capsys, "ik", TARGETS, "--out", tmp_path / "out", "--resume")
    assert again["targets"] == first["targets"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x,y,z\nnan,0,0\n", "row 2, column x: 'nan' is no finite number"),
        ("x,y\n0,0\n", "no column z"),
        ("x,y,z\n0,0,up\n", "row 2, column z: 'up' is no number"),
        ("x,y,z\n0,0,1e300\n", "row 2, column z: 1e+300 m is beyond 1e+06"),
    ],
)
def test_bad_files_are_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    file = written(tmp_path / "t.csv", text)
    line = refused(capsys, "ik", file)
    assert reason in line
    assert str(file) in line


def test_a_pose_needs_unit_quaternions(tmp_path: Path, capsys: Capture) -> None:
    bare = written(tmp_path / "b.csv", "x,y,z\n0,0,0\n")
    assert "no column qx, qy, qz, qw" in refused(capsys, "ik", bare, "--task", "pose")
    long = written(tmp_path / "l.csv", "x,y,z,qx,qy,qz,qw\n0,0,0,1,1,1,1\n")
    line = refused(capsys, "ik", long, "--task", "pose")
    assert "row 2, columns qx to qw: a quaternion of length 2" in line


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--arm", "uper_limb"), "unknown arm 'uper_limb'; did you mean 'upper_limb'?"),
        (("--limit", "elbow=1:2"), "unknown"),
        (("--limit", "elbow_flexion=114:64.2"), "the low bound 114 is above the high 64.2"),
        (("--limit", "elbow_flexion=0:400"), "allowed are angles from -360 to 360 degrees"),
        (("--task", "poses"), "unknown --task 'poses'; did you mean 'pose'?"),
        (("--task", "rows=x,rot_w"), "unknown row in --task 'rows=x,rot_w': 'rot_w'"),
        (("--task", "rows=x,x"), "a row stands twice"),
        (("--weights", "1,2"), "weights"),
        (("--weights", "a"), "--weights 'a': allowed are 9 numbers"),
        (("--jobs", "0"), "--jobs 0: allowed is 1 and above"),
        (("--resume",), "--resume: name the folder"),
    ],
)
def test_bad_options_are_one_line(capsys: Capture, options: tuple[str, ...], reason: str) -> None:
    assert reason in refused(capsys, "ik", TARGETS, *options)


def path_file(folder: Path, n: int = 30) -> Path:
    """A straight line of the hand in one second."""
    t = np.linspace(0.0, 1.0, n)
    line = np.outer(1 - t, [0.1, 0.4, -0.2]) + np.outer(t, [0.3, 0.4, 0.0])
    rows = "\n".join(",".join(f"{v:.6f}" for v in (a, *p)) for a, p in zip(t, line, strict=True))
    return written(folder / "path.csv", "time,x,y,z\n" + rows + "\n")


def test_a_path_is_followed_and_costs_hold_a_joint(tmp_path: Path, capsys: Capture) -> None:
    file = path_file(tmp_path)
    free = answered(capsys, "ik", file, "--follow")
    stiff = answered(capsys, "ik", file, "--follow", "--cost", "velocity:elbow_flexion=1e4")
    assert free["path"]["ok"] and free["path"]["status"] == "followed without a jump"
    arm = load_arm("upper_limb")
    for found in (free, stiff):
        q = np.array([t["q"] for t in found["targets"]])
        T = forward_kinematics(arm.chain, q, arm.tip("hand"))
        wanted = np.loadtxt(file, delimiter=",", skiprows=1)
        np.testing.assert_allclose(T[:, :3, 3], wanted[:, 1:], atol=1e-5)
        np.testing.assert_allclose([t["time"] for t in found["targets"]], wanted[:, 0])
        found["span"] = np.ptp(q[:, 5])
    assert stiff["span"] < 0.2 * free["span"]
    assert stiff["path"]["velocity"] == [1.0] * 5 + [1e4] + [1.0] * 3
    assert stiff["path"]["rest"] == [None] * 9


def test_a_rest_posture_draws_a_joint(tmp_path: Path, capsys: Capture) -> None:
    words = ("ik", path_file(tmp_path), "--follow", "--cost", "displacement=1", "--cost")
    words = (*words, "velocity=1e-6")
    ends = []
    for angle in (-20, 20):
        found = answered(capsys, *words, "--rest", f"wrist_flexion={angle}")
        assert found["path"]["rest"][7] == pytest.approx(np.radians(angle))
        ends.append(found["targets"][-1]["q"][7])
    assert ends[0] < ends[1] - 0.2


def test_a_path_out_of_reach_fails(tmp_path: Path, capsys: Capture) -> None:
    file = written(tmp_path / "p.csv", "time,x,y,z\n0,0.2,0.4,0\n1,0.2,1.4,0\n")
    found = answered(capsys, "ik", file, "--follow", code=1)
    assert [t["failed"] for t in found["targets"]] == [False, True]
    assert not found["path"]["ok"] and "not reached" in found["path"]["status"]


def test_the_published_scheme_stays_away_from_the_limits(capsys: Capture) -> None:
    """Its tangent mapping never comes to a limit; the default does, and may."""
    found = answered(capsys, "ik", TARGETS, *SPLINT, "--method", "paper", code=1)
    assert 0 < sum(t["failed"] for t in found["targets"]) < 4  # it stalls at one or another
    q = np.array([t["q"] for t in found["targets"]])
    assert (q > np.array(found["lower"])).all() and (q < np.array(found["upper"])).all()
    assert found["provenance"]["choices"]["method"] == "paper"
    assert all(t["restarts"] == 0 for t in found["targets"])


def test_restarts_are_counted(tmp_path: Path, capsys: Capture) -> None:
    file = written(tmp_path / "t.csv", "x,y,z\n3,0,0\n")
    for n in (0, 3):
        found = answered(capsys, "ik", file, "--restarts", n, code=1)
        count = found["targets"][0]["restarts"]
        # A target that was missed is looked for again at the ends of the ranges.
        assert count >= n and (count == 0) == (n == 0)


def test_reports_are_written(tmp_path: Path, capsys: Capture) -> None:
    page = tmp_path / "r.html"
    answered(capsys, "ik", TARGETS, *SPLINT, "--report", page)
    text = page.read_text(encoding="utf-8")
    assert "4 of 4 targets are reached" in text and "elbow flexion" in text
    answered(capsys, "ik", path_file(tmp_path), "--follow", "--report", page)
    assert "followed without a jump" in page.read_text(encoding="utf-8")
    far = written(tmp_path / "t.csv", "x,y,z\n3,0,0\nnan,0,0\n")
    answered(capsys, "ik", far, "--report", page, code=1)
    assert "2 targets are not reached" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x,y,z\n0.1,0.4,0\n", "no column time"),
        ("time,x,y,z\n0,0.1,0.4,0\n0,0.1,0.4,0\n", "row 3, column time: '0' must be above"),
        ("time,x,y,z\n0,0.1,0.4,0\n,0.1,0.4,0\n", "row 3, column time: '' must be above"),
        ("time,x,y,z\n0,0.1,0.4,0\n1,,0.4,0\n", "row 3, column x: '' is no finite number; a path"),
    ],
)
def test_bad_paths_are_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    file = written(tmp_path / "p.csv", text)
    assert reason in refused(capsys, "ik", file, "--follow")


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--restarts", "-1"), "--restarts -1: allowed is 0 to 40"),
        (("--restarts", "5", "--method", "paper"), "--method paper starts once"),
        (("--cost", "velocity=1"), "add --follow"),
        (("--rest", "elbow_flexion=1"), "add --follow"),
        (("--follow", "--method", "paper"), "--follow takes each posture from the one before"),
        (("--follow", "--cost", "speed=1"), "unknown kind in --cost 'speed=1'"),
        (("--follow", "--cost", "velocity=-1"), "--cost 'velocity=-1': write kind=weight"),
        (("--follow", "--cost", "velocity=nan"), "--cost 'velocity=nan': write kind=weight"),
        (("--follow", "--cost", "velocity"), "--cost 'velocity': write kind=weight"),
        (("--follow", "--cost", "velocity=0"), "scapula_protraction costs nothing"),
        (("--follow", "--cost", "velocity:elbow=1"), "unknown joint in --cost"),
        (("--follow", "--rest", "elbow_flexion=500"), "--rest 'elbow_flexion=500': write"),
        (("--follow", "--rest", "elbow=5"), "unknown joint in --rest"),
    ],
)
def test_bad_path_options_are_one_line(
    capsys: Capture, options: tuple[str, ...], reason: str
) -> None:
    assert reason in refused(capsys, "ik", TARGETS, *options)
