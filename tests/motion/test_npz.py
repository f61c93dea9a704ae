"""The .npz format: round trips, views, one-line errors, and damaged files."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from selfmotion.errors import FileFormatError, SelfmotionError
from selfmotion.motion import Frame, Labels, Recording, Study
from selfmotion.motion.files import load
from selfmotion.motion.files.npz import read_npz, write_npz

K, M, N = 12, 3, 4
# The folder is shared by all examples of a test: each overwrites its one file.
BOUNDED = settings(
    deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def fields(**changes: Any) -> dict[str, Any]:
    rng = np.random.default_rng(5)
    qd, jacobian = rng.normal(size=(K, N)), rng.normal(size=(K, M, N))
    out: dict[str, Any] = {"qd": qd, "jacobian": jacobian}
    out["xd"] = np.einsum("kij,kj->ki", jacobian, qd)
    out |= changes
    return {name: value for name, value in out.items() if value is not None}


def saved(tmp_path: Path, **changes: Any) -> Path:
    path = tmp_path / "reach.npz"
    np.savez(path, **fields(**changes))
    return path


def people() -> Study:
    recordings = []
    for i, (subject, condition) in enumerate([("P1", "a"), ("P1", "b"), ("P2", "a"), ("P2", "a")]):
        given = fields()
        recordings.append(
            Recording(
                np.arange(K) / 50 + i,
                q=given["qd"] * (i + 1),
                **given,
                joints=("s1", "s2", "s3", "elbow"),
                labels=Labels(subject=subject, condition=condition, target="1" if i else None),
                frame=Frame(up="y", forward="x", name="file"),
                source="x.npz",
            )
        )
    return Study(tuple(recordings))


def test_round_trip_keeps_everything(tmp_path):
    study = people()  # the last two carry the same labels and must stay two
    path = write_npz(tmp_path / "x.npz", study)
    back = read_npz(path)
    assert len(back) == 4
    for ours, theirs in zip(study, back, strict=True):
        assert (theirs.labels, theirs.joints, theirs.rows) == (ours.labels, ours.joints, ours.rows)
        assert theirs.frame == ours.frame and theirs.timed and theirs.source == str(path)
        for name in ("time", *ours.held):
            np.testing.assert_array_equal(getattr(theirs, name), getattr(ours, name))


def test_the_contract_alone_is_enough(tmp_path):
    study = read_npz(saved(tmp_path, trial=[1] * 5 + [2] * 7))
    assert [r.n_samples for r in study] == [5, 7]
    assert [r.labels.trial for r in study] == ["1", "2"]
    assert not study[0].timed and study[0].rate is None
    assert study.joints == ("joint_1", "joint_2", "joint_3", "joint_4")


def test_trials_are_views_of_one_array(tmp_path):
    study = load(saved(tmp_path, trial=np.repeat([1.0, 2.0, 3.0], 4)))
    first, last = study[0].array("jacobian"), study[2].array("jacobian")
    assert first.base is not None and np.shares_memory(first.base, last.base)


def test_scattered_samples_of_a_trial_come_together(tmp_path):
    study = read_npz(saved(tmp_path, trial=["a", "b"] * (K // 2)))
    assert [r.labels.trial for r in study] == ["a", "b"]
    np.testing.assert_array_equal(study[1].array("qd"), fields()["qd"][1::2])


def test_labels_of_several_kinds(tmp_path):
    study = read_npz(
        saved(
            tmp_path, trial=np.repeat([1, 2, 1, 2], 3), target=[b"N"] * 6 + [b""] * 6, subject="P7"
        )
    )
    assert [(r.labels.subject, r.labels.target, r.labels.trial) for r in study] == [
        ("P7", "N", "1"), ("P7", "N", "2"), ("P7", None, "1"), ("P7", None, "2"),
    ]  # fmt: skip


def test_dt_restarts_with_each_trial(tmp_path):
    study = read_npz(saved(tmp_path, dt=0.01, trial=np.repeat([1, 2], 6)))
    assert [r.rate for r in study] == [pytest.approx(100.0)] * 2
    assert study[1].time[0] == 0.0


def test_gaps_are_kept_for_the_caller_to_drop(tmp_path):
    given = fields()
    given["qd"][3:5] = np.nan
    assert int(read_npz(saved(tmp_path, **given))[0].gaps().sum()) == 2


def hole(name: str, where: tuple[int, ...], value: float) -> dict[str, Any]:
    array = fields()[name].copy()
    array[where] = value
    return {name: array}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (hole("qd", (3, 1), np.nan), "qd[3, 1] = nan"),
        (hole("jacobian", (2, 0, 3), np.nan), "jacobian[2, 0, 3] = nan"),
        (hole("jacobian", (2, 0, 3), np.inf), "jacobian[2, 0, 3] = inf"),
        ({"qd": np.zeros((K + 1, N))}, "xd has shape (12, 3): 13 samples are needed"),
        ({"qd": np.zeros((K, N + 1))}, "jacobian: expected shape (12, 3, 5), found (12, 3, 4)"),
        ({"qd": np.zeros(K)}, "qd: expected 2 dimension(s)"),
        ({"jacobian": np.zeros((M, N))}, "jacobian: expected 3 dimension(s)"),
        ({"xd": 2 * fields()["xd"]}, "xd differs from jacobian @ qd by 50 % of its size"),
        ({"xd": fields()["xd"][:, :2]}, "jacobian: expected shape (12, 2, 4)"),
        ({"jacobian": None, "xd": None}, "qd with jacobian, or q, or x is needed; it holds qd"),
        ({"qd": None, "qdot": fields()["qd"]}, "qd with jacobian"),
        ({"xd": None, "XD": fields()["xd"]}, "unknown field 'XD'; did you mean 'xd'?"),
        ({"trial": [1, 2, 3]}, "trial has shape (3,): one value or (12,) is needed"),
        ({"trial": np.arange(K) + 0.5}, "trial = 0.5: allowed is text or a whole number"),
        ({"trial": np.full(K, np.nan)}, "trial = nan: allowed is text or a whole number"),
        ({"trial": np.full(K, 1j)}, "trial: expected text or whole numbers"),
        ({"time": np.zeros(K)}, "time[1] = 0 after 0: time must increase strictly"),
        ({"time": np.arange(K - 1.0)}, "time has shape (11,): (12,) is needed"),
        ({"time": np.full(K, np.nan)}, "time: 12 of 12 values are not finite"),
        ({"dt": -1.0}, "dt = [-1.]: one positive number"),
        ({"dt": [1.0, 2.0]}, "dt = [1. 2.]: one positive number"),
        ({"joints": ["a", "b"]}, "joints: 2 names for 4 joints"),
        ({"joints": [1, 2, 3, 4]}, "joints: expected text"),
        ({"frame_up": "w"}, "frame up = 'w': allowed is one of"),
        ({"qd": np.array([["a"] * N] * K)}, "qd: expected real numbers"),
        ({"qd": fields()["qd"] + 1j}, "qd: expected real numbers"),
        ({"qd": np.array([{}] * K)}, "qd holds Python objects"),
        ({k: v[:1] for k, v in fields().items()}, "has 1 sample(s): at least 2 are needed"),
        ({k: v[:0] for k, v in fields().items()}, "has 0 sample(s): at least 2 are needed"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_with_file_field_and_value(tmp_path, changes, message):
    path = saved(tmp_path, **changes)
    with pytest.raises(SelfmotionError, match=re.escape(message)) as raised:
        read_npz(path)
    assert str(raised.value).startswith(f"{path}: ") and "\n" not in str(raised.value)


def test_what_is_no_archive(tmp_path):
    bare = tmp_path / "bare.npz"
    with open(bare, "wb") as stream:
        np.save(stream, np.zeros(3))
    for path in (bare, tmp_path / "absent.npz", tmp_path):
        with pytest.raises(FileFormatError, match=re.escape(str(path))):
            read_npz(path)


def test_truncation_anywhere_is_one_line(tmp_path):
    whole = saved(tmp_path).read_bytes()
    cut = tmp_path / "cut.npz"
    for length in range(0, len(whole), 97):
        cut.write_bytes(whole[:length])
        with pytest.raises(SelfmotionError) as raised:
            read_npz(cut)
        assert "\n" not in str(raised.value)


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_damaged_bytes_never_raise_anything_else(tmp_path, data):
    path = saved(tmp_path, trial=np.repeat([1, 2], 6))
    damaged = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(damaged)
    try:
        read_npz(path)
    except SelfmotionError as error:
        assert "\n" not in str(error)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_arrays_of_any_shape_are_read_right_or_refused(tmp_path, data):
    """Whatever the shapes: either a study whose samples add up, or one line."""
    shape = st.lists(st.integers(0, 4), max_size=4).map(tuple)
    names = st.sampled_from(["q", "qd", "jacobian", "x", "xd", "time", "trial", "dt", "other"])
    given_ = data.draw(st.dictionaries(names, shape, min_size=1))
    path = tmp_path / "any.npz"
    arrays: dict[str, Any] = {n: np.arange(float(np.prod(s))).reshape(s) for n, s in given_.items()}
    np.savez(path, **arrays)
    try:
        study = read_npz(path)
    except SelfmotionError as error:
        assert "\n" not in str(error)
    else:
        for name in study[0].held:
            assert study.n_samples == len(arrays[name])


def test_differing_recordings_are_not_written(tmp_path):
    study = people()
    other = Recording(np.arange(3.0), q=np.zeros((3, 4)))
    with pytest.raises(SelfmotionError, match="one file holds one kind"):
        write_npz(tmp_path / "x.npz", [study[0], other])
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = write_npz(tmp_path / "kept.npz", people())
    old = path.read_bytes()

    def breaks(stream, **fields):
        stream.write(b"ne")
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez", breaks)
    with pytest.raises(KeyboardInterrupt):
        write_npz(path, people())
    assert path.read_bytes() == old and os.listdir(tmp_path) == ["kept.npz"]


def test_reading_npz_needs_no_heavy_package(tmp_path):
    code = (
        "import sys; from selfmotion.motion.files import load; load(sys.argv[1]);"
        "print([m for m in ('pandas', 'xarray', 'scipy', 'h5py', 'numba') if m in sys.modules])"
    )
    path = str(saved(tmp_path))
    out = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True)
    assert out.stdout.strip() == "[]", out.stderr
