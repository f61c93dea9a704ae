"""A study of people whose observations are planted: a folder, and the journal of a run."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.methods.predictors.catalogue import CRITERIA, EFFORT, START
from selfmotion.studies.prediction import JOURNAL, PredictionPlan, plan_items
from selfmotion.studies.study_file import load_study_file

STUDY = r"""
pattern = '(?P<subject>[PQ]\d)_(?P<condition>[a-z]+)_(?P<trial>\d)\.csv'
static = "{subject}_static.csv"
[moments.reach]
end_of_reach = {at = "farthest"}
[moments.drink]
mid_drink = {at = "farthest"}
"""
BIAS, EFFORT_ERROR = 0.2, 0.5
REPEATS = 3


def record(person: int, task: str, trial: int, rng: np.random.Generator) -> dict[str, Any]:
    """Plant a person: natural = nearest to start + BIAS; effort misses by EFFORT_ERROR."""
    natural = 0.3 + 0.1 * person + (0.4 if task == "drink" else 0.0) + 0.01 * trial
    said = {p.name: float(rng.normal(0.5, 0.3)) for p in CRITERIA}
    said |= {START: natural - BIAS, EFFORT: natural + EFFORT_ERROR}
    return {
        "variant": "as recorded",
        "subject": f"P{person}",
        "side": "right",
        "task": task,
        "moment": "end_of_reach" if task == "reach" else "mid_drink",
        "trial": str(trial),
        "natural": natural,
        "start": 0.1,
        "wrist": [0.1, 0.5, 0.1 * person],
        "hand": np.eye(3).tolist(),
        "criteria": {name: [angle, True, "found"] for name, angle in said.items()},
        "wrist_m": [0.05, 0.3, 0.05 * person],
        "elbow_radius_m": 0.1 if trial else 0.01,
        "natural_inside": True,
        "intervals": [[-1.0, 2.0]],
        "fit_error_m": 0.002,
        "coordinate_error": [0.1] * 7,
        "effort_ratio": 1.5,
    }


def planted(folder: Path, n_people: int = 4) -> Path:
    """Write a study and the journal of its run into folder/out; give the study file.

    The first repeat of every movement has its elbow on the line from shoulder to wrist.
    """
    rng = np.random.default_rng(3)
    study = folder / "study.toml"
    study.write_text(STUDY)
    for p in range(1, n_people + 1):
        for task in ("reach", "drink"):
            for trial in range(REPEATS):
                (folder / f"P{p}_{task}_{trial}.csv").write_text(f"{p} {task} {trial}")
    plan = PredictionPlan((folder,), load_study_file(study))
    lines = []
    for item in plan_items(plan):
        p = int(item.key[1])
        records = [
            record(p, task, trial, rng) for task in ("reach", "drink") for trial in range(REPEATS)
        ]
        fit = {
            "variant": "as recorded",
            "subject": f"P{p}",
            "side": "right",
            "upper_arm_m": 0.3,
            "forearm_m": 0.25,
            "fit_error_m": 0.002,
            "deviation_offset_rad": 0.0,
            "flexion_offset_rad": 0.0,
            "postures_inside": 1.0,
        }
        entry = {
            "key": item.key,
            "fingerprint": item.fingerprint,
            "ok": True,
            "status": "done",
            "result": {"observations": records, "failed": [], "fits": [fit]},
        }
        lines.append(json.dumps(entry))
    (folder / "out").mkdir()
    (folder / "out" / JOURNAL).write_text("\n".join(lines) + "\n")
    return study
