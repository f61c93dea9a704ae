from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.redundancy.task import Pointing
from tests.cli.running import Capture, answered, refused, written

CENTER_OUT = ("plan", "--arm", "wrist", "--center-out")
LAW = "stiffness = [2.0, 1.0, 1.0]\nrest_deg = [30, 40, 20]\n"
TARGETS = "target,direction,x,y\nA,outbound,0.3,0.4\nB,inbound,0.35,0.3\n"


def test_center_out_is_what_the_paper_shows(capsys: Capture) -> None:
    """Fig. 3: diagonals curve, both ways to the same side; the hand arrives with k = 22.5."""
    found = answered(capsys, *CENTER_OUT, "--spring", "22.5")
    names = [(m["target"], m["direction"]) for m in found["movements"]]
    assert names[:2] == [("E", "outbound"), ("NE", "outbound")]
    assert names[8:10] == [("E", "inbound"), ("NE", "inbound")]
    assert all(m["end_error"] < 1e-5 for m in found["movements"])
    net = {name: m["a_net"] for name, m in zip(names, found["movements"], strict=True)}
    for diagonal in ("NE", "SE", "SW", "NW"):
        assert abs(net[diagonal, "outbound"]) > 4 * abs(net["E", "outbound"])
        assert net[diagonal, "outbound"] * net[diagonal, "inbound"] > 0
    for name, total in found["hysteresis"].items():
        assert total == pytest.approx(net[name, "outbound"] + net[name, "inbound"])
    for m in found["movements"]:
        assert m["a_net"] == pytest.approx(m["a_right"] - m["a_left"])


def test_x_is_where_q_points(capsys: Capture) -> None:
    found = answered(capsys, *CENTER_OUT, "--steps", "10")
    assert found["joints"] == list(load_arm("wrist").joints)
    for m in found["movements"][:3]:
        np.testing.assert_allclose(Pointing(load_arm("wrist")).value(m["q"]), m["x"], atol=1e-12)
        assert m["time"] == pytest.approx(np.linspace(0, 0.4, 11).tolist())


def test_movements_through_the_targets_of_a_file(tmp_path: Path, capsys: Capture) -> None:
    law = written(tmp_path / "law.toml", LAW)
    targets = written(tmp_path / "t.csv", TARGETS)
    words = ("plan", "--arm", "planar", "--task", "planar", "--law", law, "--targets", targets)
    found = answered(capsys, *words, "--duration", "2", "--out", tmp_path / "out")
    first, second = found["movements"]
    assert (first["target"], first["direction"]) == ("A", "outbound")
    np.testing.assert_allclose(first["q"][0], np.radians([30, 40, 20]), atol=1e-12)
    np.testing.assert_allclose(second["q"][0], first["q"][-1], atol=1e-12)
    assert first["end_error"] < 1e-3
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"plan.json", "plan.csv"}


def test_locked_joints_stay_and_the_start_is_typed_in_degrees(capsys: Capture) -> None:
    found = answered(capsys, *CENTER_OUT, "--lock", "pronation", "--start", "10,0,0")
    q = np.array([m["q"] for m in found["movements"]])
    np.testing.assert_allclose(q[:, :, 0], np.radians(10), atol=1e-12)


def test_a_target_out_of_reach_says_so(tmp_path: Path, capsys: Capture) -> None:
    targets = written(tmp_path / "t.csv", "x,y\n0.2,0.1\n1.5,0\n")
    found = answered(capsys, "plan", "--arm", "wrist", "--targets", targets, code=1)
    assert [m["failed"] for m in found["movements"]] == [False, True]
    assert "out of reach" in found["movements"][1]["status"]


def test_a_report_is_written(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "plan.html"
    answered(capsys, *CENTER_OUT, "--report", file)
    text = file.read_text(encoding="utf-8")
    assert "Planned movements" in text
    assert "<svg" in text


@pytest.mark.parametrize(
    ("law", "reason"),
    [
        ("stiffness = [1, 2\nrest = [0, 0, 0]\n", "line 2"),
        ("rest = [0, 0, 0]\n", "needs stiffness"),
        ("stiffness = [1, 1, -1]\nrest = [0, 0, 0]\n", "positive definite"),
        ("stiffness = [1, 1, 1]\nrest = [0, nan, 0]\n", "rest"),
        ("stiffness = [1, 1]\nrest = [0, 0]\n", "rest has 2 joints, wrist has 3"),
        ("stiffness = [1, 1, 1]\nrest = [0, 0, 0]\ndamping_time = 0\n", "damping_time = 0"),
        ("stiffness = [1, 1, 1]\nrest = [0, 0, 0]\nspring = 2\n", "unknown field 'spring'"),
    ],
)
def test_a_bad_law_is_one_line(tmp_path: Path, capsys: Capture, law: str, reason: str) -> None:
    file = written(tmp_path / "law.toml", law)
    line = refused(capsys, *CENTER_OUT, "--law", file)
    assert reason in line
    assert str(file) in line


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x,y\n0.1,nan\n0.1,0.1\n", "row 2, column y: 'nan' is no finite number"),
        ("x,z\n0.1,0\n", "no column y"),
        ("target,x,y\nA,0.1,near\n", "row 2, column y: 'near' is no number"),
    ],
)
def test_bad_targets_are_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    file = written(tmp_path / "t.csv", text)
    line = refused(capsys, "plan", "--arm", "wrist", "--targets", file)
    assert reason in line
    assert str(file) in line


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("plan",), "give either --targets FILE or --center-out"),
        ((*CENTER_OUT, "--spring", "stiff"), "--spring 'stiff': allowed are from-damping"),
        ((*CENTER_OUT, "--spring", "-1"), "--spring '-1': allowed are from-damping or a number"),
        ((*CENTER_OUT, "--duration", "0"), "duration = 0 s: must be above 0"),
        ((*CENTER_OUT, "--lock", "elbow"), "elbow"),
        ((*CENTER_OUT, "--start", "1,2"), "--start '1,2': allowed are 3 angles in degrees"),
        ((*CENTER_OUT, "--weights", "1,0,1"), "weight"),
        (("plan", "--arm", "planar", "--center-out"), "--law: planar needs a FILE.toml"),
    ],
)
def test_bad_options_are_one_line(capsys: Capture, words: tuple[str, ...], reason: str) -> None:
    assert reason in refused(capsys, *words)
