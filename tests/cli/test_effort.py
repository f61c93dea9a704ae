from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.muscles.static_optimization import muscle_effort
from tests.cli.golden import ROOT
from tests.cli.running import Capture, answered, refused, written

POSTURES = ROOT / "examples" / "postures.csv"
NAMES = POSTURES.read_text(encoding="utf-8").splitlines()[0]


def test_activations_give_the_torque_and_their_squares_the_effort(capsys: Capture) -> None:
    found = answered(capsys, "effort", POSTURES)["postures"]
    model = load_musculoskeletal_arm()
    q = np.loadtxt(POSTURES, delimiter=",", skiprows=1)[:, 1:]
    lengths, arms = model.geometry.lengths_and_moment_arms(q)
    force = model.forces.full_activation(lengths)
    for k, posture in enumerate(found):
        a = np.array(list(posture["activations"].values()))
        torque = (arms[k] * (force[k] * a)[:, None]).sum(axis=0)
        np.testing.assert_allclose(torque, list(posture["torque"].values()), atol=1e-5)
        assert posture["effort"] == pytest.approx((a**2).sum(), rel=1e-12)
        assert posture["status"] == "held"


def test_a_report_draws_the_arm_and_the_hardest_muscles(tmp_path: Path, capsys: Capture) -> None:
    page = tmp_path / "report.html"
    found = answered(capsys, "effort", POSTURES, "--report", page)["postures"]
    text = page.read_text(encoding="utf-8")
    assert text.count("<svg") == 2 * len(found)
    for posture in found:
        assert f"Posture {posture['id']}" in text
        hardest = max(posture["activations"], key=posture["activations"].get)
        assert f"{hardest} {posture['activations'][hardest]:.2f}" in text
    for words in ("Effort (sum of", "activation (no unit)", "coloured by activation"):
        assert words in text


def test_degrees_are_read_where_the_names_say_so(tmp_path: Path, capsys: Capture) -> None:
    q = np.degrees(np.loadtxt(POSTURES, delimiter=",", skiprows=1)[0, 1:])
    header = ",".join(f"{name}_deg" for name in NAMES.split(",")[1:])
    row = ",".join(repr(float(v)) for v in q)
    file = written(tmp_path / "q.csv", f"{header}\n{row}\n")
    found = answered(capsys, "effort", file)["postures"][0]
    wanted = answered(capsys, "effort", POSTURES)["postures"][0]
    assert found["effort"] == pytest.approx(wanted["effort"], rel=1e-9)


def test_a_posture_that_nothing_holds_says_what_is_missing(tmp_path: Path, capsys: Capture) -> None:
    text = POSTURES.read_text(encoding="utf-8")
    file = written(tmp_path / "q.csv", text)
    found = answered(capsys, "effort", file, "--hand-load", 100, code=1)["postures"][0]
    assert "no activation holds the posture" in found["status"]
    assert found["failed"]
    assert max(map(abs, found["missing"].values())) > 1.0


def test_a_posture_outside_the_joint_limits_says_so(tmp_path: Path, capsys: Capture) -> None:
    file = written(tmp_path / "q.csv", f"{NAMES}\n1,0.6,0.9,-0.3,-0.2,0.2,0,0.1\n")
    found = answered(capsys, "effort", file)["postures"][0]
    assert found["status"] == "held; outside the joint limits: elbow_flexion by 11.5 deg"
    assert found["effort"] is not None and not found["failed"]


def test_columns_of_velocity_make_it_a_movement(tmp_path: Path, capsys: Capture) -> None:
    q = np.loadtxt(POSTURES, delimiter=",", skiprows=1)[0, 1:]
    names = NAMES.split(",")[1:]
    header = ",".join([*names, *(f"{n}_velocity" for n in names)])
    speed = np.full(7, 0.5)
    row = ",".join(repr(float(v)) for v in (*q, *speed))
    found = answered(capsys, "effort", written(tmp_path / "q.csv", f"{header}\n{row}\n"))
    wanted = muscle_effort(load_musculoskeletal_arm(), [q], velocity=[speed]).effort[0]
    assert found["postures"][0]["effort"] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(
    ("header", "row", "reason"),
    [
        (NAMES, "1,0,nan,0,0,0,0,0", "row 2, column shoulder_elv: 'nan' is no finite number"),
        (NAMES.replace(",flexion", ""), "1,0,0,0,0,0,0", "no column flexion"),
        (NAMES + ",elbow_flex", "1,0,0,0,0,0,0,0,0", "'elbow_flex'; did you mean 'elbow_flexion'?"),
        (NAMES, "1,0,45,0,0,0,0,0", "column shoulder_elv: '45' is beyond 2 pi rad"),
        (NAMES + ",flexion_velocity", "1,0,0,0,0,0,0,0,0", "no column elv_angle_velocity"),
    ],
)
def test_bad_files_are_one_line(
    tmp_path: Path, capsys: Capture, header: str, row: str, reason: str
) -> None:
    file = written(tmp_path / "q.csv", f"{header}\n{row}\n")
    line = refused(capsys, "effort", file)
    assert reason in line
    assert str(file) in line


def test_a_bad_exponent_is_refused(capsys: Capture) -> None:
    assert "exponent = 1: allowed is 2 to 10" in refused(
        capsys, "effort", POSTURES, "--exponent", 1
    )
