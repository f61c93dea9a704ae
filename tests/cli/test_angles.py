"""`selfmotion angles`: markers in, angles in files out."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.motion.files import load
from tests.cli.running import Capture, answered, refused

ROOT = Path(__file__).parents[2]
STATIC, DRINK = ROOT / "examples/markers_static.csv", ROOT / "examples/markers_drink.csv"


@pytest.mark.parametrize("kind", ["mot", "csv"])
def test_angles_are_written_and_read_back(tmp_path: Path, capsys: Capture, kind: str):
    words = ("angles", DRINK, "--static", STATIC, "--out", tmp_path, "--format", kind)
    document = answered(capsys, *words)
    (movement,) = document["movements"]
    assert 0 < document["rms_marker_error_mm"] < 15 and movement["frames_not_converged"] == 0
    assert document["lengths_mm"]["upper_arm"] == pytest.approx(290, abs=5)
    back = load(movement["written"])[0]
    assert back.joints == tuple(document["joints"]) and back.n_samples == movement["frames"]
    elbow = np.rad2deg(back.array("q")[:, back.joints.index("elbow_flexion")])
    # The example drinks: from 85 to 130 degrees and back.
    assert elbow.max() == pytest.approx(130, abs=3) and elbow[[0, -1]] == pytest.approx(85, abs=3)


def test_the_7_dof_arm_takes_the_same_markers(capsys: Capture):
    document = answered(capsys, "angles", DRINK, "--static", STATIC, "--arm", "srs7")
    assert len(document["joints"]) == 7 and document["rms_marker_error_mm"] < 15


def test_refusals_name_what_is_missing(tmp_path: Path, capsys: Capture):
    assert "RGTH" in refused(capsys, "angles", DRINK, "--static", DRINK)
    assert "no such file" in refused(capsys, "angles", tmp_path / "x.csv", "--static", STATIC)
    assert "reaching" in refused(
        capsys, "angles", DRINK, "--static", STATIC, "--protocol", "unknown"
    )
    angles = tmp_path / "angles.csv"
    angles.write_text("time,elbow\n0,1\n1,1\n")
    assert "no marker" in refused(capsys, "angles", angles, "--static", STATIC)
