import numpy as np
import pytest

from selfmotion.arms import myoarm, planar, srs7
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import ModelError, RangeError, ShapeError
from selfmotion.kinematics.chain import CoupledCurve, Coupling
from selfmotion.kinematics.forward import forward_kinematics, frames_and_jacobian
from selfmotion.kinematics.srs import SrsRelative
from selfmotion.kinematics.swivel import arm_swivel_angle
from selfmotion.redundancy import pose_kernels
from selfmotion.redundancy.manifold import ManifoldFinder, self_motion_manifold
from selfmotion.redundancy.refine import path_arrays, pose_from_quaternion, refine

ARMS = {"srs7": srs7, "myoarm": myoarm}


@pytest.fixture(scope="module", params=list(ARMS))
def arm(request):
    return ARMS[request.param]()


def hand(arm, q):
    return forward_kinematics(arm.chain, q, arm.tip("hand"))


def test_the_kernel_gives_frames_and_jacobian_of_the_chain(arm):
    from dataclasses import replace

    from scipy.interpolate import CubicSpline

    bent = arm
    if not arm.chain.coupling.is_identity:  # let one joint follow a curve
        curve = CubicSpline([-1.0, 0.0, 2.0], [-1.5, 0.0, 2.5])
        c = arm.chain.coupling
        i = arm.chain.names.index("shoulder1_r2")
        matrix = c.matrix.copy()
        matrix[i] = 0.0
        coupling = Coupling(c.coordinates, matrix, c.offset, (CoupledCurve(i, 0, curve),))
        bent = replace(arm, chain=replace(arm.chain, coupling=coupling))
    for one in (arm, bent):
        q = one.random_postures(20, np.random.default_rng(0))
        T, J = frames_and_jacobian(one.chain, q, one.tip("hand"))
        path = path_arrays(one.chain, one.tip("hand"))
        Tk, Jk = np.empty((3, 4)), np.empty((6, 7))
        scratch = np.empty((len(path.offset), 7))
        for k in range(len(q)):
            pose_kernels.hand_and_jacobian(path, q[k], Tk, Jk, scratch)
            assert Tk == pytest.approx(T[k, :3], abs=1e-13)
            assert Jk == pytest.approx(J[k], abs=1e-13)


def test_the_closed_form_is_exact_where_the_arm_is_its_own_relative():
    arm = srs7()
    relative = SrsRelative.of(arm)
    for q in arm.random_postures(20, np.random.default_rng(1)):
        T = hand(arm, q)[0]
        found, out = relative.postures(T, arm_swivel_angle(arm, q))
        good = np.isfinite(out[0])
        assert hand(arm, found[0][good]) == pytest.approx(np.repeat(T[None], good.sum(), 0))
        assert np.abs(found[0][good] - q).max(axis=1).min() < 1e-7


def test_refinement_reaches_the_pose_and_reports_where_it_does_not(arm):
    rng = np.random.default_rng(2)
    q = arm.random_postures(30, rng)
    done = refine(arm, q + rng.normal(scale=0.15, size=q.shape), hand(arm, q))
    assert done.reached.all()
    assert hand(arm, done.q) == pytest.approx(hand(arm, q), abs=1e-9)
    far = hand(arm, q[:1]).copy()
    far[0, :3, 3] += 5.0
    assert not refine(arm, q[:1], far).reached[0]


def test_a_manifold_holds_the_posture_that_its_pose_came_from(arm):
    finder = ManifoldFinder.of(arm)
    postures = arm.random_postures(25, np.random.default_rng(3))
    # A little off the limits: a posture on a limit may stand at the very end of an interval.
    postures = arm.middle() + 0.9 * (postures - arm.middle())
    for q in postures:
        manifold = finder.find(hand(arm, q)[0])
        gaps = []
        for interval in manifold.intervals:
            s = np.linspace(0.0, interval.arc[-1], 400)
            gaps.append(np.abs(interval.at(s) - q).max(axis=1).min())
        assert min(gaps) < 0.02


def distance(manifold, q):
    """Greatest coordinate between a posture and the nearest of all intervals (rad)."""
    least = np.inf
    for interval in manifold.intervals:
        s = np.linspace(0.0, interval.arc[-1], max(50, int(interval.arc[-1] / 0.02)))
        for _ in range(4):
            gap = np.abs(interval.at(s) - q).max(axis=1)
            i = gap.argmin()
            s = np.linspace(s[max(i - 1, 0)], s[min(i + 1, len(s) - 1)], 20)
            least = min(least, gap.min())
    return least


# Degrees, in the order of the joints: postures from which a hand pose was made.
HARD = {
    "raised arm, nearly straight elbow": (-64.86, 171.42, -32.64, 9.35, 78.27, 23.98, 1.19),
    "hanging arm, nearly straight elbow": (116.15, 5.2, -61.16, 7.51, -11.42, 3.47, 33.31),
    "hanging arm, singular shoulder": (74.47, 0.46, -76.13, 8.09, 20.25, 9.26, 28.06),
    "raised arm, singular shoulder": (-46.29, 178.94, 102.23, 8.86, 0.2, -4.03, 29.44),
    "out of reach of the relative": (96.15, 134.44, 110.23, 4.52, 69.22, 9.13, 32.1),
    "singular shoulder, straight elbow": (129.97, 180.0, -80.12, 6.28, 77.8, 11.59, -37.08),
    "singular shoulder, bent elbow": (127.66, 179.56, -88.1, 62.71, -28.72, 15.69, 13.5),
    "a loop of which little is outside": (31.9, 164.76, 29.46, 0.22, 67.45, 17.14, 29.99),
    "a loop entered at its seam": (-70.1, 0.84, 105.24, 0.01, 40.93, -8.26, 22.17),
    "a curve that comes back beside itself": (-57.49, 67.97, 117.17, 1.0, 86.8, 24.99, 22.93),
    "a small loop at the edge of reach": (-94.08, 53.43, 21.98, 0.12, 55.14, 7.06, -14.14),
}


@pytest.mark.parametrize("name", HARD)
def test_a_hard_pose_has_the_interval_of_the_posture_it_came_from(name):
    arm = load_musculoskeletal_arm().arm
    q = np.deg2rad(HARD[name])
    manifold = ManifoldFinder.of(arm).find(hand(arm, q)[0])
    assert distance(manifold, q) < 1e-4
    for interval in manifold.intervals:
        assert "end of the curve" not in interval.ends


@pytest.mark.long
@pytest.mark.parametrize("edge_deg", [None, 2.0])
def test_two_thousand_poses_have_the_interval_of_the_posture_they_came_from(edge_deg):
    arm = load_musculoskeletal_arm().arm
    finder, rng = ManifoldFinder.of(arm), np.random.default_rng(7)
    postures = arm.random_postures(2000, rng)
    if edge_deg is not None:  # one coordinate of each beside one of its limits
        joint, off = rng.integers(0, 7, 2000), np.deg2rad(rng.uniform(0.0, edge_deg, 2000))
        low = rng.integers(0, 2, 2000) == 0
        beside = np.where(low, arm.lower[joint] + off, arm.upper[joint] - off)
        postures[np.arange(2000), joint] = beside
    missed = [q for q in postures if not distance(finder.find(hand(arm, q)[0]), q) < 1e-4]
    assert not missed


def test_a_loop_is_walked_round_once():
    """A shoulder and wrist that turn without limits: the whole circle of the elbow is feasible."""
    wide = {joint: (-3.1415, 3.1415) for joint in srs7().joints}
    arm = srs7().with_limits(wide)
    for q in arm.random_postures(20, np.random.default_rng(8)):
        T = hand(arm, q)[0]
        for interval in ManifoldFinder.of(arm).find(T).intervals:
            low, high = interval.swivel_range
            assert high - low < 2 * np.pi + 1e-6
            if interval.ends == ("closed", "closed"):
                turn = (interval.q[-1] - interval.q[0] + np.pi) % (2 * np.pi) - np.pi
                assert np.abs(turn).max() < 1e-9


def test_intervals_stay_on_the_pose_and_end_on_the_limit_they_name(arm):
    finder = ManifoldFinder.of(arm)
    for q in arm.random_postures(8, np.random.default_rng(4)):
        T = hand(arm, q)[0]
        for interval in finder.find(T).intervals:
            s = np.linspace(0.0, interval.arc[-1], 50)
            on = interval.at(s)
            assert hand(arm, on) == pytest.approx(np.repeat(T[None], 50, axis=0), abs=1e-8)
            assert (on >= arm.lower - 1e-9).all() and (on <= arm.upper + 1e-9).all()
            for end, name in zip((interval.q[0], interval.q[-1]), interval.ends, strict=True):
                if " " not in name or name == "end of the curve":
                    continue
                joint, side = name.rsplit(" ", 1)
                limit = {"lower": arm.lower, "upper": arm.upper}[side]
                i = arm.joints.index(joint)
                assert end[i] == pytest.approx(limit[i], abs=1e-12)
                assert hand(arm, end)[0] == pytest.approx(T, abs=1e-8)


def test_a_brute_force_sweep_finds_no_posture_outside_the_intervals():
    arm = srs7()
    finder, relative = ManifoldFinder.of(arm), SrsRelative.of(arm)
    for q in arm.random_postures(6, np.random.default_rng(5)):
        T = hand(arm, q)[0]
        manifold = finder.find(T)
        swivel = np.deg2rad(np.arange(-180, 180, 0.5))
        found, out = relative.postures(T, swivel)
        inside = (found > arm.lower + 0.01).all(axis=2) & (found < arm.upper - 0.01).all(axis=2)
        places = [i.at(np.linspace(0, i.arc[-1], 600)) for i in manifold.intervals]
        for posture in found[inside & (out < 1e-12)]:
            assert min(np.abs(q - posture).max(axis=1).min() for q in places) < 0.02


def test_an_excluded_body_cuts_intervals_where_it_begins():
    arm = srs7()
    T = hand(arm, arm.middle())[0]
    whole = self_motion_manifold(arm, T)
    middle = float(np.mean(whole.swivel_intervals[0]))

    def clearance(q):
        return middle - arm_swivel_angle(arm, q)

    part = self_motion_manifold(arm, T, clearance=clearance)
    ends = [end for interval in part.intervals for end in interval.ends]
    assert "body" in ends
    assert part.swivel_width < whole.swivel_width
    assert max(high for _, high in part.swivel_intervals) == pytest.approx(middle, abs=1e-6)


def test_what_cannot_be_reached_says_by_how_much(arm):
    T = hand(arm, arm.middle())[0].copy()
    T[:3, 3] += 2.0 * arm.forward
    manifold = self_motion_manifold(arm, T)
    assert not manifold.intervals and not manifold.status
    assert "out of reach" in manifold.status.sentence and "mm" in manifold.status.sentence


def test_bad_input_is_refused_in_one_line():
    arm = srs7()
    with pytest.raises(RangeError, match="not a rotation"):
        self_motion_manifold(arm, np.diag([1.0, 1.0, 2.0, 1.0]))
    with pytest.raises(ShapeError, match="2 poses given"):
        self_motion_manifold(arm, np.repeat(np.eye(4)[None], 2, axis=0))
    with pytest.raises(ModelError, match="a swivel needs 7"):
        self_motion_manifold(planar([0.3, 0.3]), np.eye(4))
    with pytest.raises(RangeError, match="has length 2"):
        pose_from_quaternion([0, 0, 0, 2], [0, 0, 0])
    assert pose_from_quaternion([0, 0, 0, 1], [1, 2, 3])[:3, 3].tolist() == [1, 2, 3]


def test_both_elbow_branches_are_found_where_the_limits_allow_them():
    wide = {joint: (-3.1, 3.1) for joint in srs7().joints} | {"elbow_flexion": (-2.2, 2.2)}
    arm = srs7().with_limits(wide)
    q = np.array([0.4, 0.8, 0.3, 1.2, 0.5, 0.3, 0.2])
    T = hand(arm, q)[0]
    manifold = self_motion_manifold(arm, T)
    elbows = [np.sign(i.q[:, 3]) for i in manifold.intervals]
    assert any((e > 0).all() for e in elbows) and any((e < 0).all() for e in elbows)
    for interval in manifold.intervals:
        on = interval.at(np.linspace(0.0, interval.arc[-1], 20))
        assert hand(arm, on) == pytest.approx(np.repeat(T[None], 20, axis=0), abs=1e-8)


def test_a_robot_arm_whose_axes_are_parallel_at_home_has_a_manifold():
    """Seven axes as on common robot arms: z, y, z, y, z, y, z, all upright at zero."""
    from selfmotion.kinematics.arm import Arm, weightless
    from selfmotion.kinematics.chain import Chain, Tip
    from selfmotion.spatial import transform

    heights = [0.34, 0.0, 0.4, 0.0, 0.4, 0.0, 0.0]
    y, z = [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
    offsets = np.array([transform(translation=[0, 0, h]) for h in heights])
    names = tuple(f"axis_{i}" for i in range(1, 8))
    bound = np.deg2rad([170.0, 120, 170, 120, 170, 120, 175])
    chain = Chain(
        names,
        np.arange(-1, 6),
        np.zeros(7, dtype=int),
        np.array([z, y] * 3 + [z]),
        offsets,
        -bound,
        bound,
    )
    tips = {"shoulder": Tip(1), "elbow": Tip(3), "wrist": Tip(5)}
    tips["hand"] = Tip(6, transform(translation=[0, 0, 0.126]))
    none = weightless(7)
    arm = Arm("robot", chain, tips, {}, none["mass"], none["com"], none["inertia"])
    finder = ManifoldFinder.of(arm)
    for q in arm.random_postures(6, np.random.default_rng(6)):
        manifold = finder.find(hand(arm, q)[0])
        near = [
            np.abs(i.at(np.linspace(0.0, i.arc[-1], 800)) - q).max(axis=1).min()
            for i in manifold.intervals
        ]
        assert min(near) < 0.05
