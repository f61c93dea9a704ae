import numpy as np
import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import RangeError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.redundancy.manifold import self_motion_manifold
from selfmotion.report.html import write_page
from selfmotion.report.li2022_figures import shoulder_figure, swivel_figure
from selfmotion.report.li2022_page import PRINTED, li2022_page
from selfmotion.report.posture_figures import coordinates_figure, effort_figure, muscles_figure
from selfmotion.studies.li2022 import (
    Size,
    reproduce,
    shoulder_displacement,
    swivel_disagreement,
)
from selfmotion.studies.li2022_poses import cup_pose


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
    assert (found.hybrid[["refined_m", "refined_rad"]] < 1e-9).all(axis=None)
    assert list(found.timing["published"]) == ["1.7 ± 0.2 ms", "794 ± 89 s", "–"]
    assert list(found.table_iv["study"])[0] == "This work"
    assert found.example.status


def test_pictures_of_a_posture_are_drawn(model, found):
    effort = effort_figure(found.curves, found.example)
    assert effort.axes[0].get_xlabel() == "swivel angle (deg)"
    coordinates = coordinates_figure(found.curves, found.example)
    assert len(coordinates.axes[0].lines) >= 7
    muscles = muscles_figure(model, found.example.q, found.example.activations)
    assert len(muscles.axes[0].collections[0].get_paths()) == 63
    for figure in (effort, coordinates, muscles):
        figure.canvas.draw()  # pyright: ignore[reportAttributeAccessIssue]
    # A metre is as long in both views, across and up.
    corners = [ax.transData.transform([(0.0, 0.0), (1.0, 1.0)]) for ax in muscles.axes[:2]]
    metre = np.diff(corners, axis=1).ravel()
    assert metre == pytest.approx(metre[0])


def test_a_page_holds_every_figure_beside_its_published_number(model, found, tmp_path):
    page = li2022_page(model, found, found.table, found.provenance)
    for section in page.sections:
        for part in (*section.pictures, *section.tables):
            assert part.caption.endswith(".")
        for picture in section.pictures:
            drawn = [ax for ax in picture.figure.axes if ax.get_visible()]
            assert all(ax.has_data() for ax in drawn)
    text = write_page(tmp_path / "r.html", page).read_text(encoding="utf-8")
    for words in ("As Fig 3", "As Fig 4", "As Fig 5", "As Fig 6", "Times of section IV-B"):
        assert words in text
    for printed in ("-6.8, 5.7, 5.7", "2.16 ± 1.02", "1.7 ± 0.2 ms", "794 ± 89 s", "3.73 ± 3.27"):
        assert printed in text
    assert text.count("<svg") == 7


def curves_of(ax):
    """Give the label, marker and heights of each line that is drawn."""
    drawn = [(line.get_label(), line.get_marker(), line.get_ydata()) for line in ax.lines]
    made = [(label, mark, np.asarray(y, dtype=float)) for label, mark, y in drawn]
    return [curve for curve in made if len(curve[2])]


def test_figures_3_and_4_hold_the_curves_and_what_is_printed(found):
    ax = shoulder_figure(found.shoulder, PRINTED["fig3"]).axes[1]
    up = next(y for label, _, y in curves_of(ax) if label == "up")
    assert up == pytest.approx(100.0 * found.shoulder["up"].to_numpy(dtype=float))
    printed = [y[0] for _, mark, y in curves_of(ax) if mark == "D"]
    assert printed == list(PRINTED["fig3"])
    assert ax.get_ylabel() == "displacement (cm)"
    left, right = swivel_figure(found.swivel, PRINTED["fig4"]).axes
    fixed, moving = (y for _, _, y in curves_of(left))
    difference = next(y for _, _, y in curves_of(right) if len(y) == len(fixed))
    assert difference == pytest.approx(np.abs(fixed - moving))
    assert [ax.get_xlabel() for ax in (left, right)] == ["shoulder elevation (deg)"] * 2


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
