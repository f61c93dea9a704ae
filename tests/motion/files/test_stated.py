"""What a caller states of a file: it fills what the file does not say, and contradicts nothing."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.motion.c3d_files import written

from selfmotion.errors import SelfmotionError
from selfmotion.motion import Frame, Labels, Recording
from selfmotion.motion.files import load, load_markers
from selfmotion.motion.files.bids_writer import write_bids
from selfmotion.motion.files.npz import write_npz
from selfmotion.motion.files.storage import write_mot
from selfmotion.motion.files.trc import write_trc
from selfmotion.motion.markers import MarkerSet

VICON = "Trajectories\n100\n,,A,,\nFrame,Sub Frame,X,Y,Z\n{units}\n1,0,1000,0,250\n2,0,1,2,3\n"


def text(path: Path, content: str) -> Path:
    path.write_text(content)
    return path


def test_units_and_rate_of_a_csv_that_names_none(tmp_path: Path):
    path = text(tmp_path / "a.csv", "elbow,hand_x\n90,250\n180,500\n")
    read = load(path, unit="deg", length_unit="mm", rate=50.0, frame=Frame("y", None))[0]
    np.testing.assert_allclose(read.array("q")[:, 0], [np.pi / 2, np.pi])
    np.testing.assert_allclose(read.array("x")[:, 0], [0.25, 0.5])
    assert read.time.tolist() == [0.0, 0.02] and read.frame == Frame("y", None, "stated")


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({}, "--rate"),
        ({"rate": 50.0, "unit": "deg"}, "hand_x.*beyond 20 m.*--length-unit"),
        ({"rate": 50.0, "length_unit": "mm"}, "elbow.*beyond 2 pi.*--angle-unit"),
        ({"rate": -1.0}, "rate = -1 Hz"),
    ],
)
def test_what_a_csv_lacks_is_named_with_its_option(
    tmp_path: Path, options: dict[str, Any], line: str
):
    path = text(tmp_path / "a.csv", "hand_x,elbow\n250,90\n500,180\n")
    with pytest.raises(SelfmotionError, match=line):
        load(path, **options)


def test_columns_that_name_a_unit_keep_it(tmp_path: Path):
    path = text(tmp_path / "a.csv", "time,elbow_rad,wrist,hand_x_mm\n0,1,90,250\n1,2,45,500\n")
    read = load(path, unit="deg", length_unit="cm")[0]
    np.testing.assert_allclose(read.array("q"), [[1.0, np.pi / 2], [2.0, np.pi / 4]])
    np.testing.assert_allclose(read.array("x")[:, 0], [0.25, 0.5])


def test_a_rate_gives_an_archive_without_times_its_seconds(tmp_path: Path):
    np.savez(tmp_path / "a.npz", q=np.zeros((4, 2)))
    assert load(tmp_path / "a.npz", rate=100.0)[0].time.tolist() == [0.0, 0.01, 0.02, 0.03]
    np.savez(tmp_path / "v.npz", qd=np.ones((4, 3)), jacobian=np.ones((4, 2, 3)))
    with pytest.raises(SelfmotionError, match="velocities come without times"):
        load(tmp_path / "v.npz", rate=100.0)


def test_contradictions_are_refused(tmp_path: Path):
    time = np.arange(4) / 100
    bent = Recording(time, q=np.ones((4, 2)), x=np.zeros((4, 3)), frame=Frame("z", "y"))
    npz, mot = write_npz(tmp_path / "a.npz", [bent]), write_mot(tmp_path / "a.mot", bent)
    who = Labels(subject="1", condition="reach")
    bids = write_bids(tmp_path, Recording(time, q=np.ones((4, 1)), joints=("elbow",), labels=who))
    cases: tuple[tuple[Path, dict[str, Any], str], ...] = (
        (npz, {"unit": "deg"}, "angles are in rad, but deg was stated"),
        (npz, {"length_unit": "mm"}, "lengths are in m, but mm was stated"),
        (npz, {"rate": 50.0}, "its times have 100 Hz, but 50 Hz was stated"),
        (npz, {"frame": Frame("y", "x")}, "its up axis is z, but y was stated"),
        (mot, {"unit": "deg"}, "inDegrees=no, but 'deg' was stated"),
        (mot, {"rate": 50.0}, "100 Hz, but 50 Hz"),
        (bids, {"unit": "rad"}, "angles are in deg, but rad was stated"),
    )
    for path, options, line in cases:
        with pytest.raises(SelfmotionError, match=line):
            load(path, **options)
    assert load(npz, unit="rad", length_unit="m", rate=100.0, frame=Frame("z", "y"))[0].rate


def test_vicon_units_come_from_the_file_or_the_caller(tmp_path: Path):
    bare = text(tmp_path / "bare.csv", VICON.format(units=",,,,"))
    with pytest.raises(SelfmotionError, match="row 5: unit is empty.*--length-unit"):
        load_markers(bare)
    assert load_markers(bare, unit="mm").point("A")[0].tolist() == [1.0, 0.0, 0.25]
    named = text(tmp_path / "named.csv", VICON.format(units=",,mm,mm,mm"))
    with pytest.raises(SelfmotionError, match="says 'mm', but 'm' was stated"):
        load_markers(named, unit="m")
    with pytest.raises(SelfmotionError, match="100 Hz, but 60 Hz"):
        load_markers(named, rate=60.0)


def test_an_axis_that_the_file_tells_fills_up_a_frame(tmp_path: Path):
    path, _ = written(tmp_path, screen="+Z")
    assert load_markers(path, frame=Frame(None, "y")).frame == Frame("z", "y", "stated")
    with pytest.raises(SelfmotionError, match="its up axis is z, but x was stated"):
        load_markers(path, frame=Frame("x", None))
    seen = MarkerSet(np.arange(3) / 10, ("A",), np.ones((3, 1, 3)))
    trc = write_trc(tmp_path / "a.trc", seen)
    assert load_markers(trc, frame=Frame("y", None)).frame == Frame("y", None, "stated")
