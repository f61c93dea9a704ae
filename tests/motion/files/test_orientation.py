"""Orientations: forms by name, orders of quaternions, gaps, refusals, and the pointing path."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from selfmotion.arms import load_arm
from selfmotion.errors import FileFormatError, RangeError, ShapeError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.motion import Frame
from selfmotion.motion.files.orientation import read_orientations
from selfmotion.motion.orientations import Orientations, Screen
from selfmotion.redundancy.task import Pointing

TURNS = Rotation.from_rotvec(np.random.default_rng(2).normal(size=(5, 3)))
VECTORS = TURNS.as_rotvec()
QUATERNIONS = TURNS.as_quat()
MATRICES = TURNS.as_matrix()
R_NAMES = [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]


def csv(tmp_path, names, values, time=True):
    head = (["time"] if time else []) + list(names)
    rows = [
        ([repr(0.01 * i)] if time else []) + [repr(float(v)) for v in row]
        for i, row in enumerate(values)
    ]
    path = tmp_path / "x.csv"
    path.write_text("\n".join(",".join(cells) for cells in [head, *rows]) + "\n")
    return path


@pytest.mark.parametrize(
    ("names", "values"),
    [
        (["qx", "qy", "qz", "qw"], QUATERNIONS),
        (["qw", "qx", "qy", "qz"], QUATERNIONS[:, [3, 0, 1, 2]]),
        (["w", "x", "y", "z"], QUATERNIONS[:, [3, 0, 1, 2]]),
        (["x", "y", "z", "w"], QUATERNIONS),
        (["Quat_W", "Quat_X", "Quat_Y", "Quat_Z"], QUATERNIONS[:, [3, 0, 1, 2]]),
        (["qx", "qy", "qz", "qw"], -QUATERNIONS.round(3)),
        (R_NAMES, MATRICES.reshape(-1, 9)),
        (R_NAMES, MATRICES.reshape(-1, 9).round(3)),
        (["rx", "ry", "rz"], VECTORS),
        (["rx_deg", "ry_deg", "rz_deg"], np.degrees(VECTORS)),
        (["rx [deg]", "ry [deg]", "rz [deg]"], np.degrees(VECTORS)),
        (["rx (rad)", "ry (rad)", "rz (rad)"], VECTORS),
        (["rotvec_x", "rotvec_y", "rotvec_z"], VECTORS),
        ([*R_NAMES, "temperature"], np.c_[MATRICES.reshape(-1, 9), np.ones(5)]),
    ],
)
def test_every_form_gives_the_same_rotations(tmp_path, names, values):
    (found,) = read_orientations(csv(tmp_path, names, values))
    np.testing.assert_allclose(found.matrices, MATRICES, atol=2e-3)
    np.testing.assert_allclose(
        np.swapaxes(found.matrices, 1, 2) @ found.matrices, np.tile(np.eye(3), (5, 1, 1)),
        atol=1e-14,
    )  # fmt: skip
    assert found.rate == pytest.approx(100.0)


def test_conversions_agree_with_scipy():
    found = Orientations(np.arange(5.0), MATRICES)
    np.testing.assert_allclose(found.rotation_vectors(), VECTORS, atol=1e-12)
    sign = np.sign((found.quaternions() * QUATERNIONS).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(sign * found.quaternions(), QUATERNIONS, atol=1e-12)
    assert found.to_frame().shape == (5, 5)


def test_sensors_and_trials_become_recordings(tmp_path):
    names = [f"{s}_{c}" for s in ("hand", "forearm") for c in ("qx", "qy", "qz", "qw")]
    path = csv(tmp_path, names, np.c_[QUATERNIONS, QUATERNIONS[::-1]])
    hand, forearm = read_orientations(path, frame=Frame("z", "x"))
    assert (hand.segment, forearm.segment, hand.frame.up) == ("hand", "forearm", "z")
    np.testing.assert_allclose(forearm.matrices, hand.matrices[::-1], atol=1e-12)
    lines = path.read_text().splitlines()
    trials = ["trial", "1", "1", "2", "2", "2"]
    path.write_text("\n".join(f"{t},{x}" for t, x in zip(trials, lines, strict=True)))
    assert [(o.segment, o.labels.trial, o.n_samples) for o in read_orientations(path)] == [
        ("hand", "1", 2), ("hand", "2", 3), ("forearm", "1", 2), ("forearm", "2", 3),
    ]  # fmt: skip


@pytest.mark.parametrize(
    "fields",
    [
        {"quaternions": QUATERNIONS},
        {"quaternions": QUATERNIONS[:, [3, 0, 1, 2]], "quaternion_order": "wxyz"},
        {"matrices": MATRICES},
        {"rotation_vectors": VECTORS, "dt": 0.01},
        {"rotation_vectors": VECTORS, "time": np.arange(5) / 100, "subject": "P1"},
    ],
)
def test_npz(tmp_path, fields):
    np.savez(tmp_path / "x.npz", **fields)
    (found,) = read_orientations(tmp_path / "x.npz")
    np.testing.assert_allclose(found.matrices, MATRICES, atol=1e-12)
    assert found.timed == ("dt" in fields or "time" in fields)


def test_a_stated_order_and_rate(tmp_path):
    np.savez(tmp_path / "x.npz", quaternions=QUATERNIONS[:, [3, 0, 1, 2]])
    (found,) = read_orientations(tmp_path / "x.npz", order="wxyz", rate=50.0)
    np.testing.assert_allclose(found.matrices, MATRICES, atol=1e-12)
    assert found.rate == pytest.approx(50.0)
    np.savez(tmp_path / "x.npz", quaternions=QUATERNIONS, quaternion_order="xyzw")
    with pytest.raises(RangeError, match="quaternion_order is xyzw, but wxyz was stated"):
        read_orientations(tmp_path / "x.npz", order="wxyz")
    with pytest.raises(RangeError, match="the file has its own time"):
        read_orientations(csv(tmp_path, ["rx", "ry", "rz"], VECTORS), rate=100.0)


def test_tables_of_quaternions_are_scalar_first(tmp_path):
    rows = [f"{0.01 * i}\t{q[3]},{q[0]},{q[1]},{q[2]}\t1,0,0,0" for i, q in enumerate(QUATERNIONS)]
    path = tmp_path / "x.sto"
    path.write_text(
        "DataRate=100.0\nDataType=Quaternion\nversion=3\nendheader\ntime\thumerus_imu\tradius_imu\n"
        + "\n".join(rows)
    )
    humerus, radius = read_orientations(path)
    np.testing.assert_allclose(humerus.matrices, MATRICES, atol=1e-12)
    assert (humerus.segment, radius.segment) == ("humerus_imu", "radius_imu")
    np.testing.assert_allclose(radius.matrices[4], np.eye(3))
    path.write_text(path.read_text().replace("1,0,0,0", "1,0,0", 1))
    with pytest.raises(FileFormatError, match="row 6, column radius_imu: four numbers"):
        read_orientations(path)


@pytest.mark.parametrize("bad", [[np.nan] * 4, [0.0] * 4, [np.nan, 0.0, 0.0, 1.0]])
def test_gaps(tmp_path, bad):
    values = QUATERNIONS.copy()
    values[2] = bad
    (found,) = read_orientations(csv(tmp_path, ["qx", "qy", "qz", "qw"], values))
    assert found.gaps().tolist() == [False, False, True, False, False]
    assert np.isnan(found.quaternions()[2]).all() and np.isnan(found.pointing()[2]).all()


@pytest.mark.parametrize(
    ("names", "values", "words"),
    [
        (["qx", "qy", "qz", "qw"], 2 * QUATERNIONS, "orientations\\[0\\]: a quaternion of length"),
        (R_NAMES, -MATRICES.reshape(-1, 9), "orientations\\[0\\]: no rotation matrix"),
        (R_NAMES, 1.1 * MATRICES.reshape(-1, 9), "no rotation matrix"),
        (["rx", "ry", "rz"], np.degrees(VECTORS), "rotation vector of length.*rx_deg"),
        (["qx", "qy", "qz"], QUATERNIONS[:, :3], "no orientation among the columns"),
        (["elbow"], VECTORS[:, :1], "no orientation among the columns"),
        (["ax", "ay", "az", "aw"], QUATERNIONS, "no orientation among the columns"),
    ],
)
def test_refusals(tmp_path, names, values, words):
    with pytest.raises(ValueError, match=words) as raised:
        read_orientations(csv(tmp_path, names, values))
    assert str(tmp_path) in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("fields", "kind"),
    [
        ({"quaternions": QUATERNIONS[:, :3]}, ShapeError),
        ({"matrices": MATRICES[:, :2]}, ShapeError),
        ({"matrices": MATRICES, "quaternions": QUATERNIONS}, FileFormatError),
        ({"qd": VECTORS}, FileFormatError),
        ({"quaternions": QUATERNIONS, "quaternion_order": "wyxz"}, RangeError),
        ({"quaternions": QUATERNIONS.astype("U")}, ShapeError),
    ],
)
def test_npz_refusals(tmp_path, fields, kind):
    np.savez(tmp_path / "x.npz", **fields)
    with pytest.raises(kind):
        read_orientations(tmp_path / "x.npz")


def test_pointing_is_equation_6_worked_by_hand():
    # Flexion f about z turns the pointer to (cos f, sin f, 0), so x1 = -sin f; deviation r about
    # y turns it to (cos r, 0, -sin r), so x2 = -sin r.
    f, r = 0.3, -0.2
    turns = [Rotation.from_rotvec([0, 0, f]), Rotation.from_rotvec([0, r, 0])]
    found = Orientations(np.arange(2.0), np.stack([t.as_matrix() for t in turns]))
    expected = [[-np.sin(f), 0.0], [0.0, -np.sin(r)]]
    np.testing.assert_allclose(found.pointing(), expected, atol=1e-15)
    far = found.pointing(Screen(distance=2.0, right=(0.0, -3.0, 0.0)))
    np.testing.assert_allclose(far, 2.0 * np.array(expected), atol=1e-15)
    assert found.pointing_recording().array("x").shape == (2, 2)


def test_pointing_is_that_of_the_wrists_own_task():
    wrist = load_arm("wrist")
    q = np.random.default_rng(6).uniform(-0.4, 0.4, size=(7, 3))
    T = forward_kinematics(wrist.chain, q, wrist.tip("hand"))
    found = Orientations(np.arange(7.0), T[:, :3, :3])
    np.testing.assert_allclose(found.pointing(), Pointing(wrist).value(q), atol=1e-12)
