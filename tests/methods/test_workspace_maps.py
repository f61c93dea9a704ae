"""Maps over a workspace: brute force on a planar arm, independent readers, refusals."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from selfmotion.arms import load_arm, planar
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.limit_margin import limit_margin, narrowed
from selfmotion.methods.reaching.map_files import write_ply, write_vtk
from selfmotion.methods.reaching.map_result import Grid
from selfmotion.methods.workspace_maps import Mapper, manipulability_of, workspace_maps
from selfmotion.muscles.static_optimization import muscle_effort

LENGTHS = (0.3, 0.25, 0.1)
LIMITS = {"shoulder": (-1.0, 2.0), "elbow": (0.1, 2.6), "wrist": (-1.2, 0.9)}


def three_links():
    arm = planar(LENGTHS)
    return arm.with_limits(dict(zip(arm.joints, LIMITS.values(), strict=True)))


def all_postures(x: float, y: float) -> np.ndarray:
    """Every posture of the three links at a point: the hand's direction, elbow left and right."""
    a, b, c = LENGTHS
    phi = np.linspace(-np.pi, np.pi, 40001)
    wx, wy = x - c * np.cos(phi), y - c * np.sin(phi)
    cosine = (wx**2 + wy**2 - a * a - b * b) / (2 * a * b)
    fits = np.abs(cosine) <= 1
    postures = []
    for sign in (1, -1):
        q2 = sign * np.arccos(cosine[fits])
        q1 = np.arctan2(wy, wx)[fits] - np.arctan2(b * np.sin(q2), a + b * np.cos(q2))
        q = np.stack([q1, q2, phi[fits] - q1 - q2], axis=1)
        postures.append((q + np.pi) % (2 * np.pi) - np.pi)
    return np.concatenate(postures)


@pytest.mark.parametrize("point", [(0.4, 0.2), (0.1, 0.35), (0.5, -0.1), (0.3, 0.45)])
def test_margin_and_manipulability_are_the_best_of_all_postures(point):
    arm = three_links()
    reached, q, values = Mapper.of(arm, ["margin", "manipulability"]).at([[*point, 0.0]])
    every = all_postures(*point)
    room = limit_margin(arm, every)
    assert reached[0]
    assert values["margin"][0] <= room.max() + 1e-4
    assert values["margin"][0] >= room.max() - 1 / 64
    assert limit_margin(arm, q)[0] == pytest.approx(values["margin"][0])
    best = manipulability_of(arm)(every[room >= 0]).max()
    assert values["manipulability"][0] == pytest.approx(best, rel=2e-3)


def test_margin_by_hand():
    arm = three_links()
    assert limit_margin(arm, arm.middle())[0] == pytest.approx(1.0)
    assert limit_margin(arm, arm.lower)[0] == pytest.approx(0.0)
    q = arm.middle() + [0.75, 0.0, 0.0]  # the shoulder's half range is 1.5
    assert limit_margin(arm, q)[0] == pytest.approx(0.5)
    inner = narrowed(arm, 0.5)
    assert limit_margin(arm, inner.lower)[0] == pytest.approx(0.5)


def test_maps_of_the_arm_stay_on_the_points():
    arm = load_arm("upper_limb")
    found = workspace_maps(arm, ["manipulability", "margin"], spacing=0.25)
    rows = found.reached
    hand = forward_kinematics(arm.chain, found.q[rows], arm.tip("hand"))[:, :3, 3]
    np.testing.assert_allclose(hand, found.grid.points[rows], atol=1.1e-5)
    margin = found.values["margin"]
    np.testing.assert_allclose(limit_margin(arm, found.q[rows]), margin[rows], atol=1e-12)
    assert np.isnan(margin[~rows]).all() and (margin[rows] >= 0).all()
    # The largest manipulability is no less than that of the posture known.
    known = manipulability_of(arm)(found.q[rows])
    assert (found.values["manipulability"][rows] >= known - 1e-12).all()
    solved = solve_ik(HandRows(arm, ("x", "y", "z")), found.grid.points).solved
    assert (solved == rows).mean() > 0.995
    assert list(found.to_frame().columns[:5]) == ["x", "y", "z", "margin", "manipulability"]
    data = found.to_xarray()
    k = int(np.flatnonzero(rows)[3])
    x, y, z = found.grid.points[k]
    assert float(data["margin"].sel(x=x, y=y, z=z, method="nearest")) == margin[k]
    assert "grid points are reached" in found.summary()


def test_a_body_takes_points_away():
    arm = load_arm("upper_limb")
    whole = workspace_maps(arm, ["margin"], spacing=0.4)
    cut = workspace_maps(arm, ["margin"], spacing=0.4, blocked=lambda x: x[:, 2] > 0)
    assert not cut.reached[cut.grid.points[:, 2] > 0].any()
    below = whole.grid.points[:, 2] <= 0
    np.testing.assert_array_equal(cut.reached[below], whole.reached[below])


def test_least_effort_is_below_that_of_other_postures():
    model = load_musculoskeletal_arm()
    arm = model.arm
    q = [[0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1]]
    point = forward_kinematics(arm.chain, q, arm.tip("hand"))[:, :3, 3]
    task = HandRows(arm, ("x", "y", "z"))
    reached, _, values = Mapper.of(model, ["effort"]).at(point)
    assert reached[0]
    starts = arm.random_postures(60, np.random.default_rng(3))
    found = solve_ik(task, np.repeat(point, 60, axis=0), start=starts)
    others = muscle_effort(model, found.q[found.solved])
    held = np.array([s.ok for s in others.status])
    assert 0 < values["effort"][0] <= others.effort[held].min()


@pytest.fixture(scope="module")
def maps():
    return workspace_maps(load_arm("upper_limb"), ["margin", "manipulability"], spacing=0.3)


def test_vtk_is_read_by_another_program(tmp_path: Path, maps):
    mesh = meshio.read(write_vtk(tmp_path / "maps.vtk", maps))
    np.testing.assert_allclose(mesh.points, maps.grid.points, atol=1e-12)
    np.testing.assert_array_equal(np.ravel(mesh.point_data["reached"]), maps.reached)
    for name, value in maps.values.items():
        np.testing.assert_array_equal(np.ravel(mesh.point_data[name]), value)


def test_ply_is_read_by_another_program(tmp_path: Path, maps):
    mesh = meshio.read(write_ply(tmp_path / "maps.ply", maps))
    np.testing.assert_array_equal(mesh.points, maps.grid.points[maps.reached])
    for name, value in maps.values.items():
        np.testing.assert_array_equal(mesh.point_data[name], value[maps.reached])


def test_grid_runs_x_first():
    grid = Grid.around(np.array([-0.1, 0.0, 0.0]), np.array([0.1, 0.0, 0.1]), 0.1)
    assert grid.shape == (3, 1, 2)
    np.testing.assert_allclose(grid.points[:3, 0], [-0.1, 0.0, 0.1])
    np.testing.assert_allclose(grid.points[3], [-0.1, 0.0, 0.1])
    assert grid.volume(np.arange(6))[2, 0, 1] == 5


@pytest.mark.parametrize(
    ("maps", "spacing", "error", "reason"),
    [
        (["comfort"], 0.3, UnknownNameError, "unknown map 'comfort'"),
        ([], 0.3, RangeError, "no map is named"),
        (["effort"], 0.3, RangeError, "upper_limb has no muscles"),
        (["margin"], 0.0, RangeError, "spacing = 0: allowed is"),
        (["margin"], 1e-3, RangeError, "allowed are 2000000 at most"),
    ],
)
def test_what_is_refused(maps, spacing, error, reason):
    with pytest.raises(error, match=reason):
        workspace_maps(load_arm("upper_limb"), maps, spacing=spacing)
