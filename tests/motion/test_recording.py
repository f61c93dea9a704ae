"""Recordings and studies: what they refuse, and that they copy nothing."""

import re
from typing import Any

import numpy as np
import pytest

from selfmotion.errors import NotFiniteError, RangeError, ShapeError, UnknownNameError
from selfmotion.motion import Frame, GapWarning, Labels, Recording, Study, sample_numbers

K, M, N = 6, 2, 3


def arrays(seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    q, qd, jacobian = rng.normal(size=(K, N)), rng.normal(size=(K, N)), rng.normal(size=(K, M, N))
    xd = np.einsum("kij,kj->ki", jacobian, qd)
    return {"q": q, "qd": qd, "jacobian": jacobian, "xd": xd, "x": xd + 1}


def recording(**changes: Any) -> Recording:
    fields: dict[str, Any] = {"time": np.arange(K) / 10.0} | arrays() | changes
    return Recording(**fields)


def test_arrays_are_read_only_views():
    given = arrays()
    rec = recording(**given)
    for name, array in given.items():
        assert np.shares_memory(rec.array(name), array)
        assert array.flags.writeable  # the caller's own array stays as it was
        with pytest.raises(ValueError, match="read-only"):
            rec.array(name)[0] = 1.0
    assert (rec.n_samples, rec.n_joints, rec.n_rows, rec.rate) == (K, N, M, 10.0)
    assert rec.rows == ("x", "y") and rec.held == ("q", "qd", "x", "xd", "jacobian")


def test_windows_and_selections_share_memory():
    rec = recording()
    part = rec.window(2, 5)
    assert part.n_samples == 3 and part.time[0] == pytest.approx(0.2)
    for name in rec.held:
        assert np.shares_memory(part.array(name), rec.array(name))
    study = Study((rec, part))
    grouped = study.group("subject")[(None,)]
    assert np.shares_memory(grouped[1].array("jacobian"), rec.array("jacobian"))


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"time": np.arange(K + 1.0)}, ShapeError, f"q: expected shape ({K + 1}, {N})"),
        ({"time": np.zeros((K, 1))}, ShapeError, "time: expected 1 dimension"),
        ({"time": [0, 1, 2, 2, 3, 4]}, RangeError, "time[3] = 2 after 2"),
        ({"time": [0, 1, np.nan, 2, 3, 4]}, NotFiniteError, "time[2] = nan"),
        ({"time": []}, ShapeError, "0 samples"),
        ({"qd": np.zeros((K, N + 1))}, ShapeError, f"qd: expected shape ({K}, {N})"),
        ({"jacobian": np.zeros((K, M, N + 1))}, ShapeError, "jacobian: expected shape"),
        ({"xd": np.zeros((K, M + 1))}, ShapeError, f"xd: expected shape ({K}, {M})"),
        ({"q": None, "qd": None, "x": None}, ShapeError, "q, or qd with jacobian, or x"),
        ({"q": np.full((K, N), np.inf)}, NotFiniteError, "q[0, 0] = inf"),
        ({"q": [["a"] * N] * K}, ShapeError, "q: expected real numbers"),
        ({"joints": ("a", "b")}, ShapeError, "joints: 2 names for 3 joints"),
        ({"joints": ("a", "b", "a")}, ShapeError, "joints: a named more than once"),
        ({"rows": ("x", "x")}, ShapeError, "rows: x named more than once"),
    ],
)
def test_refused(changes, error, message):
    with pytest.raises(error, match=re.escape(message)) as raised:
        recording(**changes)
    assert "\n" not in str(raised.value)


def test_an_infinite_value_is_found_beyond_the_first_chunk():
    q = np.zeros((70_000, 1))
    q[69_000] = -np.inf
    with pytest.raises(NotFiniteError, match=re.escape("q[69000, 0] = -inf")):
        Recording(sample_numbers(70_000), q=q, timed=False)


def test_without_seconds_nothing_is_per_second():
    rec = recording(time=sample_numbers(K), timed=False)
    assert rec.rate is None
    assert "sample" in rec.to_frame() and "time" not in rec.to_frame()
    assert np.isnan(Study((rec,)).index.duration[0])


@pytest.mark.parametrize("window", [(0, 0), (3, 2), (-1, 2), (0, K + 1)])
def test_bad_windows(window):
    with pytest.raises(RangeError, match=f"{window[0]}:{window[1]}"):
        recording().window(*window)


def test_missing_fields_are_named():
    rec = Recording(np.arange(3.0), q=np.zeros((3, 1)), source="walk.npz")
    with pytest.raises(ShapeError, match=r"walk.npz: jacobian is needed; it holds q"):
        rec.array("jacobian")
    with pytest.raises(UnknownNameError, match="did you mean 'jacobian'"):
        rec.array("jacobians")


def test_gaps_are_dropped_and_counted():
    given = arrays()
    given["q"][1] = np.nan
    given["jacobian"][[1, 4]] = np.nan
    rec = recording(**given)
    assert np.flatnonzero(rec.gaps()).tolist() == [1, 4]
    with pytest.warns(GapWarning, match="2 of 6 samples hold NaN"):
        kept, dropped = rec.drop_gaps()
    assert dropped == 2 and kept.time.tolist() == [0.0, 0.2, 0.3, 0.5]
    assert kept.drop_gaps() == (kept, 0)
    with pytest.warns(GapWarning, match="2 of 12 samples") as seen:
        study, dropped = Study((rec, recording())).drop_gaps()
    assert len(seen) == 1 and dropped == 2 and study.n_samples == 10


def test_nothing_but_gaps_is_refused():
    with pytest.raises(NotFiniteError, match="all 6 samples hold NaN"):
        recording(q=np.full((K, N), np.nan)).drop_gaps()


def test_xarray_and_frame():
    labels = Labels(subject="P1", trial="3")
    rec = recording(labels=labels, joints=("a", "b", "c"), frame=Frame(up="y", forward="x"))
    data = rec.to_xarray()
    assert dict(data.sizes) == {"time": K, "axis": M, "joint": N}
    np.testing.assert_allclose((data.jacobian * data.qd).sum("joint"), data.xd)
    assert data.attrs["subject"] == "P1" and data.attrs["frame_up"] == "y"
    assert "side" not in data.attrs
    table = rec.to_frame()
    assert list(table)[:4] == ["subject", "trial", "time", "a"]
    np.testing.assert_array_equal(table["b_velocity"], rec.array("qd")[:, 1])
    np.testing.assert_array_equal(table["hand_y"], rec.array("x")[:, 1])


def people() -> Study:
    return Study(
        tuple(
            recording(labels=Labels(subject=s, condition=c, trial=str(t)))
            for s in ("P1", "P2")
            for c in ("natural", "viscous")
            for t in range(2)
        )
    )


def test_study_selects_groups_and_indexes():
    study = people()
    assert len(study) == 8 and study.n_samples == 48
    assert len(study.select(subject="P1", condition=("natural", "viscous"))) == 4
    groups = study.group("condition", "subject")
    assert list(groups)[0] == ("natural", "P1") and {len(g) for g in groups.values()} == {2}
    assert study.group()[()].recordings == study.recordings
    assert list(study.index.columns)[:5] == ["subject", "side", "condition", "target", "trial"]
    assert study.index.duration.tolist() == [pytest.approx(0.5)] * 8
    assert study.values("subject") == ("P1", "P2")


def test_study_refuses():
    with pytest.raises(UnknownNameError, match="unknown condition 'viscuos'; did you mean"):
        people().select(condition="viscuos")
    with pytest.raises(UnknownNameError, match="unknown label"):
        people().group("person")
    with pytest.raises(ShapeError, match="0 recordings"):
        Study(())
    mixed = Study((recording(), recording(joints=("a", "b", "c"))))
    with pytest.raises(ShapeError, match="joints a, b, c differ from"):
        _ = mixed.joints
    apart = Study((*people().recordings, recording(labels=Labels(subject="P9"))))
    with pytest.raises(RangeError, match="no recording has subject 'P9', condition 'natural'"):
        apart.select(subject="P9", condition="natural")


def test_frames_turn_into_each_other():
    z_up, y_up = Frame(up="z", forward="y"), Frame(up="y", forward="x")
    R = y_up.rotation_to(z_up)
    np.testing.assert_array_equal(R @ [1, 0, 0], [0, 1, 0])  # forward stays forward
    np.testing.assert_array_equal(R @ [0, 0, 1], [1, 0, 0])  # z is right where y is up
    np.testing.assert_array_equal(R @ z_up.rotation_to(y_up), np.eye(3))
    assert np.linalg.det(Frame(up="-z", forward="x").rotation_to(z_up)) == pytest.approx(1.0)
    with pytest.raises(RangeError, match="not known"):
        Frame(up=None).rotation_to(z_up)
    with pytest.raises(RangeError, match="perpendicular"):
        Frame(up="z", forward="-z")
    with pytest.raises(RangeError, match="allowed is one of"):
        Frame(up="w")
