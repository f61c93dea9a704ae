"""Chains, couplings and arms: what they refuse, and what they give back."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly

from selfmotion.arms import load_arm, planar
from selfmotion.errors import (
    ModelError,
    NotFiniteError,
    RangeError,
    SelfmotionError,
    ShapeError,
    UnknownNameError,
)
from selfmotion.kinematics.arm import weightless
from selfmotion.kinematics.chain import GROUND, Chain, CoupledCurve, Coupling, Tip
from selfmotion.kinematics.dynamics import gravity_torque, inertia_matrix
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.kinematics.mirror import mirror


def two_joints(**changes) -> Chain:
    parts = {
        "names": ("a", "b"),
        "parent": np.array([GROUND, 0]),
        "joint_type": np.zeros(2, dtype=np.int64),
        "axes": np.eye(3)[:2],
        "offsets": np.stack([np.eye(4)] * 2),
        "lower": -np.ones(2),
        "upper": np.ones(2),
        "coupling": Coupling.identity(("a", "b")),
    }
    return Chain(**(parts | changes))


@pytest.mark.parametrize(
    ("changes", "error", "sentence"),
    [
        ({"parent": np.array([1, 0])}, ModelError, "joint 'a': its parent must come before"),
        ({"axes": np.array([[2.0, 0, 0], [0, 1, 0]])}, ModelError, "'a': axis .* unit length"),
        ({"joint_type": np.array([0, 7])}, ModelError, "'b' has type 7"),
        ({"lower": np.array([2.0, 0])}, RangeError, "a: lower limit 2"),
        ({"upper": np.array([1.0, np.nan])}, RangeError, "b: lower limit"),
        ({"offsets": np.full((2, 4, 4), np.inf)}, NotFiniteError, "offsets: 32 of 32"),
    ],
)
def test_bad_chains_are_refused_in_one_line(changes, error, sentence):
    with pytest.raises(error, match=sentence) as caught:
        two_joints(**changes)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("q", "error", "sentence"),
    [
        ([0.0], ShapeError, r"q has shape \(1,\); expected \(2,\) or \(samples, 2\) for a, b"),
        (np.zeros((3, 3)), ShapeError, r"q has shape \(3, 3\)"),
        (np.zeros((1, 1, 2)), ShapeError, r"q has shape \(1, 1, 2\)"),
        ([[0.0, 1.0], [0.0, np.nan]], NotFiniteError, r"first is q\[1, 1\] = nan"),
        ([1j, 0.0], ShapeError, "expected real numbers, found dtype complex128"),
        (["x", "y"], ShapeError, "expected real numbers"),
        ([[0.0, 1.0], [0.0]], ShapeError, "rows have different lengths"),
    ],
)
def test_bad_postures_are_refused_in_one_line(q, error, sentence):
    with pytest.raises(error, match=sentence) as caught:
        forward_kinematics(two_joints(), q, Tip(1))
    assert "\n" not in str(caught.value)


def test_arrays_of_a_chain_cannot_be_changed_and_are_its_own():
    axes = np.eye(3)[:2].copy()
    chain = two_joints(axes=axes)
    axes[0] = 0.0
    assert chain.axes[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        chain.axes[0, 0] = 2.0


def test_index_names_the_nearest_joint():
    assert two_joints().index("b") == 1
    with pytest.raises(UnknownNameError, match="unknown joint 'c'"):
        two_joints().index("c")


def test_coupling_derivative_by_finite_differences():
    spline = CubicSpline([-1.0, 0.0, 1.0], [-0.3, 0.0, 0.6])
    coupling = Coupling(
        ("u", "v"),
        np.array([[1.0, 0.0], [0.5, -2.0], [0.0, 0.0]]),
        np.array([0.0, 0.3, 0.0]),
        (CoupledCurve(2, 1, PPoly(spline.c, spline.x)),),
    )
    assert not coupling.is_identity
    q = np.random.default_rng(0).uniform(-0.9, 0.9, (7, 2))
    h = 1e-6
    slope = np.stack(
        [(coupling.value(q + h * e) - coupling.value(q - h * e)) / (2 * h) for e in np.eye(2)],
        axis=-1,
    )
    np.testing.assert_allclose(coupling.derivative(q), slope, rtol=0, atol=1e-8)
    np.testing.assert_allclose(coupling.value(q)[:, 2], spline(q[:, 1]), atol=1e-15)


def test_curves_go_on_beyond_their_last_knots():
    curve = PPoly(np.array([[1.0], [0.0], [0.0]]), [0.0, 1.0])
    coupling = Coupling(("u",), np.zeros((1, 1)), np.zeros(1), (CoupledCurve(0, 0, curve),))
    np.testing.assert_allclose(coupling.value(np.array([[-2.0], [3.0]])), [[4.0], [9.0]])


class TestArm:
    def test_limits_can_be_changed_by_name(self):
        arm = load_arm("exoskeleton").with_limits({"elbow_flexion": (0.5, 1.0)})
        assert (arm.lower[3], arm.upper[3]) == (0.5, 1.0)
        assert arm.middle()[3] == 0.75
        q = arm.random_postures(50, np.random.default_rng(0))
        assert (q >= arm.lower).all() and (q <= arm.upper).all()

    def test_bad_limits_and_names(self):
        arm = load_arm("exoskeleton")
        with pytest.raises(
            UnknownNameError, match="unknown joint 'elbow_flex'; did you mean 'elbow_f"
        ):
            arm.with_limits({"elbow_flex": (0.0, 1.0)})
        with pytest.raises(RangeError, match="elbow_flexion: lower limit 2"):
            arm.with_limits({"elbow_flexion": (2.0, 1.0)})
        with pytest.raises(UnknownNameError, match="unknown landmark 'hnad'; did you mean 'hand'"):
            arm.tip("hnad")

    def test_every_arm_has_the_four_landmarks(self):
        arm = planar([0.3, 0.2])
        marks = {key: tip for key, tip in arm.landmarks.items() if key != "elbow"}
        with pytest.raises(UnknownNameError, match="unknown landmark 'elbow'"):
            replace(arm, landmarks=marks)

    def test_weight_is_not_negative(self):
        arm = planar([0.3, 0.2])
        with pytest.raises(RangeError, match="mass of 'joint_2' is -1 kg"):
            replace(arm, mass=np.array([1.0, -1.0]))

    def test_an_arm_without_weight(self):
        arm = replace(load_arm("exoskeleton"), **weightless(4))
        assert not gravity_torque(arm, [0.1, 0.2, 0.3, 0.4]).any()
        assert not inertia_matrix(arm, [0.1, 0.2, 0.3, 0.4]).any()

    @pytest.mark.parametrize(
        "build",
        [
            lambda: planar([]),
            lambda: planar([0.3, -0.1]),
            lambda: planar([0.3, np.nan]),
            lambda: planar([0.3], joints=("a", "b")),
            lambda: planar([0.3, 0.3], joints=("a", "a")),
        ],
    )
    def test_bad_lengths_and_names_are_one_line(self, build):
        with pytest.raises(SelfmotionError) as caught:
            build()
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["exoskeleton", "upper_limb_anatomical", "srs7", "myoarm"])
class TestMirror:
    def test_landmarks_are_mirror_images_and_weights_the_same(self, name):
        arm = load_arm(name)
        other = mirror(arm)
        q = arm.random_postures(5, np.random.default_rng(3))
        across = np.cross(arm.up, arm.forward)
        for key in arm.landmarks:
            here, there = (
                forward_kinematics(a.chain, q, a.tip(key))[:, :3, 3] for a in (arm, other)
            )
            np.testing.assert_allclose(
                there, here - 2 * np.outer(here @ across, across), atol=1e-12
            )
        np.testing.assert_allclose(gravity_torque(other, q), gravity_torque(arm, q), atol=1e-12)
        np.testing.assert_allclose(inertia_matrix(other, q), inertia_matrix(arm, q), atol=1e-12)

    def test_frames_stay_right_handed(self, name):
        other = mirror(load_arm(name))
        T = forward_kinematics(other.chain, other.middle(), other.tip("hand"))[0]
        assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)

    def test_twice_is_nothing(self, name):
        arm = load_arm(name)
        back = mirror(mirror(arm))
        q = arm.random_postures(3, np.random.default_rng(3))
        assert back.name == arm.name
        np.testing.assert_allclose(
            geometric_jacobian(back.chain, q, back.tip("hand")),
            geometric_jacobian(arm.chain, q, arm.tip("hand")),
            atol=1e-12,
        )
