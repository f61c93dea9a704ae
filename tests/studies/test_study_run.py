"""A whole study of generated marker files: from a folder to tables, statistics and resume."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from selfmotion.batch import Runner
from selfmotion.capture.simulated_markers import MarkerFaults, simulate_markers
from selfmotion.errors import FileFormatError, SelfmotionError
from selfmotion.motion.markers import MarkerSet
from selfmotion.studies.study_file import find_trials, load_study_file
from selfmotion.studies.study_run import StudyPlan, run_study
from selfmotion.studies.study_statistics import comparisons

STUDY = r"""
pattern = '(?P<subject>P\d+)_(?P<condition>[a-z]+)_(?P<side>[RL])(?P<trial>\d+)\.csv'
static = "{subject}_static.csv"
frame = {up = "z", forward = "y"}
landmark = "wrist"
cutoff = 8

[names.side]
R = "right"
L = "left"

[moments.drink]
strokes = 2
mid_drink = {between = [1, 2], at = "slowest"}
"""


def write_vicon(path: Path, markers: MarkerSet) -> None:
    """Write markers as Vicon Nexus does."""
    lines = ["Trajectories", "100", ",," + ",,,".join(f"X:{n}" for n in markers.names)]
    lines += [
        "Frame,Sub Frame" + ",X,Y,Z" * markers.n_markers,
        ",," + "mm," * 3 * markers.n_markers,
    ]
    for k, row in enumerate(1e3 * markers.positions.reshape(markers.n_samples, -1)):
        cells = ["" if np.isnan(v) else f"{v:.4f}" for v in row]
        lines.append(f"{k + 1},0," + ",".join(cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8-sig")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    where = tmp_path_factory.mktemp("study")
    for number in (1, 2):
        rng = np.random.default_rng(number)
        faults = MarkerFaults(noise=2e-4, skin=2e-3, gaps=1)
        capture = simulate_markers(faults=faults, rng=rng, repeats=2)
        write_vicon(where / f"P{number}_static.csv", capture.static)
        for markers in capture.movements:
            name = f"P{number}_{markers.labels.condition}_R{markers.labels.trial}.csv"
            write_vicon(where / name, markers)
    (where / "P2_comb_R3.csv").write_text("Trajectories\n100\nbroken")
    (where / "study.toml").write_text(STUDY)
    return where


def plan(folder: Path, out: Path) -> StudyPlan:
    study = load_study_file(folder / "study.toml")
    return StudyPlan((folder,), study, "upper_limb_anatomical", out=out)


def test_a_study_runs_to_its_tables_and_resumes(folder, tmp_path):
    seen = []
    run = run_study(plan(folder, tmp_path), on_start=lambda n: (seen.append(n), seen.append)[1])
    assert seen[0] == 21 and len(seen) == 22
    assert run.n_failed == 1
    broken = run.trials.set_index("file").loc["P2_comb_R3.csv"].to_dict()
    assert "row" in str(broken["status"])
    good = run.trials[run.trials["ok"]]
    assert max(good["rms_landmark_mm"].tolist()) < 15
    assert not any(good["frames_not_converged"].tolist())
    assert set(run.weights["joint"]) == set(run.movements.joints)
    assert len(run.estimates) == 10 and {k[:2] for k in run.pooled} == {
        ("P1", "right"),
        ("P2", "right"),
    }
    drinks = run.summary.swivel.set_index(["condition", "moment", "selection"])
    assert drinks.loc[("drink", "mid_drink", "all"), "movements"] == 4
    curve = run.swivel.loc[run.swivel["file"] == "P1_drink_R1.csv"]
    drink = good.set_index("file").loc["P1_drink_R1.csv"]
    assert curve["percent"].tolist() == list(range(101))
    assert curve["swivel_deg"].iloc[0] == pytest.approx(drink["swivel_start_deg"])
    assert np.isfinite(run.groups["task_share_others"].to_numpy(float)).any()
    assert len(run.groups) == 10 and run.groups["task_share"].between(0, 1).all()
    assert run.tests["sentence"].str.contains("no test").all()  # two people are too few

    journal = (tmp_path / "journal.jsonl").read_text()
    (tmp_path / "journal.jsonl").write_text(journal[: int(0.6 * len(journal))])  # interrupted
    again = run_study(plan(folder, tmp_path), Runner(resume=True))
    assert again.weights.equals(run.weights)
    lines = [line for line in (tmp_path / "journal.jsonl").read_text().splitlines() if line]
    assert sum(json.loads(line)["ok"] for line in lines if line.endswith("}")) >= 20


def test_trials_carry_their_labels_and_static(folder):
    trials = find_trials(load_study_file(folder / "study.toml"), (folder,))
    assert trials[0].labels.to_dict() == {
        "subject": "P1",
        "side": "right",
        "condition": "comb",
        "target": None,
        "trial": "1",
    }
    assert trials[0].static == folder / "P1_static.csv"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("(?P<subject>", "(?P<person>"),
        ("(?P<subject>", "("),
        ("pattern", "patern"),
        ("cutoff = 8", "cutoff = true"),
        ('up = "z"', 'up = "up"'),
        ('up = "z"', 'north = "z"'),
        ('R = "right"', "R = 1"),
        ("landmark", "rest_share = 2\nlandmark"),
        ("[names.side]", "[names.arm]"),
        ("strokes = 2", "strokes = 1"),
        ("cutoff = 8", "cutoff = 8\ncentres = 'middle'"),
        ("between = [1, 2]", "between = [2, 1]"),
        ("[moments.drink]", "[moment.drink]"),
    ],
)
def test_broken_study_files_are_refused_in_one_line(tmp_path, old, new):
    where = tmp_path / "study.toml"
    where.write_text(STUDY.replace(old, new, 1))
    with pytest.raises(SelfmotionError) as refused:
        load_study_file(where)
    assert "\n" not in str(refused.value)


def test_a_folder_without_recordings_is_refused(tmp_path, folder):
    with pytest.raises(FileFormatError, match="no file is named"):
        find_trials(load_study_file(folder / "study.toml"), (tmp_path,))


def test_sides_and_conditions_are_compared_within_people():
    keys = [("P1", s, c) for s in ("right", "left") for c in ("reach", "drink")]
    assert [c.name for c in comparisons(keys)] == [
        "reach: right against left",
        "drink: right against left",
        "right: reach against drink",
        "left: reach against drink",
    ]


def test_one_bad_movement_does_not_cost_a_person_the_others(tmp_path):
    capture = simulate_markers(rng=np.random.default_rng(5))
    first, second, third = capture.movements[:3]
    write_vicon(tmp_path / "P1_static.csv", capture.static)
    scaled = replace(first, positions=1e3 * first.positions)
    flipped = {"RUAR1": "RUAR3", "RUAR3": "RUAR1"}  # a plate that is turned over fits its shape
    names = tuple(flipped.get(name, name) for name in third.names)
    write_vicon(tmp_path / "P1_huge_R1.csv", scaled)
    write_vicon(tmp_path / "P1_lost_R1.csv", first.select([n for n in first.names if n != "RUAR1"]))
    write_vicon(tmp_path / "P1_flip_R1.csv", replace(third, names=names))
    for markers in (second, *capture.movements[3:]):
        write_vicon(tmp_path / f"P1_{markers.labels.condition}_R1.csv", markers)
    (tmp_path / "study.toml").write_text(STUDY)
    run = run_study(plan(tmp_path, tmp_path / "out"))
    states = run.trials.set_index("file")["status"].to_dict()
    assert "off their shape" in states.pop("P1_huge_R1.csv")
    assert "RUAR1" in states.pop("P1_lost_R1.csv")
    assert "misses the landmarks" in states.pop("P1_flip_R1.csv")
    assert set(states.values()) == {"done"} and len(states) == 3
