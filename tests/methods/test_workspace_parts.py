"""What bounds a workspace, what one joint would give back, and the named regions."""

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm, weightless
from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.kinematics.chain import Chain, Tip
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.mirror import mirror
from selfmotion.kinematics.solid_shapes import Box, Capsule
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.boundary import BODY, LENGTH, boundary_limits
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.regained import regained_by_joint, share_without_body
from selfmotion.methods.reaching.regions import REGIONS, NamedRegion, decide_way, region_reach
from selfmotion.methods.reaching.screen import ReachScreen, reach_screen
from selfmotion.methods.reaching.sections import bounded_slices
from selfmotion.methods.workspace import Workspace, WorkspaceOptions, workspace
from selfmotion.spatial import transform
from tests.methods.test_workspace import BRACE, telescope

XYZ = ("x", "y", "z")
BY_NAME = {region.name: region for region in REGIONS}
# Abduction that keeps the elbow below the shoulder (rad).
LOW = {"upper_limb": (1.2, 1.6), "upper_limb_anatomical": (0.01, 0.4)}


def screen_of(arm: Arm) -> ReachScreen:
    return reach_screen(HandRows(arm, XYZ), n_points=512)


def elbow_arm() -> Arm:
    """Two turns at the shoulder and an elbow that may bend both ways by 2 rad."""
    along = transform(None, [0.3, 0.0, 0.0])
    names = ("turn", "lift", "elbow")
    lower, upper = np.array([-np.pi, -np.pi / 2, -2.0]), np.array([np.pi, np.pi / 2, 2.0])
    axes = np.array([[0.0, 0, 1], [0, 1, 0], [0, 1, 0]])
    offsets = np.stack([np.eye(4), np.eye(4), along])
    chain = Chain(names, np.array([-1, 0, 1]), np.zeros(3, int), axes, offsets, lower, upper)
    marks = {"shoulder": Tip(1, np.eye(4)), "elbow": Tip(2, np.eye(4))}
    marks |= {"wrist": Tip(2, along), "hand": Tip(2, along)}
    none = weightless(3)
    return Arm("elbow arm", chain, marks, {}, none["mass"], none["com"], none["inertia"])


def test_a_shell_is_bounded_by_the_two_ends_of_the_slide() -> None:
    found = boundary_limits(screen_of(telescope()), n_points=8192)
    table = found.to_frame().set_index("limit")
    assert set(table["bounded_by"]) == {"slide"}
    # Layers 20 mm thick: outside the outer sphere, inside the inner one.
    outer, inner = 0.52**3 - 0.5**3, 0.3**3 - 0.28**3
    share = 100 * outer / (outer + inner)
    assert table.loc["upper", "share_percent"] == pytest.approx(share, abs=4)
    np.testing.assert_allclose(np.abs(found.gains[:, 2]), 1.0, atol=1e-6)
    radius = np.linalg.norm(found.points, axis=1)
    np.testing.assert_allclose(radius, np.where(found.side > 0, 0.5, 0.3), atol=1e-4)


def test_limits_of_slices_lie_in_the_slices() -> None:
    options = WorkspaceOptions(n_points=256, shifts=2)
    heights = [0.0, 0.25, 0.45]
    cuts = bounded_slices(workspace(telescope(), heights=heights, options=options))
    assert len(cuts) == 3
    for cut, height in zip(cuts, heights, strict=True):
        assert cut.boundary is not None
        assert np.abs(cut.boundary.points[:, 2] - height).max() <= 0.02
        # The inner sphere ends below the highest slice.
        assert set(np.unique(cut.boundary.side)) == ({-1, 1} if height < 0.3 else {1})


def test_a_straight_arm_is_bounded_by_its_length_and_a_bent_one_by_the_elbow() -> None:
    found = boundary_limits(screen_of(elbow_arm()), n_points=8192)
    radius = np.linalg.norm(found.points, axis=1)
    near = 2 * 0.3 * np.cos(1.0)
    assert set(np.unique(found.main)) == {LENGTH, 2}
    np.testing.assert_allclose(radius[found.main == LENGTH], 0.6, atol=1e-3)
    np.testing.assert_allclose(radius[found.main == 2], near, atol=1e-3)
    # The chord of two links of 0.3 m changes by 0.3 sin(1) for a radian at a bend of 2 rad.
    bent = np.abs(found.gains[found.main == 2, 2])
    np.testing.assert_allclose(bent, 0.3 * np.sin(1.0), atol=1e-4)


def test_the_surface_of_the_body_is_a_boundary_of_its_own() -> None:
    ball = BodyShapes({"ball": Capsule(np.array([0.4, 0, 0]), np.array([0.4, 0, 0]), 0.08)})
    found = boundary_limits(screen_of(telescope()), body=ball, n_points=16384)
    on_body = found.points[found.main == BODY]
    assert len(on_body) > 5
    away = np.linalg.norm(on_body - [0.4, 0, 0], axis=1)
    assert ((away <= 0.08) & (away >= 0.06)).all()
    assert np.isnan(found.normals[found.main == BODY]).all()


def test_a_limit_that_gives_way_moves_the_boundary_as_far_as_its_gain_says() -> None:
    arm = load_arm("upper_limb").with_limits(BRACE)
    found = boundary_limits(screen_of(arm), n_points=4096)
    give = 0.01
    for joint, side in found.limit_names()[:3]:
        name, at = arm.joints[joint], found.chosen(joint, side)
        low, high = float(arm.lower[joint]), float(arm.upper[joint])
        wider = (low - give, high) if side < 0 else (low, high + give)
        gain = np.abs(found.gains[at, joint])[:, None]
        beyond = found.points[at] + 0.8 * give * gain * found.normals[at]
        before = solve_ik(HandRows(arm, XYZ), beyond)
        after = solve_ik(HandRows(arm.with_limits({name: wider}), XYZ), beyond)
        assert before.solved.mean() < 0.05
        assert after.solved.mean() > 0.95


def test_what_one_joint_gives_back_lies_between_nothing_and_all() -> None:
    arm = load_arm("upper_limb")
    both = arm.with_limits({**BRACE, "shoulder_flexion": (-0.3, 1.6)})
    options = WorkspaceOptions(n_points=256, shifts=2)
    lost = workspace(arm, limited=both, options=options).regions["lost"]
    parts = regained_by_joint(arm, both, lost)
    assert set(parts) == {"elbow_flexion", "shoulder_flexion"}
    assert all(0 < share.part < 1 for share in parts.values())
    assert parts["elbow_flexion"].volume < lost.volume
    with pytest.raises(RangeError, match="no joint has a narrower range"):
        regained_by_joint(arm, arm, lost)


def test_a_body_that_is_out_of_the_way_forbids_no_posture() -> None:
    arm = load_arm("upper_limb")
    space = workspace(arm, options=WorkspaceOptions(n_points=128, shifts=2))
    free = space.regions["free"]
    away = BodyShapes({"thorax": Box(np.array([0, 0, 5.0]), np.ones(3))})
    assert share_without_body(space.screens[-1], free, away).part == 0.0
    around = BodyShapes({"thorax": Box(np.zeros(3), np.full(3, 2.0))})
    whole = share_without_body(space.screens[-1], free, around)
    assert (whole.part, whole.volume) == (1.0, free.volume)


def small(arm: Arm, **more: object) -> Workspace:
    options = WorkspaceOptions(n_points=1024, shifts=4)
    return workspace(arm, options=options, **more)  # pyright: ignore[reportArgumentType]


def test_an_open_region_holds_what_the_workspace_holds_there() -> None:
    arm = load_arm("upper_limb_anatomical")
    space = small(arm, limited=arm.with_limits(BRACE))
    found = region_reach(space, [BY_NAME["overhead"]])[0]
    frame = BodyFrame.of(arm)
    high = frame.coordinates(space.regions["free"].points)[:, 2] > 0.182 * frame.stature
    for name, region in space.regions.items():
        there = region.where(name, high)
        error = np.hypot(there.standard_error, found.sets[name].standard_error)
        assert found.sets[name].volume == pytest.approx(there.volume, abs=4 * error)
    assert not (found.sets["limited"].inside & ~found.sets["free"].inside).any()


def test_regions_are_the_same_for_the_left_arm() -> None:
    arm = load_arm("upper_limb_anatomical")
    chosen = [BY_NAME["table"], BY_NAME["opposite_shoulder"], BY_NAME["over_shoulder"]]
    right, left = (region_reach(small(a), chosen) for a in (arm, mirror(arm)))
    for one, other in zip(right, left, strict=True):
        error = np.hypot(one.sets["free"].standard_error, other.sets["free"].standard_error)
        assert one.space == pytest.approx(other.space)
        assert one.sets["free"].volume == pytest.approx(other.sets["free"].volume, abs=5 * error)


@pytest.mark.parametrize(("name", "elbow"), [("upper_limb", 64.2), ("upper_limb_anatomical", 0)])
def test_over_the_shoulder_is_a_way_as_well_as_a_place(name: str, elbow: float) -> None:
    rng = np.random.default_rng(2)
    arm = load_arm(name).with_limits({"elbow_flexion": (np.deg2rad(elbow), np.deg2rad(114.0))})
    region, frame = BY_NAME["over_shoulder"], BodyFrame.of(arm)
    q = arm.random_postures(200_000, rng)
    shoulder, raised, hand = np.moveaxis(
        tip_positions(arm.chain, q, [arm.tip(n) for n in ("shoulder", "elbow", "hand")]), 1, 0
    )
    place = frame.coordinates(hand) / frame.stature
    ends = np.array([region.outwards, region.forward, region.up])
    there = ((place > ends[:, 0]) & (place < ends[:, 1])).all(axis=1)
    over = there & (raised[:, 2] > shoulder[:, 2] + 1e-3)
    # One posture a cell: random postures crowd where the way is easily found.
    cells = np.unique(np.floor(hand[over] / 0.03), axis=0, return_index=True)[1]
    places = hand[over][cells]
    assert len(places) > 300
    screen = screen_of(arm)
    found = decide_way(screen, places, "over", frame, 1)
    assert found.mean() > 0.99
    # With the arm kept below the shoulder there is no way over it.
    low = arm.with_limits({"shoulder_flexion": (-0.3, 0.5), "shoulder_adduction": LOW[name]})
    none = decide_way(screen_of(low), places[::4], "over", frame, 1)
    assert not none.any()


def test_a_region_beyond_all_reach_holds_nothing() -> None:
    space = small(load_arm("upper_limb"))
    far = NamedRegion("far", "Far above", up=(2.0, np.inf))
    box = NamedRegion("box", "A box far above", (0, 1), (0, 1), (2.0, 3.0))
    for found in region_reach(space, [far, box]):
        assert found.sets["free"].volume == 0.0


def test_bad_regions_are_refused() -> None:
    with pytest.raises(RangeError, match="up = 0.2 to 0.1: the second number must be above"):
        NamedRegion("x", "X", up=(0.2, 0.1))
    with pytest.raises(RangeError, match="forward = nan"):
        NamedRegion("x", "X", forward=(np.nan, 0.1))


def test_a_workspace_that_limits_leave_empty_names_them() -> None:
    arm = load_arm("upper_limb")
    still = {j: (0.5, 0.5) for j in arm.joints if j not in ("elbow_flexion", "shoulder_adduction")}
    still |= {"elbow_flexion": (1.0, 1.0), "shoulder_adduction": (1.0, 2.0)}
    held = Arm(**{**vars(arm), "chain": arm.with_limits(still).chain})
    with pytest.raises(RangeError, match="no volume, the hand moves on a line; no range: scapula"):
        workspace(held, options=WorkspaceOptions(n_points=64, shifts=2))
    with pytest.raises(RangeError, match="on a surface; its joints allow no more"):
        workspace(load_arm("planar"), options=WorkspaceOptions(n_points=64, shifts=2))
    free = arm.with_limits({j: (-3.0, 3.0) for j in arm.joints})
    space = workspace(free, limited=held, options=WorkspaceOptions(n_points=64, shifts=2))
    assert space.regions["limited"].volume == 0.0
    assert "reaches no volume (no range: " in space.summary()
    assert space.hull_volume("limited") >= 0.0
