import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.kinematics.body_frame import BodyFrame, stature_of
from selfmotion.kinematics.body_shapes import (
    BodyShapes,
    SegmentRadii,
    segment_distance,
)
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.kinematics.mirror import mirror
from selfmotion.kinematics.solid_shapes import Box, Capsule, Ellipsoid, Shape
from selfmotion.methods.workspace import Workspace, WorkspaceOptions, workspace
from selfmotion.redundancy.manifold import ManifoldFinder
from selfmotion.spatial import rotation_about

TURNED = rotation_about([0.0, 0.6, 0.8], 0.7)


def capsule_of(start: list[float], end: list[float], radius: float) -> Capsule:
    return Capsule(np.array(start), np.array(end), radius)


def ellipsoid_of(
    centre: list[float], half: list[float] | np.ndarray, axes: np.ndarray | None = None
) -> Ellipsoid:
    return Ellipsoid(np.array(centre), np.array(half), np.eye(3) if axes is None else axes)


def box_of(centre: list[float], half: list[float], axes: np.ndarray | None = None) -> Box:
    return Box(np.array(centre), np.array(half), np.eye(3) if axes is None else axes)


SHAPES: dict[str, Shape] = {
    "capsule": capsule_of([0.1, 0.0, -0.2], [0.0, 0.2, 0.3], 0.08),
    "ellipsoid": ellipsoid_of([0.1, 0.2, 0.0], [0.1, 0.3, 0.2], TURNED),
    "box": box_of([0.1, 0.2, 0.0], [0.1, 0.3, 0.2], TURNED),
}


def test_capsule_beside_beyond_and_within_its_segment() -> None:
    capsule = capsule_of([0.0, 0.0, 0.0], [0.0, 0.0, 2.0], 0.5)
    points = [[3.0, 4.0, 1.0], [3.0, 0.0, 6.0], [0.0, 0.0, -0.5], [0.2, 0.0, 1.0]]
    np.testing.assert_allclose(capsule.distance(points), [4.5, 4.5, 0.0, -0.3], atol=1e-15)
    ball = capsule_of([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.5)
    np.testing.assert_allclose(ball.distance([[1.0, 2.0, 0.0]]), [1.5])


def test_box_at_face_edge_corner_and_within() -> None:
    box = box_of([1.0, 0.0, 0.0], [1.0, 2.0, 3.0])
    points = [[5.0, 0.0, 0.0], [5.0, 6.0, 0.0], [4.0, 4.0, 4.0], [1.5, 0.0, 0.0]]
    np.testing.assert_allclose(box.distance(points), [3.0, 5.0, 3.0, -0.5])
    # Turned by a right angle about z, the long edge lies along x.
    turned = box_of([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], rotation_about([0.0, 0.0, 1.0], np.pi / 2))
    np.testing.assert_allclose(turned.distance([[5.0, 0.0, 0.0]]), [3.0])


def test_ellipsoid_on_its_axes_at_its_centre_and_between_its_focal_points() -> None:
    ellipsoid = ellipsoid_of([0.0, 0.0, 0.0], [2.0, 1.0, 1.5])
    points = [[5.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 0.0], [1.9, 0.0, 0.0]]
    # The last is outside the centre of curvature 2 - 1²/2 of the end: nearest is the end itself.
    np.testing.assert_allclose(ellipsoid.distance(points), [3.0, 2.0, -1.0, -0.1], atol=1e-13)
    # (1, 0) in the ellipse (2, 1): nearest x = 4/3, y² = 1 - 4/9, distance sqrt(2/3).
    flat = ellipsoid_of([0.0, 0.0, 0.0], [2.0, 1.0, 10.0])
    np.testing.assert_allclose(flat.distance([[1.0, 0.0, 0.0]]), [-np.sqrt(2 / 3)], atol=1e-12)


def test_points_along_the_normals_of_an_ellipsoid_are_as_far_as_they_were_put() -> None:
    rng = np.random.default_rng(1)
    half = np.array([0.07, 0.13, 0.27])
    u = rng.normal(size=(2000, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    normal = u / half
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    # Inwards no farther than the least radius of curvature.
    away = rng.uniform(-(half.min() ** 2) / half.max(), 0.5, 2000)
    points = half * u + away[:, None] * normal
    found = ellipsoid_of([0.1, 0.2, 0.3], half, TURNED).distance(
        points @ TURNED.T + [0.1, 0.2, 0.3]
    )
    np.testing.assert_allclose(found, away, atol=1e-13)


def test_ellipsoid_with_equal_axes_is_a_ball() -> None:
    points = np.vstack([np.zeros(3), np.random.default_rng(2).normal(size=(500, 3))])
    found = ellipsoid_of([0.0, 0.0, 0.0], [0.7, 0.7, 0.7]).distance(points)
    np.testing.assert_allclose(found, np.linalg.norm(points, axis=1) - 0.7, atol=1e-13)


@pytest.mark.parametrize("name", SHAPES)
def test_outside_the_distance_grows_by_one_a_metre_along_its_gradient(name: str) -> None:
    shape = SHAPES[name]
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (300, 3))
    points = points[shape.distance(points) > 0.01]
    h = 1e-5
    slope = np.column_stack(
        [(shape.distance(points + h * e) - shape.distance(points - h * e)) for e in np.eye(3)]
    ) / (2 * h)
    np.testing.assert_allclose(np.linalg.norm(slope, axis=1), 1.0, atol=1e-6)
    # The nearest point, found by going down the gradient, is on the surface.
    foot = points - shape.distance(points)[:, None] * slope
    np.testing.assert_allclose(shape.distance(foot), 0.0, atol=1e-6)


@pytest.mark.parametrize("name", SHAPES)
def test_a_segment_is_as_near_as_the_nearest_of_many_places(name: str) -> None:
    rng = np.random.default_rng(4)
    a, b = rng.uniform(-1.0, 1.0, (2, 50, 3))
    share = np.linspace(0.0, 1.0, 3001)[:, None, None]
    fine = SHAPES[name].distance((a + share * (b - a)).reshape(-1, 3)).reshape(3001, -1).min(axis=0)
    spacing = np.linalg.norm(b - a, axis=1) / 256
    assert (np.abs(segment_distance(SHAPES[name], a, b) - fine) <= spacing).all()


@pytest.mark.parametrize("name", SHAPES)
def test_an_unknown_point_has_no_distance_and_harms_no_other(name: str) -> None:
    found = SHAPES[name].distance([[1.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
    np.testing.assert_array_equal(np.isnan(found), [False, True])


def test_bad_shapes_are_refused() -> None:
    with pytest.raises(RangeError, match="radius = 0"):
        capsule_of([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.0)
    with pytest.raises(RangeError, match="half = -1"):
        ellipsoid_of([0.0, 0.0, 0.0], [1.0, -1.0, 1.0])
    with pytest.raises(RangeError, match="orthonormal"):
        box_of([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], 2 * np.eye(3))
    with pytest.raises(RangeError, match="skipped"):
        SegmentRadii(skipped=1.0)


@pytest.mark.parametrize("name", ["upper_limb", "myoarm"])
def test_the_body_is_its_own_mirror_image_and_serves_both_arms(name: str) -> None:
    arm = load_arm(name)
    body, other = BodyShapes.of(arm, "standing"), BodyShapes.of(mirror(arm), "standing")
    points = np.random.default_rng(5).uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 1.8], (500, 3))
    image = points * [-1.0, 1.0, 1.0]
    np.testing.assert_allclose(body.distance(points), body.distance(image), atol=1e-12)
    np.testing.assert_allclose(body.distance(points), other.distance(points), atol=1e-12)
    q = arm.random_postures(50, np.random.default_rng(6))
    left = other.clearance(mirror(arm))(q)
    np.testing.assert_allclose(body.clearance(arm)(q), left, atol=1e-12)


def test_heights_of_the_body_follow_the_stature() -> None:
    arm = load_arm("upper_limb")
    body = BodyShapes.of(arm, "standing", stature=2.0)
    # Shoulders are at 0.818 of the stature and at height 0 of this arm; the midline at x = 0.
    heights = (np.array([1.0, 0.87]) - 0.818) * 2.0
    forward = 0.015 * 2.0
    top, chin = body.shapes["head"].distance([[0.0, forward, z] for z in heights])
    assert (top, chin) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.0, abs=1e-12))
    knee = [0.1, 0.0, (0.285 - 0.818) * 2.0]
    assert body.shapes["right thigh"].distance([knee])[0] == pytest.approx(-0.09)
    seated = BodyShapes.of(arm, "seated", stature=2.0)
    knee = [0.1, 0.49, (0.530 - 0.818) * 2.0]
    assert seated.shapes["right thigh"].distance([knee])[0] == pytest.approx(-0.09)
    assert stature_of(arm) == pytest.approx((0.286 + 0.259) / 0.31626, rel=1e-4)


def test_shapes_are_added_replaced_and_taken_out() -> None:
    body = BodyShapes.of(load_arm("upper_limb"))
    wheel = capsule_of([0.0, 0.0, 2.0], [0.0, 0.0, 2.0], 0.1)
    assert not body.inside([[0.0, 0.0, 2.0]])[0]
    assert body.with_shape("wheel", wheel).inside([[0.0, 0.0, 2.0]])[0]
    assert body.with_shape("head", wheel).shapes["head"] is wheel
    assert list(body.without("head", "neck").shapes)[0] == "thorax"
    assert np.isinf(BodyShapes({}).distance([[0.0, 0.0, 0.0]]))[0]
    with pytest.raises(UnknownNameError, match="tail"):
        body.without("tail")
    with pytest.raises(UnknownNameError, match="tail"):
        body.clearance(load_arm("upper_limb"), against=("tail",))
    with pytest.raises(RangeError, match="stature"):
        BodyShapes.of(load_arm("upper_limb"), stature=17.0)


@pytest.mark.parametrize("name", ["upper_limb_anatomical", "myoarm"])
def test_the_hanging_arm_is_allowed(name: str) -> None:
    arm = load_arm(name)
    home = np.clip(np.zeros((1, arm.n_joints)), arm.lower, arm.upper)
    assert BodyShapes.of(arm).clearance(arm)(home)[0] > 0


def test_a_hand_in_the_thorax_has_no_posture_and_one_before_it_has() -> None:
    arm = load_arm("myoarm")
    body = BodyShapes.of(arm)
    clear = body.clearance(arm)
    finder = ManifoldFinder.of(arm)
    q = arm.random_postures(4000, np.random.default_rng(7))
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    depth = body.shapes["thorax"].distance(T[:, :3, 3])
    within = T[int(np.argmin(depth))]
    assert depth.min() < -0.05
    assert finder.find(within).intervals
    excluded = finder.find(within, clearance=clear)
    assert not excluded.intervals
    assert excluded.status.sentence == "every posture meets an excluded body"
    # Where the arm is free at first, what is left of the manifold is free all along.
    near = clear(q)
    pose = T[int(np.flatnonzero((near > 0.01) & (near < 0.02))[0])]
    kept = finder.find(pose, clearance=clear).intervals
    assert kept
    for interval in kept:
        places = np.linspace(interval.arc[0], interval.arc[-1], 20)[1:-1]
        assert (clear(interval.at(places)) >= -1e-4).all()


def test_a_body_makes_the_workspace_smaller_and_nothing_is_added() -> None:
    arm = load_arm("upper_limb_anatomical")
    body = BodyShapes.of(arm)
    free, cut = _small(arm, None), _small(arm, body)
    a, b = free.regions["free"], cut.regions["free"]
    np.testing.assert_array_equal(a.points, b.points)
    assert 0 < b.volume < a.volume
    assert not (b.inside & ~a.inside).any()
    assert not body.inside(b.points[b.inside]).any()
    np.testing.assert_array_equal(b.inside, a.inside & ~body.inside(a.points))
    assert not body.inside(cut.boundary["free"]).any()


def _small(arm, body: BodyShapes | None) -> Workspace:
    return workspace(
        arm,
        blocked=None if body is None else body.inside,
        options=WorkspaceOptions(n_points=512, shifts=2),
    )


def test_body_coordinates_are_the_same_for_both_arms() -> None:
    arm = load_arm("upper_limb")
    right, left = BodyFrame.of(arm), BodyFrame.of(mirror(arm))
    points = np.random.default_rng(7).normal(size=(20, 3))
    image = points * [-1.0, 1.0, 1.0]
    np.testing.assert_allclose(right.coordinates(points), left.coordinates(image), atol=1e-12)
    np.testing.assert_allclose(left.points(left.coordinates(image)), image, atol=1e-12)
    np.testing.assert_allclose(right.coordinates(right.shoulder[None]), [[0.188, 0, 0]], atol=1e-12)
    # The myoarm's ground has other axes, and its shoulder is still outwards of the middle.
    for arm in (load_arm("myoarm"), mirror(load_arm("myoarm"))):
        frame = BodyFrame.of(arm)
        assert frame.coordinates(frame.shoulder[None])[0, 0] > 0.05
