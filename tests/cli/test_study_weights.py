"""`selfmotion weights DIR --study FILE.toml`, on files of joint angles."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import upper_limb_anatomical
from selfmotion.motion.files.angles_csv import write_angles_csv
from selfmotion.motion.recording import Recording
from tests.cli.running import Capture, answered, refused

STUDY = r"""
pattern = '(?P<subject>P\d)_(?P<condition>[a-z]+)_(?P<trial>\d)\.csv'
cutoff = 0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    arm = upper_limb_anatomical()
    rng = np.random.default_rng(1)
    t = np.arange(60) / 50
    for subject in ("P1", "P2"):
        for trial in range(3):
            phase, size = rng.uniform(0, 6, 9), rng.uniform(0.1, 0.3, 9)
            q = arm.middle() + size * (arm.upper - arm.lower) * np.sin(3 * t[:, None] + phase)
            where = tmp_path / f"{subject}_reach_{trial}.csv"
            write_angles_csv(where, [Recording(t, q=q, joints=arm.joints)])
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


def test_a_study_of_angles_gives_tables_and_a_report(folder: Path, capsys: Capture):
    (folder / "P2_reach_9.csv").write_text("time,elbow\n0,1\n")
    out, report = folder / "out", folder / "report.html"
    words = ("weights", folder, "--arm", "upper_limb_anatomical", "--study", folder / "study.toml")
    document = answered(capsys, *words, "--out", out, "--report", report, code=1)
    assert document["schema"] == "selfmotion/weights-study/1" and document["n_files"] == 7
    assert [bad["file"] for bad in document["failed"]] == ["P2_reach_9.csv"]
    assert len(document["weights"]) == 18 and len(document["groups"]) == 2
    for table in ("trials", "groups", "weights", "tests", "changes"):
        assert (out / f"{table}.csv").is_file()
    assert {path.stem for path in (out / "figures").iterdir()} >= {"shares", "angles"}
    assert document["swivel"] == []  # no markers, no landmarks
    assert {row["what"] for row in document["people"]} >= {"task_share", "synergy"}
    assert "P2_reach_9.csv" in report.read_text(encoding="utf-8")


def test_refusals(folder: Path, capsys: Capture):
    study = folder / "study.toml"
    assert "--arm" in refused(capsys, "weights", folder, "--study", study)
    words = ("weights", folder, "--arm", "srs7", "--study")
    assert "cannot be opened" in refused(capsys, *words, folder / "no.toml")
    assert "--out" in refused(capsys, *words, study, "--resume")
    line = refused(capsys, *words, study, "--out", folder / "out", "--report", folder)
    assert "a folder stands" in line and not (folder / "out").exists()  # said before the work
