"""The 9-DoF upper limb: Table 1 as printed, and what each correction changes."""

import numpy as np
import pytest

from selfmotion.arms import (
    ANATOMICAL,
    Corrections,
    upper_limb,
    upper_limb_anatomical,
    upper_limb_rest,
)
from selfmotion.arms._upper_limb import SPLINT_DEG
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.redundancy.task import Position
from tests.arms.closeness import RNG_SEED, equal, hand, random_angles
from tests.arms.dh import craig_row


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
