"""Vicon Nexus CSV: what real exports do, and what is refused."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.motion.files import load_markers
from selfmotion.motion.files.vicon_csv import read_vicon_csv, write_vicon_csv
from selfmotion.motion.labels import Frame, Labels
from selfmotion.motion.markers import MarkerSet

DATA = Path(__file__).parents[3].joinpath("shared", "data", "ue_adl")

LINES = [
    "Trajectories",
    "200",
    ",,P1:A,,,P1:B,,",
    "Frame,Sub Frame,X,Y,Z,X,Y,Z",
    ",,mm,mm,mm,mm,mm,mm",
    "41,0,1,2,3,,,",
    "42,0,1,2,3,4,5,6",
]


def write(tmp_path: Path, lines: list[str], **kind) -> Path:
    where = tmp_path / "trial.csv"
    where.write_text("\n".join(lines) + "\n", **kind)
    return where


def test_units_gaps_prefix_and_frame_numbers(tmp_path):
    seen = read_vicon_csv(write(tmp_path, LINES, encoding="utf-8-sig"), frame=Frame())
    assert seen.names == ("A", "B") and seen.labels.subject == "P1" and seen.frame.up == "z"
    np.testing.assert_allclose(seen.time, [0.2, 0.205])
    np.testing.assert_allclose(seen.positions[1], [[0.001, 0.002, 0.003], [0.004, 0.005, 0.006]])
    assert np.isnan(seen.positions[0, 1]).all()


@pytest.mark.parametrize("mark", [";", "\t"])
def test_other_delimiters_and_metres(tmp_path, mark):
    lines = [line.replace(",", mark).replace("mm", "m") for line in LINES]
    seen = read_vicon_csv(write(tmp_path, lines))
    assert seen.positions[1, 1].tolist() == [4.0, 5.0, 6.0]


def test_other_sections_and_short_last_rows_are_passed_over(tmp_path):
    devices = ["Devices", "1000", ",,Force", "Frame,Sub Frame,Fx", ",,N", "1,0,5.0", ""]
    lines = [*devices, *LINES, "43,0,7,8,9", "", "Model Outputs", "nonsense"]
    seen = read_vicon_csv(write(tmp_path, lines))
    assert seen.n_samples == 3
    assert np.isnan(seen.positions[2, 1]).all() and seen.positions[2, 0, 0] == 0.007


@pytest.mark.parametrize(
    ("row", "text", "message"),
    [
        (0, "Forces", "no line that says Trajectories"),
        (1, "fast", "row 2: rate 'fast'"),
        (2, ",,P1:A,,,P1:A,,", "more than once"),
        (2, ",,P1:A,P1:B,,,", "every third column"),
        (3, "X,Y,Z", "row 4"),
        (4, ",,mm,mm,mm,inch,mm,mm", "unit 'inch'"),
        (5, "41,0,1,2,3,x,,", "row 6, column 6: 'x' is no number"),
        (5, ",0,1,2,3,,,", "row 6"),
        (6, "41,0,1,2,3,4,5,6", "must increase"),
        (6, "42,0,1,2,3,4,5,6,7", "row 7 has 9 cells"),
    ],
)
def test_refusals_name_the_row(tmp_path, row, text, message):
    lines = LINES.copy()
    lines[row] = text
    with pytest.raises(SelfmotionError, match=message):
        read_vicon_csv(write(tmp_path, lines))


def test_a_row_that_was_cut_off_is_refused(tmp_path):
    where = tmp_path / "trial.csv"
    whole = "\n".join([*LINES, "43,0,1,2,3,4,5,6"])
    where.write_text(whole)  # no end of line, but all cells
    assert read_vicon_csv(where).n_samples == 3
    where.write_text(whole[:-5])  # 43,0,1,2,3,4 could have been 43,0,1,2,3,41.7,...
    with pytest.raises(FileFormatError, match="row 8 ends after 6 of 8 cells .* cut off"):
        read_vicon_csv(where)
    where.write_text(whole[:-5] + "\n")  # Nexus leaves the last empty cells of a row out
    assert np.isnan(read_vicon_csv(where).positions[2, 1]).any()


def test_a_file_that_ends_early_is_refused(tmp_path):
    for count in range(1, 6):
        with pytest.raises(FileFormatError):
            read_vicon_csv(write(tmp_path, LINES[:count]))


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_broken_files_are_refused_in_one_line_or_read_with_the_right_shape(tmp_path, data):
    text = list("\n".join(LINES) + "\n")
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(
            st.sampled_from([",", "\n", "", "1", "-", "nan", "e", ":", "inf", "µ"])
        )
    where = tmp_path / "broken.csv"
    where.write_text("".join(text), encoding="utf-8")
    try:
        seen = read_vicon_csv(where)
    except SelfmotionError as error:
        assert "\n" not in str(error)
    else:
        assert seen.positions.shape == (seen.n_samples, seen.n_markers, 3)


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the reaching recordings are not at {DATA}")
def test_the_reaching_recordings_read():
    static = read_vicon_csv(DATA / "ADL001" / "ADL001_static.csv", frame=Frame())
    trial = read_vicon_csv(DATA / "ADL001" / "ADL001FR1.csv", frame=Frame())
    assert static.names == trial.names and len(static.names) == 49
    assert static.rate == pytest.approx(100.0) and not static.missing().any()
    gone = {trial.names[i] for i in np.flatnonzero(np.isnan(trial.positions).all(axis=(0, 2)))}
    assert gone == {side + mark for side in "RL" for mark in ("GTH", "LEP", "MEP", "SPR", "SPU")}


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(2, 30), st.integers(1, 4), st.sampled_from(["mm", "cm", "m"]), st.integers(0, 9))
def test_what_is_written_is_read_back(n_samples, n_markers, unit, seed):
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(n_samples, n_markers, 3))
    positions[rng.random((n_samples, n_markers)) < 0.3] = np.nan
    first = int(rng.integers(0, 50))
    rate = float(rng.choice([60.0, 69.9, 100.0, 1000.0]))
    seen = MarkerSet(
        (first + np.arange(n_samples)) / rate,
        tuple(f"M{i}" for i in range(n_markers)),
        positions,
        Frame("z", "y"),
        Labels(subject="P1"),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = write_vicon_csv(Path(folder, "x.csv"), seen, unit=unit)
        back = read_vicon_csv(path, frame=Frame("z", "y"))
        assert load_markers(path).names == seen.names
    assert back.names == seen.names and back.labels == seen.labels and back.frame == seen.frame
    np.testing.assert_allclose(back.time, seen.time, rtol=0, atol=1e-9)
    np.testing.assert_allclose(back.positions, positions, rtol=1e-15)


def test_frames_turn_on_the_way_and_uneven_times_are_refused(tmp_path):
    seen = MarkerSet(
        np.arange(3) / 50, ("A",), np.tile([1.0, 2.0, 3.0], (3, 1, 1)), Frame("z", "y")
    )
    path = write_vicon_csv(tmp_path / "x.csv", seen, frame=Frame("y", "x"))
    assert read_vicon_csv(path).point("A")[0].tolist() == [2.0, 3.0, 1.0]
    for time in ([0.0, 0.01, 0.05], [-1.0, -0.9, -0.8], [0.004, 0.014, 0.024]):
        uneven = MarkerSet(np.array(time), ("A",), np.ones((3, 1, 3)))
        with pytest.raises(RangeError, match="no whole frame"):
            write_vicon_csv(tmp_path / "y.csv", uneven)
    with pytest.raises(RangeError, match="one sample"):
        write_vicon_csv(tmp_path / "y.csv", seen.window(0, 1))
