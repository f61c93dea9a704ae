import numpy as np
import pytest

from selfmotion.arms.person_with_muscles import PersonSize, myoarm_lengths, myoarm_of_person
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.kinematics.dynamics import gravity_torque, potential_energy
from selfmotion.kinematics.forward import forward_kinematics, tip_positions
from selfmotion.methods.natural_posture import natural_posture
from selfmotion.muscles.fitted import mirror_muscles, scale_to_person
from selfmotion.muscles.static_optimization import muscle_effort

OWN = {"upper_arm": 0.31, "forearm": 0.24, "hand": 0.085}


@pytest.fixture(scope="module")
def standard():
    return load_musculoskeletal_arm()


@pytest.fixture(scope="module")
def person():
    return myoarm_of_person(PersonSize(OWN))


@pytest.fixture
def q(standard):
    return standard.arm.random_postures(6, np.random.default_rng(0))


def distance(model, q, near, far):
    tips = [model.arm.tip(near), model.arm.tip(far)]
    points = tip_positions(model.arm.chain, q, tips)
    return np.linalg.norm(points[:, 1] - points[:, 0], axis=1)


def test_the_models_own_lengths_give_the_model(standard, q):
    same = myoarm_of_person(PersonSize(myoarm_lengths()))
    np.testing.assert_allclose(same.geometry.lengths(q), standard.geometry.lengths(q), rtol=1e-12)
    np.testing.assert_allclose(
        same.geometry.moment_arms(q), standard.geometry.moment_arms(q), atol=1e-13
    )
    np.testing.assert_allclose(same.arm.chain.offsets, standard.arm.chain.offsets, atol=1e-14)
    np.testing.assert_allclose(
        muscle_effort(same, q).effort, muscle_effort(standard, q).effort, rtol=1e-9
    )


@pytest.mark.parametrize("strength", ["constant", "area", "mass"])
def test_even_scaling_is_homogeneous(standard, q, strength):
    """Lengths and moment arms grow by s, gravity torque by s^4, and all is as by one factor."""
    s = 1.15
    sizes = {name: s * length for name, length in myoarm_lengths().items()}
    large = myoarm_of_person(PersonSize(sizes, strength=strength))
    np.testing.assert_allclose(
        large.geometry.lengths(q), s * standard.geometry.lengths(q), rtol=1e-10
    )
    np.testing.assert_allclose(
        large.geometry.moment_arms(q), s * standard.geometry.moment_arms(q), atol=1e-11
    )
    np.testing.assert_allclose(
        gravity_torque(large.arm, q), s**4 * gravity_torque(standard.arm, q), atol=1e-10
    )
    even = scale_to_person(standard, length=s, strength=strength)
    np.testing.assert_allclose(
        muscle_effort(large, q).effort, muscle_effort(even, q).effort, rtol=1e-7
    )


def test_each_segment_has_the_length_asked_for_in_every_posture(person, q):
    for near, far, segment in (
        ("shoulder", "elbow", "upper_arm"),
        ("wrist", "middle_knuckle", "hand"),
    ):
        np.testing.assert_allclose(distance(person, q, near, far), OWN[segment], rtol=1e-9)
    home = np.zeros((1, 7))
    assert distance(person, home, "elbow", "wrist")[0] == pytest.approx(OWN["forearm"], rel=1e-9)


def test_moment_arms_stay_minus_the_derivative_of_length(person, q):
    step = 1e-6
    arms = person.geometry.moment_arms(q)
    for i in range(7):
        e = step * np.eye(7)[i]
        slope = (person.geometry.lengths(q + e) - person.geometry.lengths(q - e)) / (2 * step)
        close = np.abs(arms[:, :, i] + slope) < 1e-7
        assert close.mean() > 0.995  # but where a path jumps over what it wraps


def test_gravity_torque_stays_the_slope_of_potential_energy(person, q):
    step = 1e-6
    for i in range(7):
        e = step * np.eye(7)[i]
        slope = (potential_energy(person.arm, q + e) - potential_energy(person.arm, q - e)) / (
            2 * step
        )
        np.testing.assert_allclose(gravity_torque(person.arm, q)[:, i], slope, atol=1e-7)


def test_muscles_of_one_segment_follow_it_and_others_stay(standard, q):
    """A longer hand does not move a muscle from shoulder blade to upper arm."""
    model = myoarm_of_person(PersonSize({**myoarm_lengths(), "hand": 0.09}))
    there, here = standard.geometry.lengths(q), model.geometry.lengths(q)
    for name in ("INFSP", "BRA", "TRImed"):
        found = [i for i, m in enumerate(standard.muscles.names) if m.startswith(name)]
        assert found
        np.testing.assert_allclose(here[:, found], there[:, found], rtol=1e-12)
    moved = np.abs(here / there - 1.0).max(axis=0) > 1e-9
    arms = np.abs(standard.geometry.moment_arms(q)).max(axis=0)
    across_the_wrist, nowhere = arms[:, 5:].max(axis=1) > 1e-6, arms.max(axis=1) < 1e-6
    assert moved[across_the_wrist].all()
    assert not (moved & ~across_the_wrist & ~nowhere).any()  # else the hand's own muscles only


def test_masses_follow_the_stated_rules(standard):
    own = myoarm_lengths()
    cubes = myoarm_of_person(PersonSize({**own, "forearm": 1.2 * own["forearm"]}))
    share = np.ones(len(standard.arm.mass))
    share[[standard.arm.chain.names.index(name) for name in ("elbow_flexion", "pro_sup")]] = 1.2**3
    np.testing.assert_allclose(cubes.arm.mass, share * standard.arm.mass, rtol=1e-12)
    lighter = myoarm_of_person(PersonSize(OWN, mass=0.8))
    assert lighter.arm.mass.sum() == pytest.approx(0.8 * standard.arm.mass.sum())
    names = standard.arm.chain.names
    parts = [("shoulder_rot",), ("elbow_flexion", "pro_sup"), ("deviation", "flexion")]
    weighed = myoarm_of_person(PersonSize(OWN, body_mass=60.0)).arm.mass
    for part, share in zip(parts, (0.0263, 0.0150, 0.00585), strict=True):
        joints = [names.index(name) for name in part]  # phantoms of the upper arm: 2 g elsewhere
        assert weighed[joints].sum() == pytest.approx(60.0 * share, rel=2e-3)


def test_an_unmeasured_girdle_grows_as_the_segments_do_in_the_mean(person):
    own = myoarm_lengths()
    mean = np.mean([OWN[name] / own[name] for name in OWN])
    home = np.clip(np.zeros((1, 7)), person.arm.lower, person.arm.upper)
    girdle = distance(person, home, "sternoclavicular", "shoulder")
    assert girdle[0] == pytest.approx(mean * own["clavicle"], rel=1e-9)


def test_a_persons_left_arm_has_a_natural_posture(person):
    q = np.array([0.7, 0.9, -0.2, 1.5, 0.2, 0.05, 0.1])
    left = mirror_muscles(person)
    poses = [forward_kinematics(m.arm.chain, q, m.arm.tip("hand"))[0] for m in (person, left)]
    right, other = natural_posture(person, poses[0]), natural_posture(left, poses[1])
    assert bool(right.status)
    assert right.effort <= muscle_effort(person, q).effort[0]
    assert other.effort == pytest.approx(right.effort, rel=1e-3)


def test_sizes_are_checked():
    with pytest.raises(UnknownNameError, match="unknown segment 'thigh'"):
        PersonSize({"thigh": 0.4})
    with pytest.raises(UnknownNameError, match="unknown strength 'age'"):
        PersonSize({}, strength="age")
    with pytest.raises(RangeError, match=r"length of forearm \(m\) = 25"):
        myoarm_of_person(PersonSize({"forearm": 25.0}))
    with pytest.raises(RangeError, match="length of forearm"):
        myoarm_of_person(PersonSize({"forearm": float("nan")}))
    with pytest.raises(RangeError, match="mass = -1"):
        PersonSize({}, mass=-1.0)
    with pytest.raises(RangeError, match=r"body mass \(kg\) = 0"):
        PersonSize({}, body_mass=0.0)
    with pytest.raises(RangeError, match="mass = 1: body_mass is given already"):
        PersonSize({}, mass=1.0, body_mass=70.0)
