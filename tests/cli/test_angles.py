"""`selfmotion angles`: markers in, angles in files out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from selfmotion.capture.moving_side import doubt_about_side
from selfmotion.capture.protocol import REACHING
from selfmotion.capture.simulated_markers import simulate_markers
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


def test_angles_of_the_arm_that_rests_are_doubted():
    seen = simulate_markers(rng=np.random.default_rng(1)).movements[0]
    assert doubt_about_side(seen, REACHING, "right") == ""
    # The other hand carries markers, too, and moves; or the one that is asked for rests.
    swapped = {n: f"{'L' if n[0] == 'R' else 'R'}{n[1:]}" for n in seen.names if n[1:4] == "HAN"}
    both = replace(
        seen,
        names=(*seen.names, *(swapped[n] for n in swapped)),
        positions=np.concatenate(
            [
                seen.positions,
                np.stack([seen.point(n)[[0]].repeat(seen.n_samples, 0) for n in swapped], 1),
            ],
            1,
        ),
    )
    assert doubt_about_side(both, REACHING, "right") == ""
    doubt = doubt_about_side(both, REACHING, "left")
    assert "the left one by 0 mm" in doubt and "--side right?" in doubt


def test_one_broken_file_leaves_the_others_be(tmp_path: Path, capsys: Capture):
    cut = tmp_path / "cut.csv"
    cut.write_bytes(DRINK.read_bytes()[:5000])
    words = ("angles", cut, DRINK, tmp_path / "none.csv", "--static", STATIC)
    document = answered(capsys, *words, "--out", tmp_path / "out", code=1)
    assert [one["file"] for one in document["failed"]] == [str(cut), str(tmp_path / "none.csv")]
    assert all(one["status"] for one in document["failed"])
    (movement,) = document["movements"]
    alone = answered(capsys, "angles", DRINK, "--static", STATIC)
    assert movement["rms_marker_error_mm"] == alone["movements"][0]["rms_marker_error_mm"]
    assert Path(movement["written"]).exists()
    assert "cut.csv" in refused(capsys, "angles", cut, cut, "--static", STATIC)


def test_refusals_name_what_is_missing(tmp_path: Path, capsys: Capture):
    assert "RGTH" in refused(capsys, "angles", DRINK, "--static", DRINK)
    assert "no such file" in refused(capsys, "angles", tmp_path / "x.csv", "--static", STATIC)
    assert "reaching" in refused(
        capsys, "angles", DRINK, "--static", STATIC, "--protocol", "unknown"
    )
    angles = tmp_path / "angles.csv"
    angles.write_text("time,elbow\n0,1\n1,1\n")
    assert "no marker" in refused(capsys, "angles", angles, "--static", STATIC)


def test_isb_angles_come_with_their_distance_from_gimbal_lock(tmp_path: Path, capsys: Capture):
    words = ("angles", DRINK, "--static", STATIC, "--isb", "--out", tmp_path)
    (movement,) = answered(capsys, *words)["movements"]
    isb = movement["isb"]
    with open(isb["written"], encoding="utf-8") as stream:
        names = stream.readline().strip().split(",")
    table = np.genfromtxt(isb["written"], delimiter=",", skip_header=1)
    column = dict(zip(names, table.T, strict=True))
    assert len(table) == movement["frames"] and column["time"][0] == 0.0
    # The example drinks with the elbow going from 85 to 130 degrees; 0 is straight in both.
    assert isb["largest_deg"]["elbow_flexion_deg"] == pytest.approx(130, abs=8)
    elevation = column["elevation_deg"]
    lock = np.minimum(elevation, 180 - elevation)
    np.testing.assert_allclose(column["shoulder_lock_deg"], lock, atol=1e-9)
    assert isb["shoulder_lock_deg"] == pytest.approx(np.nanmin(lock))
    carrying = 90 - np.abs(column["carrying_angle_deg"])
    assert isb["elbow_lock_deg"] == pytest.approx(np.nanmin(carrying))
    near = (lock < 10) | (carrying < 10)
    assert isb["share_near_lock"] == pytest.approx(near.mean())
    assert answered(capsys, *words[:4])["movements"][0]["isb"] is None
