"""Reach screen and workspace: known volumes, independent decisions, containment."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial import KDTree

from selfmotion.arms import load_arm
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm, weightless
from selfmotion.kinematics.chain import Chain, Tip
from selfmotion.kinematics.fast_position import positions
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import Reach, reach_screen
from selfmotion.methods.workspace import WorkspaceOptions, workspace
from selfmotion.redundancy.task import Position
from selfmotion.spatial import transform

XYZ = ("x", "y", "z")
BRACE = {"elbow_flexion": (np.deg2rad(64.2), np.deg2rad(114.0))}


def at_ends(arm, n_samples, rng):
    """Postures with about half of the joints at an end of their range."""
    ends = np.where(rng.random((n_samples, arm.n_joints)) < 0.5, arm.lower, arm.upper)
    held = rng.random((n_samples, arm.n_joints)) < 0.5
    return np.where(held, ends, arm.random_postures(n_samples, rng))


def telescope(inner: float = 0.3, outer: float = 0.5) -> Arm:
    """Two turns and a slide: the hand fills a shell between two spheres, all the way round."""
    names = ("turn", "lift", "slide")
    lower, upper = np.array([-np.pi, -np.pi / 2, inner]), np.array([np.pi, np.pi / 2, outer])
    axes = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])
    chain = Chain(
        names,
        np.array([-1, 0, 1]),
        np.array([0, 0, 1]),
        axes,
        np.stack([np.eye(4)] * 3),
        lower,
        upper,
    )
    marks = {name: Tip(2, transform()) for name in ("shoulder", "elbow", "wrist", "hand")}
    none = weightless(3)
    return Arm("telescope", chain, marks, {}, none["mass"], none["com"], none["inertia"])


def test_volume_of_a_shell():
    found = workspace(telescope(), options=WorkspaceOptions(n_points=1024, shifts=4))
    true = 4 / 3 * np.pi * (0.5**3 - 0.3**3)
    free = found.regions["free"]
    assert free.volume == pytest.approx(true, abs=4 * free.standard_error + 1e-3 * true)
    assert free.standard_error < 0.02 * true  # an estimate from four shifts, so it scatters
    # The hull fills the hollow core.
    assert found.hull_volume() == pytest.approx(4 / 3 * np.pi * 0.5**3, rel=0.02)


def test_area_of_a_slice_of_a_shell():
    options = WorkspaceOptions(n_points=64, shifts=4, slice_points=512)
    found = workspace(telescope(), heights=[0.0, 0.4], options=options)
    (ring, e0), (disc, e1) = (s.area() for s in found.slices)
    assert ring == pytest.approx(np.pi * (0.5**2 - 0.3**2), abs=4 * e0 + 2e-3)
    assert disc == pytest.approx(np.pi * (0.5**2 - 0.4**2), abs=4 * e1 + 2e-3)


def test_a_hull_of_too_few_points_is_no_number():
    found = workspace(load_arm("upper_limb"), options=WorkspaceOptions(n_points=64, shifts=2))
    assert np.isnan(found.hull_volume()) and len(found.hull()) > 3


def test_limited_lies_inside_free_and_the_lost_region_is_the_rest():
    arm = load_arm("upper_limb")
    options = WorkspaceOptions(n_points=256, shifts=4)
    found = workspace(arm, limited=arm.with_limits(BRACE), heights=[0.0], options=options)
    free, limited, lost = (found.regions[name] for name in ("free", "limited", "lost"))
    assert found.hull_volume() > 0.98 * free.volume - 3 * free.standard_error
    assert not (limited.inside & ~free.inside).any()
    np.testing.assert_array_equal(lost.inside, free.inside & ~limited.inside)
    assert lost.volume == pytest.approx(free.volume - limited.volume)
    hand = forward_kinematics(arm.chain, found.q[free.inside], arm.tip("hand"))[:, :3, 3]
    np.testing.assert_allclose(hand, free.points[free.inside], atol=1.1e-5)
    assert found.hull_volume("limited") > limited.volume
    assert "is lost, where help is needed" in found.summary()
    assert set(found.to_frame()["region"]) == {"free", "limited", "lost"}
    assert len(found.slices_frame()) == 3


def test_no_dependence_on_the_seed_beyond_the_error():
    arm, options = load_arm("upper_limb"), WorkspaceOptions(n_points=256, shifts=8)
    regions = [
        workspace(arm, options=options, rng=np.random.default_rng(seed)).regions["free"]
        for seed in (1, 2)
    ]
    error = np.hypot(regions[0].standard_error, regions[1].standard_error)
    assert abs(regions[0].volume - regions[1].volume) < 4 * error


def test_no_reachable_point_is_refused():
    arm, rng = load_arm("upper_limb").with_limits(BRACE), np.random.default_rng(3)
    screen = reach_screen(HandRows(arm, XYZ), n_points=1024)
    points = positions(arm.chain, arm.random_postures(100_000, rng), arm.tip("hand"))
    assert not screen.refuses(points).any()
    assert screen.decide(points[:2000]).reachable.all()


@pytest.mark.parametrize("limits", [{}, BRACE], ids=["free", "braced"])
def test_no_point_reached_at_the_ends_of_ranges_is_refused(limits):
    """The edge of what is reached, which random postures seldom meet."""
    arm, rng = load_arm("upper_limb").with_limits(limits), np.random.default_rng(5)
    screen = reach_screen(HandRows(arm, XYZ))
    q = at_ends(arm, 200_000, rng)
    assert not screen.refuses(positions(arm.chain, q, arm.tip("hand"))).any()


@pytest.mark.parametrize(
    ("limits", "centre", "claimed", "posture"),
    [
        (
            {},
            [0.11506772, -0.26934187, -0.02923154],
            5.605e-3,
            "0.23387412 0.07986577 -0.37175513 1.65866886 -1.18682389 2.13575742 -0.48694686 "
            "-0.50310182 2.66860843",
        ),
        (
            BRACE,
            [0.70910073, 0.14870255, -0.30505199],
            80.848e-3,
            "-0.02834831 0.21293017 -0.37175513 0.51619865 2.32128791 1.12050138 -0.11457373 "
            "-0.66021049 0.70882207",
        ),
    ],
    ids=["beside the reach", "far out"],
)
def test_a_misjudged_distance_refuses_nothing_reached(limits, centre, claimed, posture):
    """Inverse kinematics once stopped short of the postures nearest to these points."""
    arm = load_arm("upper_limb").with_limits(limits)
    screen = reach_screen(HandRows(arm, XYZ), n_points=16)
    q = np.clip(np.array([posture.split()], dtype=float), arm.lower, arm.upper)
    hand = positions(arm.chain, q, arm.tip("hand"))
    assert np.linalg.norm(hand - centre) < 0.95 * claimed - 1e-3
    far = 0.5 * (arm.lower + arm.upper)[None]
    misjudged = Reach(np.array([centre]), np.array([False]), np.array([claimed]), far)
    assert not screen.learn(misjudged).refuses(hand).any()


def test_distances_are_no_longer_than_to_any_known_posture():
    arm, rng = load_arm("upper_limb").with_limits(BRACE), np.random.default_rng(6)
    task = HandRows(arm, XYZ)
    screen = reach_screen(task, n_points=64)
    points = rng.uniform(screen.low, screen.high, (1500, 3))
    known = KDTree(positions(arm.chain, at_ends(arm, 200_000, rng), arm.tip("hand")))
    missed = solve_ik(task, points).position_error - known.query(points)[0]
    assert missed.max() < 1e-3


def test_decisions_agree_with_bounded_least_squares():
    """A point reached is seen to be; to the others SciPy's solver comes no nearer than 1 mm."""
    arm, rng = load_arm("upper_limb").with_limits(BRACE), np.random.default_rng(4)
    task = Position(arm)
    screen = reach_screen(HandRows(arm, XYZ), n_points=512)
    points = rng.uniform(screen.low, screen.high, (400, 3))
    reach = screen.decide(points)
    hand = positions(arm.chain, reach.q[reach.reachable], arm.tip("hand"))
    np.testing.assert_allclose(hand, points[reach.reachable], atol=1.1e-5)

    starts = at_ends(arm, 2000, rng)
    known = KDTree(positions(arm.chain, starts, arm.tip("hand")))
    settled = reach.reachable | (reach.distance < 1e-3)  # those are too near to the edge to argue
    away = np.where(settled, np.inf, known.query(points)[0])
    for point in points[np.argsort(away)[:8]]:  # the nearest ones: the hardest to decide
        for start in starts[known.query(point, k=3)[1]]:
            fit = least_squares(
                lambda q, x=point: task.error(q, x)[0],
                start,
                jac=lambda q: -task.jacobian(q)[0],  # pyright: ignore[reportArgumentType]
                bounds=(arm.lower, arm.upper),
                max_nfev=40,
            )
            assert np.linalg.norm(fit.fun) > 1e-4


@pytest.mark.parametrize("limits", [{}, BRACE], ids=["free", "braced"])
def test_neighbours_find_what_many_starts_find(limits):
    arm, rng = load_arm("upper_limb").with_limits(limits), np.random.default_rng(7)
    screen = reach_screen(HandRows(arm, XYZ), n_points=256)
    points = rng.uniform(screen.low, screen.high, (6000, 3))
    reach, learned = screen.explore(points)
    hand = positions(arm.chain, reach.q[reach.reachable], arm.tip("hand"))
    np.testing.assert_allclose(hand, points[reach.reachable], atol=1.1e-5)
    left = points[~reach.reachable]
    again = solve_ik(HandRows(arm, XYZ), left)
    assert again.solved.sum() <= 3  # of some 3000 that are reached
    tried = np.isfinite(reach.distance[~reach.reachable]) & ~again.solved
    longer = reach.distance[~reach.reachable][tried] - again.position_error[tried]
    assert (longer > 1e-3).mean() < 0.01
    np.testing.assert_allclose(
        positions(arm.chain, learned.postures, arm.tip("hand")), learned.hands, atol=1.1e-5
    )


def test_nothing_to_explore():
    screen = reach_screen(HandRows(load_arm("upper_limb"), XYZ), n_points=64)
    reach, learned = screen.explore(np.zeros((0, 3)))
    assert len(reach.reachable) == 0 and len(learned.hands) == len(screen.hands)


def test_a_thin_shell_is_not_missed():
    found = workspace(telescope(0.49, 0.5), options=WorkspaceOptions(n_points=4096, shifts=4))
    free, true = found.regions["free"], 4 / 3 * np.pi * (0.5**3 - 0.49**3)
    assert free.volume == pytest.approx(true, abs=4 * free.standard_error + 2e-3 * true)


def test_blocked_space_does_not_count():
    options = WorkspaceOptions(n_points=512, shifts=4)
    whole = workspace(telescope(), options=options).regions["free"]
    half = workspace(telescope(), options=options, blocked=lambda x: x[:, 2] < 0).regions["free"]
    assert half.volume == pytest.approx(whole.volume / 2, rel=0.03)
    assert (half.points[half.inside, 2] >= 0).all()


def test_bad_input():
    arm = load_arm("upper_limb")
    wide = arm.with_limits({"elbow_flexion": (0.0, 2.0)})
    with pytest.raises(RangeError, match="elbow_flexion 0 to 114.6 degrees: allowed is within"):
        workspace(arm, limited=wide)
    with pytest.raises(RangeError, match="the body blocks all of it"):
        workspace(
            telescope(),
            options=WorkspaceOptions(n_points=64, shifts=2),
            blocked=lambda x: np.ones(len(x), dtype=np.bool_),
        )
    with pytest.raises(RangeError, match="needs x, y and z held"):
        reach_screen(HandRows(arm, ("x", "y")))
    with pytest.raises(RangeError, match="shifts = 1"):
        WorkspaceOptions(shifts=1)
