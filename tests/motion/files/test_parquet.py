"""Parquet keeps recordings, labels and gaps, and refuses what it did not write."""

from typing import Any

import numpy as np
import pytest

from selfmotion.errors import FileFormatError, MissingExtraError, ShapeError
from selfmotion.motion import Frame, Labels, Recording, Study
from selfmotion.motion.files import load
from selfmotion.motion.files import parquet as module
from selfmotion.motion.files.parquet import write_parquet


def study(**changes: Any) -> Study:
    rng = np.random.default_rng(8)
    q = rng.normal(size=(5, 2))
    q[3, 1] = np.nan
    kept: dict[str, Any] = {"qd": rng.normal(size=(5, 2)), "x": rng.normal(size=(5, 3))} | changes
    return Study(
        tuple(
            Recording(
                np.arange(5) / 100 + i,
                q=q * (i + 1),
                joints=("elv", "elbow"),
                labels=Labels(subject="P1", trial="1" if i else None),
                frame=Frame("y", "x"),
                **kept,
            )
            for i in range(3)
        )
    )


@pytest.mark.parametrize("changes", [{}, {"qd": None, "x": None}, {"timed": False}])
def test_round_trip(tmp_path, changes):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    ours = study(**changes)
    theirs = load(write_parquet(tmp_path / "x.parquet", ours))
    assert len(theirs) == 3
    for a, b in zip(ours, theirs, strict=True):
        assert (a.labels, a.joints, a.rows, a.held) == (b.labels, b.joints, b.rows, b.held)
        assert (a.frame.up, a.frame.forward, a.timed) == (b.frame.up, b.frame.forward, b.timed)
        for name in a.held:
            np.testing.assert_array_equal(a.array(name), b.array(name))


def test_other_and_damaged_files(tmp_path):
    arrow = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from pyarrow import parquet

    path = tmp_path / "x.parquet"
    parquet.write_table(arrow.table({"elbow": [1.0, 2.0]}), path)
    with pytest.raises(FileFormatError, match="no Parquet file of this library"):
        load(path)
    whole = write_parquet(path, study()).read_bytes()
    for length in range(4, len(whole), 499):
        path.write_bytes(whole[:length])
        with pytest.raises(FileFormatError):
            load(path)


def test_recordings_of_two_kinds_do_not_share_a_table(tmp_path):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    other = Recording(np.arange(2.0), q=np.zeros((2, 2)))
    with pytest.raises(ShapeError, match="differ from those"):
        write_parquet(tmp_path / "x.parquet", [study()[0], other])


def test_without_pyarrow_the_extra_is_named(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match="selfmotion\\[parquet\\]"):
        module.write_parquet(tmp_path / "x.parquet", study())
