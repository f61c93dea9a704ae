"""ISB angles: frames built from known angles give them back, on both sides."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from selfmotion.capture.isb import isb_angles
from selfmotion.errors import UnknownNameError

# From the report's axes (x forward, y up, z right) to right, forward, up.
TO_LAB = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])


def points(shoulder: np.ndarray, elbow: np.ndarray) -> dict[str, np.ndarray]:
    """Place landmarks for YXY angles (elevation positive) and ZXY angles, (K, 3) each."""
    H = Rotation.from_euler("YXY", shoulder * [1, -1, 1]).as_matrix()
    F = H @ Rotation.from_euler("ZXY", elbow).as_matrix()
    centre = H @ [0, -0.3, 0]
    ulnar = centre + F @ [0, -0.25, 0]
    found = {
        "shoulder": np.zeros_like(centre),
        "lateral_epicondyle": centre + H @ [0, 0, 0.04],
        "medial_epicondyle": centre - H @ [0, 0, 0.04],
        "radial_styloid": ulnar + F @ [0, 0, 0.05],
        "ulnar_styloid": ulnar,
    }
    return {k: v @ TO_LAB.T for k, v in found.items()}


@pytest.mark.parametrize("side", ["right", "left"])
def test_angles_come_back_in_any_trunk_posture(side):
    rng = np.random.default_rng(1)
    shoulder = rng.uniform([-1.5, 0.1, -1.5], [1.5, 3.0, 1.5], (50, 3))
    elbow = rng.uniform([0.0, -0.3, -1.5], [2.5, 0.3, 1.5], (50, 3))
    marks = points(shoulder, elbow)
    if side == "left":
        marks = {k: v * [-1, 1, 1] for k, v in marks.items()}
    trunk = Rotation.random(50, rng=rng).as_matrix()
    turned = {k: np.einsum("kij,kj->ki", trunk, v) + 0.3 for k, v in marks.items()}
    found = isb_angles(turned, trunk, side=side)
    np.testing.assert_allclose(found.angles[:, :3], shoulder, atol=1e-9)
    np.testing.assert_allclose(found.angles[:, 3:], elbow, atol=1e-9)
    lock = np.minimum(shoulder[:, 1], np.pi - shoulder[:, 1])
    np.testing.assert_allclose(found.shoulder_lock, lock, atol=1e-9)
    np.testing.assert_allclose(found.elbow_lock, np.pi / 2 - np.abs(elbow[:, 1]), atol=1e-9)
    assert "elevation_deg" in found.to_frame()


def test_gaps_stay_gaps_and_missing_landmarks_are_named():
    marks = points(np.full((3, 3), 0.5), np.full((3, 3), 0.2))
    marks["shoulder"][1] = np.nan
    found = isb_angles(marks, np.tile(np.eye(3), (3, 1, 1)), side="right")
    assert np.isnan(found.angles[1, :3]).all() and np.isfinite(found.angles[[0, 2]]).all()
    with pytest.raises(UnknownNameError, match="ulnar_styloid"):
        isb_angles(
            {k: v for k, v in marks.items() if k != "ulnar_styloid"},
            np.tile(np.eye(3), (3, 1, 1)),
            side="right",
        )
