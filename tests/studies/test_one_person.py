from pathlib import Path

import numpy as np
import pytest

from selfmotion.report.person_page import sentences, write_person_report
from selfmotion.studies.one_person import analyse_one, filled_weights, identified
from selfmotion.studies.people import load_person
from selfmotion.studies.person_plans import ALIKE, OWN_LAW, OWN_WEIGHTS
from selfmotion.studies.study_file import find_trials, load_study_file
from selfmotion.studies.trial_run import plan_people

FOLDER = Path(__file__).parents[2] / "examples" / "people"


@pytest.fixture(scope="module")
def found():
    study = load_study_file(FOLDER / "study.toml")
    plan = plan_people(find_trials(study, [FOLDER]))[0]
    return analyse_one(load_person(plan, study))


def test_every_part_is_there(found):
    assert found.weights is not None and found.law is not None and found.change is not None
    assert set(found.plans["model"]) == {OWN_LAW, OWN_WEIGHTS, ALIKE}
    assert len(found.postures) == len(set(found.postures["task"]))
    assert found.reach is not None and found.splinted is not None


def test_ranges_used_hold_every_posture(found):
    for movement in found.person.movements:
        q = movement.motion.recording.q
        if len(q) < 10:
            continue
        for i, joint in enumerate(found.person.person.arm.joints):
            low, high = found.ranges[joint].low, found.ranges[joint].high
            outside = ((q[:, i] < low - 1e-9) | (q[:, i] > high + 1e-9)).mean()
            assert outside < 0.5  # 0.1 s at either end may lie beyond


def test_what_is_limited_is_less(found):
    for space in (found.reach, found.splinted):
        assert space.regions["limited"].volume <= space.regions["free"].volume


def test_weights_that_are_not_told_take_the_mean_of_the_others(found):
    assert (filled_weights(None, 9) == 1.0).all()
    filled = filled_weights(found.weights, 9)
    assert np.isfinite(filled).all() and (filled > 0).all()
    if identified(found.weights):
        known = np.isfinite(found.weights.weights)
        np.testing.assert_allclose(filled[known], found.weights.weights[known])


def test_the_report_is_written_and_says_it_in_words(found, tmp_path):
    page = write_person_report(tmp_path / "p.html", found).read_text(encoding="utf-8")
    assert "With a splinted elbow" in page and "Natural posture" in page
    assert all(said.split(".")[0] in page for said in sentences(found)[:1])
