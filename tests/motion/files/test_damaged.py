"""Damaged files, bounded: a SelfmotionError, or a result of the right shape; nothing else."""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.motion.c3d_files import written

from selfmotion.errors import SelfmotionError
from selfmotion.motion import Frame, Labels, Recording
from selfmotion.motion.files import load, load_markers
from selfmotion.motion.files.bids_writer import write_bids
from selfmotion.motion.files.c3d import read_c3d
from selfmotion.motion.files.describe import describe
from selfmotion.motion.files.orientation import read_orientations
from selfmotion.motion.files.storage import write_mot
from selfmotion.motion.files.trc import write_trc
from selfmotion.motion.markers import MarkerSet

BOUNDED = settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
K = 6
WHO = Labels(subject="01", condition="reach")
# What breaks parsers: separators, signs, numbers that are none, huge ones, other alphabets.
PIECES = ["\t", ",", ";", "\n", "\r\n", "\0", "-", ".", "nan", "inf", "1e400", "1e51", "9" * 40]
PIECES += [
    "é",
    "\ufeff",
    '"',
    "#",
    "Frame#",
    "endheader",
    "X1",
    "=",
    "n/a",
    "{}",
    "",
    "１",
    "0x1p4",
]


def text_files(folder: Path) -> list[Path]:
    rng = np.random.default_rng(0)
    seen = MarkerSet(
        np.arange(K) / 100, ("A", "B"), rng.normal(size=(K, 2, 3)), Frame("z", "y"), WHO
    )
    bent = Recording(np.arange(K) / 100, q=rng.normal(size=(K, 3)), labels=WHO)
    (folder / "turn.csv").write_text("time,qx,qy,qz,qw\n" + "".join(
        f"0.0{i},0,0,{np.sin(i):.6f},{np.cos(i):.6f}\n" for i in range(K)
    ))  # fmt: skip
    (folder / "turn.sto").write_text("DataType=Quaternion\nendheader\ntime\ta\tb\n" + "".join(
        f"0.0{i}\t1,0,0,0\t0,1,0,0\n" for i in range(K)
    ))  # fmt: skip
    marked, bids = write_bids(folder / "m", seen), write_bids(folder / "b", bent)
    beside = [p.with_name(p.name.replace("_motion", "_channels")) for p in (marked, bids)]
    return [
        write_trc(folder / "x.trc", seen),
        write_mot(folder / "x.mot", bent, unit="deg"),
        folder / "turn.csv",
        folder / "turn.sto",
        marked,
        bids,
        *beside,
        marked.with_name(marked.name.replace("_motion.tsv", "_channels.json")),
        marked.with_suffix(".json"),
    ]


def read_all(path: Path) -> None:
    """Read a file in every way; whatever comes out must hold together."""
    stem = path.name.replace("_channels.tsv", "_motion.tsv").replace(
        "_channels.json", "_motion.tsv"
    )
    path = path.with_name(stem.replace("_motion.json", "_motion.tsv"))
    for reader in (load, load_markers, read_orientations, describe):
        try:
            found: Any = reader(path)
        except SelfmotionError as error:
            assert "\n" not in str(error) and str(path.parent) in str(error)
            continue
        if reader is load_markers:
            assert found.positions.shape == (len(found.time), len(found.names), 3)
        elif reader is load:
            for recording in found:
                assert recording.array("q").shape == (recording.n_samples, recording.n_joints)
        elif reader is read_orientations:
            assert all(o.matrices.shape == (o.n_samples, 3, 3) for o in found)
        else:
            assert found.samples > 0 and found.names


@BOUNDED
@given(data=st.data())
@pytest.mark.parametrize("number", range(10))
def test_damaged_text_never_raises_anything_else(tmp_path, number, data):
    path = text_files(tmp_path)[number]
    content = path.read_text()
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(content)))
        gone = data.draw(st.sampled_from([0, 1, 1, 5, len(content)]))
        piece = data.draw(st.one_of(st.sampled_from(PIECES), st.text(max_size=3)))
        content = content[:at] + piece + content[at + gone :]
    path.write_bytes(content.encode("utf-8", "surrogatepass"))
    read_all(path)


@BOUNDED
@given(data=st.data())
@pytest.mark.parametrize("number", range(4))
def test_damaged_bytes_never_raise_anything_else(tmp_path, number, data):
    path = text_files(tmp_path)[number]
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    read_all(path)


def whole_markers(path: Path) -> bool:
    seen = read_c3d(path)
    return seen.positions.shape == (len(seen.time), len(seen.names), 3)


def whole_angles(path: Path) -> bool:
    return all(r.array("q").shape == (r.n_samples, r.n_joints) for r in load(path))


def outcome_of_reading(path: Path, read: Callable[[Path], bool] = whole_markers) -> str:
    """Read in a child process, so that a crash of the C++ library is an outcome like another."""
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        try:
            os._exit(0 if read(path) else 2)
        except SelfmotionError:
            os._exit(0)
        except BaseException:
            os._exit(3)
    return str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))


@pytest.mark.skipif(sys.platform == "win32", reason="needs fork")
@settings(BOUNDED, max_examples=80)
@given(data=st.data())
def test_damaged_c3d_never_ends_the_process(tmp_path, data):
    path, _ = written(tmp_path, screen="+Z", analog=2)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        where = st.one_of(st.integers(0, 24), st.integers(512, 1600))
        value = st.one_of(st.sampled_from([0, 1, 127, 128, 255]), st.integers(0, 255))
        content[data.draw(where) % len(content)] = data.draw(value)
    path.write_bytes(content)
    assert outcome_of_reading(path) == "0"


@pytest.mark.skipif(sys.platform == "win32", reason="needs fork")
@settings(BOUNDED, max_examples=40)
@given(data=st.data())
def test_damaged_parquet_never_ends_the_process(tmp_path, data):
    pytest.importorskip("pyarrow")
    from selfmotion.motion.files.parquet import write_parquet

    rng = np.random.default_rng(0)
    bent = Recording(np.arange(K) / 100, q=rng.normal(size=(K, 3)), labels=WHO)
    path = write_parquet(tmp_path / "x.parquet", [bent])
    assert outcome_of_reading(path, whole_angles) == "0"
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(len(content) // 2, len(content)))])
    assert outcome_of_reading(path, whole_angles) == "0"
