import numpy as np
import pytest
from scipy.integrate import solve_ivp

from selfmotion.methods.passive.lockstep import Slope, StepControl, _step, integrate_lockstep


class Equations:
    """Equations with one Jacobian for all postures, which counts how often it is asked for."""

    def __init__(self, velocity, jacobian):
        self.rule, self.jacobian = velocity, np.atleast_2d(jacobian)
        self.n_velocities = self.n_jacobians = 0

    def velocity(self, t, q):
        self.n_velocities += 1
        return self.rule(t, q)

    def __call__(self, t, q):
        self.n_jacobians += 1
        return Slope(self.velocity(t, q), np.repeat(self.jacobian[None], len(q), axis=0))


def pendulum(jacobian):
    """Two coupled equations that depend on time, with a given (wrong) Jacobian."""

    def velocity(t, q):
        a = q[:, 1] * np.cos(t) - q[:, 0] ** 2
        b = -q[:, 0] - 0.3 * q[:, 1] ** 3 + np.sin(3.0 * t)
        return np.stack([a, b], axis=1)

    return Equations(velocity, jacobian)


@pytest.mark.parametrize("jacobian", [np.zeros((2, 2)), np.array([[-3.0, 1.0], [0.5, -8.0]])])
def test_the_order_is_three_whatever_the_jacobian(jacobian):
    start = np.array([[1.0, 0.2]])
    slopes = pendulum(jacobian)
    exact = solve_ivp(
        lambda t, q: slopes.velocity(t, q[None])[0], (0, 1), start[0], rtol=1e-12, atol=1e-13
    ).y[:, -1]
    errors = []
    for n in (32, 64, 128):
        q = start
        for i in range(n):
            q, _ = _step(slopes, i / n, q, 1.0 / n, slopes(i / n, q))
        errors.append(np.abs(q[0] - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 2.7).all()


def test_a_stiff_decay_takes_few_steps():
    slopes = Equations(lambda t, q: -1e9 * (q - np.sin(t)), -1e9)
    time = np.linspace(0.0, 1.0, 11)
    q, reached = integrate_lockstep(slopes, np.array([[1.0]]), time, StepControl(1e-6))
    assert reached == 1.0
    assert slopes.n_velocities < 2000
    np.testing.assert_allclose(q[0, 1:, 0], np.sin(time[1:]), atol=1e-5)


def test_giving_up_is_said_and_leaves_gaps():
    slopes = Equations(lambda t, q: q**2, 0.0)  # infinite at t = 1
    time = np.linspace(0.0, 2.0, 21)
    q, reached = integrate_lockstep(slopes, np.array([[1.0]]), time, StepControl(1e-8, 5000))
    assert 0.9 < reached < 1.01
    np.testing.assert_allclose(q[0, :9, 0], 1.0 / (1.0 - time[:9]), rtol=1e-5)
    assert np.isnan(q[0, -1, 0])


def test_the_jacobian_is_asked_for_once_a_step():
    """Second derivatives of muscle effort cost ten times its slope."""
    slopes = pendulum(np.zeros((2, 2)))
    time = np.linspace(0.0, 1.0, 3)
    _, reached = integrate_lockstep(slopes, np.array([[1.0, 0.2]]), time, StepControl(1e-6))
    assert reached == 1.0
    assert slopes.n_velocities >= 4 * (slopes.n_jacobians - 1)
