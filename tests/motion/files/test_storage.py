"""MOT and STO: units by inDegrees, lengths by name, what is no motion, and the round trip."""

import numpy as np
import pytest

from selfmotion.errors import FileFormatError, ShapeError
from selfmotion.motion import Recording
from selfmotion.motion.files import load
from selfmotion.motion.files.storage import is_length, read_mot, read_storage, write_mot

HEAD = "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\nendheader\n"
ROWS = "time\telbow\tpelvis_tx\n0.00\t180\t0.5\n0.01\t90\t0.6\n"


def read(tmp_path, content, **options):
    path = tmp_path / "x.mot"
    path.write_text(content, encoding=options.pop("encoding", "utf-8"), newline="")
    return read_mot(path, **options)[0]


def spaced(content):
    head, rows = content.split("endheader\n")
    return head + "endheader\n" + rows.replace("\t180\t", "\t180   ").replace("\t90\t", "\t90   ")


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t,
        lambda t: t.replace("\t", ","),
        lambda t: "\n".join(line + ",," for line in t.replace("\t", ",").splitlines()) + "\n",
        lambda t: t.replace("nRows=2", "nRows=250"),
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("inDegrees=yes", "inDegrees = Yes "),
        lambda t: t.replace("\t", "   "),
        spaced,
        lambda t: t.replace("tx\n", "tx\tEVENT\n").replace("0.5\n", "0.5\tstart\n"),
        lambda t: t.replace("endheader\n", "endheader\n\n"),
        lambda t: t.replace("180", "3.14159265358979").replace("90", "1.570796326794897")
        .replace("=yes", "=no"),
        lambda t: t.rstrip("\n"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_what_real_files_do_gives_the_same_motion(tmp_path, change, encoding):
    r = read(tmp_path, change(HEAD + ROWS), encoding=encoding)
    assert r.joints == ("elbow", "pelvis_tx")
    np.testing.assert_allclose(r.array("q"), [[np.pi, 0.5], [np.pi / 2, 0.6]])
    assert r.rate == pytest.approx(100.0)


def test_units_are_stated_or_in_the_file_never_guessed(tmp_path):
    bare = (HEAD + ROWS).replace("inDegrees=yes\n", "")
    with pytest.raises(
        FileFormatError, match='no inDegrees.*state it \\(unit="deg" or "rad"; --angle-unit\\)'
    ):
        read(tmp_path, bare)
    assert read(tmp_path, bare, unit="deg").array("q")[0, 0] == pytest.approx(np.pi)
    assert read(tmp_path, bare, unit="rad").array("q")[0, 0] == 180.0
    with pytest.raises(FileFormatError, match="inDegrees=yes, but 'rad' was stated"):
        read(tmp_path, HEAD + ROWS, unit="rad")
    with pytest.raises(FileFormatError, match="allowed are yes and no"):
        read(tmp_path, HEAD.replace("=yes", "=perhaps") + ROWS)


def test_lengths_are_known_by_name_or_stated(tmp_path):
    assert is_length("thorax_ty") and is_length("box_transZ") and not is_length("pro_sup")
    as_angle = read(tmp_path, HEAD + ROWS, lengths=[])
    assert as_angle.array("q")[0, 1] == pytest.approx(np.radians(0.5))
    stated = read(tmp_path, HEAD + ROWS, lengths=["elbow", "pelvis_tx"])
    assert stated.array("q")[0].tolist() == [180.0, 0.5]
    with pytest.raises(FileFormatError, match="no coordinate 'knee'"):
        read(tmp_path, HEAD + ROWS, lengths=["knee"])


def test_states_give_positions_and_velocities(tmp_path):
    modern = (
        "states\ninDegrees=no\nendheader\ntime\t/jointset/e/elbow/value\t/jointset/e/elbow/speed\t"
        "/forceset/BIC/activation\n0\t1\t2\t0.5\n0.1\t1.2\t2\t0.5\n"
    )
    older = "states\ninDegrees=no\nendheader\ntime elbow elbow_u BIC.activation\n0 1 2 .5\n1 1 2 .5"
    for content in (modern, older):
        r = read(tmp_path, content)
        assert r.joints == ("elbow",)
        assert (r.array("q")[0, 0], r.array("qd")[0, 0]) == (1.0, 2.0)


@pytest.mark.parametrize(
    ("title", "columns"),
    [
        ("Static Optimization", "BRA"),
        ("Inverse Dynamics Generalized Forces", "elbow_moment"),
        ("results", "elbow_moment"),
        ("ground", "ground_force_vx"),
        ("Speeds", "elbow"),
        ("controls", "BRA"),
    ],
)
def test_tables_of_something_else_are_refused_as_motion_and_read_as_tables(
    tmp_path, title, columns
):
    content = f"{title}\ninDegrees=no\nendheader\ntime\t{columns}\n0\t1\n1\t2\n"
    with pytest.raises(FileFormatError, match="holds no coordinates"):
        read(tmp_path, content)
    table = read_storage(tmp_path / "x.mot")
    assert (table.title, table.columns, table.values.tolist()) == (title, (columns,), [[1], [2]])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "no line endheader"),
        (HEAD, "ends after its header"),
        (HEAD + "time\telbow\n", "no rows of numbers"),
        (HEAD + "elbow\ttime\n0\t1\n", "first column 'elbow'; time is needed"),
        (HEAD + "time\n0\n", "each column needs a name"),
        (HEAD + "time\ta\ta\n0\t1\t2\n", "column 'a' is there more than once"),
        (HEAD + ROWS.replace("90", "9o"), "row 9, column elbow: '9o' is no finite number"),
        (HEAD + ROWS + "0.02\t5\n", "row 10 has 2 cells: 3 are needed"),
        (HEAD + ROWS + "0.02\t5\t6\t7\t8\t9\t10\t11\n", "row 10 has 8 cells"),
        (HEAD + ROWS.replace("0.01", ""), "row 9: no time"),
        (HEAD + ROWS.replace("0.01", "0"), "time must increase strictly"),
        ((HEAD + ROWS).replace("nRows=2", "nRows=9")[:-2], "the file is cut off"),
    ],
)
def test_refusals_say_where_and_what(tmp_path, content, words):
    with pytest.raises(ValueError, match=words) as raised:
        read(tmp_path, content)
    assert str(tmp_path) in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize("unit", ["rad", "deg"])
@pytest.mark.parametrize("name", ["x.mot", "x.sto"])
def test_round_trip(tmp_path, unit, name):
    rng = np.random.default_rng(4)
    q = rng.normal(size=(4, 3))
    q[2, 1] = np.nan
    joints = ("shoulder_elv", "elbow_flexion", "pelvis_ty")
    ours = Recording(np.arange(4) / 120, q=q, joints=joints)
    theirs = load(write_mot(tmp_path / name, ours, unit=unit))[0]
    assert theirs.joints == joints
    np.testing.assert_array_equal(theirs.time, ours.time)
    np.testing.assert_allclose(theirs.array("q"), q, rtol=1e-14)


def test_what_a_table_of_coordinates_cannot_hold_is_refused(tmp_path):
    with pytest.raises(ShapeError, match="no time in seconds"):
        write_mot(tmp_path / "x.mot", Recording(np.arange(2.0), q=np.zeros((2, 1)), timed=False))
    with pytest.raises(ShapeError, match="q is needed"):
        write_mot(tmp_path / "x.mot", Recording(np.arange(2.0), x=np.zeros((2, 3))))
