"""Donders' law on people: a generated person whose law is known, and real ones where at hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import Status
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import body_frames
from selfmotion.methods.donders import JointElasticity
from selfmotion.methods.elasticity.posture import donders_postures
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.redundancy.task import Position
from selfmotion.studies.donders_paths import PLAIN_JERK
from selfmotion.studies.donders_people import donders_people, rms_by_person
from selfmotion.studies.donders_postures import LAW_JOINTS, PersonPostures, law_arm
from selfmotion.studies.donders_predictions import (
    LAW,
    MEAN,
    REPEAT,
    REPEATS,
    SURFACE,
    TASK,
    fold_laws,
    folds,
    prediction_table,
    swivel_of_law,
)
from selfmotion.studies.donders_surfaces import surface_table
from selfmotion.studies.people_means import by_person, interval, rows_of
from selfmotion.studies.reach_measures import bow, by_length
from selfmotion.studies.study_file import StudyFile, load_study_file

DATA = Path(__file__).parents[3].joinpath("shared", "data", "ue_adl")
CALM = np.radians([0, 0, 40, 20, 10, 80, 0, 0, 0])


def upper_arm(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Give the upper arm's orientations (K, 3, 3) in the thorax."""
    return body_frames(arm.chain, q)[:, arm.chain.names.index("shoulder_rotation"), :3, :3]


def generated() -> tuple[PersonPostures, JointLaw]:
    """Somebody who takes the posture of least elastic energy, in two tasks of three repeats."""
    whole = load_arm("upper_limb_anatomical")
    arm = law_arm(whole, CALM[None])
    calm = CALM[[whole.joints.index(j) for j in LAW_JOINTS]]
    law = JointLaw(np.diag([1.4, 1.0, 0.6, 1.0]), calm + np.radians([5.0, 8.0, -5.0, 0.0]))
    task = Position(arm, "wrist")
    rng = np.random.default_rng(5)
    middle = task.value(calm)[0]
    ways = {"reach": [0.08, 0.08, 0.08], "drink": [-0.12, 0.0, 0.12]}
    places, labels = [], []
    for condition, way in ways.items():
        for trial in ("1", "2", "3"):
            bent = rng.normal(0.0, 0.02, 3)
            for phase, u in enumerate(np.linspace(0.0, 1.0, 12)):
                places.append(middle + u * np.array(way) + np.sin(np.pi * u) * bent)
                labels.append((condition, trial, phase))
    found = donders_postures(task, law, np.array(places))
    assert found.least.all()
    q = found.q + rng.normal(0.0, np.radians(0.2), found.q.shape)
    condition, trial, phase = (np.array(column) for column in zip(*labels, strict=True))
    frames = np.tile(np.eye(3), (len(q), 1, 1))
    axes = {name: np.array([0.0, 0.0, 1.0]) for name in ("shoulder", "forearm", "wrist")}
    rotations = {**dict.fromkeys(axes, frames), "shoulder": upper_arm(arm, q)}
    axes["shoulder"] = arm.chain.axes[arm.chain.names.index("shoulder_rotation")]
    none = np.full(len(q), "")
    return PersonPostures(
        "P1", "right", arm, q, rotations, axes, condition, trial, phase, none
    ), law


def errors(table: pd.DataFrame) -> dict[tuple[str, str], float]:
    """Give the errors on the path (deg) by what was left out and predictor."""
    rows = rows_of(rms_by_person(table), {"place": "path"}).to_dict("records")
    return {(row["left_out"], row["predictor"]): row["rms_deg"] for row in rows}


@pytest.fixture(scope="module")
def person() -> tuple[PersonPostures, JointLaw]:
    return generated()


@pytest.fixture(scope="module")
def laws(person) -> dict[tuple[str, str], JointElasticity]:
    return fold_laws(person[0])


def test_the_law_of_a_person_who_has_one_predicts_what_was_left_out(person, laws):
    postures, law = person
    assert [key[0] for key in laws] == [REPEAT] * 3 + [TASK] * 2
    assert all(fit.status.ok for fit in laws.values())
    table = prediction_table(postures, laws)
    rms = errors(table)
    assert rms[REPEAT, LAW] < 1.0
    assert rms[REPEAT, LAW] < 0.5 * rms[REPEAT, MEAN]
    # With a whole task left out, the other repeats of it do not exist.
    assert (TASK, REPEATS) not in rms
    assert rms[TASK, LAW] < rms[TASK, MEAN]
    # The law that made the postures predicts them up to their noise.
    away = swivel_of_law(postures, law, postures.q) - postures.swivel(postures.q)
    assert np.degrees(np.abs(away)).max() < 3.0


def test_no_predictor_sees_what_it_predicts(person, laws):
    postures, _ = person
    fold = next(folds(postures))
    before = prediction_table(postures, laws)
    # Turn the held-out arms about the line from shoulder to wrist: the wrist stays where it is.
    held = postures.q.copy()
    other = donders_postures(
        postures.task,
        JointLaw(np.eye(4), postures.q.mean(axis=0) + 0.3),
        postures.task.value(held[fold.held]),
    )
    held[fold.held] = other.q

    from selfmotion.kinematics.forward import body_frames

    upper = postures.arm.chain.names.index("shoulder_rotation")
    turned = {
        **postures.rotations,
        "shoulder": body_frames(postures.arm.chain, held)[:, upper, :3, :3],
    }
    after = prediction_table(replace(postures, q=held, rotations=turned), laws)
    for name in (LAW, SURFACE, MEAN, REPEATS):
        own = {"predictor": name, "trial": fold.name, "left_out": REPEAT}
        one, other = (np.array(rows_of(t, own)["predicted"]) for t in (before, after))
        np.testing.assert_allclose(one, other, atol=2e-3)


def test_a_law_whose_fit_failed_predicts_nothing(person, laws):
    (key, fit), *_ = laws.items()
    failed = laws | {key: replace(fit, status=Status(False, "did not settle"))}
    table = prediction_table(person[0], failed)
    said = table.loc[(table["predictor"] == LAW) & (table["left_out"] == key[0])]
    of_fold = said.loc[said["trial" if key[0] == REPEAT else "task"].astype(str) == key[1]]
    assert len(of_fold) and of_fold["predicted"].isna().all()
    assert said["predicted"].notna().any()


def test_a_surface_of_postures_that_do_not_turn_is_refused_with_a_sentence(person):
    table = surface_table(person[0])
    for row in rows_of(table, {"segment": "forearm"}).to_dict("records"):
        assert np.isnan(row["thickness_deg"])
        assert "along one line" in row["status"]
    (shoulder,) = rows_of(table, {"segment": "shoulder", "task": "all tasks"}).to_dict("records")
    assert shoulder["thickness_deg"] < 3.0
    assert shoulder["held_out_deg"] >= 0.9 * shoulder["thickness_deg"]


def test_paths_are_compared_by_length():
    u = np.linspace(0.0, 1.0, 200)
    slow = np.stack([u**2, 0.1 * np.sin(np.pi * u**2), 0.0 * u], axis=1)
    even = np.stack([u, 0.1 * np.sin(np.pi * u), 0.0 * u], axis=1)
    np.testing.assert_allclose(by_length(slow), by_length(even), atol=1e-4)
    assert bow(by_length(even)) == pytest.approx(0.1, abs=1e-3)


def test_each_person_counts_once():
    table = pd.DataFrame(
        {"subject": ["a", "a", "a", "b"], "side": "right", "task": "x", "v": [1.0, 1.0, 1.0, 3.0]}
    )
    (row,) = by_person(table, "v", ["task"]).to_dict("records")
    assert (row["mean"], row["n"]) == (2.0, 2)
    # Student's t with one degree of freedom: 12.706 times the standard error of 1.
    assert row["upper"] - row["mean"] == pytest.approx(12.706, abs=1e-3)
    assert np.isnan(interval(np.array([1.0]))[1])


@pytest.mark.long
@pytest.mark.skipif(not DATA.is_dir(), reason="recordings not at hand")
def test_a_recorded_person(tmp_path):
    study = load_study_file(Path(__file__).parents[2] / "docs" / "donders_study.toml")
    assert isinstance(study, StudyFile)
    run = donders_people([DATA / "ADL005"], study, effort=False)
    rms = errors(run.predictions)
    assert rms[REPEAT, LAW] < rms[REPEAT, MEAN]
    straight = rows_of(run.reaches, {"model": PLAIN_JERK})
    assert np.array(straight["bow_mm"]).max() < 0.01
    assert np.array(straight["end_error_mm"]).max() < 0.01
    assert len(rows_of(run.reaches, {"status": "done"})) == 4 * len(straight) == 40
