import mujoco
import numpy as np
import pytest

from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.muscles.hill import (
    ForceCurves,
    MuscleSet,
    StiffTendonForces,
    active_force_length,
    fibre_length,
    force_velocity,
    passive_force_length,
)


def one_muscle(pennation: float = 0.0) -> MuscleSet:
    return MuscleSet(
        ("m",), np.array([100.0]), np.array([0.1]), np.array([0.2]), np.array([pennation])
    )


def curves() -> ForceCurves:
    one = np.ones(1)
    return ForceCurves(0.5 * one, 1.6 * one, 10.0 * one, 1.3 * one, 1.2 * one)


@pytest.mark.parametrize("length", [0.22, 0.26, 0.29, 0.3, 0.31, 0.33, 0.36, 0.4])
@pytest.mark.parametrize("velocity", [-1.5, -0.3, 0.0, 0.1, 0.4])
def test_forces_are_those_of_mujoco(length, velocity):
    muscles = one_muscle()
    forces = StiffTendonForces(muscles, curves())
    # One fibre length of MuJoCo is the ratio of the two ranges: 0.1 m here, tendon 0.2 m.
    prm = np.array([0.5, 1.5, 100.0, 1.0, 0.5, 1.6, 10.0, 1.3, 1.2])
    spread = np.array([0.25, 0.35])
    gain = -mujoco.mju_muscleGain(length, velocity, spread, 1.0, prm)
    bias = -mujoco.mju_muscleBias(length, spread, 1.0, prm)
    path, rate = np.array([[length]]), np.array([[velocity]])
    assert forces.full_activation(path, rate)[0, 0] == pytest.approx(gain, abs=1e-10)
    assert forces.passive(path)[0, 0] == pytest.approx(bias, abs=1e-10)


def test_curves_are_continuous_and_known_at_their_knots():
    x = np.linspace(0.3, 2.0, 20001)[:, None]
    for curve in (active_force_length, passive_force_length):
        assert np.abs(np.diff(curve(x, curves())[:, 0])).max() < 1e-3
    v = np.linspace(-1.5, 1.0, 20001)[:, None]
    f = force_velocity(v, curves())[:, 0]
    assert np.abs(np.diff(f)).max() < 1e-3
    assert (np.diff(f) >= 0).all() and f[0] == 0.0 and f[-1] == 1.2
    assert force_velocity(np.zeros((1, 1)), curves())[0, 0] == 1.0


def test_pennate_fibres_keep_their_height():
    muscles = one_muscle(pennation=0.5)
    fibre, cosine = fibre_length(muscles, np.array([[0.2 + 0.1 * np.cos(0.5)], [0.2]]))
    assert fibre[:, 0] == pytest.approx([1.0, np.sin(0.5)])
    assert cosine[:, 0] == pytest.approx([np.cos(0.5), 0.0])


def test_a_muscle_set_refuses_what_has_no_force():
    with pytest.raises(RangeError, match="max_force of 'm'"):
        MuscleSet(("m",), np.zeros(1), np.ones(1), np.ones(1), np.zeros(1))
    with pytest.raises(UnknownNameError, match="unknown muscle 'n'"):
        one_muscle().index("n")
