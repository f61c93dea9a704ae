"""Marker inverse kinematics: what a solution must satisfy, on several arms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PPoly, make_interp_spline
from scipy.optimize import lsq_linear, minimize

from selfmotion.arms import exoskeleton, load_arm, srs7, upper_limb, upper_limb_anatomical
from selfmotion.capture.marker_ik import MarkerIkOptions, MarkerModel, solve_marker_ik
from selfmotion.capture.scaling import place_shoulder, scale_arm, segment_lengths
from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import CoupledCurve, Coupling, Tip
from selfmotion.kinematics.forward import geometric_jacobian
from selfmotion.kinematics.mirror import mirror
from selfmotion.spatial import transform


def with_a_curve() -> Arm:
    """Let the forearm's turn follow the elbow along a spline with bends, beyond its ends too."""
    arm = srs7()
    chain = arm.chain
    x = np.linspace(-0.5, 2.0, 6)
    curve = PPoly.from_spline(make_interp_spline(x, 0.4 * np.sin(2.0 * x), k=3))
    matrix = np.delete(np.eye(7), 4, axis=1)
    matrix[4] = 0.0
    names = tuple(n for i, n in enumerate(chain.coupling.coordinates) if i != 4)
    coupling = Coupling(names, matrix, np.zeros(7), (CoupledCurve(4, 3, curve),))
    lower, upper = (np.delete(v, 4) for v in (chain.lower, chain.upper))
    bent = replace(chain, coupling=coupling, lower=lower, upper=upper)
    return replace(arm, name="srs7 with a curve", chain=bent)


ARMS = [upper_limb(), upper_limb_anatomical(), srs7(), exoskeleton(), mirror(srs7())]
ARMS += [with_a_curve(), load_arm("myoarm")]


def with_markers(arm, rng, per_body: int = 3) -> MarkerModel:
    """Put markers on every body, so that every joint shows."""
    tips = {
        f"m{body}_{i}": Tip(body, transform(None, 0.05 * rng.normal(size=3)))
        for body in range(len(arm.chain.names))
        for i in range(per_body)
    }
    return MarkerModel(arm, tips)


def smooth_motion(arm, rng, n_samples: int = 60) -> np.ndarray:
    t = np.linspace(0, 1, n_samples)[:, None]
    phase = rng.uniform(0, 2 * np.pi, arm.n_joints)
    return arm.middle() + 0.4 * (arm.upper - arm.lower) * np.sin(2 * t + phase)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_angles_come_back(arm):
    rng = np.random.default_rng(1)
    model = with_markers(arm, rng)
    q = smooth_motion(arm, rng)
    found = solve_marker_ik(model, model.positions(q))
    assert found.status.ok and found.rms.max() < 1e-6
    np.testing.assert_allclose(found.q, q, atol=1e-4)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_out_of_reach_the_solution_is_stationary_inside_the_limits(arm):
    rng = np.random.default_rng(2)
    model = with_markers(arm, rng)
    far = model.positions(smooth_motion(arm, rng)) + 0.15 * rng.normal(size=(60, 1, 3))
    found = solve_marker_ik(model, far, options=MarkerIkOptions(pull=0.0, max_iterations=300))
    assert (found.q >= arm.lower).all() and (found.q <= arm.upper).all()
    assert found.at_limit.any()
    for k in np.flatnonzero(found.converged)[::10]:
        J = np.concatenate(
            [geometric_jacobian(arm.chain, found.q[k], tip)[0, :3] for tip in model.tips.values()]
        )
        e = (far[k] - model.positions(found.q[k])[0]).ravel()
        low, high = arm.lower - found.q[k] - 1e-12, arm.upper - found.q[k] + 1e-12
        # The linearised problem inside the same limits, by another solver, gains nothing.
        gain = 2 * lsq_linear(J, e, (low, high)).cost / (e @ e)
        assert gain > 1 - 1e-5


def test_the_cost_is_no_larger_than_a_general_optimiser_finds():
    rng = np.random.default_rng(3)
    arm = upper_limb_anatomical()
    model = with_markers(arm, rng, per_body=1)
    targets = model.positions(smooth_motion(arm, rng)[:1]) + 0.01 * rng.normal(size=(1, 9, 3))
    found = solve_marker_ik(model, targets, options=MarkerIkOptions(pull=0.0))
    ours = (found.error**2).sum()

    def cost(q: np.ndarray) -> float:
        return float(((model.positions(q) - targets) ** 2).sum())

    bounds = list(zip(arm.lower, arm.upper, strict=True))
    theirs = minimize(cost, found.q[0], bounds=bounds, method="L-BFGS-B").fun
    assert ours <= theirs * (1 + 1e-6)


def test_gaps_weights_and_pull():
    rng = np.random.default_rng(4)
    arm = upper_limb_anatomical()
    q = smooth_motion(arm, rng)
    model = with_markers(arm, rng)
    targets = model.positions(q)
    targets[10, :, :] = np.nan
    targets[20:25, -6:] = np.nan  # the hand is hidden: the wrist must stay, not drift
    found = solve_marker_ik(model, targets)
    assert np.isnan(found.q[10]).all() and np.isnan(found.rms[10])
    assert "1 without markers" in found.status.sentence
    np.testing.assert_allclose(found.q[20:25, :6], q[20:25, :6], atol=1e-3)
    assert np.abs(found.q[20:25, 7] - q[20:25, 7]).max() < 0.15
    np.testing.assert_allclose(found.q[26:], q[26:], atol=1e-5)
    spoilt = model.positions(q)
    spoilt[:, 0] += 0.2
    heedless = MarkerModel(arm, model.tips, {model.markers[0]: 0.0})
    np.testing.assert_allclose(solve_marker_ik(heedless, spoilt).q, q, atol=1e-5)


def test_refusals():
    arm = srs7()
    model = MarkerModel(arm, {"hand": arm.tip("hand")})
    with pytest.raises(NotFiniteError, match="none of hand"):
        solve_marker_ik(model, np.full((3, 1, 3), np.nan))
    with pytest.raises(SelfmotionError):
        solve_marker_ik(model, np.zeros((3, 2, 3)))
    with pytest.raises(RangeError, match="weight of marker 'foot'"):
        MarkerModel(arm, {"hand": arm.tip("hand")}, {"foot": 1.0})


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_scaling_changes_the_lengths_asked_for_and_no_others(arm):
    before = segment_lengths(arm)
    wanted = {"upper_arm": 0.31, "forearm": 0.22}
    after = segment_lengths(scale_arm(arm, wanted))
    assert after["hand"] == pytest.approx(before["hand"], abs=1e-12)
    for segment, length in wanted.items():
        assert after[segment] == pytest.approx(length, abs=1e-12)


@pytest.mark.parametrize("arm", [upper_limb_anatomical(), srs7(), mirror(upper_limb_anatomical())])
def test_the_shoulder_goes_where_it_is_put(arm):
    moved = place_shoulder(arm, [0.1, 0.2, 0.3])
    model = MarkerModel(moved, {"shoulder": moved.tip("shoulder")})
    np.testing.assert_allclose(model.positions(np.zeros(arm.n_joints))[0, 0], [0.1, 0.2, 0.3])
    assert segment_lengths(moved) == pytest.approx(segment_lengths(arm))


def test_frames_far_beyond_the_limits_converge_too():
    # Slow there: a fifth of the iterations leaves some of them unsolved.
    rng = np.random.default_rng(3)
    arm = load_arm("srs7")
    model = MarkerModel(arm, {k: arm.tip(k) for k in ("shoulder", "elbow", "wrist", "hand")})
    beyond = 0.3 * (arm.upper - arm.lower)
    q = rng.uniform(arm.lower - beyond, arm.upper + beyond, (400, arm.n_joints))
    seen = model.positions(q) + rng.normal(0.0, 0.02, (400, 4, 3))
    found = solve_marker_ik(model, seen)
    assert found.converged.all()
    assert (found.q >= arm.lower).all() and (found.q <= arm.upper).all()
