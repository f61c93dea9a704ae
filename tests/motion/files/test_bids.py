"""Motion-BIDS: round trips, axes by letters, units by channel, and what is refused."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.motion import Frame, Labels, Recording
from selfmotion.motion.files import load, load_markers
from selfmotion.motion.files.bids import read_bids
from selfmotion.motion.files.bids_names import frame_of, spatial_axes
from selfmotion.motion.files.bids_writer import write_bids
from selfmotion.motion.markers import MarkerSet

WHO = Labels(subject="01", condition="reach", trial="3")


def markers():
    positions = np.random.default_rng(3).normal(size=(4, 2, 3))
    positions[1, 0] = np.nan
    return MarkerSet(np.arange(4) / 50 + 7.0, ("STRN", "RSHO"), positions, Frame("y", "x"), WHO)


def joints():
    q = np.random.default_rng(3).normal(size=(4, 2))
    q[2, 1] = np.nan
    return Recording(np.array([0.0, 0.1, 0.3, 0.4]), q=q, joints=("a", "b"), labels=WHO)


def changed(path, ending, change):
    beside = path.with_name(path.name.replace("_motion.tsv", ending))
    beside.write_text(change(beside.read_text()))


def test_markers_round_trip(tmp_path):
    ours = markers()
    path = write_bids(tmp_path / "motion", ours)
    assert path.name == "sub-01_task-reach_tracksys-markers_run-3_motion.tsv"
    theirs = load_markers(path)
    assert (theirs.names, theirs.labels) == (ours.names, WHO)
    assert (theirs.frame.up, theirs.frame.forward) == ("y", "x")
    np.testing.assert_array_equal(theirs.positions, ours.positions)
    np.testing.assert_allclose(theirs.time, ours.time - ours.time[0], atol=1e-12)


def test_angles_round_trip(tmp_path):
    ours = joints()
    theirs = load(write_bids(tmp_path, ours))[0]
    assert (theirs.joints, theirs.labels) == (ours.joints, WHO)
    np.testing.assert_allclose(theirs.array("q"), ours.array("q"), rtol=1e-14)
    np.testing.assert_array_equal(theirs.time, ours.time)


def test_files_keep_to_the_specification(tmp_path):
    path = write_bids(tmp_path, markers(), tracksys="omc 1", task="drink")
    assert path.name.startswith("sub-01_task-drink_tracksys-omc1")
    about = json.loads(path.with_name(path.name.replace(".tsv", ".json")).read_text())
    assert about["SamplingFrequency"] == pytest.approx(50.0)
    channels = path.with_name(path.name.replace("_motion.tsv", "_channels.tsv")).read_text()
    rows = [line.split("\t") for line in channels.splitlines()]
    assert rows[0][:5] == ["name", "component", "type", "tracked_point", "units"]
    widths = {len(line.split("\t")) for line in path.read_text().splitlines()}
    assert widths == {len(rows) - 1} == {about["MotionChannelCount"]}
    assert "n/a" in path.read_text() and "nan" not in path.read_text().lower()


@pytest.mark.parametrize(
    ("letters", "up", "forward"),
    [
        ("ALS", "z", "x"),
        ("RAS", "z", "y"),
        ("ASR", "y", "x"),
        ("PRS", "z", "-x"),
        ("LPS", "z", "-y"),
    ],
)
def test_axes_by_letters(letters, up, forward):
    frame = frame_of(letters)
    assert (frame.up, frame.forward) == (up, forward)
    assert spatial_axes(frame) == letters


@pytest.mark.parametrize("letters", ["ARS", "LAS", "AAS", "APS"])
def test_axes_that_are_no_right_handed_frame(letters):
    with pytest.raises(RangeError, match=f"SpatialAxes '{letters}'"):
        frame_of(letters)


@pytest.mark.parametrize("letters", ["", "A_S", "XYZ"])
def test_axes_not_told_are_unknown(letters):
    assert not frame_of(letters).known


def test_units_are_those_of_each_channel(tmp_path):
    path = write_bids(tmp_path, markers())
    changed(path, "_channels.tsv", lambda t: t.replace("RSHO\tm\t", "RSHO\tmm\t"))
    ours, theirs = markers(), load_markers(path)
    np.testing.assert_allclose(theirs.point("RSHO"), ours.point("RSHO") / 1000)
    changed(path, "_channels.tsv", lambda t: t.replace("STRN\tm\t", "STRN\tvm\t"))
    with pytest.raises(FileFormatError, match="channel STRN_x: unit 'vm'"):
        load_markers(path)


def test_orientations_and_other_channels(tmp_path):
    turns = Rotation.from_rotvec(np.random.default_rng(2).normal(size=(3, 3)))
    path = tmp_path / "sub-02_task-point_tracksys-imu_motion.tsv"
    values = np.c_[turns.as_quat()[:, [3, 0, 1, 2]], np.ones(3)]
    path.write_text("\n".join("\t".join(map(repr, row)) for row in values.tolist()) + "\n")
    names = ["quat_w", "quat_x", "quat_y", "quat_z"]
    rows = [f"hand_{n}\t{n}\tORNT\thand\tn/a" for n in names] + ["acc\tx\tACCEL\thand\tm/s^2"]
    beside = path.with_name(path.name.replace("_motion.tsv", "_channels.tsv"))
    beside.write_text("\n".join(["name\tcomponent\ttype\ttracked_point\tunits", *rows]))
    path.with_suffix(".json").write_text('{"SamplingFrequency": 60}')
    found = read_bids(path)
    assert found.markers is None and found.recording is None and found.aside == {"ACCEL": 1}
    (hand,) = found.orientations
    assert (hand.segment, hand.labels.subject) == ("hand", "02")
    np.testing.assert_allclose(hand.matrices, turns.as_matrix(), atol=1e-12)
    assert hand.rate == pytest.approx(60.0)
    with pytest.raises(FileFormatError, match="no channel of type POS"):
        load_markers(path)
    with pytest.raises(FileFormatError, match="no channel of type JNTANG"):
        load(path)


@pytest.mark.parametrize(
    ("ending", "change", "words"),
    [
        ("_motion.tsv", lambda t: t.replace("\t", "\t1\t", 1), "row 1 has 8 cells"),
        ("_motion.tsv", lambda t: t.replace("0.0", "zero", 1), "'zero' is no finite number"),
        ("_motion.tsv", lambda t: "", "no samples"),
        ("_channels.tsv", lambda t: t.replace("tracked_point", "place"), "no column tracked_point"),
        ("_channels.tsv", lambda t: t.replace("STRN_z\tz", "STRN_z\ty"), "component y twice"),
        ("_channels.tsv", lambda t: t.replace("STRN_z\tz", "STRN_z\tn/a"), "lacks component z"),
        ("_channels.json", lambda t: t.replace("ASR", "ASL"), "left-handed axes"),
        ("_channels.json", lambda t: t[:20], "no JSON"),
        ("_motion.json", lambda t: "[1]", "a JSON object is needed"),
    ],
)
def test_refusals(tmp_path, ending, change, words):
    path = write_bids(tmp_path, markers())
    changed(path, ending, change)
    with pytest.raises(SelfmotionError, match=words):
        load_markers(path)


def test_missing_files_and_rates(tmp_path):
    path = write_bids(tmp_path, joints())
    changed(path, "_channels.tsv", lambda t: t.replace("LATENCY", "MISC"))
    assert load(path)[0].rate == pytest.approx(7.5)
    changed(path, "_motion.json", lambda t: t.replace("SamplingFrequency", "Rate"))
    with pytest.raises(FileFormatError, match="SamplingFrequency is None"):
        load(path)
    path.with_name(path.name.replace("_motion.tsv", "_channels.tsv")).unlink()
    with pytest.raises(FileFormatError, match="no such file; Motion-BIDS needs it"):
        load(path)


def test_what_bids_cannot_name_is_refused(tmp_path):
    with pytest.raises(RangeError, match="subject None"):
        write_bids(tmp_path, Recording(np.arange(2.0), q=np.zeros((2, 1))))
