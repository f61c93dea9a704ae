"""Units, rate and axes typed on the command line, and folders in which a file is broken."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.motion.files.storage import write_mot
from selfmotion.motion.recording import Recording
from tests.cli.running import Capture, answered, refused, written

ROOT = Path(__file__).parents[2]
REACH = ROOT / "examples/reach.csv"
COMMANDS = ("weights", "split", "segment", "curvature")


def in_degrees_without_a_word(folder: Path) -> Path:
    """Write the example's first reach as a MOT whose header does not name the unit."""
    lines = [line.split(",") for line in REACH.read_text().splitlines()]
    first = [row for row in lines[1:] if row[:5] == lines[1][:5]]
    time = np.array([float(row[5]) for row in first])
    q = np.array([[float(cell) for cell in row[6:]] for row in first])
    path = write_mot(
        folder / "reach.mot", Recording(time, q=q, joints=tuple(lines[0][6:])), unit="deg"
    )
    return written(path, path.read_text().replace("inDegrees=yes\n", ""))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_mot_without_its_unit_names_the_option_that_states_it(
    command: str, tmp_path: Path, capsys: Capture
):
    path = in_degrees_without_a_word(tmp_path)
    words = (command, path, "--arm", "exoskeleton")
    assert "--angle-unit" in refused(capsys, *words)
    document = answered(capsys, *words, "--angle-unit", "deg")
    assert document["provenance"]["choices"]["angle_unit"] == "deg"


@pytest.mark.parametrize("command", COMMANDS)
def test_axes_that_are_not_those_of_the_arm_are_refused(command: str, capsys: Capture):
    words = (command, REACH, "--arm", "exoskeleton", "--up", "y", "--forward")
    assert "but y was stated" in refused(capsys, *words, "x")
    assert "perpendicular" in refused(capsys, *words, "-y")


def test_weights_of_a_csv_in_degrees_are_those_of_the_radians(tmp_path: Path, capsys: Capture):
    header, *rows = [line.split(",") for line in REACH.read_text().splitlines()]
    degrees = [[*r[:6], *(repr(float(np.rad2deg(float(c)))) for c in r[6:])] for r in rows]
    path = written(tmp_path / "deg.csv", "\n".join(",".join(r) for r in [header, *degrees]) + "\n")
    words = ("--arm", "exoskeleton")
    wanted = answered(capsys, "weights", REACH, *words)["contribution"]
    assert "--angle-unit" in refused(capsys, "weights", path, *words)
    found = answered(capsys, "weights", path, *words, "--angle-unit", "deg")["contribution"]
    assert [c is None for c in found] == [c is None for c in wanted] and any(wanted)
    assert [c or 0.0 for c in found] == pytest.approx([c or 0.0 for c in wanted], rel=1e-5)


@pytest.mark.parametrize("command", ["weights", "split"])
def test_a_broken_file_of_a_folder_is_in_the_document_and_the_rest_goes_on(
    command: str, tmp_path: Path, capsys: Capture
):
    written(tmp_path / "a.csv", REACH.read_text())
    bad = written(tmp_path / "b.csv", "time,elbow\n0,x\n")
    words = ("--arm", "exoskeleton")
    document = answered(capsys, command, tmp_path, *words, code=1)
    (left_out,) = document["unread"]
    assert left_out["file"] == str(bad) and "'x'" in left_out["status"]
    whole = answered(capsys, command, tmp_path / "a.csv", *words)
    assert whole["weights"] == document["weights"] and whole["unread"] == []
    assert "'x'" in refused(capsys, command, tmp_path / "a.csv", bad, *words)


def test_a_folder_of_broken_files_alone_is_refused(tmp_path: Path, capsys: Capture):
    written(tmp_path / "b.csv", "time,elbow\n0,x\n")
    assert "b.csv" in refused(capsys, "weights", tmp_path, "--arm", "exoskeleton")


def test_validate_takes_what_is_stated(tmp_path: Path, capsys: Capture):
    path = written(tmp_path / "a.csv", "elbow,hand_x\n90,250\n95,260\n")
    assert "--rate" in answered(capsys, "validate", path, code=1)["files"][0]["status"]
    words = ("--rate", 50, "--angle-unit", "deg", "--length-unit", "mm", "--up", "y")
    (entry,) = answered(capsys, "validate", path, *words)["files"]
    assert entry["content"]["units"]["angles"] == "deg (stated)"
    assert entry["content"]["units"]["lengths"] == "mm (stated)"
    assert entry["content"]["rate_hz"] == 50.0 and entry["content"]["frame"]["up"] == "y"


def test_angles_takes_units_and_axes(tmp_path: Path, capsys: Capture):
    static, drink = (ROOT / f"examples/markers_{name}.csv" for name in ("static", "drink"))
    words = ("angles", drink, "--static", static)
    assert "says 'mm', but 'm' was stated" in refused(capsys, *words, "--length-unit", "m")
    assert "perpendicular" in refused(capsys, *words, "--up", "y")
    assert answered(capsys, *words, "--up", "z", "--forward", "y")["movements"]


def test_options_of_the_contract_that_change_nothing_are_accepted(capsys: Capture):
    words = ("split", REACH, "--arm", "exoskeleton")
    plain = answered(capsys, *words)
    assert answered(capsys, *words, "--jobs", 2, "--resume", "--seed", 3, "--quiet") == plain
