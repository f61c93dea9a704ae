from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.effort import curve
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.muscles.static_optimization import muscle_effort


def sampler(length, slope, arc):
    """A sampler that knows one muscle's path over a coordinate that is the place itself."""
    made: Any = object.__new__(curve._Sampler)
    made.arc = np.asarray(arc, dtype=np.float64)
    made.lengths, made.slopes = length(made.arc)[:, None], slope(made.arc)[:, None]
    made.interval = SimpleNamespace(at=lambda place: np.atleast_2d(place))
    made.model = SimpleNamespace(
        geometry=SimpleNamespace(length=lambda q, muscle: float(length(q)[0]))
    )
    return made


@pytest.mark.parametrize("bias", [0.0, 5e-3])
@pytest.mark.parametrize("place", [0.1502, 0.2, 0.2871])
def test_a_jump_of_a_path_is_found_between_two_samples(place, bias):
    """Also where moment arms are not the slope of the length, as with OpenSim's moving points."""

    def length(s):
        return 0.3 + 0.02 * np.sin(s) + 4e-4 * (s > place)

    made = sampler(length, lambda s: 0.02 * np.cos(s) + bias, 0.15 * np.arange(-2, 6))
    a, b = made.sides(3, 0)
    assert 0.15 <= a < place < b <= 0.3 and b - a <= curve.JUMP_GAP


def test_a_path_that_only_bends_is_given_the_middle():
    def length(s):
        return 0.3 + 0.2 * (s - 0.2) ** 2

    made = sampler(length, lambda s: 0.0 * s, 0.15 * np.arange(-2, 6))
    assert made.sides(3, 0) == (pytest.approx(0.225), pytest.approx(0.225))


def test_curvature_is_not_taken_across_a_jump():
    s = np.linspace(0.0, 0.8, 9)
    E = s**2 + 5.0 * (s > 0.45)
    jump = np.zeros(8, dtype=np.bool_)
    jump[4] = True
    assert curve._curvature(s, E, jump) == pytest.approx(np.full(9, 2.0))
    jump[6] = True  # what is left between the two has two samples
    assert (curve._curvature(s, E, jump)[5:7] < 0).all()


def test_the_least_effort_beside_a_jump_is_at_its_edge():
    """Effort jumps up within a hair of the least: the edge is found to the tolerance."""
    model = load_musculoskeletal_arm()
    finder = PostureFinder.of(model)
    arm = model.arm
    rng, seen = np.random.default_rng(2022), 0
    q = arm.random_postures(104, rng)[103]

    T = forward_kinematics(arm.chain, q, arm.tip("hand"))[0]
    found = finder.find(T)
    for interval in finder.manifolds.find(T).intervals:
        place = np.linspace(0.0, interval.arc[-1], 4000)
        effort = muscle_effort(model, interval.at(place))
        held = np.array([bool(s) for s in effort.status])
        assert (effort.effort[held] > found.effort * (1 - 1e-3)).all()
        seen += held.sum()
    assert seen > 100 and found.minima[0].beside_jump and found.jumps
