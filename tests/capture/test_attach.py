"""Joint angles of an arm become velocities, hand motion and Jacobians."""

import numpy as np
import pytest

from selfmotion.arms import exoskeleton
from selfmotion.capture.attach import attach_arm
from selfmotion.errors import NotFiniteError, ShapeError, UnknownNameError
from selfmotion.motion.recording import Recording


def swing(arm, n_samples=101):
    time = np.linspace(0.0, 1.0, n_samples)
    speed = np.linspace(0.3, 0.6, arm.n_joints)
    return time, 0.4 + 0.3 * np.sin(np.outer(time, 2 * speed))


def test_velocity_of_the_hand_is_the_derivative_of_its_path():
    arm = exoskeleton()
    time, q = swing(arm)
    r = attach_arm(Recording(time, q=q, joints=arm.joints), arm)
    path = np.gradient(r.array("x"), time, axis=0, edge_order=2)
    np.testing.assert_allclose(r.array("xd")[2:-2], path[2:-2], atol=2e-4)


def test_columns_are_matched_by_name_in_any_order():
    arm = exoskeleton()
    time, q = swing(arm)
    names = arm.joints[::-1]
    straight = attach_arm(Recording(time, q=q, joints=arm.joints), arm)
    extra = np.concatenate([q[:, ::-1], q[:, :1]], axis=1)
    mixed = attach_arm(Recording(time, q=extra, joints=(*names, "thumb")), arm)
    np.testing.assert_array_equal(straight.array("jacobian"), mixed.array("jacobian"))
    assert mixed.joints == arm.joints


def test_missing_joint_is_named():
    arm = exoskeleton()
    time, q = swing(arm)
    with pytest.raises(UnknownNameError, match="no column for elbow_flexion"):
        attach_arm(Recording(time, q=q, joints=(*arm.joints[:-1], "elbow")), arm)


def test_gap_stays_a_gap():
    arm = exoskeleton()
    time, q = swing(arm)
    q[40:45, 1] = np.nan
    r = attach_arm(Recording(time, q=q, joints=arm.joints), arm)
    assert r.gaps().sum() == 5
    assert np.isnan(r.array("jacobian")[42]).all()


def test_recorded_velocities_are_kept():
    arm = exoskeleton()
    time, q = swing(arm)
    qd = np.ones_like(q)
    r = attach_arm(Recording(time, q=q, qd=qd, joints=arm.joints), arm)
    np.testing.assert_array_equal(r.array("qd"), qd)


def test_without_angles_nothing_can_be_attached():
    arm = exoskeleton()
    time, q = swing(arm)
    with pytest.raises(ShapeError, match="q is needed"):
        attach_arm(Recording(time, x=q[:, :3]), arm)


def test_all_gaps_are_refused():
    arm = exoskeleton()
    time, q = swing(arm)
    q[:, 0] = np.nan
    with pytest.raises(NotFiniteError):
        attach_arm(Recording(time, q=q, joints=arm.joints), arm)
