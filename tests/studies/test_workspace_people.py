"""Measured hands in predicted workspaces: a generated person, causes by hand, real people."""

from pathlib import Path

import numpy as np
import pytest
from tests.studies.test_study_run import write_vicon

from selfmotion.arms import load_arm
from selfmotion.capture.simulated_markers import simulate_markers
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.workspace import WorkspaceOptions
from selfmotion.report.workspace_people_figures import people_figure
from selfmotion.studies.people import load_people
from selfmotion.studies.study_file import load_study_file
from selfmotion.studies.workspace_people import (
    arm_length,
    explain,
    people_frame,
    totals_frame,
    workspace_people,
)

ROOT = Path(__file__).parents[2]
DATA = ROOT.joinpath("..", "shared", "data", "ue_adl").resolve()
FEW = WorkspaceOptions(n_points=128, shifts=2)
STUDY = r"""
pattern = '(?P<subject>P\d+)_(?P<condition>[a-z]+)_(?P<side>[RL])(?P<trial>\d+)\.csv'
static = "{subject}_static.csv"
frame = {up = "z", forward = "y"}
cutoff = 12
[names.side]
R = "right"
"""


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    where = tmp_path_factory.mktemp("people")
    capture = simulate_markers(rng=np.random.default_rng(4))
    write_vicon(where / "P1_static.csv", capture.static)
    for markers in capture.movements:
        write_vicon(where / f"P1_{markers.labels.condition}_R1.csv", markers)
    (where / "study.toml").write_text(STUDY)
    people = load_people([where], load_study_file(where / "study.toml"))
    return workspace_people(people, options=FEW)


def test_a_generated_person_stays_inside(generated):
    """The markers come from an arm within its limits."""
    table = people_frame(generated)
    assert len(table) == 5 and min(table["places"].to_list()) > 10
    assert max(table["beyond_5_mm"].to_list()) == 0
    assert min(table["depth_mm"].to_list()) > 0
    totals = totals_frame(table)
    assert totals["condition"].tolist()[-1] == "all"
    assert totals["places"].iloc[-1] == table["places"].sum()
    assert totals["most_mm"].iloc[-1] == table["most_mm"].max()


def test_pictures_are_drawn(generated):
    assert len(people_figure(generated).axes) == 3


def test_causes():
    """A hand beyond the stretched arm; one that only more elbow flexion would let in."""
    arm = load_arm("upper_limb_anatomical")
    q = arm.middle()
    elbow = arm.joints.index("elbow_flexion")
    tight = arm.with_limits({"elbow_flexion": (float(arm.lower[elbow]), 1.2)})
    q[elbow] = 1.2 + np.deg2rad(18)
    wrist = {name: (0.0, 0.0) for name in arm.joints if name.startswith("wrist")}
    tight = tight.with_limits(wrist)
    q[[arm.joints.index(name) for name in wrist]] = 0.0
    T = {k: forward_kinematics(arm.chain, q, arm.tip(k))[0, :3, 3] for k in ("shoulder", "hand")}
    far = T["shoulder"] + [0.0, arm_length(arm) + 0.01, 0.0]
    hand = np.stack([far, T["hand"]])
    found = explain(tight, hand, np.stack([T["shoulder"], T["shoulder"]]))
    assert found["stretch"] == 1
    assert sum(found.values()) == 2
    assert set(found) <= {"stretch", "girdle", "elbow_flexion"}
    assert explain(arm, np.zeros((0, 3)), np.zeros((0, 3))) == {}


@pytest.mark.long
@pytest.mark.skipif(not DATA.is_dir(), reason="the UE_ADL recordings are not at hand")
def test_hands_of_real_people_lie_inside():
    """docs/workspace_people.md."""
    study = load_study_file(ROOT / "docs" / "donders_study.toml")
    people = workspace_people(load_people([DATA], study), options=FEW)
    totals = totals_frame(people_frame(people)).iloc[-1]
    assert totals["places"] > 10_000
    assert totals["beyond_5_mm"] == 0
    assert totals["outside_percent"] < 1.0
    assert totals["in_body_percent"] < 5.0
