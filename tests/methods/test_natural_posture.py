import numpy as np
import pytest

from selfmotion.arms.person_with_muscles import PersonSize, myoarm_of_person
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import FileFormatError, RangeError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.kinematics.srs import SrsRelative
from selfmotion.methods.effort.posture_result import NaturalPosture
from selfmotion.methods.effort.two_phase_search import TwoPhaseOptions, two_phase_search
from selfmotion.methods.hybrid_ik import hybrid_ik
from selfmotion.methods.natural_posture import (
    PostureFinder,
    SearchOptions,
    natural_posture,
    natural_postures,
)
from selfmotion.muscles.fitted import mirror_muscles
from selfmotion.muscles.static_optimization import EffortOptions, muscle_effort
from selfmotion.redundancy.refine import refine


@pytest.fixture(scope="module")
def model():
    return load_musculoskeletal_arm()


@pytest.fixture(scope="module")
def finder(model):
    return PostureFinder.of(model)


def poses(model, count, seed):
    q = model.arm.random_postures(count, np.random.default_rng(seed))
    return forward_kinematics(model.arm.chain, q, model.arm.tip("hand"))


def sweep(model, manifold, step_deg):
    """Least effort over a dense sweep, and its swivel angle."""
    best, at = np.inf, np.nan
    for interval in manifold.intervals:
        low, high = interval.swivel_range
        count = max(int(np.rad2deg(high - low) / step_deg), 20)
        q = interval.at(np.linspace(0.0, interval.arc[-1], count))
        found = muscle_effort(model, q)
        held = np.array([bool(s) for s in found.status])
        effort = np.where(held, found.effort, np.inf)
        i = int(effort.argmin())
        if effort[i] < best:
            best, at = effort[i], interval.swivel_at(q)[i]
    return best, at


def test_the_least_effort_is_that_of_a_dense_sweep(model, finder):
    for T in poses(model, 5, 1):
        manifold = finder.manifolds.find(T)
        if not manifold.intervals:
            continue
        found = finder.find(T)
        best, at = sweep(model, manifold, 0.1)
        assert found.effort <= best * (1 + 1e-3)
        assert forward_kinematics(model.arm.chain, found.q, model.arm.tip("hand"))[
            0
        ] == pytest.approx(T, abs=1e-8)
        low, high = found.minima[0].valley
        slack = np.deg2rad(0.2)
        turn = 2 * np.pi * np.round((at - found.swivel) / (2 * np.pi))
        tied = [m for m in found.minima if m.tied]
        assert len(tied) > 1 or low - slack <= at - turn <= high + slack


@pytest.mark.parametrize("side", ["right", "left"])
def test_no_posture_of_a_scaled_arm_holds_the_pose_with_less_effort(side):
    """Against a sweep at a twentieth of a degree, and postures found without the manifold."""
    size = PersonSize({"upper_arm": 0.33, "forearm": 0.24, "hand": 0.09}, 1.4, "mass")
    own = myoarm_of_person(size) if side == "right" else mirror_muscles(myoarm_of_person(size))
    finder, arm, rng = PostureFinder.of(own), own.arm, np.random.default_rng(5)
    for q, T in zip(
        arm.random_postures(2, np.random.default_rng(6)), poses(own, 2, 6), strict=True
    ):
        found = finder.find(T)
        best, at = sweep(own, finder.manifolds.find(T), 0.05)
        assert found.effort <= best * (1 + 1e-3)
        wide = 0.5 * np.ptp(found.minima[0].valley)
        gap = abs((at - found.swivel + np.pi) % (2 * np.pi) - np.pi)
        assert sum(m.tied for m in found.minima) > 1 or gap < max(np.deg2rad(0.2), wide)
        free = refine(arm, arm.random_postures(30, rng), T)
        inside = free.reached & ((free.q >= arm.lower) & (free.q <= arm.upper)).all(axis=1)
        others = muscle_effort(own, np.vstack([q, free.q[inside]]))
        held = np.array([bool(s) for s in others.status])
        assert (others.effort[held] >= found.effort * (1 - 1e-3)).all()


@pytest.mark.long
def test_a_thousand_random_poses_against_a_sweep_at_a_twentieth_of_a_degree(model, finder):
    good = total = 0
    for T in poses(model, 1000, 2):
        manifold = finder.manifolds.find(T)
        total += 1
        if not manifold.intervals:
            continue
        found = finder.find(T)
        best, at = sweep(model, manifold, 0.05)
        gap = abs((at - found.swivel + np.pi) % (2 * np.pi) - np.pi)
        least = found.minima[0]
        undetermined = least.flat or sum(m.tied for m in found.minima) > 1
        wide = 0.5 * (least.valley[1] - least.valley[0])
        good += found.effort <= best * (1 + 1e-3) and (
            undetermined or gap < max(np.deg2rad(0.2), wide)
        )
    assert good >= 0.99 * total


def test_minima_are_sorted_and_inside_the_feasible_intervals(model, finder):
    for T in poses(model, 6, 3):
        found = finder.find(T)
        efforts = [m.effort for m in found.minima]
        assert efforts == sorted(efforts)
        for m in found.minima:
            low, high = found.feasible_swivel[m.interval]
            assert low - 1e-9 <= m.swivel <= high + 1e-9
        if found.minima:
            assert len(found.to_frame()) == len(found.minima)
            assert found.provenance.choices["convention"] == "plain"


def test_unreachable_and_bad_poses_do_not_stop_the_others(model, finder):
    T = poses(model, 3, 4)
    far, broken = T[1].copy(), T[2].copy()
    far[:3, 3] += 3.0
    broken[:3, :3] *= 2.0
    results = natural_postures(finder, [T[0], far, broken])
    first, second = results[:2]
    assert isinstance(first, NaturalPosture) and isinstance(second, NaturalPosture)
    assert bool(first.status)
    assert not second.status and "out of reach" in second.status.sentence
    assert np.isnan(second.q).all()
    assert isinstance(results[2], RangeError)


def test_the_published_search_drifts_and_is_never_better_on_the_pose(model, finder):
    q = [0.7, 0.9, -0.2, 1.5, 0.2, 0.05, 0.1]
    T = forward_kinematics(model.arm.chain, q, model.arm.tip("hand"))[0]
    options = TwoPhaseOptions(interval=float(np.deg2rad(10.0)))
    search = SearchOptions(search="paper", published=options)
    published = natural_posture(model, T, search=search)
    certain = finder.find(T)
    assert published.provenance.choices["search"] == "paper"
    assert published.drift[0] > 1e-7  # null-space steps are not corrected
    raw = two_phase_search(model, T, effort=EffortOptions(), options=options)
    assert raw.effort[0] == pytest.approx(published.effort)
    assert raw.passes >= 1 and raw.n_evaluations > raw.n_candidates > 0
    # Off the pose by millimetres, it may undercut the least effort on the pose a little.
    assert published.effort > 0.9 * certain.effort


def test_hybrid_ik_is_exact_and_keeps_the_swivel_angle(model):
    arm = model.arm
    q = [0.7, 0.9, -0.2, 1.5, 0.2, 0.05, 0.1]
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))[0]
    found = hybrid_ik(arm, T, relative=SrsRelative.of(arm))
    assert forward_kinematics(arm.chain, found.q, arm.tip("hand")) == pytest.approx(
        np.repeat(T[None], len(found.q), axis=0), abs=1e-9
    )
    inside = found.feasible
    assert inside.sum() > 10
    # The paper's Fig. 5 (A): a few degrees.
    assert np.rad2deg(np.abs(found.uncertainty[inside])).mean() < 8.0
    assert list(found.to_frame().columns[:4]) == ["swivel_asked", "swivel", "branch", "feasible"]


def test_names_that_do_not_exist_are_refused(model):
    with pytest.raises(UnknownNameError, match="unknown search 'best'"):
        SearchOptions(search="best")
    with pytest.raises(UnknownNameError, match="unknown on_jump"):
        SearchOptions(on_jump="ignore")
    with pytest.raises(FileFormatError, match=r"expected myoarm, an \.osim"):
        load_musculoskeletal_arm("arm.txt")
    with pytest.raises(RangeError, match="rule = 12"):
        TwoPhaseOptions(rule=12)
