"""Rigid clusters, landmarks and joint centres against known motions."""

import numpy as np
import pytest

from selfmotion.capture.joint_centres import Prior, functional_centre
from selfmotion.capture.landmarks import (
    Cluster,
    ClusterPose,
    cluster_from_static,
    fit_cluster,
    fuse,
    landmark_covariance,
)
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.motion.markers import MarkerSet
from selfmotion.spatial import exp_rotation

SHAPE = np.array([[0.03, 0, 0], [-0.03, 0.01, 0], [0, 0.04, 0.01], [0, -0.02, 0.02]])
NAMES = ("a", "b", "c", "d")


def moving(rng: np.random.Generator, n_samples: int = 40) -> tuple[np.ndarray, np.ndarray]:
    return exp_rotation(rng.normal(size=(n_samples, 3))), rng.normal(size=(n_samples, 3))


def seen_from(R: np.ndarray, t: np.ndarray) -> MarkerSet:
    return MarkerSet(np.arange(len(R)) / 100, NAMES, SHAPE @ R.mT + t[:, None])


def test_poses_are_exact_and_proper_without_noise_even_with_a_marker_missing():
    R, t = moving(np.random.default_rng(1))
    markers = seen_from(R, t)
    positions = markers.positions.copy()
    positions[5, 2] = np.nan
    positions[6, 1:3] = np.nan  # two are too few
    pose = fit_cluster(Cluster("plate", NAMES, SHAPE), MarkerSet(markers.time, NAMES, positions))
    assert np.isnan(pose.translation[6]).all() and np.isnan(pose.residual[6])
    kept = np.arange(len(R)) != 6
    np.testing.assert_allclose(pose.rotation[kept], R[kept], atol=1e-12)
    np.testing.assert_allclose(pose.carry([0.1, 0.2, 0.3])[kept], (R @ [0.1, 0.2, 0.3] + t)[kept])
    np.testing.assert_allclose(np.linalg.det(pose.rotation[kept]), 1.0)
    assert np.nanmax(pose.residual) < 1e-12


def test_the_fit_is_the_least_squares_one():
    rng = np.random.default_rng(2)
    R, t = moving(rng, 3)
    noisy = seen_from(R, t).positions + 0.002 * rng.normal(size=(3, 4, 3))
    cluster = Cluster("plate", NAMES, SHAPE)
    pose = fit_cluster(cluster, MarkerSet(np.arange(3.0), NAMES, noisy))

    def cost(rotation: np.ndarray, translation: np.ndarray) -> np.ndarray:
        return ((SHAPE @ rotation.mT + translation[:, None] - noisy) ** 2).sum(axis=(1, 2))

    best = cost(pose.rotation, pose.translation)
    np.testing.assert_allclose(np.sqrt(best / 4), pose.residual)
    for _ in range(20):
        turn = exp_rotation(1e-3 * rng.normal(size=(3, 3)))
        assert (cost(turn @ pose.rotation, pose.translation) >= best).all()


def test_the_shape_of_a_swaying_static_trial_is_found():
    R, t = moving(np.random.default_rng(3), 30)
    found = cluster_from_static("plate", seen_from(R, t), NAMES)
    apart = np.linalg.norm(found.reference[:, None] - found.reference, axis=2)
    np.testing.assert_allclose(apart, np.linalg.norm(SHAPE[:, None] - SHAPE, axis=2), atol=1e-12)


def test_covariance_of_a_landmark_is_what_noise_makes_of_it():
    rng = np.random.default_rng(4)
    cluster = Cluster("plate", NAMES, SHAPE - SHAPE.mean(axis=0))
    point = np.array([0.02, 0.1, -0.15])
    noisy = cluster.reference + 1e-4 * rng.normal(size=(20_000, 4, 3))
    pose = fit_cluster(cluster, MarkerSet(np.arange(20_000.0), NAMES, noisy))
    found = np.cov(pose.carry(point), rowvar=False)
    wanted = landmark_covariance(cluster, point, noise=1e-4)
    np.testing.assert_allclose(found, wanted, atol=0.05 * wanted.max())


def test_fusing_is_the_bayesian_mean_and_knows_gaps():
    first, second = np.zeros((3, 3)), np.tile([0.03, 0.0, 0.0], (3, 1))
    second[1] = np.nan
    first[2] = second[2] = np.nan
    along = np.diag([4e-6, 1e-6, 1e-6])
    both = fuse([first, second], [along, 2 * along])
    np.testing.assert_allclose(both.path[0], [0.01, 0, 0])
    np.testing.assert_allclose(both.deviation[0], np.sqrt(np.trace(along * 2 / 3) / 3))
    np.testing.assert_allclose(both.path[1], 0.0)
    assert np.isnan(both.path[2]).all() and np.isnan(both.disagreement[1:]).all()


@pytest.mark.parametrize("names", [NAMES[:2], NAMES[:3]])
def test_clusters_without_a_rotation_are_refused(names):
    line = np.arange(len(names))[:, None] * np.array([[0.02, 0.01, 0.0]])
    with pytest.raises(ShapeError, match="cluster plate"):
        fit_cluster(Cluster("plate", names, line), MarkerSet(np.zeros(1), names, line[None]))


def test_a_marker_never_seen_in_the_static_trial_is_named():
    positions = np.tile(SHAPE, (5, 1, 1))
    positions[:, 2] = np.nan
    with pytest.raises(NotFiniteError, match="c of cluster plate"):
        cluster_from_static("plate", MarkerSet(np.arange(5.0), NAMES, positions), NAMES)


def joint(rng: np.random.Generator, axes: np.ndarray, n_samples: int = 200):
    """Two segments around a joint at (0.1, 0.2, 0.3) of the first, turning about `axes`."""
    R1, t1 = moving(rng, n_samples)
    R2 = R1 @ exp_rotation(rng.normal(size=(n_samples, len(axes))) @ axes)
    centre = R1 @ [0.1, 0.2, 0.3] + t1
    zeros = np.zeros(n_samples)
    return ClusterPose(R1, t1, zeros), ClusterPose(R2, centre - R2 @ [0, 0.1, -0.2], zeros)


def test_score_finds_the_centre_in_both_segments():
    first, second = joint(np.random.default_rng(5), np.eye(3))
    found = functional_centre([first], [second])
    np.testing.assert_allclose(found.proximal, [0.1, 0.2, 0.3], atol=1e-10)
    np.testing.assert_allclose(found.distal, [0, 0.1, -0.2], atol=1e-10)
    assert found.residual < 1e-10 and found.n_samples == 200


def test_a_hinge_needs_a_prior_and_keeps_to_it_along_the_axis_only():
    axis = np.array([[0.0, 0.0, 1.0]])
    first, second = joint(np.random.default_rng(6), axis)
    with pytest.raises(RangeError, match="at least two axes"):
        functional_centre([first], [second])
    off = Prior([0.11, 0.21, 0.31], [0.01, 0.11, -0.19], deviation=0.02, noise=0.001)
    found = functional_centre([first], [second], prior=off)
    np.testing.assert_allclose(found.proximal, [0.1, 0.2, 0.31], atol=1e-4)


def test_the_centre_is_the_same_in_any_laboratory_frame():
    rng = np.random.default_rng(7)
    first, second = joint(rng, np.eye(3))
    noise = 0.01 * rng.normal(size=(200, 3))
    turn, shift = exp_rotation(np.array([[0.3, -0.8, 1.2]]))[0], np.array([1.0, 2.0, 3.0])

    def elsewhere(pose: ClusterPose, extra: np.ndarray) -> ClusterPose:
        moved = (pose.translation + extra) @ turn.T + shift
        return ClusterPose(turn @ pose.rotation, moved, pose.residual)

    noisy = ClusterPose(second.rotation, second.translation + noise, second.residual)
    here = functional_centre([first], [noisy])
    there = functional_centre([elsewhere(first, 0 * noise)], [elsewhere(second, noise)])
    np.testing.assert_allclose(here.distal, there.distal, atol=1e-10)
    assert here.residual == pytest.approx(there.residual)
