"""The default arm with muscles at a person's size, as `posture` and `effort` take it."""

from pathlib import Path

import pytest

from selfmotion.arms.person_with_muscles import PersonSize, myoarm_of_person
from selfmotion.muscles.static_optimization import muscle_effort
from tests.cli.golden import ROOT
from tests.cli.running import Capture, answered, refused, written

POSES = ROOT / "examples" / "poses.csv"
HEADER = "elv_angle,shoulder_elv,shoulder_rot,elbow_flexion,pro_sup,deviation,flexion\n"
ONE = HEADER + "0.6,0.9,-0.3,1.4,0.2,0,0.1\n"


def test_typed_lengths_and_a_subject_file_give_the_same_person(
    tmp_path: Path, capsys: Capture
) -> None:
    postures = written(tmp_path / "q.csv", ONE)
    subject = written(
        tmp_path / "me.toml", "[lengths_mm]\nupper_arm = 310\nforearm = 240\npalm = 74\n"
    )
    typed = answered(capsys, "effort", postures, "--lengths", "upper_arm=0.31, forearm=0.24")
    read = answered(capsys, "effort", postures, "--lengths", subject)
    assert typed["postures"] == read["postures"]
    assert "upper_arm 1.066" in typed["provenance"]["choices"]["source"]
    model = myoarm_of_person(PersonSize({"upper_arm": 0.31, "forearm": 0.24}))
    expected = muscle_effort(model, [0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1]).effort[0]
    assert typed["postures"][0]["effort"] == pytest.approx(expected, rel=1e-9)
    heavy = answered(capsys, "effort", postures, "--mass", "90")["postures"][0]
    lighter = answered(capsys, "effort", postures, "--mass", "45")["postures"][0]
    for name, torque in heavy["torque"].items():  # torque is that of gravity alone
        assert torque == pytest.approx(2.0 * lighter["torque"][name], rel=1e-9)
    constant = answered(
        capsys, "effort", postures, "--lengths", "upper_arm=0.31", "--strength", "constant"
    )
    assert constant["postures"][0]["effort"] != pytest.approx(expected, rel=1e-3)


def test_the_natural_posture_is_that_of_the_person(tmp_path: Path, capsys: Capture) -> None:
    lines = POSES.read_text(encoding="utf-8").splitlines()
    file = written(tmp_path / "p.csv", "\n".join([lines[0], lines[3]]) + "\n")
    generic = answered(capsys, "posture", file)["poses"][0]
    own = answered(capsys, "posture", file, "--lengths", "upper_arm=0.27,forearm=0.29")["poses"][0]
    assert own["q"]["elbow_flexion"] != pytest.approx(generic["q"]["elbow_flexion"], abs=0.01)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("upper_arm", "--lengths 'upper_arm': write segment=metres"),
        ("upper_arm=long", "--lengths 'upper_arm=long': write segment=metres"),
        ("upper_arm=nan", "--lengths 'upper_arm=nan': write segment=metres"),
        ("thigh=0.4", "unknown segment 'thigh'"),
        ("hand=0.08,hand=0.09", "--lengths: hand stands twice"),
        ("upper_arm=310", "length of upper_arm (m) = 310"),
        ("nowhere.toml", "nowhere.toml"),
    ],
)
def test_bad_lengths_are_one_line(capsys: Capture, text: str, reason: str) -> None:
    assert reason in refused(capsys, "posture", POSES, "--lengths", text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("lengths_mm = 3", "a table lengths_mm with clavicle, upper_arm"),
        ("[lengths_mm]\nupper_arm = true", "lengths_mm.upper_arm = True: a number is expected"),
        ("[lengths_mm]\nhand = 80\nfoot = 20", "unknown segment 'foot'"),
        ("[lengths_mm", "no TOML"),
    ],
)
def test_bad_subject_files_are_one_line(
    tmp_path: Path, capsys: Capture, text: str, reason: str
) -> None:
    file = written(tmp_path / "me.toml", text)
    line = refused(capsys, "posture", POSES, "--lengths", file)
    assert reason in line and str(file) in line


def test_other_models_are_not_scaled(tmp_path: Path, capsys: Capture) -> None:
    line = refused(capsys, "posture", POSES, "--model", "a.osim", "--lengths", "hand=0.08")
    assert "--lengths: myoarm alone is scaled here, not a.osim" in line
    line = refused(capsys, "effort", POSES, "--model", "a.osim", "--mass", "70")
    assert "--mass: myoarm alone is scaled here, not a.osim" in line
    assert "body mass (kg) = 0: allowed is 2 to 400" in refused(
        capsys, "posture", POSES, "--mass", "0"
    )
