import numpy as np
import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.kinematics.dynamics import gravity_torque
from selfmotion.kinematics.forward import forward_kinematics, tip_positions
from selfmotion.methods.natural_posture import natural_posture
from selfmotion.muscles.fitted import mirror_muscles, scale_to_person
from selfmotion.muscles.static_optimization import muscle_effort

from .test_mujoco_bridge import ARM, MUSCLE


def test_scaling_follows_its_rules(muscle_arm):
    q = muscle_arm.arm.random_postures(4, np.random.default_rng(0))
    large = scale_to_person(muscle_arm, length=1.1, mass=1.3, strength="constant")
    assert large.geometry.lengths(q) == pytest.approx(1.1 * muscle_arm.geometry.lengths(q))
    assert gravity_torque(large.arm, q) == pytest.approx(1.43 * gravity_torque(muscle_arm.arm, q))
    here, there = (m.forces.full_activation(m.geometry.lengths(q)) for m in (muscle_arm, large))
    assert there == pytest.approx(here)
    tips = [muscle_arm.arm.tip("elbow")], [large.arm.tip("elbow")]
    assert tip_positions(large.arm.chain, q, tips[1]) == pytest.approx(
        1.1 * tip_positions(muscle_arm.arm.chain, q, tips[0])
    )
    # Moment arms still are minus the derivative of length.
    step = np.zeros(7)
    step[1] = 1e-6
    slope = (large.geometry.lengths(q + step) - large.geometry.lengths(q - step)) / 2e-6
    assert large.geometry.moment_arms(q)[:, :, 1] == pytest.approx(-slope, abs=1e-6)


def test_an_arm_that_grows_evenly_works_harder_by_the_square_cube_law(muscle_arm):
    q = np.array([[0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1]])
    large = scale_to_person(muscle_arm, length=1.2)
    # Torque grows by length^4, strength times moment arm by length^3: activation by length.
    ratio = muscle_effort(large, q).effort / muscle_effort(muscle_arm, q).effort
    assert ratio == pytest.approx(1.2**2, rel=1e-9)


def test_the_left_arm_is_the_mirror_image(muscle_arm):
    left = mirror_muscles(muscle_arm)
    q = np.array([0.7, 0.9, -0.2, 1.5, 0.2, 0.05, 0.1])
    assert muscle_effort(left, q).effort == pytest.approx(muscle_effort(muscle_arm, q).effort)
    across = np.cross(left.arm.up, left.arm.forward)
    for mine, theirs in zip(left.geometry.paths(q), muscle_arm.geometry.paths(q), strict=True):
        assert mine @ across == pytest.approx(-theirs @ across, abs=1e-12)
    poses = [forward_kinematics(m.arm.chain, q, m.arm.tip("hand"))[0] for m in (muscle_arm, left)]
    right, other = natural_posture(muscle_arm, poses[0]), natural_posture(left, poses[1])
    assert other.effort == pytest.approx(right.effort, rel=1e-3)
    assert other.swivel == pytest.approx(-right.swivel, abs=0.02)


def test_a_users_own_mjcf_with_muscles(tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(ARM.format(MUSCLE))
    model = load_musculoskeletal_arm(file)
    assert model.muscles.names == ("m",) and model.convention == "plain"
    found = muscle_effort(model, [0.0, 0.2])
    assert not found.status[0]  # one muscle does not hold two joints


def test_factors_and_rules_are_checked(muscle_arm):
    with pytest.raises(RangeError, match="length = 9"):
        scale_to_person(muscle_arm, length=9.0)
    with pytest.raises(UnknownNameError, match="unknown strength 'age'"):
        scale_to_person(muscle_arm, length=1.0, strength="age")
