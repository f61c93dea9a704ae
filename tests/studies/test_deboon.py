"""The study of the three scenarios, small, against what the paper prints and says."""

import numpy as np
import pytest

from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.solid_shapes import Ellipsoid
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import reach_screen
from selfmotion.methods.workspace import WorkspaceOptions
from selfmotion.report.ik_figures import saturation_figure
from selfmotion.report.workspace_figures import (
    DEVICE_JOINTS,
    arc_joints_figure,
    arcs_figure,
    hulls_figure,
    island_figure,
    slices_figure,
)
from selfmotion.studies.deboon import RADII, StudySize, deboon_study
from selfmotion.studies.deboon_figures import counterparts


@pytest.fixture(scope="module")
def study():
    options = WorkspaceOptions(n_points=256, shifts=3, slice_points=64)
    return deboon_study(size=StudySize(options, n_samples=24, heights=(-0.2, 0.0)))


def test_printed_lengths_and_limits_are_ours(study):
    known = study.numbers[study.numbers["published"].notna()]
    np.testing.assert_allclose(known["ours"], known["published"], atol=1e-9)
    assumed = study.numbers[study.numbers["published"].isna()]
    assert len(assumed) == 3 and assumed["note"].str.contains("assumed").all()


def test_the_splint_takes_a_part_of_the_workspace(study):
    """Fig 6: the constrained workspace is a subset of the unconstrained one."""
    regions = study.workspace.regions
    assert 0.6 < regions["limited"].volume / regions["free"].volume < 0.8
    assert not (regions["limited"].inside & ~regions["free"].inside).any()
    assert "not public" in study.summary()


def test_the_splint_shortens_every_circle(study):
    for device in study.devices:
        turn = {key: sum(a.last - a.first for a in arcs) for key, arcs in device.arcs.items()}
        for radius in RADII:
            assert turn["splinted", radius] <= turn["free", radius] + 1e-9
    table = study.devices[0].to_frame()
    splinted = table[table["elbow"] == "splinted"]
    assert (splinted["elbow_from_deg"] >= 64.2 - 1e-9).all()
    assert (splinted["elbow_to_deg"] <= 114.0 + 1e-9).all()


def test_the_body_is_cut_out_by_its_share_of_the_workspace(study):
    """The part of the body within reach, counted again by points of our own drawing."""
    body, space = study.places.body, study.workspace
    box = np.array([[-0.5, -0.3, -0.7], [0.5, 0.3, 0.6]])
    points = np.random.default_rng(1).uniform(box[0], box[1], (20_000, 3))
    within = np.zeros(len(points), dtype=bool)
    for shape in body.shapes.values():
        if isinstance(shape, Ellipsoid):
            local = (points - shape.centre) @ shape.axes / shape.half
            within |= (local**2).sum(axis=1) < 1
        else:
            along = shape.end - shape.start
            at = np.clip((points - shape.start) @ along / (along @ along), 0, 1)
            nearest = shape.start + at[:, None] * along
            within |= np.linalg.norm(points - nearest, axis=1) < shape.radius
    reached = reach_screen(HandRows(space.arm, ("x", "y", "z"))).decide(points[within]).reachable
    ours = 1e6 * np.prod(box[1] - box[0]) * reached.sum() / len(points)
    free = study.places.volumes.set_index("region").loc["free"]
    assert free["inside_the_body_cm3"] == pytest.approx(ours, rel=0.15)
    whole = free["inside_the_body_cm3"] + free["without_the_body_cm3"]
    assert whole == pytest.approx(free["volume_cm3"])


def test_the_way_over_the_shoulder_is_told_apart(study):
    island, over = study.places.island, study.places.over
    for name in ("free", "limited"):
        reached = island.part.regions[name].inside
        out = ~study.places.body.inside(island.part.regions[name].points)
        np.testing.assert_array_equal(island.over[name] | island.under[name], reached & out)
    assert 0 < over.sets["limited"].volume < over.sets["free"].volume < over.space


def test_every_figure_has_its_counterpart(study):
    table = counterparts(study)
    told = " ".join(table["in the paper"])
    assert all(number in told for number in ("3", "5", "6", "7", "8", "9", "10", "11", "12", "13"))
    assert (table["difference"].str.len() > 10).all()


def test_a_way_round_is_found_from_the_ends_of_an_arc_too(study):
    """The splinted elbow on the widest circle: from the middle each way ends short of the arc."""
    arcs = study.devices[0].arcs["splinted", RADII[-1]]
    assert len(arcs) == 2
    for arc in arcs:
        assert arc.path.status.ok
        assert arc.path.time[0] == pytest.approx(arc.first, abs=0.01)
        assert arc.path.time[-1] == pytest.approx(arc.last, abs=0.01)
        hands = tip_positions(arc.path.task.arm.chain, arc.path.q, [arc.path.task.arm.tip("hand")])
        centre = np.array(study.devices[0].scenario.centre)
        away = np.linalg.norm(hands[:, 0] - centre, axis=1)
        np.testing.assert_allclose(away, RADII[-1], atol=2e-5)


def test_pictures_are_drawn(study):
    body = study.places.body
    assert len(slices_figure(study.workspace, body).axes) >= 2
    assert len(hulls_figure(study.workspace, body).axes) == 2
    assert all(len(ax.lines) == 4 for ax in island_figure(study.places.island, body).axes)
    assert len(arcs_figure(study.devices[1]).axes) == 4
    arm = study.workspace.arm
    for ax in saturation_figure(arm).axes:  # fig. 2: no curve leaves its joint's range
        for line, low, high in zip(ax.lines, arm.lower, arm.upper, strict=True):
            angles = np.deg2rad(np.asarray(line.get_ydata()))
            assert low < angles.min() < angles.max() < high
    joints = arc_joints_figure(study.devices[0]).axes
    assert len(joints) == 2 * len(DEVICE_JOINTS) and all(ax.lines for ax in joints)
