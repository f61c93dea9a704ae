"""Donders surfaces of any segment, and arms some of whose joints are held."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from selfmotion.arms import load_arm, wrist
from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.elasticity.orientation_surface import (
    fit_orientation_surface,
    mean_rotation,
)
from selfmotion.methods.elasticity.surface import fit_surface
from selfmotion.methods.passive.held_joints import hold_joints

A, B = (g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 7), np.linspace(-0.4, 0.4, 7)))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_it_is_the_surface_of_the_wrist_where_the_axis_is_a_coordinate(axis):
    r = np.insert(np.stack([A, B], axis=1), axis, 0.1 + 0.2 * A - 0.3 * A * B + 0.1 * B**2, axis=1)
    r = r + np.random.default_rng(0).normal(0.0, 0.01, r.shape)
    found = fit_orientation_surface(
        Rotation.from_rotvec(r).as_matrix(), axis=np.eye(3)[axis], reference=np.eye(3)
    )
    expected = fit_surface(r, torsion_axis=axis)
    # The directions a and b may be turned within their plane; what remains is the same.
    assert found.thickness_deg == pytest.approx(expected.thickness_deg, rel=1e-9)
    np.testing.assert_allclose(found.surface.residual, expected.residual, atol=1e-12)


def test_it_does_not_depend_on_the_body_that_the_segment_is_seen_from():
    r = np.stack([A, 0.2 * A * B, B], axis=1)
    r = r + np.random.default_rng(1).normal(0.0, 0.02, r.shape)
    turns = Rotation.from_rotvec(r)
    seen = Rotation.from_rotvec([0.4, -1.0, 2.0]) * turns
    one, two = (fit_orientation_surface(t.as_matrix(), axis=[0, 1, 0]) for t in (turns, seen))
    np.testing.assert_allclose(one.residual(turns.as_matrix()), two.residual(seen.as_matrix()))


def test_orientations_without_a_surface_are_refused():
    turns = Rotation.from_rotvec(np.stack([A, 0 * A, B], axis=1)).as_matrix()
    line = Rotation.from_rotvec(A[:, None] * [1.0, 0.0, 0.0]).as_matrix()
    with pytest.raises(RangeError, match="along one line"):
        fit_orientation_surface(line, axis=[0, 1, 0])
    with pytest.raises(RangeError, match="no rotation matrix"):
        fit_orientation_surface(2.0 * turns, axis=[0, 1, 0])
    with pytest.raises(NotFiniteError):
        fit_orientation_surface(np.full((20, 3, 3), np.nan), axis=[0, 1, 0])
    with pytest.raises(SelfmotionError):
        fit_orientation_surface(turns, axis=[0, 0, 0])
    half = Rotation.from_rotvec([np.pi, 0.0, 0.0]).as_matrix()
    with pytest.raises(RangeError, match="degrees from the reference"):
        fit_orientation_surface(turns, axis=[0, 1, 0], reference=half)
    with pytest.raises(RangeError, match="scattered"):
        mean_rotation(Rotation.from_rotvec(np.pi * np.eye(3)).as_matrix()[[0, 1]])


def test_the_mean_of_two_rotations_is_half_way():
    turns = Rotation.from_rotvec([[0.0, 0.0, 0.2], [0.0, 0.0, 0.6]]).as_matrix()
    expected = Rotation.from_rotvec([0.0, 0.0, 0.4]).as_matrix()
    np.testing.assert_allclose(mean_rotation(turns), expected, atol=1e-12)


@pytest.mark.parametrize("name", ["upper_limb_anatomical", "exoskeleton", "wrist"])
def test_an_arm_with_held_joints_goes_where_the_whole_arm_goes(name):
    arm = load_arm(name)
    q = np.random.default_rng(2).uniform(arm.lower, arm.upper, (5, arm.n_joints))
    q[:, 1] = 0.3
    held = hold_joints(arm, {arm.joints[1]: 0.3})
    assert held.joints == (arm.joints[0], *arm.joints[2:])
    whole = forward_kinematics(arm.chain, q, arm.tip("hand"))
    part = forward_kinematics(held.chain, np.delete(q, 1, axis=1), held.tip("hand"))
    np.testing.assert_allclose(part, whole, atol=1e-12)


def test_joints_that_cannot_be_held_are_refused():
    with pytest.raises(UnknownNameError):
        hold_joints(wrist(), {"elbow": 0.0})
    with pytest.raises(RangeError, match="finite"):
        hold_joints(wrist(), {"flexion": np.nan})
    with pytest.raises(RangeError, match="at least one"):
        hold_joints(wrist(), dict.fromkeys(wrist().joints, 0.0))
