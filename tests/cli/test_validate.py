import json
from pathlib import Path

import numpy as np
import pytest

from selfmotion.cli.app import main
from selfmotion.motion import Labels, Recording
from selfmotion.motion.files.describe import describe, gap_lengths
from selfmotion.motion.files.npz import write_npz
from selfmotion.motion.files.trc import write_trc
from selfmotion.motion.markers import MarkerSet
from tests.cli.golden import ROOT
from tests.cli.running import answered

Capture = pytest.CaptureFixture[str]


def markers(folder: Path) -> Path:
    positions = np.ones((10, 2, 3))
    positions[3:5, 0] = np.nan
    positions[8, 0] = np.nan
    names = ("STRN", "RSHO")
    return write_trc(folder / "reach.trc", MarkerSet(np.arange(10) / 50, names, positions))


def test_markers_with_units_frame_and_gaps(tmp_path: Path, capsys: Capture) -> None:
    path = markers(tmp_path)
    assert main(["validate", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (entry,) = document["files"]
    found = entry["content"]
    assert (entry["status"], found["holds"], found["samples"]) == ("ok", "markers", 10)
    assert found["units"] == {"lengths": "mm", "time": "s"}
    assert found["frame"] == {"up": None, "forward": None}
    assert found["gaps"] == [{"name": "STRN", "missing": 3, "longest": 2}]
    assert found["rate_hz"] == pytest.approx(50.0)
    assert list(document["provenance"]["inputs"]) == [str(path)]


def test_text_for_a_person(tmp_path: Path, capsys: Capture) -> None:
    assert main(["validate", str(markers(tmp_path))]) == 0
    out = capsys.readouterr().out
    assert "TRC: markers; 10 samples, 0.180 s, 50 Hz" in out
    assert "units: lengths mm, time s; frame: up not told, forward not told" in out
    assert "gaps: 1 of 2 have some; most STRN: 3 samples, the longest gap 2" in out


def test_a_refused_file_has_its_reason_and_the_rest_goes_on(
    tmp_path: Path, capsys: Capture
) -> None:
    (tmp_path / "a.trc").write_text("nonsense")
    markers(tmp_path)
    (tmp_path / "z.osim").write_text("<OpenSimDocument/>")
    assert main(["validate", str(tmp_path), "--json"]) == 1
    entries = json.loads(capsys.readouterr().out)["files"]
    assert [Path(e["file"]).name for e in entries] == ["a.trc", "reach.trc", "z.osim"]
    assert [e["status"] == "ok" for e in entries] == [False, True, False]
    assert entries[0]["content"] is None and "no TRC file" not in entries[1]["status"]
    assert entries[2]["status"] == "a model, no recording: `selfmotion arms` describes it"
    assert main(["validate", str(tmp_path / "a.trc")]) == 1
    assert "REFUSED" in capsys.readouterr().out


def test_folders_are_looked_through(tmp_path: Path, capsys: Capture) -> None:
    for name in ("P1/a.osim", "P2/b.osim", ".git/c.osim"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text("")
    files = [e["file"] for e in answered(capsys, "validate", tmp_path, code=1)["files"]]
    assert files == [str(tmp_path / name) for name in ("P1/a.osim", "P2/b.osim")]


@pytest.mark.parametrize("empty", [True, False])
def test_nothing_there_is_bad_input(tmp_path: Path, capsys: Capture, empty: bool) -> None:
    assert main(["validate", str(tmp_path if empty else tmp_path / "absent.trc")]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.count("\n") == 1


def test_recordings_of_a_study(tmp_path: Path, capsys: Capture) -> None:
    recordings = [
        Recording(np.arange(4.0), q=np.zeros((4, 2)), labels=Labels(subject="P1", trial=str(i)))
        for i in range(3)
    ]
    path = write_npz(tmp_path / "x.npz", recordings)
    assert main(["validate", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["files"][0]["content"]
    assert (found["recordings"], found["samples"], found["seconds"]) == (3, 12, 9.0)
    assert [labels["trial"] for labels in found["labels"]] == ["0", "1", "2"]
    assert found["names"] == ["joint_1", "joint_2"]


@pytest.mark.parametrize(
    ("name", "content", "holds", "units"),
    [
        ("a.csv", "time,e_deg\n0,1\n1,2\n", "joint angles", {"angles": "deg", "time": "s"}),
        ("a.csv", "sample,e\n0,1\n1,2\n", "joint angles", {"angles": "rad (not named)"}),
        ("a.csv", "time,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1\n", "orientations (quaternions)", {}),
        ("a.mot", "x\ninDegrees=no\nendheader\ntime\te\n0\t1\n1\t2\n", "joint angles",
         {"angles": "rad (inDegrees=no)"}),
        ("a.sto", "Activations\nendheader\ntime\te\n0\t1\n1\t2\n", "a table: Activations", {}),
        ("a.csv", "Trajectories\n100\n,,A,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n",
         "markers", {"lengths": "mm"}),
    ],
)  # fmt: skip
def test_what_each_format_holds(
    tmp_path: Path, name: str, content: str, holds: str, units: dict[str, str]
) -> None:
    path = tmp_path / name
    path.write_text(content)
    found = describe(path)
    assert found.holds == holds
    assert units.items() <= found.units.items()


def test_gap_lengths_by_hand() -> None:
    assert gap_lengths(np.array([], dtype=bool)) == (0, 0)
    assert gap_lengths(np.array([True] * 3)) == (3, 3)
    assert gap_lengths(np.array([False, True, False, True, True])) == (3, 2)


def test_a_study_file_among_recordings_is_left_aside(capsys: Capture) -> None:
    told = answered(capsys, "validate", ROOT / "examples" / "study")
    assert {Path(f["file"]).suffix for f in told["files"]} == {".csv"}
