"""TRC: what real files do, what is refused, and the round trip."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as some

from selfmotion.errors import FileFormatError, RangeError
from selfmotion.motion import Frame
from selfmotion.motion.files.trc import read_trc, read_trc_table, write_trc
from selfmotion.motion.markers import MarkerSet

KEYS = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits"
TOP = f"PathFileType\t4\t(X/Y/Z)\tx.trc\n{KEYS}\n"


def text(units="mm", rows=("1\t0.00\t1000\t0\t250\t1\t2\t3", "2\t0.01\t1001\t0\t250\t1\t2\t3")):
    lines = [
        f"100\t100\t{len(rows)}\t2\t{units}",
        "Frame#\tTime\tA\t\t\tB\t\t",
        "\t\tX1\tY1\tZ1\tX2\tY2\tZ2",
        "",
        *rows,
    ]
    return TOP + "\n".join(lines) + "\n"


def read(tmp_path, content, **options):
    path = tmp_path / "x.trc"
    path.write_text(content, encoding=options.pop("encoding", "utf-8"), newline="")
    return read_trc(path, **options)


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t,
        lambda t: t.replace("\t", ","),
        lambda t: t.replace("\n\n", "\n"),
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("\tA\t", "\tA \t").replace("\tB\t", "\tB  \t"),
        lambda t: t.replace("\tA\t", "\tP1:A\t").replace("\tB\t", "\tP1:B\t"),
        lambda t: t.replace("100\t100\t2\t2", "100\t100\t652\t51"),
        lambda t: t.replace("Frame#\tTime\tA\t\t\tB\t\t", "Frame#\tTime\tA\tB"),
        lambda t: t.replace("250\t1\t2\t3\n2", "250\t1\t2\t3\t\t\n2"),
        lambda t: t.replace("B\t\t\n", "B\t\t\tEvent\n").replace("1\t2\t3\n2", "1\t2\t3\t\n2"),
        lambda t: t.rstrip("\n"),
        lambda t: t.replace("\t0.01\t", "\t0.00\t"),  # rounded too coarsely: by frame and rate
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_what_real_files_do_gives_the_same_markers(tmp_path, change, encoding):
    seen = read(tmp_path, change(text()), encoding=encoding)
    assert seen.names == ("A", "B")
    np.testing.assert_allclose(seen.time, [0.0, 0.01], atol=1e-12)
    np.testing.assert_allclose(seen.positions[0], [[1.0, 0.0, 0.25], [0.001, 0.002, 0.003]])


@pytest.mark.parametrize(
    "cells", ["\t\t", "NaN\tNaN\tNaN", "nan\t0\t5", "0\t0\t0", "0.0\t-0.0\t0.000", "\t5\t"]
)
def test_gaps(tmp_path, cells):
    rows = (f"1\t0.00\t{cells}\t1\t2\t3", "2\t0.01\t1001\t0\t250\t1\t2\t3", "3\t0.02")
    seen = read(tmp_path, text(rows=rows))
    assert seen.missing().tolist() == [[True, False], [False, False], [True, True]]


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1.0), ("m", 1000.0), ("cm", 10.0)])
def test_units_are_those_of_the_header(tmp_path, unit, metres):
    assert read(tmp_path, text(unit)).positions[0, 0, 0] == pytest.approx(metres)
    assert read(tmp_path, text(""), unit=unit).positions[0, 0, 0] == pytest.approx(metres)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (text(""), 'Units is empty.*state it \\(unit="mm"'),
        (text("inch"), "Units 'inch': allowed are m, cm, mm"),
        (text().replace("1001", "x1"), "row 8, column A:X: 'x1' is no finite number"),
        (text().replace("1001", "inf"), "'inf' is no finite number"),
        (text().replace("1001", "1_0"), "'1_0' is no finite number"),
        (text().replace("2\t0.01", "2\t0.01\t1\t1\t1"), "row 8 has 11 cells"),
        (text()[: text().index("2\t0.01") + 15], "the file is cut off"),
        (text().replace("X2\tY2\tZ2", ""), "2 marker labels for 1 triples"),
        (text().replace("\tB\t", "\tA\t"), "marker 'A' is there more than once"),
        (text()[:60], "within its header"),
        (text().split("1\t0.00")[0], "no rows of samples"),
        (text().replace("Frame#", "Nr"), "where Frame# and Time are needed"),
        (text().replace("\t0.01", "\t-7"), "column Time does not increase"),
        ("", "no PathFileType"),
        ("time,elbow\n0,1\n", "no PathFileType"),
    ],
)
def test_refusals_say_where_and_what(tmp_path, content, words):
    with pytest.raises(ValueError, match=words):
        read(tmp_path, content)


def test_a_stated_unit_may_not_contradict_the_file(tmp_path):
    with pytest.raises(FileFormatError, match="says 'mm', but 'm' was stated"):
        read(tmp_path, text(), unit="m")


def test_unlabelled_trajectories_keep_their_place(tmp_path):
    seen = read(tmp_path, text().replace("\tA\t\t\tB", "\t\t\t\tB"))
    assert seen.names == ("unlabelled_1", "B")
    assert seen.point("B")[0].tolist() == pytest.approx([0.001, 0.002, 0.003])


def test_frame_and_labels_are_the_callers(tmp_path):
    assert not read(tmp_path, text()).frame.known
    assert read(tmp_path, text(), frame=Frame("y", "x")).frame == Frame("y", "x")
    seen = read(tmp_path, text().replace("\tA\t", "\tP7:A\t").replace("\tB\t", "\tP7:B\t"))
    assert seen.labels.subject == "P7"


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    positions=some.arrays(
        np.float64, (3, 2, 3), elements=st.floats(-10, 10).filter(lambda v: abs(v) > 1e-9)
    ),
    unit=st.sampled_from(["m", "cm", "mm"]),
    gap=st.booleans(),
)
def test_round_trip(tmp_path, positions, unit, gap):
    if gap:
        positions[1, 0] = np.nan
    ours = MarkerSet(np.array([0.0, 0.01, 0.03]), ("A b", "C"), positions, Frame("z", "y"))
    path = write_trc(tmp_path / "x.trc", ours, unit=unit)
    theirs = read_trc(path, frame=ours.frame)
    assert theirs.names == ours.names
    np.testing.assert_array_equal(theirs.time, ours.time)
    np.testing.assert_allclose(theirs.positions, ours.positions, rtol=1e-14)
    header = read_trc_table(path).header
    assert (header["numframes"], header["nummarkers"], header["units"]) == ("3", "2", unit)


def test_writing_turns_the_axes_where_asked(tmp_path):
    ours = MarkerSet(np.arange(2.0), ("A",), np.tile([1.0, 2.0, 3.0], (2, 1, 1)), Frame("z", "y"))
    path = write_trc(tmp_path / "x.trc", ours, frame=Frame("y", "x"))
    # right, forward, up = 1, 2, 3: OpenSim's x is forward, y is up, z is right.
    np.testing.assert_allclose(read_trc(path).positions[0, 0], [2.0, 3.0, 1.0])
    lost = MarkerSet(np.arange(2.0), ("A",), np.ones((2, 1, 3)))
    with pytest.raises(RangeError, match="up and forward axes are not known"):
        write_trc(tmp_path / "y.trc", lost, frame=Frame("y", "x"))
