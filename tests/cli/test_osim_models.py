"""The commands on a user's own .osim; they need the extra `opensim`."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.muscles.static_optimization import muscle_effort
from tests.cli.running import Capture, answered, refused, written
from tests.muscles.osim_models import small_arm

osim = pytest.importorskip("opensim", reason="needs the extra: pip install 'selfmotion[opensim]'")

REFERENCE = Path(__file__).parents[3] / "shared" / "data" / "memikrr"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "small.osim"
    small_arm(osim, path)
    return path


@pytest.fixture(scope="module")
def reference() -> Path:
    path = REFERENCE / "Model_Scaled_LQL.osim"
    if not path.is_file():
        pytest.skip("the reference model is not at hand")
    return path


def test_effort_of_an_osim_has_the_convention_of_opensim(
    small: Path, tmp_path: Path, capsys: Capture
) -> None:
    from selfmotion.muscles.opensim_bridge import read_osim

    file = written(tmp_path / "q.csv", "shoulder_angle,elbow_angle_deg\n0.4,40\n0.2,60\n")
    document = answered(capsys, "effort", file, "--model", small)
    assert document["convention"] == "opensim"
    assert document["coordinates"] == ["shoulder_angle", "elbow_angle"]
    q = [[0.4, np.deg2rad(40.0)], [0.2, np.deg2rad(60.0)]]
    wanted = muscle_effort(read_osim(small), q)
    for k, posture in enumerate(document["postures"]):
        assert posture["effort"] == pytest.approx(wanted.effort[k], rel=1e-9)
        activations = np.array(list(posture["activations"].values()))
        assert activations.min() >= 0.01 - 1e-12  # the lower bound of that convention


def test_the_plain_convention_lets_muscles_rest(
    small: Path, tmp_path: Path, capsys: Capture
) -> None:
    file = written(tmp_path / "q.csv", "shoulder_angle,elbow_angle\n0.4,0.7\n")
    document = answered(capsys, "effort", file, "--model", small, "--convention", "plain")
    assert document["convention"] == "plain"
    assert min(document["postures"][0]["activations"].values()) < 0.01


def test_an_arm_without_seven_coordinates_has_no_natural_posture(
    small: Path, tmp_path: Path, capsys: Capture
) -> None:
    file = written(tmp_path / "p.csv", "id,qx,qy,qz,qw,x,y,z\n1,0,0,0,1,0.2,0.1,0\n")
    line = refused(capsys, "posture", file, "--model", small)
    assert "2 free coordinates; a swivel needs 7" in line


@pytest.mark.parametrize("on_jump", ["keep", "exclude"])
def test_a_posture_of_the_reference_model(
    reference: Path, tmp_path: Path, capsys: Capture, on_jump: str
) -> None:
    row = np.loadtxt(REFERENCE / "wrist_poses_001_060.txt", max_rows=1)
    row[1:5] /= np.linalg.norm(row[1:5])
    file = written(tmp_path / "p.txt", " ".join(repr(float(v)) for v in row) + "\n")
    words = ("posture", file, "--model", reference, "--on-jump", on_jump)
    pose = answered(capsys, *words)["poses"][0]
    assert not pose["failed"]
    assert set(pose["q"]) == {
        "elv_angle", "shoulder_elv", "shoulder_rot", "elbow_flexion", "pro_sup", "deviation",
        "flexion",
    }  # fmt: skip
    assert pose["minima"][0]["effort"] == pytest.approx(pose["effort"], rel=1e-6)
