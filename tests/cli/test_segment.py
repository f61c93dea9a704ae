"""`selfmotion segment`, on generated markers and on joint angles."""

from pathlib import Path

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


def test_wrong_shares_are_refused(capsys: Capture):
    assert "share = 2" in refused(capsys, "segment", DRINK, "--marker", "RFB", "--share", "2")
