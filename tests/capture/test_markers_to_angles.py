"""Markers to joint angles, on generated recordings whose angles are known."""

import numpy as np
import pytest

from selfmotion.arms import srs7, upper_limb_anatomical
from selfmotion.capture.angles import angles_from_markers
from selfmotion.capture.person import CaptureOptions, calibrate_person
from selfmotion.capture.scaling import with_adult_ranges
from selfmotion.capture.simulated_markers import (
    LENGTHS,
    MarkerFaults,
    SimulatedCapture,
    capture_of,
    simulate_markers,
)
from selfmotion.errors import SelfmotionError
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.swivel import swivel_angle

HALF_A_DEGREE = np.deg2rad(0.5)
RAW = CaptureOptions(cutoff=None)


def calibrated(capture: SimulatedCapture, options: CaptureOptions = RAW):
    arm = with_adult_ranges(upper_limb_anatomical())
    return calibrate_person(
        arm, capture.static, capture.movements, side=capture.side, options=options
    )


@pytest.mark.parametrize("side", ["right", "left"])
def test_angles_come_back_within_half_a_degree_without_noise(side):
    capture = simulate_markers(side=side, rng=np.random.default_rng(3))
    person = calibrated(capture)
    for segment, length in LENGTHS.items():
        if segment != "hand":
            assert person.lengths[segment] == pytest.approx(length, abs=1e-3)
    for markers, q in zip(capture.movements, capture.angles, strict=True):
        motion = angles_from_markers(person, markers)
        assert motion.ik.status.ok
        assert np.abs(motion.ik.q - q).max() < HALF_A_DEGREE
        assert motion.recording.labels.side == side
        assert motion.recording.labels.condition == markers.labels.condition


def test_the_girdle_counts_from_where_movements_start_and_the_rest_does_not_depend_on_it():
    raised = np.deg2rad([3.0, 6.0])
    exact = simulate_markers(rng=np.random.default_rng(3))
    moved = [(m.labels, q) for m, q in zip(exact.movements, exact.angles, strict=True)]
    for _, q in moved:
        q[:, :2] += raised
    capture = capture_of(exact.arm, moved, rng=np.random.default_rng(3))
    person = calibrated(capture)
    assert person.lengths["upper_arm"] == pytest.approx(LENGTHS["upper_arm"], abs=1e-3)
    tips = [capture.arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
    for markers, q in zip(capture.movements, capture.angles, strict=True):
        motion = angles_from_markers(person, markers)
        wrong = motion.ik.q - q
        np.testing.assert_allclose(motion.ik.q[0, :2], 0.0, atol=HALF_A_DEGREE)
        np.testing.assert_allclose(wrong[:, 1], -raised[1], atol=HALF_A_DEGREE)
        # What the girdle lacks the shoulder has more; beyond the shoulder nothing changes.
        assert np.abs(wrong[:, 2:5]).max() > np.deg2rad(2.0)
        assert np.abs(wrong[:, 5:]).max() < HALF_A_DEGREE
        points = tip_positions(capture.arm.chain, q, tips)
        wanted = swivel_angle(points[:, 0], points[:, 1], points[:, 2], down=[0, 0, -1])
        np.testing.assert_allclose(motion.swivel, wanted, atol=HALF_A_DEGREE)


def test_with_noise_skin_and_gaps_errors_stay_moderate_and_limits_hold():
    faults = MarkerFaults(noise=5e-4, skin=4e-3, gaps=6)
    capture = simulate_markers(faults=faults, rng=np.random.default_rng(5))
    person = calibrated(capture, CaptureOptions(cutoff=6.0))
    wrong, far = [], []
    for markers, q in zip(capture.movements, capture.angles, strict=True):
        motion = angles_from_markers(person, markers)
        wrong.append(np.abs(motion.ik.q - q))
        far.append(motion.ik.rms)
        assert (motion.ik.q >= person.arm.lower).all() and (motion.ik.q <= person.arm.upper).all()
    assert np.rad2deg(np.median(np.concatenate(wrong))) < 3.0
    assert np.median(np.concatenate(far)) < 0.015
    assert person.centres["elbow"].residual > 1e-3  # the skin shows in the two views


def test_the_swivel_angle_of_the_landmarks_is_that_of_the_joint_centres():
    capture = simulate_markers(rng=np.random.default_rng(7))
    motion = angles_from_markers(calibrated(capture), capture.movements[0])
    tips = [capture.arm.tip(name) for name in ("shoulder", "elbow", "wrist")]
    points = tip_positions(capture.arm.chain, capture.angles[0], tips)
    wanted = swivel_angle(points[:, 0], points[:, 1], points[:, 2], down=[0, 0, -1])
    np.testing.assert_allclose(motion.swivel, wanted, atol=HALF_A_DEGREE)


def test_both_sides_have_the_same_swivel_angle_for_mirrored_movements():
    swivels = []
    for side in ("right", "left"):
        capture = simulate_markers(side=side, rng=np.random.default_rng(3))
        swivels.append(angles_from_markers(calibrated(capture), capture.movements[1]).swivel)
    np.testing.assert_allclose(*swivels, atol=HALF_A_DEGREE)


def test_the_7_dof_arm_follows_the_same_markers():
    capture = simulate_markers(rng=np.random.default_rng(3))
    widest = {"elbow_flexion": (-0.1, 2.7), "wrist_deviation": (-0.6, 0.6)}
    arm = srs7().with_limits({**widest, "shoulder_elevation": (0.0, np.pi)})
    person = calibrate_person(arm, capture.static, capture.movements, options=RAW)
    elbow = person.arm.joints.index("elbow_flexion")
    for markers, q in zip(capture.movements, capture.angles, strict=True):
        motion = angles_from_markers(person, markers)
        assert np.nanmax(motion.ik.rms) < 3e-3  # it has no girdle to turn the upper arm
        np.testing.assert_allclose(motion.ik.q[:, elbow], q[:, 5], atol=HALF_A_DEGREE)


def test_long_gaps_of_a_whole_cluster_leave_gaps_not_guesses():
    capture = simulate_markers(rng=np.random.default_rng(3))
    person = calibrated(capture)
    markers = capture.movements[0]
    positions = markers.positions.copy()
    positions[100:160] = np.nan
    lost = type(markers)(markers.time, markers.names, positions, markers.frame, markers.labels)
    motion = angles_from_markers(person, lost)
    assert np.isnan(motion.ik.q[100:160]).all() and np.isnan(motion.swivel[100:160]).all()
    assert np.abs(motion.ik.q[160:] - capture.angles[0][160:]).max() < HALF_A_DEGREE


def test_without_movements_the_landmarks_alone_serve():
    capture = simulate_markers(rng=np.random.default_rng(3))
    person = calibrate_person(
        with_adult_ranges(upper_limb_anatomical()), capture.static, [], options=RAW
    )
    assert not person.centres
    motion = angles_from_markers(person, capture.movements[0])
    assert np.nanmedian(motion.ik.rms) < 0.02


def test_missing_markers_and_sides_are_refused_in_one_line():
    capture = simulate_markers(rng=np.random.default_rng(3))
    arm = with_adult_ranges(upper_limb_anatomical())
    without = capture.static.select([n for n in capture.static.names if n != "RLEP"])
    for static, side in ((without, "right"), (capture.static, "left"), (capture.static, "both")):
        with pytest.raises(SelfmotionError) as refused:
            calibrate_person(arm, static, capture.movements, side=side, options=RAW)
        assert "\n" not in str(refused.value)
