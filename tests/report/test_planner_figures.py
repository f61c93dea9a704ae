import io

import numpy as np
import pytest

from selfmotion.methods.passive.settings import PlanSettings
from selfmotion.report.planner_figures import (
    joint_trajectories_figure,
    net_area_figure,
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
    figure = net_area_figure(compared)
    # The path of a bar is a unit square under the transform of its corners.
    bars = [bar.get_patch_transform().get_matrix()[1, 1] for bar in figure.axes[1].patches]
    np.testing.assert_allclose(bars[:8], compared.model_tests.mean[8:])
    np.testing.assert_allclose(bars[8:], compared.model_tests.against[8:])
    assert drawn(figure)


def test_joints_and_speed_by_target(compared, planned):
    assert len(joint_trajectories_figure(compared, planned.joints).axes) == 4
    figure = speed_figure(compared)
    assert [ax.get_title(loc="left") for ax in figure.axes][:2] == ["E", "NE"]
    assert drawn(figure)
