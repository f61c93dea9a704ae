import numpy as np

from selfmotion.arms import planar, srs7
from selfmotion.methods.reach import miss_distance
from selfmotion.redundancy.task import Planar, Position


def test_the_distance_beyond_the_longest_reach():
    task = Planar(planar([0.3, 0.25, 0.2]))
    targets = np.array([[0.5, 0.3], [0.9, 0.0], [0.0, -1.5]])
    start = np.tile([0.2, 0.4, 0.3], (3, 1))
    found = miss_distance(task, start, targets, np.arange(3))
    np.testing.assert_allclose(found, [0.0, 0.15, 0.75], atol=1e-6)


def test_locked_joints_shorten_the_reach():
    task = Planar(planar([0.3, 0.25, 0.2]))
    start = np.array([[0.0, np.pi / 2, 0.0]])  # elbow locked at a right angle
    reach = np.hypot(0.3, 0.25) + 0.2  # the last link in line with the stiff first two
    target = np.array([[reach + 0.1, 0.0]])
    np.testing.assert_allclose(miss_distance(task, start, target, np.array([0, 2])), 0.1, atol=1e-6)


def test_every_posture_s_own_place_is_within_reach():
    task = Position(srs7())
    rng = np.random.default_rng(0)
    q = task.arm.random_postures(20, rng)
    found = miss_distance(task, q + rng.normal(0.0, 0.2, q.shape), task.value(q), np.arange(7))
    assert found.max() < 1e-8
