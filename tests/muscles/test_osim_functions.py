import numpy as np
import pytest

from selfmotion.muscles.opensim_forces import LimitForces
from selfmotion.muscles.osim_functions import Curve


def bent():
    return Curve(np.array([-1.0, 0.5, 2.0]), np.array([0.0, 1.0, 0.5]), np.array([1.0, 0.2, -0.4]))


def test_a_curve_goes_on_straight_beyond_its_ends():
    curve, poly = bent(), bent().to_ppoly()
    for x in (-3.0, -1.0, 0.1, 0.5, 1.7, 2.0, 4.0):
        value, slope = curve(x)
        assert float(poly(x)) == pytest.approx(value, abs=1e-12)
        assert float(poly.derivative()(x)) == pytest.approx(slope, abs=1e-12)
    assert curve(4.0)[0] == pytest.approx(0.5 - 0.4 * 2.0)
    assert curve(-3.0)[0] == pytest.approx(-2.0)


@pytest.mark.parametrize("slope", [2.0, -0.5])
def test_lines_before_and_after_a_curve(slope):
    line = Curve.line(slope, 0.3)
    for x in (-2.0, 0.1, 0.9, 3.0):
        inner = bent().after(line)
        outer = line.after(bent())
        assert inner is not None and outer is not None
        assert inner(x)[0] == pytest.approx(bent()(slope * x + 0.3)[0], abs=1e-12)
        assert outer(x)[0] == pytest.approx(slope * bent()(x)[0] + 0.3, abs=1e-12)
    assert bent().after(bent()) is None


def test_a_spline_on_a_line_is_that_line():
    x = np.array([0.0, 1.0, 3.0])
    assert Curve(x, 2 * x + 1, np.full(3, 2.0)).as_line == pytest.approx((2.0, 1.0))
    assert bent().as_line is None


def test_limit_torque_rises_smoothly_beyond_a_limit():
    one = np.ones(1)
    limits = LimitForces(
        np.zeros(1, dtype=int), one, 0 * one, 4 * one, 2 * one, 0.5 * one, 0.3 * one
    )
    q = np.array([[0.5], [1.25], [2.0], [-1.0]])
    torque = limits(q)[:, 0]
    # Half way through the transition the step is 1/2.
    assert torque == pytest.approx([0.0, -4 * 0.5 * 0.25, -4.0, 2.0])
    damped = limits(q, np.full((4, 1), 2.0))[:, 0]
    assert damped - torque == pytest.approx([0.0, -0.3 * 0.5 * 2.0, -0.6, -0.6])
