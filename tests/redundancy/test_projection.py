"""The weighted pseudo-inverse and the null-space projector: identities and an optimiser."""

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from selfmotion.arms import load_arm, planar
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.kinematics.dynamics import inertia_matrix
from selfmotion.redundancy.projection import project, split_velocity
from selfmotion.redundancy.task import Planar, Pose, Position

RNG_SEED = 7


def close(actual: np.ndarray, expected: np.ndarray, tolerance: float = 1e-11) -> None:
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance)


def case(kind: str) -> tuple[np.ndarray, np.ndarray | None]:
    """Jacobians of an arm and a weight of each kind that `project` takes."""
    arm, rng = load_arm("upper_limb_anatomical"), np.random.default_rng(RNG_SEED)
    q = arm.random_postures(8, rng)
    J = Pose(arm).jacobian(q)
    A = rng.normal(size=(9, 9))
    weights = {
        "identity": None,
        "diagonal": rng.uniform(0.1, 10.0, 9),
        "full": A @ A.T + np.eye(9),
        "inertia": inertia_matrix(arm, q) + 1e-3 * np.eye(9),
    }
    return J, weights[kind]


def as_matrices(W: np.ndarray | None, n: int, k: int) -> np.ndarray:
    if W is None:
        return np.broadcast_to(np.eye(n), (k, n, n))
    return np.broadcast_to(np.diag(W) if W.ndim == 1 else W, (k, n, n))


KINDS = ["identity", "diagonal", "full", "inertia"]


@pytest.mark.parametrize("kind", KINDS)
class TestIdentities:
    def test_projector(self, kind):
        J, W = case(kind)
        p = project(J, W)
        close(J @ p.null, np.zeros((8, 6, 9)))
        close(p.null @ p.null, p.null)
        close(p.inverse @ J + p.null, np.broadcast_to(np.eye(9), (8, 9, 9)))
        assert (p.rank == 6).all()
        close(np.trace(p.null, axis1=1, axis2=2), np.full(8, 3.0))

    def test_pseudo_inverse(self, kind):
        J, W = case(kind)
        p = project(J, W)
        close(p.inverse @ J @ p.inverse, p.inverse)
        close(J @ p.inverse, np.broadcast_to(np.eye(6), (8, 6, 6)))
        # The two parts are square to each other in the weight's own measure.
        M = as_matrices(W, 9, 8)
        close(np.swapaxes(p.inverse, 1, 2) @ M @ p.null, np.zeros((8, 6, 9)), 1e-10)

    def test_formula_of_the_papers(self, kind):
        J, W = case(kind)
        M = as_matrices(W, 9, 8)
        WiJt = np.linalg.solve(M, np.swapaxes(J, 1, 2))
        expected = np.swapaxes(np.linalg.solve(J @ WiJt, np.swapaxes(WiJt, 1, 2)), 1, 2)
        close(project(J, W).inverse, expected, 1e-9)

    def test_damped_formula(self, kind):
        J, W = case(kind)
        M, mu = as_matrices(W, 9, 8), 0.05
        WiJt = np.linalg.solve(M, np.swapaxes(J, 1, 2))
        damped = J @ WiJt + mu * np.eye(6)
        expected = np.swapaxes(np.linalg.solve(damped, np.swapaxes(WiJt, 1, 2)), 1, 2)
        p = project(J, W, damping=mu)
        close(p.inverse, expected)
        close(p.null, project(J, W).null)  # a projector whatever the damping
        close(J @ p.null, np.zeros((8, 6, 9)))

    def test_least_weighted_velocity(self, kind):
        J, W = case(kind)
        M = as_matrices(W, 9, 8)
        rng = np.random.default_rng(1)
        for k in range(2):
            xd = rng.normal(size=6)
            found = minimize(
                lambda v, Mk=M[k]: (0.5 * v @ Mk @ v, Mk @ v),
                np.zeros(9),
                jac=True,
                hess=lambda _, Mk=M[k]: Mk,
                method="trust-constr",
                constraints=LinearConstraint(J[k], xd, xd),  # pyright: ignore[reportArgumentType]
                options={"gtol": 1e-12, "xtol": 1e-14},
            )
            ours = project(J, W).inverse[k] @ xd
            np.testing.assert_allclose(ours, found.x, rtol=0, atol=1e-6 * np.abs(ours).max())

    def test_row_scale_does_not_matter_without_damping(self, kind):
        J, W = case(kind)
        scale = np.array([1, 1, 1, 0.1, 0.1, 30.0])
        plain, scaled = project(J, W), project(J, W, row_scale=scale)
        close(scaled.inverse, plain.inverse, 1e-9)
        close(scaled.null, plain.null, 1e-9)

    def test_split_adds_up_and_keeps_the_task(self, kind):
        J, W = case(kind)
        qd = np.random.default_rng(2).normal(size=(8, 9))
        task, null = split_velocity(J, qd, W)
        close(task + null, qd)
        close(np.einsum("kij,kj->ki", J, null), np.zeros((8, 6)))


def test_damping_counts_in_scaled_rows():
    J, _ = case("identity")
    scale = np.array([1, 1, 1, 0.2, 0.2, 0.2])
    SJ = scale[:, None] * J
    expected = np.swapaxes(SJ, 1, 2) @ np.linalg.inv(SJ @ np.swapaxes(SJ, 1, 2) + 0.3 * np.eye(6))
    close(project(J, damping=0.3, row_scale=scale).inverse, expected * scale)


def test_two_sliding_joints_of_eq_14():
    p = project([[1.0, 1.0]], [1.0, 1 / 9])
    close(p.inverse[0, :, 0], np.array([0.1, 0.9]), 1e-15)
    close(p.null[0], np.array([[0.9, -0.1], [-0.9, 0.1]]), 1e-15)


def test_update_of_deboon_is_the_same_formula():
    # D (J D)^+ = J# for W = D^-2.
    J, _ = case("identity")
    d = np.random.default_rng(3).uniform(0.1, 1.0, 9)
    expected = d[:, None] * np.linalg.pinv(J * d)
    close(project(J, d**-2.0).inverse, expected)


def test_scale_of_the_weights_does_not_matter():
    J, W = case("full")
    assert W is not None
    close(project(J, 1e6 * W).inverse, project(J, W).inverse)


def test_singular_posture_is_reported_and_served():
    arm = planar([0.3, 0.25, 0.1])
    straight, bent = np.zeros(3), np.array([0.3, 0.5, 0.4])
    J = Planar(arm).jacobian([straight, bent])
    p = project(J, [1.0, 2.0, 3.0])
    assert p.rank.tolist() == [1, 2]
    close(J @ p.null, np.zeros((2, 2, 3)))
    close(np.trace(p.null, axis1=1, axis2=2), np.array([2.0, 1.0]))
    # Along y, the direction that is left, the velocity is still made; x is given up.
    close(J[0] @ p.inverse[0], np.diag([0.0, 1.0]))
    assert np.isfinite(p.inverse).all()
    assert p.singular_values[0, 1] < 1e-12


def test_damped_inverse_is_bounded_near_a_singular_posture():
    arm = planar([0.3, 0.25])
    J = Planar(arm).jacobian([0.0, 1e-6])
    assert abs(project(J).inverse).max() > 1e5
    mu = 1e-4
    assert np.linalg.norm(project(J, damping=mu).inverse[0], 2) <= 0.5 / np.sqrt(mu) + 1e-9


def test_a_jacobian_of_zeros_has_rank_zero():
    p = project(np.zeros((2, 3)))
    assert p.rank.tolist() == [0]
    close(p.null[0], np.eye(3))
    close(p.inverse[0], np.zeros((3, 2)))


def test_more_rows_than_joints():
    arm = load_arm("exoskeleton")
    J = Pose(arm).jacobian([0.1, 0.2, 0.5, 1.0])
    p = project(J)
    assert p.rank.tolist() == [4]
    close(p.inverse[0], np.linalg.pinv(J[0]))
    close(p.null[0], np.zeros((4, 4)))


def test_many_samples_are_one_after_the_other():
    arm = load_arm("exoskeleton")
    q = arm.random_postures(5, np.random.default_rng(0))
    J = Position(arm).jacobian(q)
    W = np.array([1.0, 0.3, 0.2, 1.0])
    together = project(J, W)
    for k in range(5):
        close(project(J[k], W).inverse[0], together.inverse[k], 1e-13)


@pytest.mark.parametrize(
    ("arguments", "options", "error", "sentence"),
    [
        (([1.0, 2.0],), {}, ShapeError, "jacobian: expected shape"),
        (([[1.0, np.inf]],), {}, NotFiniteError, r"jacobian: 1 of 2 values .* jacobian\[0, 0, 1\]"),
        (([[1.0, 1.0]], [1.0, 0.0]), {}, RangeError, r"weights\[1\] = 0: every weight"),
        (([[1.0, 1.0]], [1.0, -1.0]), {}, RangeError, r"weights\[1\] = -1"),
        (([[1.0, 1.0]], [1.0, np.nan]), {}, NotFiniteError, "weights"),
        (([[1.0, 1.0]], [1.0, 1.0, 1.0]), {}, ShapeError, "weights have shape"),
        (([[1.0, 1.0]], [[1.0, 2.0], [0.0, 1.0]]), {}, RangeError, "must be symmetric"),
        (([[1.0, 1.0]], [[1.0, 2.0], [2.0, 1.0]]), {}, RangeError, "smallest eigenvalue is -1"),
        (([[1.0, 1.0]], np.stack([np.eye(2)] * 3)), {}, ShapeError, "weights have shape"),
        (([[1.0, 1.0]],), {"damping": -1.0}, RangeError, "damping = -1: allowed is 0 and above"),
        (([[1.0, 1.0]],), {"damping": np.nan}, RangeError, "damping = nan"),
        (([[1.0, 1.0]],), {"row_scale": [0.0]}, RangeError, "row_scale"),
        (([[1.0, 1.0]],), {"row_scale": [1.0, 1.0]}, ShapeError, "row_scale: expected shape"),
    ],
)
def test_bad_input_is_one_line(arguments, options, error, sentence):
    with pytest.raises(error, match=sentence) as caught:
        project(*arguments, **options)
    assert "\n" not in str(caught.value)


def test_split_wants_as_many_velocities_as_jacobians():
    with pytest.raises(ShapeError, match="velocity has 3 samples, jacobian 2"):
        split_velocity(np.ones((2, 1, 2)), np.ones((3, 2)))
    with pytest.raises(NotFiniteError, match="velocity"):
        split_velocity(np.ones((1, 1, 2)), [[np.nan, 1.0]])
    with pytest.raises(ShapeError, match="velocity"):
        split_velocity(np.ones((2, 1, 2)), np.ones((2, 3)))
