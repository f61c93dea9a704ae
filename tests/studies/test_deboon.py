"""The study of the three scenarios, small, against what the paper prints and says."""

import numpy as np
import pytest

from selfmotion.methods.workspace import WorkspaceOptions
from selfmotion.report.workspace_figures import (
    DEVICE_JOINTS,
    arc_joints_figure,
    arcs_figure,
    slices_figure,
)
from selfmotion.studies.deboon import RADII, StudySize, deboon_study


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


def test_pictures_are_drawn(study):
    assert len(slices_figure(study.workspace).axes) >= 2
    assert len(arcs_figure(study.devices[1]).axes) == 4
    joints = arc_joints_figure(study.devices[0]).axes
    assert len(joints) == 2 * len(DEVICE_JOINTS) and all(ax.lines for ax in joints)
