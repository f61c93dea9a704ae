"""Words about identifiability name what can be compared, and why the rest cannot."""

import numpy as np

from selfmotion.methods.identification import (
    MotionArrays,
    identify_weights,
    identify_weights_from_arrays,
)
from selfmotion.report.explain import explain_identifiability
from selfmotion.studies.synthetic_samples import random_samples


def test_groups_and_joints_without_weight_are_named():
    samples = random_samples([1.0, 0.5, 0.1], rng=np.random.default_rng(1), n_rows=2, sigma=0.01)
    said = explain_identifiability(identify_weights(samples))
    assert len(said) == 1
    assert "joint 3 is moved most readily" in said[0] and "10 times as costly" in said[0]


def test_joint_that_nothing_can_replace_is_named():
    rng = np.random.default_rng(1)
    J = np.tile([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], (60, 1, 1))
    hand = rng.standard_normal((60, 2))
    qd = np.column_stack([0.1 * hand[:, 0], 0.9 * hand[:, 0], hand[:, 1]])
    qd[:, :2] += 0.01 * rng.standard_normal((60, 1)) * [1.0, -1.0]
    said = explain_identifiability(identify_weights_from_arrays(MotionArrays(qd, J)))
    assert said[0].startswith("Joint 1, joint 2 can be compared: joint 2 is moved most readily")
    assert said[1].startswith("Joint 3 has no weight: over-specified")
