import io

import numpy as np
import pytest

from selfmotion.methods.passive.settings import PlanSettings
from selfmotion.report.planner_figures import (
    areas_figure,
    joint_trajectories_figure,
    net_areas_of_people_figure,
    paths_figure,
    planned_movements_figure,
    speed_figure,
)
from selfmotion.studies.center_out import CenterOut, predicted, simulate
from selfmotion.studies.tommasino2017 import compare
from selfmotion.studies.tommasino2017_numbers import figure_3_law


@pytest.fixture(scope="module")
def planned():
    return predicted(figure_3_law(), CenterOut(settings=PlanSettings(spring=22.5)))


@pytest.fixture(scope="module")
def compared():
    law = figure_3_law()
    study = simulate(law, np.random.default_rng(0), protocol=CenterOut(n_trials=3))
    return compare(study, law)


def drawn(figure) -> bytes:
    stream = io.BytesIO()
    figure.savefig(stream, format="svg")
    return stream.getvalue()


def test_planned_movements_show_paths_joints_and_speed(planned):
    figure = planned_movements_figure(planned)
    paths, joints, speed = figure.axes
    assert len(paths.lines) == 1 + 16  # the targets, then the movements
    np.testing.assert_array_equal(paths.lines[1].get_xdata(), planned.x[0, :, 0])
    assert len(joints.lines) == 3 * 8
    assert len(speed.lines) == 16
    assert b"pronation" in drawn(figure)


def test_paths_have_a_panel_a_person(compared):
    figure = paths_figure([compared, compared], ["One", "Two"])
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["One", "Two"]
    dashed = [line for line in figure.axes[0].lines if line.get_linestyle() == "--"]
    assert len(dashed) == 16
    assert b"SW" in drawn(figure)


def test_net_areas_are_those_of_the_tests(compared):
    figure = net_areas_of_people_figure([compared, compared], ["One", "Two"])
    assert len(figure.axes) == 4
    # The path of a bar is a unit square under the transform of its corners.
    bars = [bar.get_patch_transform().get_matrix()[1, 1] for bar in figure.axes[1].patches]
    np.testing.assert_allclose(bars[:8], compared.model_tests.mean[8:])
    np.testing.assert_allclose(bars[8:], compared.model_tests.against[8:])
    assert drawn(figure)


def test_joints_and_speed_by_target(compared, planned):
    titles = ["One", "Two"]
    joints = joint_trajectories_figure([compared, compared], titles, planned.joints)
    assert len(joints.axes) == 8 and all(len(ax.lines) >= 6 for ax in joints.axes)
    figure = speed_figure(compared)
    assert [ax.get_title(loc="left") for ax in figure.axes][:2] == ["E", "NE"]
    assert drawn(figure)


def test_areas_lie_beside_the_straight_line(planned):
    out, back = areas_figure(planned).axes
    # Of the way out to the north-east: along the line it goes as far as the target.
    along, left = np.asarray(out.lines[1].get_data(), dtype=float)
    assert along[-1] == pytest.approx(100.0 * np.pi / 12, abs=0.1)
    assert abs(left[-1]) < 1e-9 and np.abs(left).max() > 0.2
    # Both ways veer to the same side of the way they go.
    inbound = np.asarray(back.lines[1].get_ydata(), dtype=float)
    assert np.sign(np.median(left)) == np.sign(np.median(inbound)) != 0.0
