from pathlib import Path

import numpy as np
import pytest

from selfmotion.cli.tables import read_rows, with_unit_quaternions
from selfmotion.errors import FileFormatError, UnknownNameError
from tests.cli.running import written

POSE = ("id", "qx", "qy", "qz", "qw", "x", "y", "z")


def test_units_at_the_end_of_names_are_brought_to_si(tmp_path: Path) -> None:
    file = written(tmp_path / "t.csv", "id,x_mm,y_cm,z,elbow_deg\na,1,2,3,180\n7.0,4,5,6,-90\n")
    rows = read_rows(file, ("x", "y", "z", "elbow"))
    expected = [[0.001, 0.02, 3.0, np.pi], [0.004, 0.05, 6.0, -np.pi / 2]]
    np.testing.assert_allclose(rows.array(("x", "y", "z", "elbow")), expected, rtol=1e-15)
    assert rows.ids == ("a", 7)


@pytest.mark.parametrize("mark", [" ", "\t", ","])
def test_rows_without_names_are_read_in_order(tmp_path: Path, mark: str) -> None:
    lines = [["3", *"0001", "0.1", "0.2", "0.3"], ["4", *"1000", "0.4", "0.5", "0.6"]]
    file = written(tmp_path / "p.txt", "\n".join(mark.join(line) for line in lines))
    rows = read_rows(file, POSE[1:], bare=POSE)
    assert rows.ids == (3, 4)
    np.testing.assert_array_equal(rows.array(("qw", "z")), [[1.0, 0.3], [0.0, 0.6]])


def test_a_gap_belongs_to_its_row(tmp_path: Path) -> None:
    rows = read_rows(written(tmp_path / "t.csv", "x,y\n1,nan\n3,4\n,6\n"), ("x", "y"))
    assert rows.problems == (
        f"{rows.table.path}: row 2, column y: 'nan' is no finite number",
        "",
        f"{rows.table.path}: row 4, column x: '' is no finite number",
    )
    assert rows.good.tolist() == [False, True, False]


def test_without_any_good_row_the_first_problem_is_raised(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="row 2, column x: 'nan' is no finite number"):
        read_rows(written(tmp_path / "t.csv", "x\nnan\nnan\n"), ("x",))


def test_a_quaternion_of_another_length_belongs_to_its_row(tmp_path: Path) -> None:
    file = written(tmp_path / "t.csv", "qx,qy,qz,qw\n0,0,0,1\n0.5,0.5,0.5,0.6\n")
    rows = with_unit_quaternions(read_rows(file, ("qx", "qy", "qz", "qw")))
    assert rows.problems[0] == ""
    assert "row 3, columns qx to qw: a quaternion of length 1.05357" in rows.problems[1]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "the file is empty"),
        ("x,y\n", "column names and rows are needed"),
        ("x,z\n1,2\n", r"no column y \(there are: x, z\)"),
        ("x,x_mm,y\n1,2,3\n", "columns x and x_mm hold the same thing"),
        ("x,y\n1,up\n", "row 2, column y: 'up' is no number"),
        ("x,y\n1,inf\n", "row 2, column y: 'inf' must be finite"),
        ("x,y\n1\n", "row 2 has 1 cells: 2 are needed"),
        ("id,x,y\na,1,2\na,1,2\n", "row 3, column id: 'a' stands twice"),
        ("x,y,elbow\n1,2,90\n", "row 2, column elbow: '90' is beyond 2 pi rad"),
        ("x,y,qx\n1,2,0\n", "no column qy"),
    ],
)
def test_a_bad_file_is_refused_with_its_place(tmp_path: Path, text: str, reason: str) -> None:
    file = written(tmp_path / "t.csv", text)
    with pytest.raises(FileFormatError, match=reason) as caught:
        read_rows(file, ("x", "y"), [("elbow",), ("qx", "qy")])
    assert str(caught.value).startswith(str(file))


def test_rows_without_names_need_all_cells(tmp_path: Path) -> None:
    file = written(tmp_path / "p.txt", "1 0 0 0 1 0.1 0.2\n")
    with pytest.raises(FileFormatError, match="row 1 has 7 cells: 8 are needed"):
        read_rows(file, POSE[1:], bare=POSE)


def test_an_unknown_column_is_refused_where_columns_are_strict(tmp_path: Path) -> None:
    file = written(tmp_path / "t.csv", "elbow,wirst\n1,2\n")
    with pytest.raises(UnknownNameError, match="'wirst'; did you mean 'wrist'"):
        read_rows(file, ("elbow", "wrist"), strict=True)
