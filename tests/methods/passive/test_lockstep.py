import numpy as np
import pytest
from scipy.integrate import solve_ivp

from selfmotion.methods.passive.lockstep import Slope, StepControl, _step, integrate_lockstep


def pendulum(jacobian):
    """Two coupled equations that depend on time, with a given (wrong) Jacobian."""

    def slopes(t, q):
        a = q[:, 1] * np.cos(t) - q[:, 0] ** 2
        b = -q[:, 0] - 0.3 * q[:, 1] ** 3 + np.sin(3.0 * t)
        return Slope(np.stack([a, b], axis=1), np.repeat(jacobian[None], len(q), axis=0))

    return slopes


@pytest.mark.parametrize("jacobian", [np.zeros((2, 2)), np.array([[-3.0, 1.0], [0.5, -8.0]])])
def test_the_order_is_three_whatever_the_jacobian(jacobian):
    start = np.array([[1.0, 0.2]])
    slopes = pendulum(jacobian)
    exact = solve_ivp(
        lambda t, q: slopes(t, q[None]).velocity[0], (0, 1), start[0], rtol=1e-12, atol=1e-13
    ).y[:, -1]
    errors = []
    for n in (32, 64, 128):
        q = start
        for i in range(n):
            q, _ = _step(slopes, i / n, q, 1.0 / n)
        errors.append(np.abs(q[0] - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 2.7).all()


def test_a_stiff_decay_takes_few_steps():
    calls = []

    def slopes(t, q):
        calls.append(t)
        return Slope(-1e9 * (q - np.sin(t)), np.full((len(q), 1, 1), -1e9))

    time = np.linspace(0.0, 1.0, 11)
    q, reached = integrate_lockstep(slopes, np.array([[1.0]]), time, StepControl(1e-6))
    assert reached == 1.0
    assert len(calls) < 2000
    np.testing.assert_allclose(q[0, 1:, 0], np.sin(time[1:]), atol=1e-5)


def test_giving_up_is_said_and_leaves_gaps():
    def slopes(t, q):
        return Slope(q**2, np.zeros((len(q), 1, 1)))  # infinite at t = 1

    time = np.linspace(0.0, 2.0, 21)
    q, reached = integrate_lockstep(slopes, np.array([[1.0]]), time, StepControl(1e-8, 5000))
    assert 0.9 < reached < 1.01
    np.testing.assert_allclose(q[0, :9, 0], 1.0 / (1.0 - time[:9]), rtol=1e-5)
    assert np.isnan(q[0, -1, 0])
