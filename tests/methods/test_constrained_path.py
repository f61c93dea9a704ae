"""Following a path inside the limits, and the arcs on which that can be done."""

import numpy as np
import pytest
from scipy.optimize import minimize

from selfmotion.arms import load_arm
from selfmotion.errors import RangeError, ShapeError
from selfmotion.methods.constrained_path import PathCosts, device_circle, follow
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.feasible_arcs import feasible_arcs
from selfmotion.methods.reaching.ik_tasks import HandRows

ROWS = ("x", "y", "z", "rot_y")


def circle(angles):
    points = device_circle([0.16, 0.40, -0.16], 0.27, "xz", angles)
    return np.concatenate([points, np.zeros((len(points), 1))], axis=1)


def test_circle_of_the_third_scenario_is_followed_all_round():
    arm = load_arm("upper_limb")
    task = HandRows(arm, ROWS)
    (arc,) = feasible_arcs(task, circle, n_samples=48)
    assert arc.path.status.ok and arc.last - arc.first == pytest.approx(2 * np.pi)
    assert np.abs(task.error(arc.path.q, circle(arc.path.time))).max() < 1e-5
    assert (arc.path.q >= arm.lower).all() and (arc.path.q <= arm.upper).all()


def test_a_braced_elbow_leaves_arcs():
    arm = load_arm("upper_limb").with_limits({"elbow_flexion": (1.12, 1.99)})
    task = HandRows(arm, ROWS)

    def path(a):
        points = device_circle([0.16, 0.40, -0.16], 0.375, "xz", a)
        return np.concatenate([points, np.zeros((len(points), 1))], axis=1)

    arcs = feasible_arcs(task, path, n_samples=48)
    assert len(arcs) >= 1
    for arc in arcs:
        assert arc.last - arc.first < 2 * np.pi
        beyond = np.array([arc.first - 0.01, arc.last + 0.01])
        assert not solve_ik(task, path(beyond)).solved.any()


def test_a_step_is_the_constrained_minimum_of_its_cost():
    """SciPy's SLSQP minimises the same cost under the same constraints."""
    arm, rng = load_arm("upper_limb"), np.random.default_rng(2)
    task = HandRows(arm, ("x", "y", "z"))
    start = arm.middle()
    target = task.value(start) + 0.04
    weights = rng.uniform(0.5, 2.0, 9)
    found = follow(task, target, start=start, costs=PathCosts(velocity=weights))
    fit = minimize(
        lambda q: 0.5 * weights @ (q - start) ** 2,
        start,
        jac=lambda q: weights * (q - start),
        bounds=list(zip(arm.lower, arm.upper, strict=True)),
        constraints={"type": "eq", "fun": lambda q: task.error(q, target)[0]},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 300},
    )
    cost = 0.5 * weights @ (found.q[0] - start) ** 2
    assert found.met.all()
    assert cost == pytest.approx(fit.fun, rel=1e-3)


def test_a_heavy_joint_moves_less():
    task = HandRows(load_arm("upper_limb"), ("x", "y", "z"))
    line = np.linspace([0.1, 0.4, -0.2], [0.3, 0.4, 0.0], 12)
    start = follow(task, line[0]).q[0]
    weights = np.ones(9)
    weights[5] = 1e4
    light, heavy = (
        follow(task, line, start=start, costs=c) for c in (None, PathCosts(velocity=weights))
    )
    assert light.status.ok and heavy.status.ok
    assert np.ptp(heavy.q[:, 5]) < 0.2 * np.ptp(light.q[:, 5])
    assert list(light.to_frame().columns)[:2] == ["time", "scapula_protraction"]


def test_four_samples_of_four_rows_are_no_frame():
    task = HandRows(load_arm("upper_limb"), ROWS)
    found = solve_ik(task, circle(np.arange(4.0)))
    assert found.solved.all() and len(found.q) == 4


def test_out_of_reach_is_said():
    task = HandRows(load_arm("upper_limb"), ("x", "y", "z"))
    found = follow(task, np.linspace([0.2, 0.4, 0.0], [0.2, 1.4, 0.0], 10))
    assert not found.status.ok and "not reached" in found.status.sentence


def test_bad_input():
    task = HandRows(load_arm("upper_limb"), ("x", "y", "z"))
    line = np.linspace([0.1, 0.4, -0.2], [0.3, 0.4, 0.0], 3)
    with pytest.raises(RangeError, match="time must increase"):
        follow(task, line, time=[0.0, 1.0, 1.0])
    with pytest.raises(ShapeError, match="weight has shape"):
        follow(task, line, costs=PathCosts(velocity=[1.0, 2.0]))
    with pytest.raises(RangeError, match="plane = 'xw'"):
        device_circle([0, 0, 0], 0.3, "xw", [0.0])
