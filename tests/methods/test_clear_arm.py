"""Workspaces whose arm keeps out of the body: nested, proved by postures, judged by SciPy."""

import numpy as np
import pytest
from scipy.optimize import minimize

from selfmotion.arms import load_arm
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.kinematics.forward import geometric_jacobian, tip_positions
from selfmotion.methods.reaching.clear_arm import clear_of_body, clear_places
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.regained import regained_by_joint
from selfmotion.methods.reaching.regions import REGIONS, region_reach
from selfmotion.methods.workspace import WorkspaceOptions, workspace

FEW = WorkspaceOptions(n_points=128, shifts=2, slice_points=64)


@pytest.fixture(scope="module")
def spaces():
    arm = load_arm("upper_limb")
    body = BodyShapes.of(arm)
    brace = arm.with_limits({"elbow_flexion": (1.12, 1.99)})
    hand = workspace(arm, limited=brace, heights=[0.1], blocked=body.inside, options=FEW)
    return body, hand, clear_of_body(hand, body)


def test_sets_are_nested(spaces):
    _, hand, arm = spaces
    for regions, whole in (
        (arm.regions, hand.regions),
        (arm.slices[0].regions, hand.slices[0].regions),
    ):
        for name in ("free", "limited"):
            assert not (regions[name].inside & ~whole[name].inside).any()
        assert not (regions["limited"].inside & ~regions["free"].inside).any()
        lost = regions["free"].inside & ~regions["limited"].inside
        np.testing.assert_array_equal(regions["lost"].inside, lost)
    assert 0.9 < arm.regions["free"].volume / hand.regions["free"].volume < 0.98


def test_hands_of_clear_postures_are_found(spaces):
    """Postures drawn at random that are clear prove their places."""
    body, hand, _ = spaces
    arm = hand.arm
    q = arm.random_postures(20_000, np.random.default_rng(3))
    x = tip_positions(arm.chain, q, [arm.tip("hand")])[:, 0]
    # Near the body, where it matters.
    near = (body.clearance(arm)(q) > 0.002) & (body.distance(x) < 0.15) & ~body.inside(x)
    places = x[near][:400]
    assert len(places) > 200
    assert clear_places(HandRows(arm, ("x", "y", "z")), places, body).mean() > 0.99


def test_scipy_finds_no_clear_posture_where_none_was_found(spaces):
    body, hand, arm = spaces
    left = hand.regions["free"].inside & ~arm.regions["free"].inside
    clear, tip, rng = body.clearance(hand.arm), hand.arm.tip("hand"), np.random.default_rng(4)
    chain, bounds = hand.arm.chain, list(zip(hand.arm.lower, hand.arm.upper, strict=True))
    for place in hand.regions["free"].points[left][:3]:

        def miss(q: np.ndarray, x: np.ndarray = place) -> np.ndarray:
            return tip_positions(chain, q[None], [tip])[0, 0] - x

        held = {
            "type": "eq",
            "fun": miss,
            "jac": lambda q: geometric_jacobian(chain, q[None], tip)[0, :3],
        }
        for _ in range(2):
            start = rng.uniform(hand.arm.lower, hand.arm.upper)
            found = minimize(
                lambda q: -10 * min(clear(q[None])[0], 0.01),
                start,
                bounds=bounds,
                constraints=[held],
                method="SLSQP",
                options={"maxiter": 30},
            ).x
            assert np.linalg.norm(miss(found)) > 1e-4 or clear(found[None])[0] < 1e-3


def test_places_and_joints_respect_the_body_too(spaces):
    body, hand, arm = spaces
    chosen = [r for r in REGIONS if r.name == "over_shoulder"]
    loose = region_reach(hand, chosen, n_points=24)
    tight = region_reach(arm, chosen, n_points=24, clear_of=body)
    for one, other in zip(loose, tight, strict=True):
        for name in ("free", "limited"):
            assert not (other.sets[name].inside & ~one.sets[name].inside).any()
    back = regained_by_joint(arm.arm, arm.limited_arm, arm.regions["lost"], clear_of=body)
    assert back["elbow_flexion"].part == 1.0


def test_without_shapes_nothing_is_taken_off():
    arm = load_arm("upper_limb_anatomical")
    space = workspace(arm, options=FEW)
    clear = clear_of_body(space, BodyShapes({}))
    np.testing.assert_array_equal(clear.regions["free"].inside, space.regions["free"].inside)
    assert clear.provenance.choices["arm_outside"] is True
