"""Fibre forces over length and velocity against the muscles of OpenSim."""

import numpy as np
import pytest

from selfmotion.errors import ModelError
from selfmotion.muscles.opensim_bridge import _forces, _muscle_set

from .osim_models import one_muscle

osim = pytest.importorskip("opensim", reason="needs the extra: pip install 'selfmotion[opensim]'")

LENGTHS = np.linspace(0.22, 0.38, 17)  # slack tendon 0.2 m, optimal fibre 0.1 m
SPEEDS = np.linspace(-1.2, 1.2, 9)  # m/s; the fastest shortening is 1 m/s


@pytest.mark.parametrize("pennation", [0.0, 0.3])
@pytest.mark.parametrize(
    "kind", ["Millard2012EquilibriumMuscle", "DeGrooteFregly2016Muscle", "Thelen2003Muscle"]
)
def test_force_over_length_and_velocity_is_that_of_the_muscle(kind, pennation):
    model = one_muscle(osim, kind, pennation)
    state = model.initSystem()
    muscle, slide = model.getMuscles().get(0), model.getCoordinateSet().get(0)
    ours = {name: _forces(osim, model, _muscle_set(model), name) for name in ("opensim", "plain")}
    for speed in SPEEDS:
        own = []
        for length in LENGTHS:
            slide.setValue(state, length, False)
            slide.setSpeedValue(state, speed)
            model.realizeVelocity(state)
            own.append(muscle.calcInextensibleTendonActiveFiberForce(state, 1.0))
        force = ours["opensim"].full_activation(LENGTHS[:, None], np.full((17, 1), speed))
        np.testing.assert_allclose(force[:, 0], own, atol=1e-8)  # of 1000 N
    if kind != "Thelen2003Muscle":  # OpenSim has no stiff tendon for it
        _check_stiff_tendon(kind, pennation, ours["plain"])


def _check_stiff_tendon(kind, pennation, ours):
    """Compare with the muscle at full activation and at rest, its tendon stiff."""
    model = one_muscle(osim, kind, pennation)
    getattr(osim, kind).safeDownCast(model.getMuscles().get(0)).set_ignore_tendon_compliance(True)
    state = model.initSystem()
    muscle, slide = model.getMuscles().get(0), model.getCoordinateSet().get(0)
    active, passive = [], []
    for length in LENGTHS:
        slide.setValue(state, length, False)
        muscle.setActivation(state, 1.0)
        model.realizeDynamics(state)
        active.append(muscle.getActiveFiberForceAlongTendon(state))
        passive.append(muscle.getPassiveFiberForceAlongTendon(state))
    np.testing.assert_allclose(ours.full_activation(LENGTHS[:, None])[:, 0], active, atol=1e-8)
    np.testing.assert_allclose(ours.passive(LENGTHS[:, None])[:, 0], passive, atol=1e-8)


def test_passive_force_of_a_thelen_muscle_is_its_own():
    model = one_muscle(osim, "Thelen2003Muscle", 0.0)
    state = model.initSystem()
    muscle = osim.Thelen2003Muscle.safeDownCast(model.getMuscles().get(0))
    ours = _forces(osim, model, _muscle_set(model), "plain")
    for length in (0.08, 0.11, 0.15, 0.18):
        muscle.setFiberLength(state, length)
        model.realizeVelocity(state)
        own = 1000.0 * muscle.getPassiveForceMultiplier(state)
        assert ours.passive(np.array([[0.2 + length]]))[0, 0] == pytest.approx(own, abs=1e-8)


def test_a_kind_that_is_not_represented_is_refused():
    model = one_muscle(osim, "RigidTendonMuscle", 0.0)
    model.initSystem()
    with pytest.raises(ModelError, match="'m' is a RigidTendonMuscle, which is not represented"):
        _forces(osim, model, _muscle_set(model), "opensim")
