"""C3D: units, axes, labels, gaps, model outputs, and files that were cut off."""

import ezc3d
import numpy as np
import pytest
from tests.motion.c3d_files import written

from selfmotion.errors import FileFormatError
from selfmotion.motion import Frame
from selfmotion.motion.files import load_markers
from selfmotion.motion.files.c3d import read_c3d, read_c3d_table


@pytest.mark.parametrize("analog", [0, 3])
@pytest.mark.parametrize(("units", "scale"), [("mm", 1e-3), ("m", 1.0), ("cm", 1e-2)])
def test_positions_in_metres(tmp_path, units, scale, analog):
    path, points = written(tmp_path, units=units, analog=analog)
    seen = read_c3d(path)
    np.testing.assert_allclose(seen.positions, points * scale, rtol=1e-6)
    assert seen.names == ("A", "B") and seen.rate == pytest.approx(100.0)
    assert not seen.frame.known


def test_a_unit_is_in_the_file_or_stated(tmp_path):
    path, points = written(tmp_path, units="")
    with pytest.raises(FileFormatError, match="POINT:UNITS is empty.*state it"):
        read_c3d(path)
    np.testing.assert_allclose(read_c3d(path, unit="mm").positions, points * 1e-3, rtol=1e-6)
    path, _ = written(tmp_path, units="furlong")
    with pytest.raises(FileFormatError, match="POINT:UNITS 'furlong': allowed are m, cm, mm"):
        read_c3d(path)
    path, _ = written(tmp_path)
    with pytest.raises(FileFormatError, match="says 'mm', but 'm' was stated"):
        load_markers(path, unit="m")


@pytest.mark.parametrize(
    ("screen", "up"), [("+Z", "z"), ("+Y", "y"), ("-Y", "-y"), ("Z", "z"), ("?", None)]
)
def test_the_up_axis_of_the_screen(tmp_path, screen, up):
    path, _ = written(tmp_path, screen=screen)
    assert (read_c3d(path).frame.up, read_c3d(path).frame.forward) == (up, None)
    assert read_c3d(path, frame=Frame("z", "y")).frame == Frame("z", "y")


def test_labels_are_stripped_prefixed_or_numbered(tmp_path):
    path, _ = written(tmp_path, labels=("P1:STRN  ", "P1:RSHO"))
    seen = read_c3d(path)
    assert (seen.names, seen.labels.subject) == (("STRN", "RSHO"), "P1")
    path, _ = written(tmp_path, labels=("STRN", ""))
    assert read_c3d(path).names == ("STRN", "unlabelled_2")


def test_unseen_samples_are_gaps(tmp_path):
    path, _ = written(tmp_path)
    made = ezc3d.c3d(str(path))
    made["data"]["points"][:3, 1, 2] = 0.0
    made["data"]["points"][:3, 0, 1] = np.nan
    made.write(str(path))
    assert np.argwhere(read_c3d(path).missing()).tolist() == [[1, 0], [2, 1]]


def test_model_outputs_are_no_markers(tmp_path):
    path, _ = written(tmp_path, labels=("STRN", "RElbowAngles"))
    made = ezc3d.c3d(str(path))
    made.add_parameter("POINT", "ANGLES", ["RElbowAngles"])
    made.write(str(path))
    table = read_c3d_table(path)
    assert (table.names, table.outputs) == (("STRN",), ("RElbowAngles",))


def test_every_cut_is_one_line(tmp_path):
    path, _ = written(tmp_path, frames=60)
    whole = path.read_bytes()
    # ezc3d fills the last block: what lies behind the last frame may go without harm.
    needed = len(whole) - (len(whole) - 60 * 2 * 16) % 512
    for length in [*range(0, needed - 512, 211), needed - 600]:
        path.write_bytes(whole[:length])
        with pytest.raises(FileFormatError) as raised:
            read_c3d(path)
        assert "\n" not in str(raised.value) and str(path) in str(raised.value)


def test_another_file_under_this_name(tmp_path):
    path = tmp_path / "x.c3d"
    path.write_text("time,elbow\n" * 200)
    with pytest.raises(FileFormatError, match="no C3D file"):
        read_c3d(path)
    with pytest.raises(FileFormatError, match="no such file"):
        load_markers(tmp_path / "absent.c3d")


def test_a_file_without_analog_group_reads(tmp_path):
    path, points = written(tmp_path)
    content = bytearray(path.read_bytes())
    at = content.index(b"ANALOG", 512) - 2
    content[at : at + 2] = b"\0\0"  # the parameters end here
    path.write_bytes(content)
    np.testing.assert_allclose(read_c3d(path).positions, points * 1e-3, rtol=1e-6)
