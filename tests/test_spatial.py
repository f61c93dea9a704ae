"""Rotations and transforms: identities, SciPy's matrix exponential, the edges."""

import numpy as np
import pytest
from scipy.linalg import expm

from selfmotion.errors import RangeError, ShapeError
from selfmotion.spatial import (
    exp_rotation,
    invert,
    log_rotation,
    rotation_about,
    rotation_taking_z_to,
    skew,
    transform,
    unit,
)

RNG_SEED = 4


def test_skew_crosses():
    v, u = np.random.default_rng(RNG_SEED).normal(size=(2, 6, 3))
    np.testing.assert_allclose(np.einsum("kij,kj->ki", skew(v), u), np.cross(v, u), atol=1e-15)
    np.testing.assert_array_equal(skew(v), -np.swapaxes(skew(v), 1, 2))


def test_exponential_is_the_matrix_exponential():
    for r in np.random.default_rng(RNG_SEED).normal(size=(6, 3)):
        np.testing.assert_allclose(exp_rotation(r), expm(skew(r)), atol=1e-13)


@pytest.mark.parametrize("length", [0.0, 1e-12, 1e-6, 1.0, np.pi - 1e-6])
def test_logarithm_undoes_the_exponential(length):
    axes = np.random.default_rng(RNG_SEED).normal(size=(5, 3))
    r = length * axes / np.linalg.norm(axes, axis=1, keepdims=True)
    np.testing.assert_allclose(log_rotation(exp_rotation(r)), r, rtol=0, atol=1e-9)


def test_half_a_turn_has_length_pi():
    R = rotation_about([1.0, 2.0, -1.0], np.pi)
    r = log_rotation(R)
    assert np.linalg.norm(r) == pytest.approx(np.pi)
    np.testing.assert_allclose(exp_rotation(r), R, atol=1e-12)


def test_batches_of_any_shape():
    r = np.random.default_rng(RNG_SEED).normal(size=(2, 3, 3)) * 0.5
    R = exp_rotation(r)
    assert R.shape == (2, 3, 3, 3)
    np.testing.assert_allclose(log_rotation(R), r, atol=1e-12)


def test_rotation_about_leaves_its_axis_and_turns_the_right_way():
    R = rotation_about([0.0, 0.0, 3.0], np.pi / 2)
    np.testing.assert_allclose(R @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(R @ [0, 0, 1], [0, 0, 1], atol=1e-15)


def test_inverse_of_transforms():
    rng = np.random.default_rng(RNG_SEED)
    T = np.array([transform(exp_rotation(r), p) for r, p in rng.normal(size=(5, 2, 3))])
    np.testing.assert_allclose(invert(T) @ T, np.broadcast_to(np.eye(4), (5, 4, 4)), atol=1e-13)


def test_transform_of_nothing_is_the_identity():
    np.testing.assert_array_equal(transform(), np.eye(4))


@pytest.mark.parametrize(
    "axis",
    [
        (0, 0, 1),
        (0, 0, -1),
        (1e-8, 0, -1),
        (1e-4, 1e-4, -1),
        (1, 0, 1e-9),
        (1, 0, -1e-9),
        (1, 0, 0),
        (0, -1, 0),
        (0.6, 0, 0.8),
        (-0.3, 0.4, -0.5),
    ],
)
def test_rotation_taking_z_to_an_axis(axis):
    a = unit("axis", np.array(axis, dtype=float))
    R = rotation_taking_z_to(a)
    np.testing.assert_allclose(R[:, 2], a, rtol=0, atol=1e-15)
    np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0, atol=2e-15)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_directions_need_a_length():
    np.testing.assert_allclose(unit("v", [0.0, 3.0, 4.0]), [0, 0.6, 0.8], atol=1e-15)
    with pytest.raises(RangeError, match=r"v = \[0.0, 0.0, 0.0\]: a direction needs a length"):
        unit("v", [0.0, 0.0, 0.0])
    with pytest.raises(RangeError, match="v = "):
        unit("v", [np.nan, 0.0, 0.0])
    with pytest.raises(ShapeError, match=r"v: expected 1 dimension\(s\), found shape \(1, 3\)"):
        unit("v", [[1.0, 0.0, 0.0]])
