"""Fast positions against the plain kernel, for chains of every kind."""

import numpy as np
import pytest
from scipy.interpolate import PPoly

from selfmotion.arms import load_arm
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.kinematics.chain import GROUND, Chain, CoupledCurve, Coupling, Tip
from selfmotion.kinematics.fast_position import path_arrays, positions
from selfmotion.kinematics.forward import body_frames, forward_kinematics, frames_and_jacobian
from selfmotion.kinematics.serial_path import SerialPath
from selfmotion.kinematics.sine_cosine import sine_cosine
from selfmotion.spatial import exp_rotation, transform


def random_tree(rng, n=7, coupled=False):
    """A tree with random frames, axes, parents and some prismatic joints."""
    axes = rng.normal(size=(n, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    axes[0], axes[1], axes[2] = (0, 0, 1), (0, 0, -1), (1, 0, 0)
    offsets = np.array(
        [transform(exp_rotation(rng.normal(size=3)), 0.3 * rng.normal(size=3)) for _ in range(n)]
    )
    offsets[3] = np.eye(4)
    parent = np.array([GROUND, 0, 1, 1, 3, 4, 3])
    kind = np.array([0, 0, 1, 0, 0, 1, 0])
    coupling = Coupling.identity(tuple(f"j{i}" for i in range(n)))
    limits = n
    if coupled:
        matrix = rng.normal(size=(n, 3))
        matrix[4] = 0.0
        offset = rng.normal(size=n)
        offset[4] = 0.0
        curve = PPoly(rng.normal(size=(4, 2)), np.array([-1.0, 0.2, 1.0]))
        coupling = Coupling(("a", "b", "c"), matrix, offset, (CoupledCurve(4, 1, curve),))
        limits = 3
    names = tuple(f"j{i}" for i in range(n))
    return Chain(
        names, parent, kind, axes, offsets, -2 * np.ones(limits), 2 * np.ones(limits), coupling
    )


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("joint", [0, 2, 3, 5, 6])
def test_agrees_with_the_plain_kernel(joint, coupled):
    rng = np.random.default_rng(3)
    chain = random_tree(rng, coupled=coupled)
    tip = Tip(joint, transform(exp_rotation(rng.normal(size=3)), rng.normal(size=3)))
    q = rng.uniform(-7, 7, (1000, chain.n_coordinates))  # no multiple of the block
    expected = forward_kinematics(chain, q, tip)[:, :3, 3]
    scale = max(1.0, np.abs(expected).max())  # coupled slides reach many metres
    np.testing.assert_allclose(positions(chain, q, tip), expected, atol=1e-12 * scale, rtol=0)


def test_sine_and_cosine_are_those_of_the_c_library():
    angle = np.concatenate([np.linspace(-40, 40, 20001), [0.0, np.pi / 2, np.pi, 1e4, -1e4]])
    s, c = np.array([sine_cosine(float(a)) for a in angle]).T
    np.testing.assert_allclose(s, np.sin(angle), atol=4e-13, rtol=0)
    near = np.abs(angle) < 50
    np.testing.assert_allclose(s[near], np.sin(angle[near]), atol=8e-15, rtol=0)
    np.testing.assert_allclose(c[near], np.cos(angle[near]), atol=8e-15, rtol=0)


def test_threads_give_the_same_numbers():
    rng = np.random.default_rng(4)
    chain = random_tree(rng)
    tip = Tip(6)
    q = rng.uniform(-2, 2, (50_001, 7))
    np.testing.assert_array_equal(positions(chain, q, tip), positions(chain, q, tip, threads=2))


def test_path_keeps_quarter_turns_exact():
    chain = random_tree(np.random.default_rng(5))
    path = SerialPath.of(chain, Tip(6))
    assert path.joints.tolist() == [0, 1, 3, 6]
    assert path.twist[0] <= np.pi


def test_a_tip_on_the_ground_stays_there():
    chain = random_tree(np.random.default_rng(5))
    tip = Tip(GROUND, transform(None, [1.0, 2.0, 3.0]))
    assert positions(chain, np.zeros((2, 7)), tip).tolist() == [[1, 2, 3], [1, 2, 3]]


def test_bad_input():
    chain = random_tree(np.random.default_rng(5))
    with pytest.raises(ShapeError, match=r"expected \(7,\) or \(samples, 7\)"):
        positions(chain, np.zeros((2, 6)), Tip(6))
    with pytest.raises(NotFiniteError, match=r"q\[1, 6\] = nan"):
        positions(chain, [[0.0] * 7, [0.0] * 6 + [np.nan]], Tip(6))
    with pytest.raises(NotFiniteError, match=r"q\[0, 2\] = inf"):
        positions(chain, [[0.0, 0.0, np.inf, 0.0, 0.0, 0.0, 0.0]], Tip(2))
    with pytest.raises(RangeError, match="threads = 0"):
        positions(chain, np.zeros(7), Tip(6), threads=0)


def test_an_array_to_fill_is_filled():
    chain = random_tree(np.random.default_rng(5))
    q, out = np.random.default_rng(6).uniform(-2, 2, (300, 7)), np.full((300, 3), np.nan)
    assert positions(chain, q, Tip(6), out=out) is out
    np.testing.assert_array_equal(out, positions(chain, q, Tip(6)))
    with pytest.raises(ShapeError, match=r"out: expected shape \(300, 3\), found \(299, 3\)"):
        positions(chain, q, Tip(6), out=out[:299])
    with pytest.raises(ShapeError, match="out: expected a writable array"):
        positions(chain, q, Tip(6), out=out[::-1])


@pytest.mark.parametrize("column", [2, 5])
def test_nan_in_a_joint_that_does_not_carry_the_tip_is_refused(column):
    chain = random_tree(np.random.default_rng(5))
    q = np.zeros((5, 7))
    q[3, column] = np.nan
    with pytest.raises(NotFiniteError, match=rf"q\[3, {column}\] = nan"):
        positions(chain, q, Tip(6))


@pytest.mark.parametrize("size", [1e5, 1e9, 1e17])
def test_angles_of_any_size(size):
    """Beyond 10⁴ rad the C library's own reduction counts: whole turns change nothing."""
    chain = random_tree(np.random.default_rng(5))
    q = np.random.default_rng(6).uniform(-2, 2, (10, 7))
    q[4, 0] = size
    small = q.copy()
    small[4, 0] = np.arctan2(np.sin(size), np.cos(size))
    for tip in (Tip(6), Tip(3)):
        np.testing.assert_allclose(
            positions(chain, q, tip), positions(chain, small, tip), atol=1e-13, rtol=0
        )
        np.testing.assert_allclose(
            forward_kinematics(chain, q, tip), forward_kinematics(chain, small, tip), atol=1e-13
        )


def test_a_joint_that_only_spins_the_tip_is_passed_over():
    arm = load_arm("upper_limb")
    path = path_arrays(SerialPath.of(arm.chain, arm.tip("hand")))
    assert path.column.tolist() == list(range(8))
    q = arm.random_postures(100, np.random.default_rng(7))
    expected = forward_kinematics(arm.chain, q, arm.tip("hand"))[:, :3, 3]
    np.testing.assert_allclose(positions(arm.chain, q, arm.tip("hand")), expected, atol=1e-14)


@pytest.mark.parametrize("joint", [0, 2, 5, 6])
def test_jacobian_of_many_is_the_derivative_and_threads_change_nothing(joint):
    chain, rng = random_tree(np.random.default_rng(5)), np.random.default_rng(8)
    tip = Tip(joint, transform(exp_rotation(rng.normal(size=3)), rng.normal(size=3)))
    q, h = rng.uniform(-2, 2, (10_001, 7)), 1e-6
    T, J = frames_and_jacobian(chain, q, tip)
    again = frames_and_jacobian(chain, q, tip, threads=2)
    np.testing.assert_array_equal(T, again[0])
    np.testing.assert_array_equal(J, again[1])
    np.testing.assert_array_equal(T[[70]], forward_kinematics(chain, q[70], tip))
    for j in range(7):
        step = h * np.eye(7)[j]
        ahead, behind = (forward_kinematics(chain, q[:99] + s * step, tip) for s in (1, -1))
        slope = (ahead - behind) / (2 * h)
        np.testing.assert_allclose(J[:99, :3, j], slope[:, :3, 3], atol=1e-8)
        spin = slope[:, :3, :3] @ np.swapaxes(T[:99, :3, :3], 1, 2)
        turn = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
        np.testing.assert_allclose(J[:99, 3:, j], turn, atol=1e-8)


def test_frames_and_jacobians_fill_arrays_that_are_given():
    chain, rng = random_tree(np.random.default_rng(5)), np.random.default_rng(9)
    tip, q = Tip(6, transform(None, [0.1, 0.2, 0.3])), rng.uniform(-2, 2, (300, 7))
    T, J = np.full((300, 4, 4), np.nan), np.full((300, 6, 7), np.nan)
    found = frames_and_jacobian(chain, q, tip, out=(T, J))
    assert found[0] is T and found[1] is J
    for given, new in zip((T, J), frames_and_jacobian(chain, q, tip), strict=True):
        np.testing.assert_array_equal(given, new)
    assert (J[:, :, [2, 4, 5]] == 0).all()  # joints that do not carry the tip
    with pytest.raises(ShapeError, match=r"out\[1\]: expected shape \(300, 6, 7\)"):
        frames_and_jacobian(chain, q, tip, out=(T, J[:, :3]))
    with pytest.raises(NotFiniteError, match=r"q\[3, 2\] = nan"):
        q[3, 2] = np.nan
        frames_and_jacobian(chain, q, tip)
    assert frames_and_jacobian(chain, q[:0], tip)[1].shape == (0, 6, 7)


@pytest.mark.parametrize("twist", [1e-11, 1e-8, 1e-5])
def test_axes_that_are_parallel_but_for_rounding(twist):
    """The common normal of such axes is not known to better than the rounding of the matrix."""
    rng = np.random.default_rng(10)
    turn = exp_rotation(np.array([0.0, 0, 0.4])) @ exp_rotation(np.array([twist, 0, 0]))
    noise = 1e-16 * rng.normal(size=(3, 3))
    offsets = np.stack([transform(turn @ exp_rotation(np.array([0, 0, 0.3])) + noise, [0.3, 0, 0])])
    along, limit = np.array([[0.0, 0, 1]]), np.array([2.0])
    chain = Chain(("a",), np.array([GROUND]), np.zeros(1, int), along, offsets, -limit, limit)
    tip = Tip(0, transform(None, [0.5, 0.0, 0.0]))
    q = rng.uniform(-2, 2, (50, 1))
    expected = body_frames(chain, q)[:, 0] @ tip.transform
    np.testing.assert_allclose(forward_kinematics(chain, q, tip), expected, atol=1e-15)
    np.testing.assert_allclose(positions(chain, q, tip), expected[:, :3, 3], atol=1e-15)
