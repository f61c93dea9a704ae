import os
import stat
from pathlib import Path

import pytest

from selfmotion.writing import whole_file, write_whole


def test_text_and_bytes_arrive(tmp_path: Path) -> None:
    assert write_whole(tmp_path / "deep" / "a.txt", "µ\n").read_bytes() == "µ\n".encode()
    assert write_whole(str(tmp_path / "b"), b"\x00").read_bytes() == b"\x00"


def test_an_earlier_file_survives_a_failure(tmp_path: Path) -> None:
    path = write_whole(tmp_path / "a.csv", "old")
    with pytest.raises(ZeroDivisionError), whole_file(path) as aside:
        aside.write_text("half of the n")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_path_aside_has_the_suffix_and_folder(tmp_path: Path) -> None:
    with whole_file(tmp_path / "a.parquet") as aside:
        assert (aside.parent, aside.suffix) == (tmp_path, ".parquet")
        assert not (tmp_path / "a.parquet").exists()


def test_a_folder_in_the_way_is_named(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError) as caught:
        write_whole(tmp_path, "text")
    assert caught.value.filename == str(tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="file modes are POSIX")
def test_the_file_has_the_mode_of_any_new_file(tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    plain.touch()
    ours = write_whole(tmp_path / "ours", "")
    assert stat.S_IMODE(ours.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)
