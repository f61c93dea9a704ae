"""`selfmotion segment`, on generated markers and on joint angles."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.cli.running import Capture, answered, refused

ROOT = Path(__file__).parents[2]
DRINK = ROOT / "examples/markers_drink.csv"


def test_there_and_back_are_two_strokes(tmp_path: Path, capsys: Capture):
    document = answered(capsys, "segment", DRINK, "--marker", "RFB", "--out", tmp_path)
    (movement,) = document["movements"]
    assert len(movement["strokes"]) == 2
    out, back = movement["strokes"]
    # It goes at 0.3 s and comes back from 1.2 s on, each for 0.8 s and the joints' lags.
    assert 0.3 <= out["onset_s"] < 0.7 and 1.2 <= back["onset_s"] < 1.6
    assert out["length_m"] == pytest.approx(back["length_m"], rel=0.25)
    assert len((tmp_path / "strokes.csv").read_text().splitlines()) == 3


def test_a_broken_file_has_a_status_and_the_rest_goes_on(tmp_path: Path, capsys: Capture):
    bad = tmp_path / "bad.csv"
    bad.write_text("Trajectories\n100\n")
    words = ("segment", bad, DRINK, "--marker", "RFB")
    movements = answered(capsys, *words, code=1)["movements"]
    assert [m["failed"] for m in movements] == [True, False] and "bad.csv" in movements[0]["status"]


def test_a_folder_stands_for_its_marker_files(tmp_path: Path, capsys: Capture):
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_bytes(DRINK.read_bytes())
    (tmp_path / "notes.md").write_text("no recording")
    found = answered(capsys, "segment", tmp_path, "--marker", "RFB")["movements"]
    assert [Path(m["name"]).name for m in found] == ["a.csv", "b.csv"]
    assert "--marker NAME" in refused(capsys, "segment", DRINK)


def test_wrong_shares_are_refused(capsys: Capture):
    assert "share = 2" in refused(capsys, "segment", DRINK, "--marker", "RFB", "--share", "2")


def test_movement_and_strokes_come_over_0_to_100_percent(tmp_path: Path, capsys: Capture):
    words = ("segment", DRINK, "--marker", "RFB", "--out", tmp_path)
    (movement,) = answered(capsys, *words, "--points", "51")["movements"]
    table = pd.read_csv(tmp_path / "normalised.csv")
    assert list(dict.fromkeys(table["part"])) == ["movement", "stroke 1", "stroke 2"]
    for _, part in table.groupby("part"):
        assert part["percent"].tolist() == np.linspace(0.0, 100.0, 51).tolist()
    whole = table.loc[table["part"] == "movement"]
    assert whole["time"].iloc[0] == pytest.approx(movement["onset_s"])
    assert whole["time"].iloc[-1] == pytest.approx(movement["offset_s"])
    # The hand comes back to where it began, and is fastest in the strokes.
    places = whole[["RFB_x_m", "RFB_y_m", "RFB_z_m"]].to_numpy(float)
    assert np.linalg.norm(places[-1] - places[0]) < 0.05
    assert whole["speed_m_s"].max() == pytest.approx(
        max(s["peak_speed"] for s in movement["strokes"]), rel=0.05
    )
    answered(capsys, *words, "--points", "51", "--format", "parquet")
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "normalised.parquet"), table)


def test_joint_angles_come_over_0_to_100_percent_too(tmp_path: Path, capsys: Capture):
    answered(
        capsys, "segment", ROOT / "examples/reach.csv", "--arm", "exoskeleton", "--out", tmp_path
    )
    table = pd.read_csv(tmp_path / "normalised.csv")
    assert {"elbow_flexion_rad", "hand_x"} <= set(table.columns)


def test_too_few_points_are_refused(capsys: Capture):
    assert "--points 1" in refused(capsys, "segment", DRINK, "--marker", "RFB", "--points", "1")
