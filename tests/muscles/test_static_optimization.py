import mujoco
import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

from selfmotion.errors import ModelError, RangeError, ShapeError, UnknownNameError
from selfmotion.kinematics.dynamics import inertia_matrix
from selfmotion.muscles import qp_kernels
from selfmotion.muscles.static_optimization import (
    EffortOptions,
    muscle_effort,
    muscle_problem,
    required_torque,
    with_hand_load,
)


def problems(rng, count, scale):
    """Random problems of arm-like sizes; a large scale makes most of them infeasible."""
    A = rng.normal(size=(count, 40, 7)) * np.array([40, 40, 20, 20, 5, 5, 5.0])
    A *= rng.random((count, 40, 7)) < 0.4
    return A, scale * rng.normal(size=(count, 7)) * np.array([10, 10, 5, 5, 1, 1, 1.0])


def solve(A, b, lower, exponent=2.0):
    a, x = np.empty(A.shape[:2]), np.empty(b.shape)
    iterations = qp_kernels.solve_many(
        A, b, np.full(A.shape[1], lower), np.ones(A.shape[1]), exponent, a, x
    )
    return a, x, iterations


@pytest.mark.parametrize("lower", [0.0, 0.01])
def test_the_dual_newton_meets_the_conditions_of_optimality(lower):
    A, b = problems(np.random.default_rng(1), 200, 1.0)
    a, x, iterations = solve(A, b, lower)
    assert (iterations >= 0).all()
    assert np.einsum("kmn,km->kn", A, a) == pytest.approx(b, abs=1e-7)
    t = np.einsum("kmn,kn->km", A, x)
    assert a == pytest.approx(np.clip(t, lower, 1.0), abs=1e-9)  # KKT: stationarity, bounds


def test_an_infeasible_torque_gives_the_least_residual():
    A, b = problems(np.random.default_rng(2), 60, 40.0)
    a, _, iterations = solve(A, b, 0.0)
    assert (iterations >= 0).all()
    for k in range(len(A)):
        residual = np.linalg.norm(b[k] - A[k].T @ a[k])
        oracle = lsq_linear(A[k].T, b[k], (0.0, 1.0), tol=1e-14)
        assert residual == pytest.approx(np.sqrt(2 * oracle.cost), rel=1e-6, abs=1e-6)


def test_other_exponents_agree_with_scipy():
    A, b = problems(np.random.default_rng(3), 3, 1.0)
    a, _, _ = solve(A, b, 0.0, exponent=3.0)
    for k in range(len(A)):
        oracle = minimize(
            lambda v: (v**3).sum(),
            a[k] * 0 + 0.3,
            jac=lambda v: 3 * v**2,
            bounds=[(0, 1)] * A.shape[1],
            constraints={"type": "eq", "fun": lambda v, k=k: A[k].T @ v - b[k]},
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 500},
        )
        assert np.einsum("mn,m->n", A[k], a[k]) == pytest.approx(b[k], abs=1e-6)
        assert (a[k] ** 3).sum() <= oracle.fun * (1 + 1e-5)


def test_effort_balances_gravity_and_daqp_agrees(muscle_arm):
    q = muscle_arm.arm.random_postures(12, np.random.default_rng(4))
    ours = muscle_effort(muscle_arm, q)
    other = muscle_effort(muscle_arm, q, options=EffortOptions(solver="daqp"))
    held = np.array([bool(s) for s in ours.status])
    assert held.sum() > 8
    problem = muscle_problem(muscle_arm, q, EffortOptions())
    given = np.einsum("kmn,km->kn", problem.strength, ours.activations)
    assert given[held] == pytest.approx(ours.torque[held], abs=1e-6)
    assert ours.effort == pytest.approx(other.effort, rel=1e-6)
    assert ours.to_frame().shape == (12, 2 + len(muscle_arm.muscles.names))


def test_what_no_muscle_can_hold_names_the_coordinate(muscle_arm):
    q = np.zeros(7)
    q[1], q[3] = np.pi / 2, 0.3
    heavy = muscle_effort(muscle_arm, q, options=EffortOptions(hand_load=60.0))
    assert not heavy.status[0]
    assert "lacks" in heavy.status[0].sentence and "N m" in heavy.status[0].sentence
    assert np.abs(heavy.missing[0]).max() > 1.0


def test_torque_of_a_movement_is_that_of_mujoco(muscle_arm):
    rng = np.random.default_rng(5)
    arm, geometry = muscle_arm.arm, muscle_arm.geometry
    model, ids = geometry.model, geometry.joint_ids
    data = mujoco.MjData(model)
    q, qd, qdd = arm.random_postures(1, rng), rng.normal(size=(1, 7)), rng.normal(size=(1, 7))
    torque = required_torque(arm, q, EffortOptions(), qd, qdd)[0]
    C = arm.chain.coupling.derivative(q)[0]
    data.qpos[model.jnt_qposadr[ids]] = arm.chain.coupling.value(q)[0]
    data.qvel[model.jnt_dofadr[ids]] = C @ qd[0]
    data.qacc[model.jnt_dofadr[ids]] = C @ qdd[0]  # the coupling is linear: no more terms
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    out = np.zeros(model.nv)
    mujoco.mj_rne(model, data, 1, out)
    assert torque == pytest.approx(C.T @ out[model.jnt_dofadr[ids]], abs=1e-6)


def test_a_load_in_the_hand_adds_its_weight_at_the_hand(muscle_arm):
    arm = muscle_arm.arm
    q = arm.random_postures(2, np.random.default_rng(6))
    from selfmotion.kinematics.forward import geometric_jacobian

    added = required_torque(arm, q, EffortOptions(hand_load=2.0)) - required_torque(
        arm, q, EffortOptions()
    )
    J = geometric_jacobian(arm.chain, q, arm.tip("hand"))[:, :3]
    assert added == pytest.approx(-2.0 * np.einsum("kin,i->kn", J, arm.gravity), abs=1e-10)
    more = inertia_matrix(with_hand_load(arm, 2.0), q) - inertia_matrix(arm, q)
    assert more == pytest.approx(2.0 * np.swapaxes(J, 1, 2) @ J, abs=1e-10)


def test_bad_options_are_refused_in_one_line(muscle_arm):
    with pytest.raises(RangeError, match="lower = -1"):
        EffortOptions(lower=-1.0)
    with pytest.raises(UnknownNameError, match="unknown load"):
        EffortOptions(loads=("wind",))  # pyright: ignore[reportArgumentType]
    with pytest.raises(RangeError, match="daqp solves exponent 2 only"):
        EffortOptions(exponent=3.0, solver="daqp")
    with pytest.raises(ModelError, match="no coordinate-limit forces"):
        muscle_effort(muscle_arm, np.zeros(7), options=EffortOptions(loads=("gravity", "limits")))
    with pytest.raises(ShapeError):
        muscle_effort(muscle_arm, np.zeros(6))


def test_effort_runs_along_a_movement(muscle_arm):
    t = np.linspace(0.0, 0.8, 9)[:, None]
    start = np.array([0.6, 0.5, -0.2, 1.2, 0.1, 0.0, 0.1])
    reach = np.array([0.3, 0.5, 0.1, -0.5, 0.2, 0.0, 0.0])
    s = t / 0.8  # minimum jerk
    q = start + reach * (10 * s**3 - 15 * s**4 + 6 * s**5)
    qd = reach * (30 * s**2 - 60 * s**3 + 30 * s**4) / 0.8
    qdd = reach * (60 * s - 180 * s**2 + 120 * s**3) / 0.8**2
    moving = muscle_effort(muscle_arm, q, velocity=qd, acceleration=qdd)
    still = muscle_effort(muscle_arm, q)
    assert moving.effort[[0, -1]] == pytest.approx(still.effort[[0, -1]], rel=1e-6)
    assert (np.abs(moving.effort[2:-2] / still.effort[2:-2] - 1) > 0.01).all()
    # Work against gravity and inertia is what muscles give: torque along velocity.
    power = (required_torque(muscle_arm.arm, q, EffortOptions(), qd, qdd) * qd).sum(axis=1)
    kinetic = 0.5 * np.einsum("ki,kij,kj->k", qd, inertia_matrix(muscle_arm.arm, q), qd)
    from selfmotion.kinematics.dynamics import potential_energy

    fine = np.linspace(0.0, 0.8, 2001)
    energy = kinetic + potential_energy(muscle_arm.arm, q)
    work = np.interp(fine, t[:, 0], power)
    assert np.trapezoid(work, fine) == pytest.approx(energy[-1] - energy[0], rel=0.05)
