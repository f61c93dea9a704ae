"""The arms of the papers against closed forms worked out apart from the library."""

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from selfmotion.arms import (
    ANATOMICAL,
    Body,
    Corrections,
    exoskeleton,
    hip_shoulder_elbow,
    planar,
    srs7,
    upper_limb,
    upper_limb_anatomical,
    upper_limb_rest,
    wrist,
)
from selfmotion.arms._upper_limb import SPLINT_DEG
from selfmotion.kinematics.dynamics import gravity_torque, inertia_matrix
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.kinematics.swivel import arm_swivel_angle
from selfmotion.redundancy.task import Pointing, Position

RNG_SEED = 3


def equal(actual: ArrayLike, expected: ArrayLike, message: str = "") -> None:
    a, b = np.asarray(actual), np.asarray(expected)
    np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-13, err_msg=message)


def random_angles(n: int, k: int = 20) -> np.ndarray:
    return np.random.default_rng(RNG_SEED).uniform(-np.pi, np.pi, (k, n))


def hand(arm, q) -> np.ndarray:
    return forward_kinematics(arm.chain, q, arm.tip("hand"))


def craig_row(a: float, twist: float, d: float, angle: float) -> np.ndarray:
    """[DeBoon] eq. 1, written out."""
    ct, st, ca, sa = np.cos(angle), np.sin(angle), np.cos(twist), np.sin(twist)
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -sa * d],
            [st * sa, ct * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )


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


class TestUpperLimb:
    def test_product_of_table_1(self):
        l0, l1, l2, l3 = 0.188, 0.286, 0.259, 0.074
        half = np.pi / 2
        rows = [
            (0, 0, 0, 0),
            (0, -half, 0, half),
            (0, half, l0, 0),
            (0, -half, 0, 0),
            (0, half, l1, 0),
            (0, -half, 0, 0),
            (0, half, l2, 0),
            (0, -half, 0, 0),
            (0, half, 0, 0),
        ]
        arm = upper_limb()
        for q in random_angles(9):
            T = np.eye(4)
            for (a, twist, d, angle), theta in zip(rows, q, strict=True):
                T = T @ craig_row(a, twist, d, angle + theta)
            T = T @ craig_row(0, 0, l3, 0)
            equal(hand(arm, q)[0], T)

    @pytest.mark.parametrize(
        ("landmark", "expected"),
        [
            ("shoulder", (188, 0, 0)),
            ("elbow", (188, 0, -286)),
            ("hand", (74.11, 0, -598.92)),
        ],
    )
    def test_landmarks_at_rest(self, landmark, expected):
        arm = upper_limb()
        T = forward_kinematics(arm.chain, upper_limb_rest(), arm.tip(landmark))
        np.testing.assert_allclose(1e3 * T[0, :3, 3], expected, atol=0.005)

    def test_zero_is_a_t_pose(self):
        x = hand(upper_limb(), np.zeros(9))[0, :3, 3]
        equal(x, [0.188 + 0.286 + 0.259 + 0.074, 0, 0])

    def test_limits(self):
        arm = upper_limb()
        assert np.degrees(arm.lower).round(6).tolist() == [
            -14.1, -6.4, -21.3, 0.4, -68.0, 15.8, -27.9, -72.1, -5.0,
        ]  # fmt: skip
        assert np.degrees(arm.upper).round(6).tolist() == [
            13.4, 12.2, 180.0, 160.7, 133.0, 150.7, 29.6, 79.2, 152.9,
        ]  # fmt: skip
        assert np.radians(SPLINT_DEG) == pytest.approx([1.12, 1.99], abs=0.005)

    def test_printed_last_joint_does_not_move_the_palm(self):
        arm = upper_limb()
        q = arm.random_postures(10, np.random.default_rng(RNG_SEED))
        assert abs(Position(arm).jacobian(q)[:, :, 8]).max() < 1e-15

    def step(self, corrections: Corrections, joint: str, **start: float) -> np.ndarray:
        """Where the hand goes (signs) when a joint of the hanging straight arm gains 0.1 rad."""
        arm, q = upper_limb(corrections=corrections), upper_limb_rest(corrections)
        q[5] = 0.0
        for name, value in start.items():
            q[arm.joints.index(name)] = value
        before = hand(arm, q)[0, :3, 3]
        q[arm.joints.index(joint)] += 0.1
        moved = hand(arm, q)[0, :3, 3] - before
        return np.where(abs(moved) < abs(moved).max() / 5, 0, np.sign(moved))

    def test_shoulder_rotation_offset_lets_the_elbow_flex_forward(self):
        on = Corrections(shoulder_rotation_offset=True)
        assert self.step(Corrections(), "elbow_flexion").tolist() == [-1, 0, 0]
        assert self.step(on, "elbow_flexion").tolist() == [0, 1, 0]
        quarter = {"shoulder_rotation": np.pi / 2}
        assert self.step(Corrections(), "elbow_flexion", **quarter).tolist() == [0, 1, 0]

    def test_scapula_sign_makes_positive_elevation(self):
        def rise(corrections: Corrections) -> float:
            arm = upper_limb(corrections=corrections)
            T = forward_kinematics(arm.chain, 0.1 * np.eye(9)[1], arm.tip("shoulder"))
            return T[0, 2, 3]

        assert rise(Corrections()) < 0 < rise(Corrections(scapula_sign=True))

    def test_abduction_from_hanging_raises_the_arm_sideways(self):
        on = Corrections(abduction_from_hanging=True)
        assert self.step(Corrections(), "shoulder_adduction").tolist() == [-1, 0, 0]
        assert self.step(on, "shoulder_adduction").tolist() == [1, 0, 0]
        # The same posture, counted the other way.
        arm = upper_limb()
        printed, hanging = upper_limb_rest(), upper_limb_rest(on)
        equal(hand(arm, printed), hand(upper_limb(corrections=on), hanging))

    def test_printed_wrist_has_no_true_deviation_and_the_universal_one_has(self):
        printed, universal = upper_limb(), upper_limb(corrections=Corrections(universal_wrist=True))
        q = upper_limb_rest()
        for arm, rank, moves in ((printed, 2, False), (universal, 3, True)):
            J = geometric_jacobian(arm.chain, q, arm.tip("hand"))[0]
            assert np.linalg.matrix_rank(J[3:, 6:]) == rank
            assert (np.linalg.norm(J[:3, 6]) > 0.07) == moves

    def test_without_corrections_nothing_changes(self):
        q = random_angles(9)
        np.testing.assert_array_equal(
            hand(upper_limb(corrections=Corrections()), q), hand(upper_limb(), q)
        )

    def test_names_and_order_of_joints_are_the_same_in_both(self):
        assert upper_limb().joints == upper_limb_anatomical().joints
        assert upper_limb_anatomical().name == "upper_limb_anatomical"


class TestAnatomicalPreset:
    """Right arm, hanging with the palm forward: x right, y forward, z up."""

    def moved(self, **angles: float) -> np.ndarray:
        arm = upper_limb_anatomical()
        q = np.zeros(9)
        for name, value in angles.items():
            q[arm.joints.index(name)] = value
        return hand(arm, q)[0]

    @pytest.mark.parametrize(
        ("joint", "direction"),
        [
            ("scapula_protraction", (0, 1, 0)),
            ("scapula_elevation", (1, 0, 1)),
            ("shoulder_flexion", (0, 1, 1)),
            ("shoulder_adduction", (1, 0, 1)),  # counted as abduction from hanging
            ("elbow_flexion", (0, 1, 1)),
            ("wrist_deviation", (-1, 0, 1)),  # ulnar: towards the body, palm forward
            ("wrist_flexion", (0, 1, 1)),
        ],
    )
    def test_positive_angles_move_the_hand(self, joint, direction):
        step = self.moved(**{joint: 0.2})[:3, 3] - self.moved()[:3, 3]
        for component, sign in zip(step, direction, strict=True):
            if sign == 0:
                assert abs(component) < abs(step).max() / 2
            else:
                assert np.sign(component) == sign

    def test_elbow_flexes_straight_forward(self):
        T = self.moved(elbow_flexion=np.pi / 2)
        equal(T[:3, 3], [0.188, 0.259 + 0.074, -0.286])

    def test_deviation_and_flexion_turn_about_two_axes_across_the_hand(self):
        arm = upper_limb_anatomical()
        J = geometric_jacobian(arm.chain, np.zeros(9), arm.tip("hand"))[0, 3:]
        along = hand(arm, np.zeros(9))[0, :3, 2]
        deviation, flexion, pronation = J[:, 6], J[:, 7], J[:, 8]
        assert max(abs(deviation @ flexion), abs(deviation @ along), abs(flexion @ along)) < 1e-15
        assert abs(pronation @ along) == pytest.approx(1.0)

    def test_pronation_is_about_the_forearm_even_with_a_bent_wrist(self):
        bent = {"wrist_flexion": 0.7, "wrist_deviation": 0.3}
        arm = upper_limb_anatomical()
        q = np.zeros(9)
        q[[5, 6, 7]] = 1.0, 0.3, 0.7
        axis = geometric_jacobian(arm.chain, q, arm.tip("hand"))[0, 3:, 8]
        points = [
            forward_kinematics(arm.chain, q, arm.tip(name))[0, :3, 3] for name in ("elbow", "wrist")
        ]
        forearm = (points[1] - points[0]) / 0.259
        assert axis @ forearm == pytest.approx(-1.0)
        assert not np.allclose(self.moved(**bent), self.moved(wrist_pronation=0.5, **bent))

    def test_pronation_turns_the_palm_from_forward_to_back(self):
        # Flexion moves the hand towards its palm.
        palm_forward = self.moved(wrist_flexion=0.3)[:3, 3][1]
        palm_back = self.moved(wrist_flexion=0.3, wrist_pronation=np.radians(152.9))[:3, 3][1]
        assert palm_forward > 0 > palm_back
        thumb_ahead = self.moved(wrist_flexion=0.3, wrist_pronation=np.pi / 2)[:3, 3] - [
            0.188,
            0,
            0,
        ]
        assert thumb_ahead[0] < -0.01  # palm towards the body

    def test_outward_rotation_turns_the_bent_forearm_to_the_right(self):
        T = self.moved(elbow_flexion=np.pi / 2, shoulder_rotation=0.3)
        assert T[0, 3] > 0.188 + 0.05

    def test_same_lengths_as_printed(self):
        assert dict(upper_limb_anatomical().lengths) == dict(upper_limb().lengths)
        assert Corrections(True, True, True, True) == ANATOMICAL


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
