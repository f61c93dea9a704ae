"""Passive motion: what eq. 5 demands, LSODA as oracle, and the magnitudes worked out for Fig. 3."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from selfmotion.arms import hip_shoulder_elbow, load_arm, planar, srs7, upper_limb, wrist
from selfmotion.errors import NotFiniteError, RangeError, ShapeError, UnknownNameError
from selfmotion.methods.passive.potentials import (
    EffortPotential,
    GravityPotential,
    JointLimitPotential,
)
from selfmotion.methods.passive.task_planners import (
    ForceField,
    MinimumJerk,
    MovementPrimitive,
    TargetSpring,
)
from selfmotion.methods.passive.tasks import arm_of, whole_task
from selfmotion.methods.passive_motion import (
    JointLaw,
    PlanSettings,
    inertia_damping,
    plan,
    plan_sequence,
)
from selfmotion.redundancy.projection import project
from selfmotion.redundancy.task import Planar, Pointing, Pose, Position, RowMask

RADIUS = np.pi / 12
ANGLES = np.radians(np.arange(0, 360, 45))
TARGETS = RADIUS * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
ROUTES = ([0], [2, 0], [4, 0], [6, 0], [1, 3, 5, 7, 0], [3, 6, 1, 0])
FAST = PlanSettings(spring=22.5)
# Tolerance of the implicit integration (rad) where what is tested holds to far less, or whatever
# the path: its steps are most of what these tests cost.
COARSE = 1e-6


def figure_3() -> JointLaw:
    return JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))


def law_of(n: int, seed: int = 0) -> JointLaw:
    """A stiffness that couples all joints, and a rest posture in front of the body."""
    L = np.random.default_rng(seed).normal(0.0, 0.3, (n, n))
    return JointLaw(L @ L.T + np.diag(np.linspace(0.5, 2.0, n)), np.linspace(0.3, 0.6, n))


CASES = {
    "wrist": lambda: Pointing(wrist()),
    "planar": lambda: Planar(planar([0.3, 0.25, 0.2])),
    "srs7": lambda: Position(srs7()),
    "nine": lambda: Position(upper_limb()),
    "nine rows": lambda: RowMask(Position(upper_limb()), (2, 0)),
    "pose": lambda: Pose(upper_limb(), rotation_scale=0.3),
}


@pytest.fixture(params=CASES, scope="module")
def case(request):
    task = CASES[request.param]()
    arm = arm_of(task)
    law = law_of(arm.n_joints)
    nearby = law.rest + np.random.default_rng(1).normal(0.0, 0.1, (3, arm.n_joints))
    return task, law, nearby, whole_task(task).value(nearby)[[1, 2, 0]]


def task_damping(task, law, q):
    J = task.jacobian(q)
    W = np.broadcast_to(law.damping, (len(J), *law.damping.shape))
    return np.linalg.inv(J @ np.linalg.solve(W, np.swapaxes(J, 1, 2)))


def growth(t, tau):
    return 1.0 - np.exp(-t / tau) - t / tau * np.exp(-t / tau)


def oracle(task, law, target, K, model):
    """The right-hand side straight from the paper, through the library's projector."""

    def slope(t, q):
        J = task.jacobian(q)
        p = project(J, law.damping)
        spring = growth(t, law.spring_time) * K @ task.error(q, target)[0]
        xd = J[0] @ np.linalg.solve(law.damping, J[0].T @ spring)
        relax = -np.linalg.solve(law.damping, law.stiffness @ (q - law.rest))
        own = {"lambda0": p.null[0] @ relax, "pmp1": 0.0 * relax, "pmp2": relax}[model]
        return p.inverse[0] @ xd + own

    return slope


def test_eq_5_holds_at_every_sample(case):
    task, law, start, targets = case
    motion = plan(task, law, start, targets, PlanSettings(spring=30.0, tolerance=COARSE))
    assert motion.status.ok
    for i in range(len(motion)):
        B = task_damping(task, law, motion.q[i])
        force = growth(motion.time, law.spring_time)[:, None] * (
            task.error(motion.q[i], targets[i]) @ motion.spring[i]
        )
        np.testing.assert_allclose(
            np.einsum("kab,kb->ka", B, motion.xd[i]), force, atol=1e-9 * np.abs(force).max()
        )


@pytest.mark.parametrize("model", ["lambda0", "pmp1", "pmp2"])
def test_lsoda_agrees(case, model):
    task, law, start, targets = case
    settings = PlanSettings(spring=10.0, model=model, n_steps=50, tolerance=1e-7)
    motion = plan(task, law, start, targets, settings)
    slope = oracle(task, law, targets[0], motion.spring[0], model)
    found = solve_ivp(slope, (0.0, 0.4), start[0], "LSODA", motion.time, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(motion.q[0], found.y.T, atol=1e-5)
    for t, q, qd in zip(motion.time[::10], motion.q[0, ::10], motion.qd[0, ::10], strict=True):
        np.testing.assert_allclose(qd, slope(t, q), atol=1e-8)


def ends(model, duration):
    task, law = Pointing(wrist()), figure_3()
    settings = PlanSettings(spring=22.5, model=model, duration=duration)
    return [plan_sequence(task, law, law.rest, TARGETS[route], settings) for route in ROUTES]


def test_lambda0_ends_in_one_posture_whatever_the_path():
    short, long = (
        np.degrees(np.ptp([m.end[-1] for m in ends("lambda0", t)], axis=0)) for t in (0.4, 1.2)
    )
    assert 0.4 < short.max() < 1.2
    assert long.max() < 4e-4
    assert max(m.end_error[-1] for m in ends("lambda0", 1.2)) < 1e-12


def test_pmp1_depends_on_the_path_and_drifts():
    spread = np.degrees(np.ptp([m.end[-1] for m in ends("pmp1", 1.2)], axis=0))
    assert 40.0 < spread.max() < 70.0
    law = figure_3()
    round_trip = plan_sequence(
        Pointing(wrist()),
        law,
        law.rest,
        TARGETS[[0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7, 0]],
        PlanSettings(spring=22.5, model="pmp1"),
    )
    drift = np.degrees(round_trip.end[16, 0] - round_trip.end[8, 0])
    assert 40.0 < drift < 75.0


def test_pmp2_keeps_its_posture_but_misses_the_target():
    found = ends("pmp2", 1.2)
    assert np.degrees(np.ptp([m.end[-1] for m in found], axis=0)).max() < 1e-3
    law = figure_3()
    settings = PlanSettings(spring=22.5, model="pmp2", duration=1.2)
    missed = plan(Pointing(wrist()), law, law.rest, TARGETS, settings).end_error / RADIUS
    assert 0.05 < missed.min() < missed.max() < 0.10


def test_opposite_targets_mirror_each_other_where_the_law_is_symmetric():
    law = figure_3()
    motion = plan(Pointing(wrist()), law, law.rest, TARGETS, FAST)
    np.testing.assert_allclose(motion.x[:4], -motion.x[4:], atol=1e-14)
    coupled = JointLaw(law.stiffness + 0.3 * (np.eye(3)[[1, 0, 2]] - np.diag([0, 0, 1])), law.rest)
    motion = plan(Pointing(wrist()), coupled, law.rest, TARGETS, FAST)
    assert np.abs(motion.x[:4] + motion.x[4:]).max() > 1e-3


def test_eq_10_gives_the_spring_of_the_paper():
    law = figure_3()
    motion = plan(Pointing(wrist()), law, law.rest, TARGETS)
    # J at the centre is a rotation of the FE and RUD columns: B = τ₀ diag(1.5, 2), k = 2.
    np.testing.assert_allclose(motion.spring, np.broadcast_to(2.0 * np.eye(2), (8, 2, 2)))
    assert 4e-3 < motion.end_error.min() < motion.end_error.max() < 15e-3
    peaks = plan(Pointing(wrist()), law, law.rest, TARGETS, FAST)
    assert (peaks.x[:, 50] - TARGETS < 0.02 * RADIUS).all()  # 22.5: nearly there after 0.2 s


@pytest.mark.parametrize(
    "spring", [22.5, 1e3, *(pytest.param(k, marks=pytest.mark.long) for k in (1e6, 1e9))]
)
def test_it_stays_stable_whatever_the_stiffness(spring):
    law = figure_3()
    coarse, fine = (
        plan(
            Pointing(wrist()),
            law,
            law.rest,
            TARGETS[:2],
            PlanSettings(spring=spring, n_steps=n),
        )
        for n in (20, 400)
    )
    assert coarse.status.ok
    assert fine.status.ok
    np.testing.assert_allclose(coarse.q[:, 4:], fine.q[:, 80::20], atol=2e-5)


def test_constant_and_anisotropic_springs():
    law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.zeros(3), spring_time=0.0)
    K = np.array([[3.0, 0.5], [0.5, 6.0]])
    motion = plan(Pointing(wrist()), law, law.rest, TARGETS[1], PlanSettings(spring=K))
    B = task_damping(Pointing(wrist()), law, motion.q[0])
    pulled = (TARGETS[1] - motion.x[0]) @ K
    np.testing.assert_allclose(np.einsum("kab,kb->ka", B, motion.xd[0]), pulled, atol=1e-10)
    assert motion.speed[0].argmax() == 0  # without growth the speed is greatest at once


def test_locked_joints_do_not_move():
    law = law_of(3)
    start = np.array([0.2, 0.0, 0.1])
    task = Pointing(wrist())
    settings = PlanSettings(spring=22.5, locked=("pronation",))
    motion = plan(task, law, start, TARGETS[3], settings)
    assert (motion.q[0, :, 0] == 0.2).all()
    # Two joints for two rows: the motion is that of the damping block alone.
    W, K = law.damping[1:, 1:], motion.spring[0]

    def slope(t, q):
        at = np.array([0.2, *q])
        J = task.jacobian(at)[0][:, 1:]
        pull = growth(t, law.spring_time) * K @ task.error(at, TARGETS[3])[0]
        return np.linalg.solve(W, J.T @ pull)

    found = solve_ivp(slope, (0.0, 0.4), start[1:], "LSODA", motion.time, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(motion.q[0, :, 1:], found.y.T, atol=3e-6)
    with pytest.raises(UnknownNameError, match="did you mean 'pronation'"):
        plan(task, law, start, TARGETS[3], PlanSettings(locked=("pronatio",)))


def test_kernels_and_implicit_integration_agree(case):
    task, law, start, targets = case
    given = PlanSettings(spring=20.0, n_steps=40, locked=())
    other = PlanSettings(
        spring=20.0,
        n_steps=40,
        tolerance=COARSE,
        damping=lambda q: np.repeat(law.damping[None], len(q), axis=0),
    )
    one, two = (plan(task, law, start, targets, s) for s in (given, other))
    np.testing.assert_allclose(one.q, two.q, atol=1e-5)
    np.testing.assert_allclose(one.xd, two.xd, atol=2e-4)


def test_damping_given_shapes_the_path():
    task, law = Planar(planar([0.3, 0.25, 0.2])), law_of(3)
    start = np.array([0.4, 0.9, 0.5])
    target = task.value(start)[0] + [-0.1, 0.12]
    settings = PlanSettings(spring=40.0, damping=np.array([1.0, 0.5, 0.2]))
    motion = plan(task, law, start, target, settings)
    J = task.jacobian(motion.q[0])
    B = np.linalg.inv(J / np.array([1.0, 0.5, 0.2]) @ np.swapaxes(J, 1, 2))
    pull = growth(motion.time, 0.08)[:, None] * 40.0 * (target - motion.x[0])
    np.testing.assert_allclose(np.einsum("kab,kb->ka", B, motion.xd[0]), pull, atol=1e-9)


def test_inertia_as_damping():
    arm = hip_shoulder_elbow()
    task, law = Planar(arm), law_of(3)
    damping = inertia_damping(arm, 5.0)
    start = np.array([0.4, 0.9, 0.5])
    target = task.value(start)[0] + [-0.05, 0.05]
    motion = plan(
        task, law, start, target, PlanSettings(spring=200.0, damping=damping, tolerance=COARSE)
    )
    W = damping(motion.q[0])
    J = task.jacobian(motion.q[0])
    B = np.linalg.inv(J @ np.linalg.solve(W, np.swapaxes(J, 1, 2)))
    pull = growth(motion.time, 0.08)[:, None] * 200.0 * (target - motion.x[0])
    np.testing.assert_allclose(np.einsum("kab,kb->ka", B, motion.xd[0]), pull, atol=1e-7)


def test_other_potentials_stay_out_of_the_task_and_shape_the_posture():
    arm = planar([0.3, 0.25, 0.2]).with_limits(
        {name: (-2.5, 2.5) for name in planar([0.3, 0.25, 0.2]).joints}
    )
    task, law = Planar(arm), JointLaw(np.diag([1.0, 0.8, 0.5]), np.array([0.2, 0.4, 1.9]))
    wall = JointLimitPotential(arm.lower, arm.upper, margin=0.9, strength=8.0)
    weight = GravityPotential(arm, share=0.1)
    start = np.array([0.3, 0.5, 1.5])
    target = task.value(start)[0] + [-0.05, 0.05]
    settings = PlanSettings(spring=40.0, duration=3.0, potentials=(wall, weight), tolerance=COARSE)
    motion = plan(task, law, start, target, settings)
    B = task_damping(task, law, motion.q[0])
    pull = growth(motion.time, 0.08)[:, None] * 40.0 * (target - motion.x[0])
    np.testing.assert_allclose(np.einsum("kab,kb->ka", B, motion.xd[0]), pull, atol=1e-7)

    def energy(q):
        e = q - law.rest
        q = q[None]
        return 0.5 * e @ law.stiffness @ e + wall.energy(q)[0] + weight.energy(q)[0]

    least = minimize(
        energy,
        start,
        method="SLSQP",
        constraints={"type": "eq", "fun": lambda q: task.error(q, target)[0]},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    np.testing.assert_allclose(motion.end[0], least.x, atol=2e-5)


def test_minimum_jerk_is_followed_exactly():
    law = figure_3()
    task = Pointing(wrist())
    settings = PlanSettings(spring=5.0, planner=MinimumJerk(), duration=0.6)
    motion = plan(task, law, law.rest, TARGETS, settings)
    s = motion.time / 0.6
    share = 10 * s**3 - 15 * s**4 + 6 * s**5
    np.testing.assert_allclose(motion.x, share[:, None] * TARGETS[:, None], atol=1e-7)
    lagging = PlanSettings(spring=5.0, planner=MinimumJerk(follow=False), duration=0.6)
    assert plan(task, law, law.rest, TARGETS, lagging).end_error.min() > 5e-4


def test_a_primitive_repeats_the_recorded_path():
    u = np.linspace(0.0, 1.0, 200)
    share = 10 * u**3 - 15 * u**4 + 6 * u**5
    path = np.stack([0.2 * share, 0.05 * np.sin(np.pi * share) ** 2], axis=1)
    primitive = MovementPrimitive.from_path(0.5 * u, path)
    law, task = figure_3(), Pointing(wrist())
    settings = PlanSettings(spring=5.0, planner=primitive, duration=0.5, n_steps=199)
    same = plan(task, law, law.rest, [0.2, 0.0], settings)
    np.testing.assert_allclose(same.x[0], path, atol=2e-3)
    # To the north it is the same path, turned by a quarter and half as long.
    north = plan(task, law, law.rest, [0.0, 0.1], settings)
    np.testing.assert_allclose(north.x[0], 0.5 * same.x[0] @ [[0.0, 1.0], [-1.0, 0.0]], atol=1e-6)


def test_a_force_field_that_is_the_spring_moves_like_the_spring():
    law, task = figure_3(), Pointing(wrist())
    field = ForceField(lambda t, x, goal: 22.5 * growth(t, 0.08) * (goal - x))
    one = plan(task, law, law.rest, TARGETS, PlanSettings(spring=22.5, planner=TargetSpring()))
    two = plan(task, law, law.rest, TARGETS, PlanSettings(planner=field, tolerance=COARSE))
    np.testing.assert_allclose(one.q, two.q, atol=5e-6)


def test_a_musculoskeletal_arm_with_an_effort_follows_eq_5():
    arm = load_arm("myoarm")
    task, law = Position(arm), JointLaw(np.eye(arm.n_joints), arm.middle())
    effort = EffortPotential(lambda q: (np.sin(q).sum(axis=1)) ** 2, scale=0.5)
    target = task.value(law.rest)[0] + [0.03, 0.04, 0.0]
    settings = PlanSettings(spring=50.0, potentials=(effort,), n_steps=10, tolerance=1e-6)
    motion = plan(task, law, law.rest, target, settings)
    assert motion.status.ok
    B = task_damping(task, law, motion.q[0])
    pull = growth(motion.time, 0.08)[:, None] * 50.0 * (target - motion.x[0])
    np.testing.assert_allclose(np.einsum("kab,kb->ka", B, motion.xd[0]), pull, atol=1e-7)


def test_targets_out_of_reach_say_so():
    law = figure_3()
    motion = plan(Pointing(wrist()), law, law.rest, [[1.4, 0.0], [0.2, 0.0]], FAST)
    assert [s.ok for s in motion.statuses] == [False, True]
    assert "out of reach" in motion.statuses[0].sentence
    assert "movement 1" in motion.status.sentence
    arm = planar([0.3, 0.25, 0.2])
    motion = plan(Planar(arm), law, [0.3, 0.6, 0.5], [0.8, 0.3], PlanSettings(spring=50.0))
    assert "out of reach" in motion.status.sentence
    # 0.854 m away, and the arm is 0.75 m long.
    missing = np.hypot(0.8, 0.3) - 0.75
    assert f"{missing:.3g}" in motion.status.sentence


def test_a_lost_rank_is_reported():
    arm = planar([0.3, 0.25, 0.2])
    law = JointLaw(np.eye(3), np.zeros(3))
    motion = plan(Planar(arm), law, np.zeros(3), [0.6, 0.1], PlanSettings(spring=20.0))
    assert "lost rank at 0 s" in motion.status.sentence
    with pytest.raises(RangeError, match="lost rank where movement 1 starts"):
        plan(Planar(arm), law, np.zeros(3), [0.6, 0.1])


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"stiffness": np.diag([1.0, -1.0, 1.0])}, RangeError, "positive definite"),
        ({"stiffness": np.triu(np.ones((3, 3)))}, RangeError, "symmetric"),
        ({"rest": np.array([0.0, np.nan, 0.0])}, NotFiniteError, "not finite"),
        ({"damping_time": 0.0}, RangeError, "damping_time = 0 s"),
        ({"spring_time": -0.1}, RangeError, "spring_time"),
    ],
)
def test_a_bad_law_is_refused(change, error, words):
    fields = {"stiffness": np.eye(3), "rest": np.zeros(3)} | change
    with pytest.raises(error, match=words) as caught:
        JointLaw(**fields)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"duration": -1.0}, "duration"),
        ({"n_steps": 0}, "n_steps"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"model": "pmp1", "potentials": (GravityPotential(wrist()),)}, "no joint potential"),
    ],
)
def test_bad_settings_are_refused(settings, words):
    with pytest.raises(RangeError, match=words):
        PlanSettings(**settings)


def test_bad_movements_are_refused():
    law, task = figure_3(), Pointing(wrist())
    with pytest.raises(ShapeError, match="start has 2 rows, targets 3"):
        plan(task, law, np.zeros((2, 3)), np.zeros((3, 2)))
    with pytest.raises(NotFiniteError):
        plan(task, law, law.rest, [np.nan, 0.0])
    with pytest.raises(ShapeError, match="law has 3 joints"):
        plan(Position(srs7()), law, np.zeros(7), np.zeros(3))
    with pytest.raises(RangeError, match="spring = -1"):
        plan(task, law, law.rest, TARGETS, PlanSettings(spring=-1.0))
    with pytest.raises(RangeError, match="at least one joint"):
        plan(task, law, law.rest, TARGETS, PlanSettings(locked=wrist().joints))


def test_tables_and_recordings_hold_the_same_numbers():
    law = figure_3()
    motion = plan(Pointing(wrist()), law, law.rest, TARGETS[:2], FAST).named(("E", "NE"))
    frame = motion.to_frame()
    assert list(frame["movement"].unique()) == ["E", "NE"]
    np.testing.assert_array_equal(frame["flexion"][101:], motion.q[1, :, 1])
    recording = motion.study(subject="S1")[1]
    np.testing.assert_array_equal(recording.array("x"), motion.x[1])
    assert recording.labels.target == "NE"
    assert list(motion.summary()["ok"]) == [True, True]
