"""Joint-limited inverse kinematics: answers are checked by what they must satisfy."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from selfmotion.arms import load_arm
from selfmotion.errors import NotFiniteError, RangeError, ShapeError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_seeds import seed_table
from selfmotion.methods.reaching.ik_tasks import (
    ROWS,
    HandRows,
    goals_of,
    roll_pitch_yaw,
    rotation_of,
)
from selfmotion.methods.reaching.saturation import saturated_posture
from selfmotion.redundancy.task import Pose, Position
from selfmotion.spatial import exp_rotation, log_rotation

SPLINT = {"elbow_flexion": (np.deg2rad(64.2), np.deg2rad(114.0))}
REST = np.deg2rad([0, 0, 0, 90, 0, 20, 0, 0, 0.0])
ROW_SETS = [
    ("x", "y", "z"),
    ROWS,
    ("x", "y", "z", "rot_y"),
    ("x", "z", "rot_x"),
    ("y", "rot_z"),
    ("x", "y", "z", "rot_x", "rot_y"),
    ("x", "y", "z", "rot_y", "rot_z"),
    ("x", "y", "z", "rot_x", "rot_z"),
    ("rot_x", "rot_y", "rot_z"),
]


def upper_limb(splint: bool = False):
    arm = load_arm("upper_limb")
    return arm.with_limits(SPLINT) if splint else arm


def hand(arm, q):
    return forward_kinematics(arm.chain, q, arm.tip("hand"))


@pytest.mark.parametrize("start", ["rest", "middle", "random", None])
@pytest.mark.parametrize("kind", [Position, Pose])
@pytest.mark.parametrize("splint", [False, True])
def test_every_reachable_target_is_reached_inside_the_limits(splint, kind, start):
    arm, rng = upper_limb(splint), np.random.default_rng(7)
    T = hand(arm, arm.random_postures(500, rng))
    starts = {
        "rest": REST,
        "middle": arm.middle(),
        "random": arm.random_postures(500, rng),
        None: None,
    }
    target = T[:, :3, 3] if kind is Position else T
    solution = solve_ik(kind(arm), target, start=starts[start])
    found = hand(arm, solution.q)
    assert solution.status.ok and solution.solved.all()
    assert np.linalg.norm(found[:, :3, 3] - T[:, :3, 3], axis=1).max() < 1e-5
    if kind is Pose:
        turn = log_rotation(T[:, :3, :3] @ np.swapaxes(found[:, :3, :3], 1, 2))
        assert np.linalg.norm(turn, axis=1).max() < 1e-3
    assert (solution.q >= arm.lower).all() and (solution.q <= arm.upper).all()


@pytest.mark.parametrize("rows", ROW_SETS, ids=",".join)
def test_any_rows_can_be_held(rows):
    arm, rng = upper_limb(), np.random.default_rng(8)
    task = HandRows(arm, rows)
    target = task.value(arm.random_postures(100, rng))
    solution = solve_ik(task, target)
    assert solution.solved.all()
    value = task.value(solution.q)
    pitch = roll_pitch_yaw(hand(arm, solution.q)[:, :3, :3])[:, 1]
    # Roll and yaw blow up near gimbal lock: there an error of 1e-5 rad turns them by more.
    difference = (value - target + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(difference * np.cos(pitch)[:, None]).max() < 3e-5
    assert np.abs(task.error(solution.q, target)).max() < 1e-5


@pytest.mark.parametrize("rows", ROW_SETS, ids=",".join)
def test_jacobian_is_the_derivative_of_the_error(rows):
    arm, rng = upper_limb(), np.random.default_rng(9)
    task = HandRows(arm, rows)
    q = arm.random_postures(1, rng)
    target = task.value(q)
    J, h = task.jacobian(q)[0], 1e-6
    for j in range(arm.n_joints):
        step = np.zeros(arm.n_joints)
        step[j] = h
        slope = (task.error(q - step, target) - task.error(q + step, target))[0] / (2 * h)
        np.testing.assert_allclose(slope, J[:, j], atol=2e-8)


@pytest.mark.parametrize("rows", [r for r in ROW_SETS if any("rot" in x for x in r)], ids=",".join)
def test_orientation_error_is_the_least_turn(rows):
    """An independent search over the angles left free finds no smaller turn."""
    arm, rng = upper_limb(), np.random.default_rng(10)
    task = HandRows(arm, rows)
    q, goal_q = arm.random_postures(2, rng)
    goal = roll_pitch_yaw(hand(arm, goal_q)[0, :3, :3])
    R = hand(arm, q)[0, :3, :3]
    free = [i for i in range(3) if i not in task.angles]

    def turn(x):
        angles = goal.copy()
        angles[free] = x
        angles[1] = np.clip(angles[1], -np.pi / 2, np.pi / 2)
        return log_rotation(rotation_of(angles) @ R.T)

    best = np.linalg.norm(turn(np.zeros(0))) if not free else np.inf
    if free:
        grid = np.linspace(-np.pi, np.pi, 13)
        starts = np.array(np.meshgrid(*[grid] * len(free))).reshape(len(free), -1).T
        begin = sorted(starts, key=lambda x: np.linalg.norm(turn(x)))[:4]
        best = min(np.linalg.norm(least_squares(turn, x).fun) for x in begin)
    error = task.error(q, task.value(goal_q))[0, len(task.axes) :]
    assert np.linalg.norm(error) == pytest.approx(best, abs=1e-5)


@pytest.mark.parametrize("name", ["planar", "wrist", "exoskeleton", "srs7", "hip_shoulder_elbow"])
def test_other_arms(name):
    arm, rng = load_arm(name), np.random.default_rng(11)
    T = hand(arm, arm.random_postures(100, rng))
    solution = solve_ik(Position(arm), T[:, :3, 3])
    assert solution.solved.all()
    np.testing.assert_allclose(hand(arm, solution.q)[:, :3, 3], T[:, :3, 3], atol=1e-5)


def test_coupled_joints_of_the_musculoskeletal_arm():
    arm = load_arm("myoarm")
    arm = getattr(arm, "arm", arm)
    T = hand(arm, arm.random_postures(50, np.random.default_rng(12)))
    solution = solve_ik(Position(arm), T[:, :3, 3])
    assert solution.solved.all()
    np.testing.assert_allclose(hand(arm, solution.q)[:, :3, 3], T[:, :3, 3], atol=1e-5)


def test_out_of_reach_ends_at_the_nearest_posture():
    """Beyond a stretched planar arm the nearest point is on the ray, by hand."""
    arm = load_arm("planar")
    length = np.linalg.norm(hand(arm, np.zeros(arm.n_joints))[0, :3, 3])
    target = np.array([[1.5 * length, 0.0, 0.0]])
    solution = solve_ik(Position(arm), target)
    assert not solution.status.ok and not solution.solved[0]
    if (arm.lower <= 0).all() and (arm.upper >= 0).all():
        assert solution.position_error[0] == pytest.approx(0.5 * length, abs=1e-3)
    assert solution.sentences()[0].startswith("not reached: ")


def test_weights_keep_a_joint_still():
    arm = upper_limb()
    weights = np.ones(9)
    weights[5] = 1e6
    target = hand(arm, REST)[:, :3, 3] + [[0.02, 0.03, 0.01]]
    light, heavy = (solve_ik(Position(arm), target, start=REST, weights=w) for w in (None, weights))
    assert heavy.solved.all()
    assert abs(heavy.q[0, 5] - REST[5]) < 1e-3 < abs(light.q[0, 5] - REST[5])


def test_published_scheme_solves_some_and_never_leaves_the_limits():
    arm, rng = upper_limb(), np.random.default_rng(13)
    target = hand(arm, arm.random_postures(200, rng))[:, :3, 3]
    options = IkOptions(scheme="published", max_iterations=500, position_tolerance=1e-5)
    middle = solve_ik(Position(arm), target, start=arm.middle(), options=options)
    edge = solve_ik(
        Position(arm), target, start=arm.lower + 1e-3 * (arm.upper - arm.lower), options=options
    )
    assert middle.solved.mean() > 0.9  # with the error clipped, from the middle
    assert edge.solved.mean() < 0.1  # saturated joints brake leaving a limit, too
    for solution in (middle, edge):
        assert (solution.q >= arm.lower).all() and (solution.q <= arm.upper).all()


def test_published_step_is_eqs_12_to_16():
    """One step, written out with NumPy from the paper's equations."""
    arm = upper_limb()
    q, target = arm.middle() + 0.1, np.array([[0.3, 0.4, 0.0]])
    options = IkOptions(scheme="published", max_iterations=1, damping=1e-3, error_clip=np.inf)
    found = solve_ik(Position(arm), target, start=q, options=options).q[0]
    width, middle = arm.upper - arm.lower, arm.middle()
    v = np.tan(np.pi / 2 * (2 * q - arm.upper - arm.lower) / width)
    dzeta = np.diag(width / np.pi / (1 + v**2))
    task = Position(arm)
    Jc = task.jacobian(q)[0] @ dzeta
    v = v + Jc.T @ np.linalg.solve(Jc @ Jc.T + 1e-3 * np.eye(3), task.error(q, target)[0])
    np.testing.assert_allclose(found, width / np.pi * np.arctan(v) + middle, atol=1e-12)


def test_saturated_postures_are_the_inverse_of_eq_10():
    arm, v = upper_limb(), np.linspace(-8.0, 8.0, 9)
    q, slopes = saturated_posture(arm, v)
    back = np.tan(np.pi / 2 * (2 * q - arm.upper - arm.lower) / (arm.upper - arm.lower))
    np.testing.assert_allclose(back, np.tile(v[:, None], len(arm.joints)), rtol=1e-9, atol=1e-12)
    above, below = (saturated_posture(arm, v + h)[0] for h in (1e-5, -1e-5))
    np.testing.assert_allclose(slopes, (above - below) / 2e-5, rtol=1e-6)
    apart = saturated_posture(arm, np.tile(v[:, None], len(arm.joints)))
    np.testing.assert_array_equal(apart[0], q)


def test_threads_and_batches_change_nothing():
    arm, rng = upper_limb(), np.random.default_rng(14)
    task = Position(arm)
    target = hand(arm, arm.random_postures(600, rng))[:, :3, 3]
    seeds = seed_table(HandRows(arm, ("x", "y", "z")))
    one = solve_ik(task, target, seeds=seeds)
    two = solve_ik(task, target, seeds=seeds, options=IkOptions(threads=2))
    np.testing.assert_array_equal(one.q, two.q)
    np.testing.assert_array_equal(one.q[5], solve_ik(task, target[5], seeds=seeds).q[0])
    frame = one.to_frame()
    assert list(frame.columns[:9]) == list(arm.joints)
    assert set(frame["status"]) == {"solved"}


def test_rotation_vector_targets_of_a_pose():
    arm = upper_limb()
    T = hand(arm, arm.middle())
    rows = Pose(arm).value(arm.middle())
    goals = goals_of(Pose(arm), rows)
    np.testing.assert_allclose(goals.rotation, T[:, :3, :3], atol=1e-12)
    np.testing.assert_allclose(exp_rotation(rows[:, 3:]), T[:, :3, :3], atol=1e-12)


def test_poses_at_the_ends_of_all_ranges_are_reached():
    """Their basins are small: evenly spread restarts alone miss one of eight."""
    arm, rng = upper_limb(), np.random.default_rng(16)
    corners = np.where(rng.random((200, 9)) < 0.5, arm.lower, arm.upper)
    for task, part in ((Pose(arm), np.s_[:]), (Position(arm), np.s_[:, :3, 3])):
        assert solve_ik(task, hand(arm, corners)[part]).solved.all()


@pytest.mark.parametrize("moving", ["scapula_elevation", "elbow_flexion", "wrist_pronation"])
def test_all_joints_locked_but_one(moving):
    arm, rng = upper_limb(), np.random.default_rng(17)
    middle = dict(zip(arm.joints, arm.middle(), strict=True))
    arm = arm.with_limits({j: (v, v) for j, v in middle.items() if j != moving})
    q = arm.random_postures(40, rng)
    solution = solve_ik(Pose(arm), hand(arm, q))
    assert solution.solved.all()
    np.testing.assert_allclose(solution.q, q, atol=1e-3)


def test_no_weights_keep_a_target_from_being_reached():
    arm, rng = upper_limb(), np.random.default_rng(18)
    target = hand(arm, arm.random_postures(40, rng))[:, :3, 3]
    for weight in (1e-12, 1e-300, 1e300):
        assert solve_ik(Position(arm), target, weights=[weight] + [1.0] * 8).solved.all()


@pytest.mark.parametrize("rows", [("x", "y", "z"), ("x", "rot_z"), ROWS], ids=",".join)
def test_out_of_reach_is_as_near_as_scipy_comes(rows):
    arm, rng = upper_limb(True), np.random.default_rng(19)
    task = HandRows(arm, rows)
    far = task.value(arm.random_postures(6, rng))
    far[:, : len(task.axes)] *= 2.5
    found = solve_ik(task, far)
    scale = task.row_scale
    for k in np.flatnonzero(~found.solved)[:3]:
        ours = np.hypot(found.position_error[k], task.rotation_scale * found.rotation_error[k])
        best = min(
            least_squares(
                lambda q, k=k: scale * task.error(q, far[k])[0],
                start,
                jac=lambda q, k=k: -scale[:, None] * task.jacobian(q)[0],  # pyright: ignore[reportArgumentType]
                bounds=(arm.lower, arm.upper),
            ).cost
            for start in arm.random_postures(3, rng)
        )
        assert ours < np.sqrt(2 * best) + 5e-3


def test_bad_targets_and_options():
    arm = upper_limb()
    with pytest.raises(RangeError, match=r"target\[0, 1\] = 1e\+300: allowed is up to 1e\+06"):
        solve_ik(Position(arm), [[0.1, 1e300, 0.2]])
    for wrong in (np.diag([2.0, 2, 2, 1]), np.diag([1.0, 1, -1, 1])):
        with pytest.raises(RangeError, match=r"target\[0\]: .* no rotation"):
            solve_ik(Pose(arm), wrong[None])
    with pytest.raises(RangeError, match="position_tolerance = inf: must be finite"):
        IkOptions(position_tolerance=np.inf)


def test_bad_input():
    arm = upper_limb()
    task = Position(arm)
    with pytest.raises(ShapeError, match=r"target has shape \(1, 2\)"):
        solve_ik(task, [[0.1, 0.2]])
    with pytest.raises(NotFiniteError, match="target"):
        solve_ik(task, [[0.1, 0.2, np.nan]])
    with pytest.raises(ShapeError, match="start has shape"):
        solve_ik(task, [[0.1, 0.2, 0.3]], start=np.zeros(8))
    with pytest.raises(RangeError, match="weight of elbow_flexion = 0"):
        solve_ik(task, [[0.1, 0.2, 0.3]], weights=[1, 1, 1, 1, 1, 0, 1, 1, 1])
    with pytest.raises(RangeError, match="restarts = -1"):
        IkOptions(restarts=-1)
    with pytest.raises(UnknownNameError, match="did you mean 'rot_y'"):
        HandRows(arm, ("x", "rot_yy"))
    with pytest.raises(RangeError, match="seed table"):
        solve_ik(
            Position(upper_limb(True)),
            [[0.1, 0.2, 0.3]],
            seeds=seed_table(HandRows(arm, ("x", "y", "z"))),
        )
