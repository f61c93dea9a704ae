"""Donders' law: exact without noise, honest errors with it, refusals where nothing can be told."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from selfmotion.arms import planar, srs7, wrist
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.donders import ElasticityPrior, fit_elasticity
from selfmotion.methods.elasticity.fit import (
    PostureGeometry,
    entries,
    past_fold,
    residuals,
    symmetric,
)
from selfmotion.methods.elasticity.orientations import Form, wrist_angles
from selfmotion.methods.elasticity.posture import donders_postures, task_hessian
from selfmotion.methods.elasticity.surface import fit_surface
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive_motion import PlanSettings, plan
from selfmotion.redundancy.task import Planar, Pointing, Position

TASK = Pointing(wrist())


def person(rng: np.random.Generator) -> JointLaw:
    """Somebody around the paper's law, with joints that pull on each other."""
    A = rng.normal(0.0, 0.15, (3, 3))
    K = np.diag([0.5, 1.5, 2.0]) + 0.5 * (A + A.T)
    return JointLaw(4.0 * K / np.trace(K), rng.normal(0.0, np.radians(8.0), 3))


def disc(degrees: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Targets spread evenly over a disc."""
    r = np.sin(np.radians(degrees)) * np.sqrt(rng.uniform(0.0, 1.0, n))
    a = rng.uniform(0.0, 2.0 * np.pi, n)
    return np.stack([r * np.cos(a), r * np.sin(a)], axis=1)


def postures(law: JointLaw, degrees: float, n: int, rng: np.random.Generator) -> np.ndarray:
    found = donders_postures(TASK, law, disc(degrees, n, rng))
    return found.q[found.least]


def test_the_posture_of_a_target_is_the_one_of_least_energy():
    rng = np.random.default_rng(0)
    law, targets = person(rng), disc(20.0, 5, rng)
    found = donders_postures(TASK, law, targets)
    assert found.status.ok
    np.testing.assert_allclose(TASK.value(found.q), targets, atol=1e-12)
    for q, target in zip(found.q, targets, strict=True):
        least = minimize(
            lambda p: (p - law.rest) @ law.stiffness @ (p - law.rest),
            law.rest,
            method="SLSQP",
            constraints={"type": "eq", "fun": lambda p, t=target: TASK.error(p, t)[0]},
            options={"ftol": 1e-15, "maxiter": 300},
        )
        np.testing.assert_allclose(q, least.x, atol=1e-6)


def test_the_planner_comes_to_rest_in_that_posture():
    rng = np.random.default_rng(1)
    law, targets = person(rng), disc(20.0, 5, rng)
    rested = plan(TASK, law, law.rest, targets, PlanSettings(spring=22.5, duration=3.0))
    np.testing.assert_allclose(rested.end, donders_postures(TASK, law, targets).q, atol=1e-7)


def test_targets_past_a_fold_say_so():
    law = JointLaw(np.diag([0.2, 1.5, 2.3]), np.radians([0.0, 20.0, 0.0]))
    found = donders_postures(TASK, law, [[0.0, 0.0], [0.99, 0.0], [1.2, 0.0]])
    assert found.least[0]
    assert not found.least[2]
    assert not found.status.ok


def test_second_derivatives_of_the_task_agree_with_the_closed_form():
    q = np.random.default_rng(2).normal(0.0, 0.4, (4, 3))
    H = task_hessian(TASK, q)
    # x is a unit vector turned by pronation: twice by q_PS gives minus x itself.
    np.testing.assert_allclose(H[:, :, 0, 0], -TASK.value(q), atol=1e-9)
    J = TASK.jacobian(q)  # and once by q_PS turns the columns of J by a right angle
    np.testing.assert_allclose(H[:, 0, 0, 1:], -J[:, 1, 1:], atol=1e-9)
    np.testing.assert_allclose(H[:, 1, 0, 1:], J[:, 0, 1:], atol=1e-9)


@pytest.mark.parametrize("task", [TASK, Position(srs7())], ids=["wrist", "srs7"])
def test_the_jacobian_of_the_residual_agrees_with_differences(task):
    rng = np.random.default_rng(3)
    n = task.arm.n_joints
    L = rng.normal(0.0, 0.2, (n, n))
    K, rest = L @ L.T + np.eye(n), rng.normal(0.0, 0.2, n)
    geometry = PostureGeometry.of(task, rest + rng.normal(0.3, 0.2, (6, n)))
    at = residuals(geometry, K, rest)
    h = 1e-6
    for j in range(len(entries(n)[0])):
        dK = symmetric(np.eye(len(entries(n)[0]))[j], n)
        ends = [residuals(geometry, K + s * h * dK, rest).delta for s in (1, -1)]
        np.testing.assert_allclose(
            at.by_stiffness[:, :, j], (ends[0] - ends[1]) / (2 * h), atol=1e-7
        )
    for j, e in enumerate(np.eye(n)):
        ends = [residuals(geometry, K, rest + s * h * e).delta for s in (1, -1)]
        np.testing.assert_allclose(at.by_rest[:, :, j], (ends[0] - ends[1]) / (2 * h), atol=1e-7)


def test_the_distance_is_that_to_the_surface():
    rng = np.random.default_rng(4)
    law = person(rng)
    q = postures(law, 25.0, 20, rng)
    geometry = PostureGeometry.of(TASK, q)
    z = geometry.Z[:, :, 0]
    off = 1e-4 * z + 1e-7
    moved = residuals(PostureGeometry.of(TASK, q + off), law.stiffness, law.rest).delta[:, 0]
    np.testing.assert_allclose(np.abs(moved), 1e-4, rtol=2e-2)


@pytest.mark.parametrize("seed", range(4))
def test_without_noise_the_law_comes_back_exactly(seed):
    rng = np.random.default_rng(seed)
    law = person(rng)
    fit = fit_elasticity(postures(law, 25.0, 60, rng))
    np.testing.assert_allclose(fit.stiffness, law.stiffness, atol=1e-8)
    np.testing.assert_allclose(fit.rest, law.rest, atol=1e-8)
    assert fit.status.ok
    assert fit.thickness_deg < 1e-8


def test_a_planar_arm_comes_back_too():
    arm = planar([0.3, 0.25, 0.15])
    task = Planar(arm)
    law = JointLaw(
        np.array([[1.8, 0.2, 0], [0.2, 1.3, -0.1], [0, -0.1, 0.9]]), np.array([0.3, 0.8, 0.4])
    )
    targets = task.value(law.rest)[0] + np.random.default_rng(0).uniform(-0.12, 0.12, (60, 2))
    found = donders_postures(task, law, targets)
    fit = fit_elasticity(found.q[found.least], task=task)
    np.testing.assert_allclose(fit.stiffness, law.stiffness, atol=1e-8)
    np.testing.assert_allclose(fit.rest, law.rest, atol=1e-8)


def coverage(n_people: int, degrees: float, n_postures: int) -> tuple[np.ndarray, np.ndarray]:
    """Give errors of K over their standard errors, and the standard errors of K_PS."""
    rng = np.random.default_rng(6)
    errors, sizes = [], []
    for _ in range(n_people):
        law = person(rng)
        q = postures(law, degrees, n_postures, rng)
        fit = fit_elasticity(q + rng.normal(0.0, np.radians(0.5), q.shape))
        off = (fit.stiffness - law.stiffness) / fit.stiffness_stderr
        errors.append(np.abs(off[np.tril_indices(3)]))
        sizes.append(fit.stiffness_stderr[0, 0])
    return np.array(errors), np.array(sizes)


def test_errors_are_honest_at_half_a_degree():
    errors, sizes = coverage(25, 30.0, 300)
    assert (errors < 3.0).all(axis=1).mean() >= 0.95
    assert 0.6 < np.sqrt(np.median(errors**2)) / 0.6745 < 1.5
    # At ±15° the same noise tells less: the errors grow, and still cover.
    near, near_sizes = coverage(12, 15.0, 300)
    assert np.median(near_sizes) > 3.0 * np.median(sizes)
    assert (near < 3.0).all(axis=1).mean() >= 0.8


@pytest.mark.long
def test_errors_are_honest_over_200_people():
    errors, _ = coverage(200, 30.0, 500)
    assert (errors < 3.0).all(axis=1).mean() >= 0.95


def test_gross_errors_do_not_carry_the_fit_away():
    rng = np.random.default_rng(7)
    law = person(rng)
    q = postures(law, 30.0, 400, rng)
    q = q + rng.normal(0.0, np.radians(0.5), q.shape)
    q[::20, 0] += np.radians(30.0)
    fit = fit_elasticity(q)
    assert (np.abs(fit.stiffness - law.stiffness) < 5.0 * fit.stiffness_stderr + 0.02).all()
    assert (fit.weights[::20] < 0.2).all()
    assert any("count less" in s for s in fit.sentences)


def test_a_prior_helps_where_the_data_do_not_and_is_stated():
    rng = np.random.default_rng(8)
    law = person(rng)
    q = postures(law, 12.0, 100, rng)
    q = q + rng.normal(0.0, np.radians(0.5), q.shape)
    alone = fit_elasticity(q)
    assert any("cannot tell the stiffness of pronation" in s for s in alone.sentences)
    prior = ElasticityPrior(
        law.stiffness, np.full((3, 3), 0.05), law.rest, np.full(3, np.radians(3.0)), "twin"
    )
    helped = fit_elasticity(q, prior=prior)
    assert (helped.stiffness_stderr <= 0.06).all()
    assert (np.abs(helped.stiffness - law.stiffness) < 0.15).all()
    assert any("prior was used (twin)" in s for s in helped.sentences)
    assert helped.provenance.choices["prior"] == "twin"


def test_all_forms_of_orientation_give_the_same_law():
    rng = np.random.default_rng(9)
    law = person(rng)
    q = postures(law, 25.0, 60, rng)
    rotations = (
        Rotation.from_rotvec(-q[:, [0]] * [1.0, 0.0, 0.0])
        * Rotation.from_rotvec(q[:, [1]] * [0.0, 0.0, 1.0])
        * Rotation.from_rotvec(q[:, [2]] * [0.0, 1.0, 0.0])
    )
    forms: dict[Form, np.ndarray] = {
        "rotation vectors": rotations.as_rotvec(),
        "quaternions": rotations.as_quat(),
        "matrices": rotations.as_matrix(),
    }
    for form, array in forms.items():
        np.testing.assert_allclose(wrist_angles(array, form), q, atol=1e-12)
        np.testing.assert_allclose(
            fit_elasticity(array, form=form).stiffness, law.stiffness, atol=1e-8
        )


def test_dependent_postures_widen_the_errors():
    rng = np.random.default_rng(10)
    law = person(rng)
    q = postures(law, 30.0, 60, rng)
    q = q + rng.normal(0.0, np.radians(0.5), q.shape)
    thrice = np.repeat(q, 3, axis=0)
    trials = np.repeat(np.arange(len(q)), 3)
    alone, blind, honest = (
        fit_elasticity(a, trials=t).stiffness_stderr
        for a, t in ((q, None), (thrice, None), (thrice, trials))
    )
    np.testing.assert_allclose(honest, alone, rtol=0.02)
    assert (blind < 0.65 * alone).all()


def test_what_cannot_be_fitted_is_refused():
    rng = np.random.default_rng(11)
    q = postures(person(rng), 25.0, 40, rng)
    with pytest.raises(ShapeError, match="5 are too few for 8 parameters"):
        fit_elasticity(q[:5])
    with pytest.raises(RangeError, match="one place, or along one line"):
        fit_elasticity(np.repeat(q[:1], 30, axis=0))
    line = donders_postures(TASK, person(rng), np.linspace(-0.3, 0.3, 30)[:, None] * [1.0, 0.5]).q
    with pytest.raises(RangeError, match="along one line"):
        fit_elasticity(line)
    with pytest.raises(NotFiniteError):
        fit_elasticity(np.where(np.eye(40, 3) > 0, np.nan, q))
    with pytest.raises(RangeError, match="a quaternion of length 2"):
        fit_elasticity(np.full((20, 4), 1.0), form="quaternions")
    with pytest.raises(RangeError, match="no rotation matrix"):
        fit_elasticity(np.ones((20, 3, 3)), form="matrices")
    with pytest.raises(RangeError, match="right angle"):
        wrist_angles([[0.0, 0.0, np.pi / 2]], "rotation vectors")
    with pytest.raises(RangeError, match="above 0"):
        ElasticityPrior(np.eye(3), np.zeros((3, 3)), np.zeros(3), np.ones(3))


def summit(law: JointLaw, target: np.ndarray) -> np.ndarray | None:
    """Give the posture of (locally) greatest energy for a target, from the closed form of eq. 6."""
    p = np.linspace(-2.5, 2.5, 20001)
    across = -np.cos(p) * target[0] - np.sin(p) * target[1]
    along = np.sin(p) * target[0] - np.cos(p) * target[1]
    deviation = np.arcsin(along)
    q = np.stack([p, np.arcsin(across / np.cos(deviation)), deviation], axis=1)
    assert np.abs(TASK.value(q) - target).max() < 1e-12
    energy = np.einsum("ki,ij,kj->k", q - law.rest, law.stiffness, q - law.rest)
    top = np.flatnonzero((energy[1:-1] > energy[:-2]) & (energy[1:-1] > energy[2:])) + 1
    return q[top[0]] if top.size else None


def test_postures_past_a_fold_are_said():
    law = JointLaw(np.diag([0.05, 1.25, 2.7]), np.zeros(3))
    targets = disc(35.0, 200, np.random.default_rng(14))
    found = donders_postures(TASK, law, targets)
    tops = np.array([q for q in (summit(law, t) for t in targets) if q is not None])
    assert len(tops) > 30
    low = found.q[found.least]
    for q, expected in ((low, False), (tops, True)):
        both = residuals(
            PostureGeometry.of(TASK, np.concatenate([low, q])), law.stiffness, law.rest
        )
        assert (past_fold(both)[len(low) :] == expected).all()
    # Postures of least and of greatest energy together: no law takes both as near its surface.
    assert not fit_elasticity(np.concatenate([low, tops])).status.ok
    few = fit_elasticity(np.concatenate([low, tops[:5]]))
    assert not few.status.ok
    assert "5 of 200 postures lie past a fold" in few.status.sentence


def test_few_postures_past_a_fold_do_not_spoil_the_law():
    law = JointLaw(np.diag([0.2, 1.5, 2.3]), np.radians([0.0, 20.0, 0.0]))
    found = donders_postures(TASK, law, disc(55.0, 300, np.random.default_rng(3)))
    q = found.q[np.isfinite(found.q).all(axis=1)]
    past = int((~found.least[np.isfinite(found.q).all(axis=1)]).sum())
    assert 0 < past < 6
    fit = fit_elasticity(q)
    assert fit.status.ok
    assert any(f"{past} of {len(q)} postures lie past a fold" in s for s in fit.sentences)
    np.testing.assert_allclose(fit.stiffness, law.stiffness, atol=1e-8)
    assert fit.thickness_deg < 1e-8


@pytest.mark.parametrize("seed", range(6))
def test_an_exact_fit_says_that_it_settled(seed):
    rng = np.random.default_rng([31, seed])
    law = person(rng)
    q = postures(law, 30.0, 100, rng)
    turns = forward_kinematics(TASK.arm.chain, q, TASK.arm.tip("hand"))[:, :3, :3]
    for fit in (
        fit_elasticity(q),
        fit_elasticity(Rotation.from_matrix(turns).as_quat(), form="quaternions"),
    ):
        assert fit.status.ok, fit.status.sentence
        np.testing.assert_allclose(fit.stiffness, law.stiffness, atol=1e-8)


def test_a_joint_that_never_moves_is_said():
    q = np.random.default_rng(15).normal(0.0, 0.3, (100, 3))
    q[:, 0] = 0.1
    fit = fit_elasticity(q)
    assert not fit.status.ok
    assert "collapsed onto pronation" in fit.status.sentence


def test_postures_without_a_law_are_said():
    q = np.random.default_rng(16).uniform(-0.5, 0.5, (200, 3))
    fit = fit_elasticity(q)
    assert any("cannot tell the stiffness" in s for s in fit.sentences)
    assert fit.thickness_deg > 10.0


def test_a_table_names_each_parameter():
    rng = np.random.default_rng(12)
    frame = fit_elasticity(postures(person(rng), 25.0, 40, rng)).to_frame()
    assert list(frame["parameter"])[:2] == ["stiffness pronation", "stiffness pronation x flexion"]
    assert len(frame) == 9


def test_a_quadratic_surface_and_its_thickness():
    rng = np.random.default_rng(13)
    a, b = rng.uniform(-0.4, 0.4, (2, 4000))
    true = np.array([0.05, 0.1, -0.2, 0.3, -0.4, 0.15])
    r = np.stack([np.zeros_like(a), a, b], axis=1)
    r[:, 0] = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1) @ true
    exact = fit_surface(r)
    np.testing.assert_allclose(exact.coefficients, true, atol=1e-12)
    np.testing.assert_allclose(exact.torsion(a, b), r[:, 0], atol=1e-12)
    r[:, 0] += rng.normal(0.0, np.radians(2.0), len(a))
    noisy = fit_surface(r)
    assert abs(noisy.thickness_deg - 2.0) < 0.1
    assert (np.abs(noisy.coefficients - true) < 4.0 * noisy.stderr).all()
    with pytest.raises(RangeError, match="one line"):
        fit_surface(np.stack([a, a, 0.5 * a], axis=1))
