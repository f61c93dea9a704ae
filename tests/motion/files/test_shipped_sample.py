"""examples/sample: every file reads to the same motion, and the script writes it anew."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.cli.app import main
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.motion.files import load, load_markers
from selfmotion.motion.files.bids import read_bids
from selfmotion.motion.files.orientation import read_orientations

EXAMPLES = Path(__file__).parents[3] / "examples"
SAMPLE = EXAMPLES / "sample"
SYSTEM = "bids/sub-P1_task-drink_tracksys-{}_run-1_motion.tsv"
MARKERS = ("drink.c3d", "drink.trc", "drink_vicon.csv", SYSTEM.format("markers"))
ANGLES = (
    *("drink_angles.csv", "drink.mot", "drink.sto", "drink.npz", "drink.mat", "drink.parquet"),
    SYSTEM.format("angles"),
)
HANDS = ("drink_hand.csv", "drink_hand.npz")
# C3D holds 32-bit millimetres; quaternions are written with nine digits.
SINGLE, NINE_DIGITS = 1e-7, 2e-9
# Markers that carry no noise but are rounded to a hundredth of a millimetre; skin does not slide.
RECOVERED = np.deg2rad(2.0)


def markers_of(folder: Path, name: str):
    path = folder / name
    if name.endswith("_motion.tsv"):
        found = read_bids(path).markers
        assert found is not None
        return found
    return load_markers(path)


def angles_of(folder: Path, name: str):
    if name.endswith(".parquet"):
        pytest.importorskip("pyarrow", reason="extra `parquet` is not installed")
    (recording,) = load(folder / name)
    return recording


@pytest.mark.parametrize("name", MARKERS)
def test_markers_are_the_same_in_every_format(name: str) -> None:
    found, wanted = markers_of(SAMPLE, name), markers_of(SAMPLE, "drink.trc")
    assert found.names == wanted.names and found.rate == pytest.approx(50.0)
    np.testing.assert_allclose(found.time, wanted.time, atol=1e-9)
    np.testing.assert_allclose(found.positions, wanted.positions, atol=SINGLE)


@pytest.mark.parametrize("name", ANGLES)
def test_angles_are_the_same_in_every_format(name: str) -> None:
    found, wanted = angles_of(SAMPLE, name), angles_of(SAMPLE, "drink_angles.csv")
    assert found.joints == wanted.joints and found.rate == pytest.approx(50.0)
    np.testing.assert_allclose(found.array("q"), wanted.array("q"), atol=1e-12)


@pytest.mark.parametrize("name", HANDS)
def test_the_hand_is_turned_as_the_angles_say(name: str) -> None:
    (hand,) = read_orientations(SAMPLE / name)
    arm = load_arm("upper_limb_anatomical")
    q = angles_of(SAMPLE, "drink_angles.csv").array("q")
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    np.testing.assert_allclose(hand.matrices, T[:, :3, :3], atol=NINE_DIGITS)


def test_angles_from_the_markers_are_those_of_the_angle_files(tmp_path: Path, capsys) -> None:
    words = ["angles", SAMPLE / "drink.c3d", "--static", SAMPLE / "static.trc", "--out", tmp_path]
    words += ["--arm", "upper_limb_anatomical", "--side", "right", "--up", "z", "--forward", "y"]
    assert main([*map(str, words)]) == 0
    capsys.readouterr()
    (found,) = load(next(tmp_path.glob("*.mot")))
    wanted = angles_of(SAMPLE, "drink_angles.csv")
    apart = found.array("q") - wanted.array("q")
    assert np.sqrt((apart**2).mean()) < RECOVERED


def test_validate_passes_every_file(capsys) -> None:
    pytest.importorskip("pyarrow", reason="extra `parquet` is not installed")
    assert main(["validate", *map(str, sorted(SAMPLE.iterdir()))]) == 0
    said = capsys.readouterr().out
    kept = [*MARKERS, *ANGLES, *HANDS, "static.trc"]
    assert all(str(SAMPLE / name) in said for name in kept) and "REFUSED" not in said
    everything = {p for p in SAMPLE.rglob("*") if p.is_file()}
    beside = {p for p in everything if p.name.endswith((".md", ".json", "_channels.tsv"))}
    assert {SAMPLE / name for name in kept} == everything - beside


def test_the_sample_is_small() -> None:
    assert sum(p.stat().st_size for p in SAMPLE.rglob("*") if p.is_file()) < 1_000_000


def test_the_script_writes_what_is_shipped(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="extra `parquet` is not installed")
    runpy.run_path(str(EXAMPLES / "make_sample.py"))["main"](tmp_path)
    for name in MARKERS:
        now, then = (markers_of(folder, name) for folder in (tmp_path, SAMPLE))
        np.testing.assert_allclose(now.positions, then.positions, atol=1e-12)
    for name in ANGLES:
        now, then = (angles_of(folder, name).array("q") for folder in (tmp_path, SAMPLE))
        np.testing.assert_allclose(now, then, atol=1e-12)
