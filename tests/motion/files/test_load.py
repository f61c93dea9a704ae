"""Finding the reader: by content, then by name; and the other kind of file says so."""

import subprocess
import sys

import numpy as np
import pytest

from selfmotion.errors import FileFormatError
from selfmotion.motion import Frame, Recording
from selfmotion.motion.files import format_of, load, load_markers
from selfmotion.motion.files.storage import write_mot
from selfmotion.motion.files.trc import write_trc
from selfmotion.motion.markers import MarkerSet

VICON = "Trajectories\n100\n,,P1:A,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n"


def seen():
    return MarkerSet(np.arange(3) / 100, ("A",), np.ones((3, 1, 3)))


def bent():
    return Recording(np.arange(3) / 100, q=np.zeros((3, 1)))


@pytest.mark.parametrize(
    ("name", "content", "kind"),
    [
        ("x.csv", VICON, "vicon"),
        ("x.txt", VICON.replace(",", "\t"), "vicon"),
        ("x.csv", "\ufeff" + VICON, "vicon"),
        ("x.csv", "time,elbow\n0,1\n", "csv"),
        ("x.txt", "Coordinates\nendheader\ntime\te\n0\t1\n", "storage"),
        ("x.csv", "PathFileType\t4\n", "trc"),
        ("sub-1_task-a_tracksys-b_motion.tsv", "1\t2\n", "bids"),
        ("x.MOT", "", "storage"),
        ("x.c3d", "", "c3d"),
    ],
)
def test_formats_by_content_and_name(tmp_path, name, content, kind):
    path = tmp_path / name
    path.write_text(content, encoding="utf-8")
    assert format_of(path) == kind


def test_the_other_kind_of_file_says_so(tmp_path):
    with pytest.raises(FileFormatError, match="holds markers, not joint angles: load_markers"):
        load(write_trc(tmp_path / "x.trc", seen()))
    with pytest.raises(FileFormatError, match="holds no marker trajectories; allowed are .c3d"):
        load_markers(write_mot(tmp_path / "x.mot", bent()))


def test_unknown_and_absent_files(tmp_path):
    (tmp_path / "x.docx").write_text("hello")
    for read in (load, load_markers):
        with pytest.raises(FileFormatError, match="unknown kind of file '.docx'"):
            read(tmp_path / "x.docx")
        with pytest.raises(FileFormatError, match="no such file"):
            read(tmp_path / "absent.trc")
        with pytest.raises(FileFormatError, match="no such file"):
            read(tmp_path)


def test_what_the_caller_states_reaches_the_reader(tmp_path):
    path = write_trc(tmp_path / "x.trc", seen())
    assert load_markers(path, frame=Frame("y", "x")).frame.up == "y"
    path.write_text(path.read_text().replace("\tmm\t", "\t\t"))
    assert load_markers(path, unit="cm").positions[0, 0, 0] == pytest.approx(10.0)
    (tmp_path / "x.csv").write_text("elbow\n180\n90\n")
    found = load(tmp_path / "x.csv", unit="deg", rate=50.0)[0]
    assert found.rate == pytest.approx(50.0) and found.array("q")[0, 0] == pytest.approx(np.pi)


def test_reading_text_formats_needs_no_heavy_package(tmp_path):
    code = (
        "import sys; from selfmotion.motion.files import load, load_markers\n"
        "load_markers(sys.argv[1]); load(sys.argv[2])\n"
        "heavy = ('pandas', 'xarray', 'scipy', 'ezc3d', 'numba', 'pyarrow')\n"
        "print([m for m in heavy if m in sys.modules])"
    )
    files = [str(write_trc(tmp_path / "x.trc", seen())), str(write_mot(tmp_path / "x.mot", bent()))]
    out = subprocess.run([sys.executable, "-c", code, *files], capture_output=True, text=True)
    assert out.stdout.strip() == "[]", out.stderr
