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


def test_a_target_out_of_this_world_is_one_line(tmp_path: Path, capsys: Capture) -> None:
    targets = written(tmp_path / "t.csv", "x,y\n1e300,0\n")
    assert "1e+300: allowed is up to" in refused(capsys, "plan", "--targets", targets)


def test_a_target_at_the_edge_of_the_reach_is_planned(tmp_path: Path, capsys: Capture) -> None:
    """There the Jacobian loses rank, and so did the search for the nearest place."""
    targets = written(tmp_path / "t.csv", "x,y\n1,0\n")
    (there,) = answered(capsys, "plan", "--targets", targets)["movements"]
    assert there["status"] == "done"
    assert 0.0 < there["end_error"] < 1.0


def test_an_integration_that_stops_says_what_to_look_at(tmp_path: Path, capsys: Capture) -> None:
    targets = written(tmp_path / "t.csv", "x,y\n0.1,0.1\n")
    words = ("plan", "--targets", targets, "--spring", "1e300")
    (there,) = answered(capsys, *words, code=1)["movements"]
    assert "too soft beside the others, or the spring too stiff" in there["status"]


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
        ("stiffness = [1, 1, 1]\nrest = [30, 0, 0]\n", "rest[0] = 30 rad: allowed is up to one"),
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
        ((*CENTER_OUT, "--start", "1,2"), "--start '1,2': allowed are 3 angles from -360"),
        ((*CENTER_OUT, "--start", "1e9,0,0"), "angles from -360 to 360 degrees"),
        ((*CENTER_OUT, "--steps", "100000000"), "n_steps = 100000000: allowed are 1 to"),
        ((*CENTER_OUT, "--weights", "1,0,1"), "weight"),
        (("plan", "--arm", "planar", "--center-out"), "--law: planar needs a FILE.toml"),
    ],
)
def test_bad_options_are_one_line(capsys: Capture, words: tuple[str, ...], reason: str) -> None:
    assert reason in refused(capsys, *words)


def test_a_recorded_path_is_imitated(tmp_path: Path, capsys: Capture) -> None:
    u = np.linspace(0.0, 1.0, 101)
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    bow = 0.05 * np.sin(np.pi * s)
    rows = [f"{9 * t:.6f},{0.2 * a:.9f},{b:.9f}" for t, a, b in zip(u, s, bow, strict=True)]
    path = written(tmp_path / "path.csv", "\n".join(["time,x,y", *rows]))
    targets = written(tmp_path / "t.csv", "x,y\n0.2,0.0\n")
    words = ("plan", "--targets", targets, "--path", path)
    (there,) = answered(capsys, *words)["movements"]
    x = np.array(there["x"])
    assert x[:, 1].max() == pytest.approx(0.05, abs=0.003)
    assert np.abs(x[-1] - [0.2, 0.0]).max() < 0.003
    assert "give one of them" in refused(capsys, *words, "--planner", "spring")
    bad = written(tmp_path / "bad.csv", "\n".join(["time,x,y", *rows[:50], *rows[40:]]))
    line = refused(capsys, "plan", "--targets", targets, "--path", bad)
    assert "bad.csv" in line and "increase" in line
    none = written(tmp_path / "none.csv", "\n".join(["x,y", *(r.partition(",")[2] for r in rows)]))
    assert "no column time" in refused(capsys, "plan", "--targets", targets, "--path", none)


def test_potentials_change_the_posture_and_not_the_task(tmp_path: Path, capsys: Capture) -> None:
    """λ0 keeps every potential out of the task (eq. 5); the posture follows it."""
    targets = written(tmp_path / "t.csv", "x,y\n0.18,0.18\n")
    words = ("plan", "--targets", targets, "--steps", "10", "--spring", "22.5", "--duration", "0.8")
    (plain,) = answered(capsys, *words)["movements"]
    (pulled,) = answered(capsys, *words, "--potential", "limits=20:30")["movements"]
    np.testing.assert_allclose(plain["x"][-1], pulled["x"][-1], atol=1e-3)
    assert np.abs(np.subtract(plain["q"][-1], pulled["q"][-1])).max() > 0.005


def test_gravity_pulls_an_arm_with_masses(tmp_path: Path, capsys: Capture) -> None:
    law = written(tmp_path / "law.toml", "stiffness = [9, 9, 9, 9]\nrest_deg = [0, 0, 30, 80]\n")
    targets = written(tmp_path / "t.csv", "x,y,z\n0.35,0.05,-0.25\n")
    words = ("plan", "--arm", "exoskeleton", "--law", law, "--targets", targets)
    words = (*words, "--duration", "1", "--spring", "100", "--steps", "10")
    ends = [
        np.array(answered(capsys, *words, *more)["movements"][0]["q"][-1])
        for more in ((), ("--potential", "gravity=0.3"))
    ]
    assert np.abs(ends[0] - ends[1]).max() > 1e-3


def test_damping_weights_shape_the_path(capsys: Capture) -> None:
    plain = answered(capsys, *CENTER_OUT)["movements"]
    shaped = answered(capsys, *CENTER_OUT, "--damping-weights", "0.04,0.12,0.16")["movements"]
    np.testing.assert_allclose(plain[1]["q"], shaped[1]["q"], atol=1e-9)  # eq. 9 spelt out
    other = answered(capsys, *CENTER_OUT, "--damping-weights", "0.16,0.04,0.04")["movements"]
    assert np.abs(np.subtract(plain[1]["q"], other[1]["q"])).max() > 0.01


@pytest.mark.parametrize(
    "text", ["foo", "gravity=-1", "gravity=a", "limits=5", "limits=200:1", "effort", "effort=0"]
)
def test_a_bad_potential_is_one_line(capsys: Capture, text: str) -> None:
    line = refused(capsys, *CENTER_OUT, "--potential", text)
    assert "potential" in line or "margin" in line
