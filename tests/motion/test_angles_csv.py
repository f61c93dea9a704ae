"""Joint angles in CSV: units are named or refused, and real files' oddities are met."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from selfmotion.errors import SelfmotionError
from selfmotion.motion import Labels, Recording, Study
from selfmotion.motion.files import load
from selfmotion.motion.files.angles_csv import read_angles_csv, write_angles_csv

BOUNDED = settings(
    deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def written(tmp_path: Path, text: str, encoding: str = "utf-8") -> Path:
    path = tmp_path / "angles.csv"
    path.write_bytes(text.encode(encoding))
    return path


def study() -> Study:
    rng = np.random.default_rng(8)
    return Study(
        tuple(
            Recording(
                np.arange(5) / 100 + i,
                q=rng.normal(size=(5, 2)),
                qd=50 * rng.normal(size=(5, 2)),
                x=rng.normal(size=(5, 3)),
                joints=("shoulder_elv", "elbow_flexion"),
                labels=Labels(subject="P1", side="left" if i else None, trial="x;y" if i else "1"),
            )
            for i in range(3)
        )
    )


@pytest.mark.parametrize("unit", ["rad", "deg"])
def test_round_trip(tmp_path, unit):
    ours = study()  # the last two carry the same labels
    back = load(write_angles_csv(tmp_path / "a.csv", ours, unit=unit))
    assert len(back) == 3
    for a, b in zip(ours, back, strict=True):
        assert (a.labels, a.joints, a.rows, a.held) == (b.labels, b.joints, b.rows, b.held)
        for name in ("time", *a.held):
            np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-15)


def test_gaps_and_untimed_samples_round_trip(tmp_path):
    q = np.array([[0.1, np.nan], [0.2, 0.3], [np.nan, np.nan]])
    path = write_angles_csv(
        tmp_path / "a.csv", [Recording(np.arange(3.0), q=q, timed=False)], unit="deg"
    )
    back = read_angles_csv(path)[0]
    np.testing.assert_allclose(back.array("q"), q)
    assert not back.timed and back.gaps().tolist() == [True, False, True]


@pytest.mark.parametrize(
    "text",
    [
        "time,a_deg,b\n0,180,0.5\n1,90,1\n",
        "time,a_deg,b_rad\r\n0,180,0.5\r\n\r\n1,90,1\r\n,,\r\n",
        "\ufefftime;a [deg];b\n0;180;0,5\n1;90,0;1\n",
        "time\ta (°)\tb\n0\t180\t0.5\n1\t90\t1\n",
        "time,a,b\ns,deg,rad\n0,180,0.5\n1,90,1\n",
        "# exported\ntime_ms,a_deg,b,\n0,180,0.5,\n1000,90,1,\n",
        't,"a_deg","b"\n0,"180","0,5"\n1,90,1\n',
        "Time [s], a_DEG , b\n 0 , 180 , 5e-1\n 1 , 90 , 1\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_real_files_oddities_give_the_same_angles(tmp_path, text, encoding):
    if encoding == "latin-1":  # which has no byte order mark
        text = text.removeprefix("\ufeff")
    rec = read_angles_csv(written(tmp_path, text, encoding))[0]
    assert rec.joints == ("a", "b") and rec.time.tolist() == [0.0, 1.0]
    np.testing.assert_allclose(rec.array("q"), [[np.pi, 0.5], [np.pi / 2, 1.0]])


def test_rate_and_unit_can_be_stated(tmp_path):
    path = written(tmp_path, "trial,elbow,slide_mm\n1,90,5\n1,180,6\n2,90,7\n2,90,8\n")
    both = read_angles_csv(path, unit="deg", rate=50.0)
    assert [r.labels.trial for r in both] == ["1", "2"] and both[1].time.tolist() == [0.0, 0.02]
    np.testing.assert_allclose(both[0].array("q"), [[np.pi / 2, 0.005], [np.pi, 0.006]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "time,a\n0,0.1\n1,90\n",
            "row 3, column a: '90' is beyond 2 pi rad: name the column",
        ),
        ("time,a\n0,0.1\n1,abc\n", "row 3, column a: 'abc' is no number"),
        ("time,a\n0,0.1\n\n1,1_0\n", "row 4, column a: '1_0' is no number"),
        ("time;a\n0;0,1\n1;1.234,5\n", "row 3, column a: '1.234,5' is no number"),
        ("time,a\n0,0.1\n1,inf\n", "row 3, column a: 'inf' must be finite"),
        ("time,a\n0,0.1\n,0.2\n", "row 3, column time: '' where a time is needed"),
        ("time,a\n0,0.1\n0,0.2\n", "time[1] = 0 after 0: time must increase strictly"),
        ("time,a,a\n0,0.1,1\n1,1,1\n", "row 1: column 'a' is there more than once"),
        ("time,a_deg,a_rad\n0,0.1,1\n1,1,1\n", "column 'a' is there in more than one unit"),
        ("time,,a\n0,0.1,1\n1,1,1\n", "row 1: column 2 has no name"),
        ("0.0,0.1\n1,0.2\n", "row 1: '0.0' where the name of column 1 is needed"),
        ("time,a\n0,0.1\n1,0.2,3\n", "row 3 has 3 cells: 2 are needed"),
        ("time,a\n0,0.1\n1\n", "row 3 has 1 cells: 2 are needed"),
        ("a,b\n0,0.1\n1,0.2\n", "no column time (s)"),
        ("time,trial\n0,1\n1,1\n", "no column of joint angles"),
        ("time,a\n0,0.1\n", "q has 1 sample(s): at least 2 are needed"),
        ("time,a\n", "1 line(s): column names and rows are needed"),
        ("", "0 line(s)"),
        ("time,a [furlong]\n0,1\n1,2\n", "column a [furlong]: unknown unit 'furlong'"),
        ("time,a_deg\ns,rad\n0,1\n1,2\n", "column a_deg: its unit row says 'rad'"),
        ("time,a,x\n0,1,2\n1,2,2\n", "column x: a joint's name is needed"),
        ("time,a,b_velocity\n0,1,2\n1,2,2\n", "position and velocity are both needed"),
        ("time [deg],a\n0,1\n1,2\n", "time is in s or ms"),
        ("time,a,hand_x_deg\n0,1,2\n1,2,2\n", "column hand_x_deg: unit 'deg'; allowed are m"),
        ('time,a\n0,"0.1\n1,0.2\n', "cannot be read as delimited text"),
        ("time,a\n0,\0\n1,0.2\n", "no text file"),
    ],
)
def test_refused_in_one_line(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(SelfmotionError, match=re.escape(message)) as raised:
        read_angles_csv(path)
    assert str(raised.value).startswith(f"{path}: ") and "\n" not in str(raised.value)


def test_rate_beside_time_and_bad_rates_are_refused(tmp_path):
    path = written(tmp_path, "time,a\n0,0.1\n1,0.2\n")
    with pytest.raises(SelfmotionError, match="there is a column time"):
        read_angles_csv(path, rate=10.0)
    with pytest.raises(SelfmotionError, match="rate = 0 Hz"):
        read_angles_csv(path, rate=0.0)
    with pytest.raises(SelfmotionError, match="cannot be opened"):
        read_angles_csv(tmp_path / "absent.csv")


@BOUNDED
@given(text=st.text(alphabet='time,abdeg_;\t"\n\r0123456789.-eE#[] ', max_size=80))
def test_any_text_is_read_or_refused_in_one_line(tmp_path, text):
    try:
        out = read_angles_csv(written(tmp_path, text))
    except SelfmotionError as error:
        assert "\n" not in str(error)
    else:
        assert out.n_samples >= 2


@BOUNDED
@given(raw=st.binary(max_size=60))
def test_any_bytes_are_read_or_refused_in_one_line(tmp_path, raw):
    path = tmp_path / "any.csv"
    path.write_bytes(b"time,a\n" + raw)
    try:
        load(path)
    except SelfmotionError as error:
        assert "\n" not in str(error)
