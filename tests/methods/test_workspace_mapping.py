"""The map from one workspace onto another: identities, known envelopes, refusals."""

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.envelope import Envelope, icosphere, reach_envelope
from selfmotion.methods.workspace_mapping import WorkspaceMapping, workspace_mapping
from selfmotion.provenance import Provenance
from selfmotion.redundancy.task import Position
from tests.methods.test_workspace import telescope

BRACE = {"elbow_flexion": (np.deg2rad(64.2), np.deg2rad(114.0))}


@pytest.fixture(scope="module")
def mapping():
    arm = load_arm("upper_limb")
    return workspace_mapping(arm, arm.with_limits(BRACE), subdivisions=2)


def some(mapping, n=500):
    """Points in, on and around the source."""
    rng = np.random.default_rng(1)
    low, high = mapping.source.vertices.min(axis=0), mapping.source.vertices.max(axis=0)
    return rng.uniform(low - 0.1, high + 0.1, (n, 3))


def test_round_trip(mapping):
    x = np.vstack([some(mapping), mapping.source.centre, mapping.source.vertices])
    there = mapping.map_points(x)
    np.testing.assert_allclose(mapping.inverse.map_points(there), x, atol=1e-12)


def test_envelope_goes_to_envelope_and_centre_to_centre(mapping):
    rng = np.random.default_rng(2)
    corners = mapping.source.vertices[mapping.source.faces]
    shares = rng.dirichlet(np.ones(3), len(corners))
    on = np.einsum("fi,fij->fj", shares, corners)
    np.testing.assert_allclose(mapping.source.gauge(on), 1.0, atol=1e-12)
    np.testing.assert_allclose(mapping.target.gauge(mapping.map_points(on)), 1.0, atol=1e-12)
    centre = mapping.map_points(mapping.source.centre[None])
    np.testing.assert_allclose(centre, mapping.target.centre[None], atol=1e-15)


def test_share_and_direction_are_kept(mapping):
    x = some(mapping)
    y = mapping.map_points(x)
    np.testing.assert_allclose(mapping.target.gauge(y), mapping.source.gauge(x), rtol=1e-10)
    a, b = x - mapping.source.centre, y - mapping.target.centre
    np.testing.assert_allclose(np.cross(a, b), 0.0, atol=1e-12)
    assert (np.einsum("ki,ki->k", a, b) > 0).all()


def test_equal_workspaces_give_the_identity(mapping):
    same = WorkspaceMapping(mapping.source, mapping.source, (1.0, 1.0), Provenance("test"))
    x = some(mapping)
    np.testing.assert_allclose(same.map_points(x), x, atol=1e-12)


def test_it_is_continuous(mapping):
    """Across edges of triangles, too: a small step stays small."""
    rng = np.random.default_rng(3)
    a = some(mapping)
    step = 1e-7 * rng.standard_normal(a.shape)
    moved = mapping.map_points(a + step) - mapping.map_points(a)
    ratio = np.linalg.norm(moved, axis=1) / np.linalg.norm(step, axis=1)
    slope = (mapping.target.radius.max() / mapping.source.radius.min()) * 20
    assert ratio.max() < slope


def test_a_sphere_is_found_and_scaled():
    """The telescope reaches a shell of 0.3 to 0.5 m; its envelope is the outer sphere."""
    centre = np.zeros(3)
    envelope = reach_envelope(telescope(), centre, subdivisions=2)
    np.testing.assert_allclose(envelope.radius, 0.5, atol=2e-4)
    larger = Envelope(centre, envelope.directions, envelope.faces, 2 * envelope.radius)
    mapping = WorkspaceMapping(envelope, larger, (1.0, 1.0), Provenance("test"))
    x = some(mapping, 50)
    np.testing.assert_allclose(mapping.map_points(x), 2 * x, rtol=1e-12)
    np.testing.assert_allclose(mapping.scale(x), 2.0, rtol=1e-12)


def test_the_two_kinds_of_envelope():
    """From inside the shell, the unbroken envelope ends at its inner wall, on the way inwards."""
    arm, centre, inwards = telescope(), [0.4, 0.0, 0.0], np.array([-1.0, 0.0, 0.0])
    outer = reach_envelope(arm, centre, subdivisions=1)
    inner = reach_envelope(arm, centre, kind="unbroken", subdivisions=1)
    assert (inner.radius <= outer.radius + 1e-3).all()
    nearest = np.argmax(outer.directions @ inwards)
    u = outer.directions[nearest]
    b = u @ centre
    assert inner.radius[nearest] == pytest.approx(-b - np.sqrt(b * b - 0.4**2 + 0.3**2), abs=2e-3)
    assert outer.radius[nearest] == pytest.approx(-b + np.sqrt(b * b - 0.4**2 + 0.5**2), abs=2e-3)


def test_images_of_the_unbroken_part_are_reached():
    arm = load_arm("upper_limb")
    splinted = arm.with_limits(BRACE)
    mapping = workspace_mapping(arm, splinted, kind="unbroken", subdivisions=3)
    assert min(mapping.fill) > 0.95
    inside = some(mapping)
    inside = inside[mapping.source.gauge(inside) < 0.9]
    there = solve_ik(Position(splinted), mapping.map_points(inside))
    assert there.solved.mean() > 0.95
    a, b = mapping.source.centre, mapping.target.centre
    np.testing.assert_allclose(a, b, atol=1e-9)  # the same person: the same place


def test_arms_with_other_axes_are_refused():
    with pytest.raises(RangeError, match="the same axes"):
        workspace_mapping(load_arm("upper_limb"), load_arm("myoarm"))


def test_fill_says_that_there_is_a_hollow():
    arm = telescope()
    mapping = workspace_mapping(arm, arm, centres=([0, 0, 0], [0, 0, 0]), subdivisions=3)
    assert mapping.fill[0] == pytest.approx(1 - 0.6**3, abs=0.02)
    assert "of which 7" in mapping.summary()


@pytest.mark.parametrize("subdivisions", [0, 1, 3])
def test_icosphere(subdivisions):
    vertices, faces = icosphere(subdivisions)
    assert len(vertices) == 10 * 4**subdivisions + 2
    assert len(faces) == 20 * 4**subdivisions
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 1.0)
    assert (np.linalg.det(vertices[faces]) > 0).all()


def test_volume_of_an_octahedron():
    directions = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array(
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    )
    assert Envelope(np.zeros(3), directions, faces, np.ones(6)).volume == pytest.approx(4 / 3)


def test_what_is_refused(mapping):
    arm = load_arm("upper_limb")
    with pytest.raises(RangeError, match="reaches nothing in the direction"):
        reach_envelope(arm, [2.0, 0.0, 0.0], subdivisions=1)
    with pytest.raises(ShapeError):
        mapping.map_points([[0.0, 1.0]])
    with pytest.raises(NotFiniteError):
        mapping.map_points([[0.0, 1.0, np.nan]])
