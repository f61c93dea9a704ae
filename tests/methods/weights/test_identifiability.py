"""Scale groups, over-specified joints and unexcited ratios on arms where they are known."""

from typing import Any

import numpy as np
import pytest

from selfmotion.methods.identification import (
    IdentificationOptions,
    MotionArrays,
    identify_weights_from_arrays,
)
from selfmotion.methods.weights.identifiability import connected, find_structure, group_by_precision
from tests.methods.ik_samples import pseudo_inverse, random_arm


def two_blocks(rng, samples=400, noise=0.0):
    """Joints 0-2 move one row, joints 3-4 another: two scale groups."""
    w = np.array([1.0, 0.5, 0.2, 1.0, 0.1])
    J = np.zeros((samples, 2, 5))
    J[:, 0, :3] = rng.standard_normal((samples, 3))
    J[:, 1, 3:] = rng.standard_normal((samples, 2))
    P = pseudo_inverse(J, w) @ J
    v = noise * rng.standard_normal((samples, 5, 1))
    qd = (P @ rng.standard_normal((samples, 5, 1)) + v - P @ v)[..., 0]
    return qd, J, w


def elbow_arm(rng, samples=400, offset=0.0, noise=0.05):
    """Joint 3 alone moves row 2 (but for `offset`): over-specified."""
    w = np.array([1.0, 0.4, 0.2, 1.0])
    J = rng.standard_normal((samples, 3, 4))
    J[:, 2] = [0.0, 0.0, 0.0, 1.0]
    J[:, 2, :3] += offset * rng.standard_normal((samples, 3))
    P = pseudo_inverse(J, w) @ J
    v = noise * rng.standard_normal((samples, 4, 1))
    return (P @ rng.standard_normal((samples, 4, 1)) + v - P @ v)[..., 0], J, w


def identify(qd, J, method: Any = "ml", **options):
    arrays = MotionArrays(qd, J, joints=tuple("abcdefg"[: qd.shape[1]]))
    return identify_weights_from_arrays(
        arrays, method=method, options=IdentificationOptions(**options)
    )


@pytest.mark.parametrize("method", ["ml", "paper"])
def test_block_structure_gives_two_scale_groups(method):
    qd, J, w = two_blocks(np.random.default_rng(0))
    found = identify(qd, J, method)
    assert found.groups == found.structural_groups == (("a", "b", "c"), ("d", "e"))
    np.testing.assert_allclose(found.weights, w, atol=1e-6)
    assert found.contribution[:3].sum() == pytest.approx(1.0)
    assert found.contribution[3:].sum() == pytest.approx(1.0)
    assert found.contribution_eq26.sum() == pytest.approx(1.0)
    assert np.isnan(found.log_ratio("a", "d")[0])


@pytest.mark.parametrize("method", ["ml", "paper"])
def test_over_specified_joint_is_named_and_follows_the_papers_convention(method):
    qd, J, w = elbow_arm(np.random.default_rng(1), noise=0.0)
    found = identify(qd, J, method)
    assert found.groups == (("a", "b", "c"),)
    assert list(found.unidentifiable) == ["d"] and "over-specified" in found.unidentifiable["d"]
    assert np.isnan(found.weights[3]) and np.isnan(found.contribution[3])
    np.testing.assert_allclose(found.full_weights, w, atol=1e-6)  # w4 = 1, section 4.2
    np.testing.assert_allclose(found.contribution_eq26, (1 / w) / (1 / w).sum(), atol=1e-6)


def test_barely_shared_joint_is_refused_by_its_standard_error():
    qd, J, w = elbow_arm(np.random.default_rng(2), offset=0.0005)
    found = identify(qd, J)
    assert found.structural_groups == (("a", "b", "c", "d"),)
    assert found.groups == (("a", "b", "c"),)
    assert "standard error too large" in found.unidentifiable["d"]
    np.testing.assert_allclose(found.weights[:3], w[:3], atol=0.05)


def test_constant_direction_does_not_excite_all_ratios():
    """One J, one direction: p never turns, F has rank n - m = 1 of 2."""
    w, J = np.array([1.0, 0.5, 0.2]), np.array([[[1.0, 2.0, 0.5], [0.3, -1.0, 1.0]]])
    J = J[:, :1]
    speed = np.sin(np.linspace(0.1, 3.0, 60))
    qd = speed[:, None] * pseudo_inverse(J, w)[0, :, 0]
    found = identify(qd, np.repeat(J, 60, axis=0))
    # p = q̇ itself is fixed in direction; N has rank 2, so both ratios are excited
    np.testing.assert_allclose(found.weights, w, atol=1e-9)
    fat = np.repeat(np.concatenate([J, [[[0.3, -1.0, 1.0]]]], axis=1), 60, axis=0)
    qd = speed[:, None] * (pseudo_inverse(fat[:1], w)[0] @ [1.0, 0.5])
    found = identify(qd, fat)  # null space of one dimension: one ratio for three joints
    assert not found.groups and not found.status
    assert all("not excited" in reason for reason in found.unidentifiable.values())


def test_still_joint_is_left_out_and_the_rest_identified():
    rng = np.random.default_rng(3)
    w = np.array([1.0, 0.5, 0.3, 0.2])
    qd, J = random_arm(rng, w, samples=200, rows=2)
    moving = np.insert(qd, 2, 0.0, axis=1)
    wider = np.insert(J, 2, rng.standard_normal((200, 2)), axis=2)
    found = identify(moving, wider)
    assert "never moves" in found.unidentifiable["c"]
    np.testing.assert_allclose(found.weights[[0, 1, 3, 4]], w, atol=1e-9)
    paper = identify(moving, wider, "paper", tolerance=1e-3)
    assert "never moves" in paper.unidentifiable["c"] and np.isnan(paper.weights[2])


def test_nothing_to_compare_once_a_joint_is_still():
    rng = np.random.default_rng(4)
    qd, J = rng.standard_normal((50, 3)), rng.standard_normal((50, 2, 3))
    qd[:, 2] = 0.0  # "Locked": two joints are left for two rows
    found = identify(qd, J)
    assert not found.status and np.isnan(found.weights).all()
    assert "among those that move" in found.unidentifiable["a"]


def test_joint_that_does_not_move_the_hand_is_named():
    rng = np.random.default_rng(5)
    w = np.array([1.0, 0.5, 0.2])
    qd, J = random_arm(rng, w, samples=200, rows=2)
    found = identify(
        np.insert(qd, 0, rng.standard_normal(200), axis=1), np.insert(J, 0, 0.0, axis=2)
    )
    assert "without moving the hand" in found.unidentifiable["a"]
    np.testing.assert_allclose(found.weights[1:], w, atol=1e-9)


def test_graph_and_linkage():
    linked = np.zeros((5, 5), dtype=bool)
    linked[0, 3] = linked[3, 0] = linked[3, 4] = linked[4, 3] = True
    assert connected(linked) == ((0, 3, 4), (1,), (2,))
    structure = find_structure(np.eye(2) * [1.0, 0.0], np.ones(2, dtype=bool))
    assert (structure.idle, structure.over_specified) == ((0,), (1,))
    errors = np.full((4, 4), 0.9)
    errors[0, 3] = errors[3, 0] = 1.5  # not transitive: 0 and 3 must not share a group
    np.fill_diagonal(errors, 0.0)
    for group in group_by_precision(((0, 1, 2, 3),), errors, 1.0):
        assert not {0, 3} <= set(group)
