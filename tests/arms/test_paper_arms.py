"""The arms of the papers against closed forms worked out apart from the library."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from selfmotion.arms import (
    Body,
    exoskeleton,
    hip_shoulder_elbow,
    planar,
    srs7,
    upper_limb,
    wrist,
)
from selfmotion.kinematics.dynamics import gravity_torque, inertia_matrix
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.kinematics.swivel import arm_swivel_angle
from selfmotion.redundancy.task import Pointing, Position
from tests.arms.closeness import RNG_SEED, equal, hand, random_angles
from tests.arms.dh import craig_row


class TestPlanar:
    def test_tip_is_the_sum_of_links(self):
        lengths, q = np.array([0.3, 0.25, 0.2, 0.1]), random_angles(4)
        angle = np.cumsum(q, axis=1)
        p = np.stack([np.cos(angle) @ lengths, np.sin(angle) @ lengths], axis=1)
        equal(hand(planar(lengths), q)[:, :2, 3], p)

    def test_landmarks_and_names(self):
        arm = planar([0.3, 0.25, 0.1], joints=("s", "e", "w"))
        assert arm.joints == ("s", "e", "w")
        T = forward_kinematics(arm.chain, [0.0, 0.0, 0.0], arm.tip("wrist"))
        equal(T[0, :3, 3], [0.55, 0, 0])

    def test_on_a_table_nothing_is_to_be_held(self):
        arm = planar([0.3, 0.25])
        assert not gravity_torque(arm, random_angles(2)).any()

    def test_upright_two_rods_by_hand(self):
        arm = planar([0.4, 0.3], gravity=(0, -10.0, 0), body=Body(mass=70))
        total = 70 * (0.0271 + 0.0162 + 0.0061)
        m1, m2 = total * 4 / 7, total * 3 / 7
        q1 = 10 * (m1 * 0.2 + m2 * (0.4 + 0.15))
        np.testing.assert_allclose(gravity_torque(arm, [0, 0])[0], [q1, 10 * m2 * 0.15], rtol=1e-12)
        # A rod about its end: m l^2 / 3.
        assert inertia_matrix(arm, [0, 0])[0, 1, 1] == pytest.approx(m2 * 0.3**2 / 3, rel=1e-12)


class TestHipShoulderElbow:
    def test_closed_form(self):
        lengths, q = (0.5, 0.3, 0.35), random_angles(3)
        angle = np.pi / 2 + np.cumsum(q, axis=1)
        p = np.stack([np.cos(angle) @ lengths, np.sin(angle) @ lengths], axis=1)
        equal(hand(hip_shoulder_elbow(lengths), q)[:, :2, 3], p)

    def test_rest_posture_of_eq_25_is_an_upright_trunk_with_the_arm_in_front_and_low(self):
        arm = hip_shoulder_elbow()
        q = [0.0, -2.7, 0.0]
        assert (np.array(q) >= arm.lower).all() and (np.array(q) <= arm.upper).all()
        T = forward_kinematics(arm.chain, q, arm.tip("shoulder"))[0, :3, 3]
        equal(T, [0, arm.lengths["trunk"], 0])
        x, y, _ = hand(arm, q)[0, :3, 3]
        assert x > 0 and y < T[1]

    def test_elbow_flexion_brings_the_hand_forward_and_up(self):
        arm = hip_shoulder_elbow()
        hanging, bent = (hand(arm, [0, -np.pi, e])[0, :3, 3] for e in (0.0, 0.5))
        assert bent[0] > hanging[0] and bent[1] > hanging[1]


class TestWrist:
    def test_closed_form_of_the_screen_point(self):
        q = random_angles(3)
        p, f, r = q.T
        x1 = -(np.sin(f) * np.cos(r) * np.cos(p) - np.sin(r) * np.sin(p))
        x2 = -(np.sin(f) * np.cos(r) * np.sin(p) + np.sin(r) * np.cos(p))
        value = Pointing(wrist()).value(q)
        equal(value, np.stack([x1, x2], axis=1))

    def test_orientation_is_eq_6(self):
        q = random_angles(3)
        R = Rotation.from_rotvec(np.outer(-q[:, 0], [1, 0, 0]))
        R = R * Rotation.from_rotvec(np.outer(q[:, 1], [0, 0, 1]))
        R = R * Rotation.from_rotvec(np.outer(q[:, 2], [0, 1, 0]))
        equal(hand(wrist(), q)[:, :3, :3], R.as_matrix())

    def test_east_is_extension_and_north_radial_deviation(self):
        task = Pointing(wrist())
        east, north = task.value([0, -np.pi / 12, 0])[0], task.value([0, 0, -np.pi / 12])[0]
        equal(east, [np.sin(np.pi / 12), 0])
        equal(north, [0, np.sin(np.pi / 12)])


class TestExoskeleton:
    def test_closed_form(self):
        arm, q = exoskeleton([0.3, 0.35]), random_angles(4)
        R = Rotation.from_euler("XZY", q[:, :3] * [1, 1, -1])
        forearm = Rotation.from_rotvec(np.outer(-q[:, 3], [0, 1, 0])).apply([0, 0, -0.35])
        equal(hand(arm, q)[:, :3, 3], R.apply(forearm + [0, 0, -0.3]))

    def test_the_elbow_has_no_part_in_motion_that_keeps_the_hand_in_place(self):
        arm = exoskeleton()
        q = arm.random_postures(200, np.random.default_rng(RNG_SEED))
        q[:, 3] = np.clip(q[:, 3], 0.2, 2.2)  # a straight elbow is singular
        J = Position(arm).jacobian(q)
        z = np.linalg.svd(J)[2][:, -1]
        conditioned = np.linalg.cond(J) < 1e3
        assert conditioned.mean() > 0.9
        assert abs(z[conditioned, 3]).max() < 1e-12
        # Why: only the elbow changes the distance to the shoulder.
        radial = np.einsum("ki,kij->kj", hand(arm, q)[:, :3, 3], J)
        assert abs(radial[:, :3]).max() < 1e-15

    def test_elevation_axis_may_point_the_other_way(self):
        q = random_angles(4)
        other = exoskeleton(elevation_axis=(-1, 0, 0))
        same = hand(exoskeleton(), q * [-1, 1, 1, 1])
        equal(hand(other, q), same)


class TestSrs7:
    def test_hangs_at_zero_with_the_frames_of_the_ground(self):
        arm = srs7([0.3, 0.25], shoulder=(0.01, 0.02, 0.2))
        T = hand(arm, np.zeros(7))[0]
        equal(T[:3, :3], np.eye(3))
        equal(T[:3, 3], [0.01, 0.02 - 0.55, 0.2])

    def test_product_of_table_i(self):
        d_se, d_ew, half = 0.3, 0.25, np.pi / 2
        rows = [
            (0, 0, 0, 0),
            (0, half, 0, 0),
            (0, -half, -d_se, half),
            (0, half, 0, 0),
            (0, -half, -d_ew, 0),
            (0, -half, 0, half),
            (0, half, 0, 0),
        ]
        # x forward, y up, z right from x right, y forward, z up.
        base = np.eye(4)
        base[:3, :3] = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
        arm = srs7([d_se, d_ew])
        frame_7 = arm.tip("hand").transform
        for q in random_angles(7, 5):
            T = base
            for (a, twist, d, angle), theta in zip(rows, q, strict=True):
                T = T @ craig_row(a, twist, d, angle + theta)
            equal(hand(arm, q)[0], T @ frame_7)

    def test_shoulder_and_wrist_are_spherical(self):
        arm, q = srs7(), random_angles(7)
        wrist_point = geometric_jacobian(arm.chain, q, arm.tip("wrist"))[:, :3, 4:]
        elbow = forward_kinematics(arm.chain, q, arm.tip("elbow"))[:, :3, 3]
        assert abs(wrist_point).max() < 1e-15
        np.testing.assert_allclose(
            np.linalg.norm(elbow, axis=1), arm.lengths["upper_arm"], rtol=1e-12
        )

    def test_signs(self):
        arm = srs7()

        def palm(**angles: float) -> np.ndarray:
            q = np.zeros(7)
            for name, value in angles.items():
                q[arm.joints.index(name)] = value
            return forward_kinematics(arm.chain, q, arm.tip("palm"))[0, :3, 3]

        assert palm(shoulder_elevation=0.3)[2] > 0.1  # to the right
        assert palm(shoulder_elevation=0.3, elevation_plane=np.pi / 2)[0] > 0.1  # forward
        assert palm(elbow_flexion=0.3)[0] > 0.05  # forward
        assert palm(wrist_flexion=0.3)[2] < -0.01  # palm faces the body
        assert palm(wrist_deviation=0.3)[0] < -0.01  # ulnar is behind, the thumb is in front

    def test_swivel_angle_of_a_raised_elbow(self):
        # Upper arm out to the right, forearm to the front: the elbow is right of the line.
        arm = srs7()
        q = [0, np.pi / 2, 0, np.pi / 2, 0, 0, 0]
        assert arm_swivel_angle(arm, q)[0] == pytest.approx(np.pi / 2, abs=1e-12)


class TestSegments:
    def test_masses_are_shares_of_body_mass(self):
        arm = upper_limb(body=Body(mass=100.0))
        np.testing.assert_allclose(arm.mass[arm.mass > 0], [2.71, 1.62, 0.61], rtol=1e-12)

    def test_centre_and_radii_of_the_upper_arm(self):
        arm = exoskeleton([0.3, 0.35], body=Body(mass=100.0))
        np.testing.assert_allclose(arm.com[2], [0, 0, -0.5772 * 0.3], rtol=1e-12)
        across = 2.71 * 0.09 * (0.285**2 + 0.269**2) / 2
        expected = np.diag([across, across, 2.71 * 0.09 * 0.158**2])
        np.testing.assert_allclose(arm.inertia[2], expected, rtol=1e-12, atol=1e-18)

    def test_arm_held_out_by_hand(self):
        # A straight arm at the horizontal: sum of weight times distance.
        arm = upper_limb(body=Body(mass=70.0, stature=1.741))
        torque = gravity_torque(arm, np.zeros(9))[0]
        arms = (0.5772 * 0.286, 0.286 + 0.4574 * 0.259, 0.286 + 0.259 + 0.79 * 0.0862)
        expected = 9.81 * 70 * np.dot((0.0271, 0.0162, 0.0061), arms)
        assert abs(torque[3]) == pytest.approx(expected, rel=1e-12)
        assert 5.0 < expected < 15.0  # N m, of the order of a shoulder's

    def test_women_have_their_own_table(self):
        arm = exoskeleton(body=Body(mass=100.0, sex="female"))
        assert arm.mass[2] == pytest.approx(2.55)
