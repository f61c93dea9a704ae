from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from selfmotion.arms import wrist
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.elasticity.posture import donders_postures
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.redundancy.task import Pointing
from tests.cli.golden import ROOT
from tests.cli.running import Capture, answered, refused, written

POSTURES = ROOT / "examples" / "wrist_postures.csv"
STIFFNESS, REST = np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0])
PRIOR = "stiffness = [0.5, 1.5, 2.0]\nstiffness_sd = 0.01\nrest_deg = [5, 0, 0]\nrest_sd_deg = 1\n"


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    """Postures of a known law, without noise."""
    angles = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    targets = np.concatenate([r * circle for r in (0.15, 0.3, 0.45)])
    return donders_postures(Pointing(wrist()), JointLaw(STIFFNESS, REST), targets).q


def test_the_law_of_the_example_is_found_within_its_errors(capsys: Capture) -> None:
    found = answered(capsys, "donders", POSTURES)
    K, K_error = np.array(found["stiffness"]), np.array(found["stderr"]["stiffness"])
    assert (np.abs(K - STIFFNESS) < 4 * K_error).all()
    assert (np.abs(found["rest"] - REST) < 4 * np.array(found["stderr"]["rest"])).all()
    assert np.trace(K) == pytest.approx(4.0)
    assert found["thickness_deg"] == pytest.approx(0.5, abs=0.25)
    assert found["surface"]["thickness_deg"] == pytest.approx(0.5, abs=0.25)


@pytest.mark.parametrize("form", ["quaternions", "matrices", "rotation vectors"])
def test_orientations_give_what_angles_give(
    exact: np.ndarray, form: str, tmp_path: Path, capsys: Capture
) -> None:
    arm = wrist()
    turns = Rotation.from_matrix(forward_kinematics(arm.chain, exact, arm.tip("hand"))[:, :3, :3])
    names, values = {
        "quaternions": ("qx,qy,qz,qw", turns.as_quat()),
        "matrices": ("r11,r12,r13,r21,r22,r23,r31,r32,r33", turns.as_matrix().reshape(-1, 9)),
        "rotation vectors": ("rx,ry,rz", turns.as_rotvec()),
    }[form]
    text = "\n".join(",".join(map(repr, row)) for row in values.round(8).tolist())
    found = answered(capsys, "donders", written(tmp_path / "r.csv", f"{names}\n{text}\n"))
    assert found["form"] == form
    np.testing.assert_allclose(found["stiffness"], STIFFNESS, atol=1e-5)
    np.testing.assert_allclose(found["rest"], REST, atol=1e-5)


def test_arrays_of_an_npz_are_read(exact: np.ndarray, tmp_path: Path, capsys: Capture) -> None:
    np.savez(tmp_path / "q.npz", q=exact.round(8))
    found = answered(capsys, "donders", tmp_path / "q.npz")
    np.testing.assert_allclose(found["stiffness"], STIFFNESS, atol=1e-6)


def test_a_prior_is_used_and_named(tmp_path: Path, capsys: Capture) -> None:
    prior = written(tmp_path / "prior.toml", PRIOR)
    found = answered(capsys, "donders", POSTURES, "--prior", prior)
    assert found["prior"] == "prior.toml"
    without = answered(capsys, "donders", POSTURES)
    assert found["stderr"]["stiffness"][0][0] < without["stderr"]["stiffness"][0][0]


def test_the_law_written_is_one_that_plan_reads(tmp_path: Path, capsys: Capture) -> None:
    found = answered(capsys, "donders", POSTURES, "--out", tmp_path)
    words = ("plan", "--arm", "wrist", "--center-out", "--steps", "5")
    planned = answered(capsys, *words, "--law", tmp_path / "law.toml")
    assert planned["stiffness"] == found["stiffness"]
    assert planned["rest"] == found["rest"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("pronation,flexion,deviation\n0,0,nan\n0,0,0\n", "row 2, column deviation: 'nan'"),
        ("pronation,flexion\n0,0\n", "no column deviation"),
        ("a,b\n0,0\n", "0 forms of posture in it; one is needed"),
        ("pronation,flexion,deviation\n0,0,0\n", "are too few"),
        ("qx,qy,qz,qw\n0,0,0,1\n0,0,0,2\n", "row 3, columns qx to qw: a quaternion of length 2"),
        ("pronation,flexion,deviation\n0,30,0\n", "column flexion: '30' is beyond 2 pi rad"),
    ],
)
def test_bad_postures_are_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    assert reason in refused(capsys, "donders", written(tmp_path / "q.csv", text))


def test_postures_along_one_line_are_refused(tmp_path: Path, capsys: Capture) -> None:
    text = "pronation,flexion,deviation\n" + "".join(f"0,{0.01 * i},0\n" for i in range(20))
    assert "along one line" in refused(capsys, "donders", written(tmp_path / "q.csv", text))


def test_bad_arrays_are_one_line(tmp_path: Path, capsys: Capture) -> None:
    np.savez(tmp_path / "p.npz", postures=np.zeros((3, 3)))
    assert "(there are: postures)" in refused(capsys, "donders", tmp_path / "p.npz")
    np.savez(tmp_path / "n.npz", q=[[0.0, np.nan, 0.0]])
    assert "q[0, 1] is no finite number" in refused(capsys, "donders", tmp_path / "n.npz")
    assert "no .npz of arrays" in refused(capsys, "donders", written(tmp_path / "t.npz", "text"))


def test_angles_may_be_stated_to_be_degrees(tmp_path: Path, capsys: Capture) -> None:
    lines = Path(POSTURES).read_text().splitlines()
    header = lines[0].split(",")
    cells = np.array([line.split(",") for line in lines[1:]])
    angles = [header.index(f"{joint}_deg") for joint in ("pronation", "flexion", "deviation")]
    degrees = cells[:, angles].astype(float)
    np.savez(tmp_path / "deg.npz", q=degrees)
    rows = [",".join(map(repr, row)) for row in degrees.tolist()]
    text = "\n".join(["pronation,flexion,deviation", *rows]) + "\n"
    wanted = answered(capsys, "donders", POSTURES)["rest"]
    for file in (tmp_path / "deg.npz", written(tmp_path / "deg.csv", text)):
        found = answered(capsys, "donders", file, "--angle-unit", "deg")
        np.testing.assert_allclose(found["rest"], wanted, atol=1e-6)
    named = written(tmp_path / "named.csv", text.replace("flexion,", "flexion_deg,", 1))
    assert "flexion_deg names its unit" in refused(capsys, "donders", named, "--angle-unit", "rad")
    np.savez(tmp_path / "q.npz", quaternions=np.tile([0.0, 0.0, 0.0, 1.0], (5, 1)))
    line = refused(capsys, "donders", tmp_path / "q.npz", "--angle-unit", "deg")
    assert "holds quaternions, which have none" in line


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("stiffness = [1, 1\n", "no TOML"),
        (PRIOR + "stifness = 1\n", "unknown field 'stifness'"),
        (PRIOR.replace("stiffness_sd = 0.01\n", ""), "stiffness_sd is missing"),
        (PRIOR.replace("= 0.01", "= 0"), "every standard deviation must be above 0"),
        (PRIOR.replace("[5, 0, 0]", "[5, 0]"), "rest_deg: 3 numbers are expected"),
        (PRIOR.replace("0.01", "'soft'"), "stiffness_sd"),
    ],
)
def test_a_bad_prior_is_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    prior = written(tmp_path / "prior.toml", text)
    line = refused(capsys, "donders", POSTURES, "--prior", prior)
    assert reason in line
    assert str(prior) in line


def test_the_surface_of_another_segment(tmp_path: Path, capsys: Capture) -> None:
    """Upper-arm orientations about y, torsion 0.3 a b exactly, in any form, from any reference."""
    a, b = (g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 7), np.linspace(-0.4, 0.4, 7)))
    turns = Rotation.from_rotvec(np.stack([a, 0.3 * a * b, b], axis=1))
    there = Rotation.from_rotvec([0.3, -1.2, 0.7]) * turns
    files = {"quaternions": there.as_quat(), "matrices": there.as_matrix()}
    for name, values in files.items():
        np.savez(tmp_path / f"{name}.npz", **{name: values})
        found = answered(capsys, "donders", tmp_path / f"{name}.npz", "--axis", "0,1,0")
        assert found["orientations"] == 49
        # The mean of the orientations is where a = b = 0 was: the surface is symmetric there.
        assert found["thickness_deg"] < 0.02
        assert np.abs(found["coefficients"]).max() == pytest.approx(0.3, abs=0.01)
        assert found["torsion_deg"] > 1.0


@pytest.mark.parametrize("axis", ["0,0,0", "1,2", "a,b,c", "inf,0,0"])
def test_a_bad_axis_is_one_line(capsys: Capture, axis: str) -> None:
    line = refused(capsys, "donders", POSTURES, "--axis", axis)
    assert "--axis" in line


def test_what_belongs_to_studies_is_said(tmp_path: Path, capsys: Capture) -> None:
    postures = POSTURES
    assert "needs --study" in refused(capsys, "donders", tmp_path)
    assert "one at a time" in refused(capsys, "donders", postures, postures)
    assert "--report" in refused(capsys, "donders", postures, "--report", tmp_path / "r.html")
    study = tmp_path / "study.toml"
    study.write_text("pattern = '(?P<subject>x).csv'\nstatic = 's.csv'\n")
    assert "no such folder" in refused(capsys, "donders", tmp_path / "no", "--study", study)
    assert "no file is named" in refused(capsys, "donders", tmp_path, "--study", study)
