import numpy as np
import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import RangeError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.redundancy.manifold import self_motion_manifold
from selfmotion.report.posture_figures import coordinates_figure, effort_figure, muscles_figure
from selfmotion.studies.li2022 import (
    Size,
    cup_pose,
    reproduce,
    shoulder_displacement,
    swivel_disagreement,
)


@pytest.fixture(scope="module")
def model():
    return load_musculoskeletal_arm()


@pytest.fixture(scope="module")
def found(model):
    return reproduce(model, size=Size(spacing=0.15, most=4, published=0))


def test_a_cup_is_held_upright(model):
    arm = model.arm
    T = cup_pose(arm, np.array([0.1, 0.2, 0.3]), across=0.0)
    assert T[:3, :3].T @ T[:3, :3] == pytest.approx(np.eye(3))
    assert T[:3, 0] == pytest.approx(arm.up)
    assert -T[:3, 1] == pytest.approx(arm.forward)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)


def test_the_shoulder_centre_moves_back_up_and_inwards(model):
    moved = shoulder_displacement(model.arm)
    first, last = moved.iloc[0], moved.iloc[-1]
    assert [first["forward"], first["up"], first["right"]] == pytest.approx([0, 0, 0])
    # [Li2022] Fig 3 (B): some centimetres in each direction at 180 degrees.
    assert last["forward"] < -0.03 and last["up"] > 0.03 and last["right"] < -0.03
    assert last["elevation_deg"] == pytest.approx(180.0, abs=0.1)


def test_swivel_angles_with_fixed_and_moving_centre_differ_by_the_elbows_arc(model):
    arm = model.arm
    q = [1.2, 0.8, -0.2, 1.6, 0.2, 0.05, 0.1]
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))[0]
    table = swivel_disagreement(self_motion_manifold(arm, T))
    off = np.deg2rad(np.abs(table["difference_deg"].to_numpy()))
    assert 0 < off.max() < np.deg2rad(10)
    # eq. 12: an arc of at most the upper arm's length
    assert (table["elbow_m"].to_numpy() <= off * 0.32).all()


def test_every_published_number_is_listed(found):
    table = found.table.set_index("where")
    assert len(table) == 8
    assert table.loc["Table IV", "kind"] == "not computed"  # needs recorded people
    assert len(found.postures) <= 4 and (found.postures["range_deg"] > 40).all()
    assert (found.hybrid["start_m"] < 0.05).all()
    assert list(found.table_iv["study"])[0] == "This work"
    assert found.example.status


def test_pictures_of_a_posture_are_drawn(model, found):
    effort = effort_figure(found.curves, found.example)
    assert effort.axes[0].get_xlabel() == "swivel angle (deg)"
    coordinates = coordinates_figure(found.curves, found.example)
    assert len(coordinates.axes[0].lines) >= 7
    muscles = muscles_figure(model, found.example.q, found.example.activations)
    assert len(muscles.axes[0].collections[0].get_paths()) == 63
    # A metre is as long in both views.
    spans = [np.ptp(limits) for ax in muscles.axes[:2] for limits in (ax.get_xlim(), ax.get_ylim())]
    assert np.allclose(spans, spans[0])
    for figure in (effort, coordinates, muscles):
        figure.canvas.draw()  # pyright: ignore[reportAttributeAccessIssue]


def test_a_grid_without_any_pose_is_refused(model):
    with pytest.raises(RangeError, match="no pose of the grid"):
        reproduce(model, size=Size(spacing=0.6))


def test_paths_begin_and_end_as_long_as_the_muscles_are(model):
    q = np.zeros(7)
    paths = model.geometry.paths(q)
    lengths = model.geometry.lengths(q[None])[0]
    biceps = model.muscles.index("BIClong")
    chord = np.linalg.norm(np.diff(paths[biceps], axis=0), axis=1).sum()
    # Straight lines cut the corners of what the path wraps.
    assert 0.9 * lengths[biceps] < chord <= lengths[biceps] + 1e-9


def test_the_finder_draws_from_the_curves_it_samples(model):
    finder = PostureFinder.of(model)
    q = [1.2, 0.8, -0.2, 1.6, 0.2, 0.05, 0.1]
    T = forward_kinematics(model.arm.chain, q, model.arm.tip("hand"))[0]
    curves = finder.curves(finder.manifolds.find(T))
    assert min(c.effort.min() for c in curves) == pytest.approx(finder.find(T).effort)
