"""People of a study with their movements: generated marker files, and real ones where at hand."""

from pathlib import Path

import numpy as np
import pytest
from tests.studies.test_study_run import write_vicon

from selfmotion.capture.simulated_markers import simulate_markers
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.studies.people import load_people
from selfmotion.studies.study_file import StudyFile, load_study_file

DATA = Path(__file__).parents[3].joinpath("shared", "data", "ue_adl")

STUDY = r"""
pattern = '(?P<subject>P\d+)_(?P<condition>[a-z]+)_(?P<side>[RL])(?P<trial>\d+)\.csv'
static = "{subject}_static.csv"
frame = {up = "z", forward = "y"}
cutoff = 12
[names.side]
R = "right"
[moments.drink]
strokes = 2
mid_drink = {between = [1, 2], at = "slowest"}
[moments.forward]
end_of_reach = {stroke = 1, at = "end"}
back = {stroke = 7, at = "end"}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    where = tmp_path_factory.mktemp("people")
    capture = simulate_markers(rng=np.random.default_rng(4))
    write_vicon(where / "P1_static.csv", capture.static)
    for markers in capture.movements:
        write_vicon(where / f"P1_{markers.labels.condition}_R1.csv", markers)
    (where / "P1_comb_R2.csv").write_text("Trajectories\n100\nbroken")
    (where / "P2_comb_R1.csv").write_text("Trajectories\n100\nbroken")  # and no static trial
    (where / "study.toml").write_text(STUDY)
    return where


def test_people_come_calibrated_with_their_moments(folder):
    study = load_study_file(folder / "study.toml")
    refused = []
    people = list(load_people([folder], study, on_refused=lambda *words: refused.append(words)))
    (one,) = people
    assert (one.subject, one.side, len(one.movements)) == ("P1", "right", 5)
    assert [file for file, _ in one.failed] == ["P1_comb_R2.csv"]
    assert refused[0][:2] == ("P2", "right") and "P2_static.csv" in refused[0][2]
    assert one.person.lengths["upper_arm"] == pytest.approx(0.29, abs=0.003)
    (drink,) = one.select("drink")
    # The simulated hand is at the mouth from 1.1 s on (and the joints' lags) until 1.2 s.
    assert 0.9 < drink.motion.recording.time[drink.moments["mid_drink"]] < 1.5
    (reach,) = one.select("forward")
    assert reach.moments["start"] < reach.moments["end_of_reach"] < reach.moments["end"]
    assert "no stroke 7" in reach.missing["back"]


def test_a_person_who_cannot_be_calibrated_is_an_error_unless_somebody_is_told(folder):
    study = load_study_file(folder / "study.toml")
    with pytest.raises(SelfmotionError, match="P2_static.csv"):
        list(load_people([folder], study))


def test_processes_give_the_same_people(folder):
    study = load_study_file(folder / "study.toml")
    told = lambda *_: None  # noqa: E731
    (alone,) = load_people([folder], study, on_refused=told)
    (spread,) = load_people([folder], study, jobs=2, on_refused=told)
    for a, b in zip(alone.movements, spread.movements, strict=True):
        np.testing.assert_array_equal(a.motion.recording.q, b.motion.recording.q)
        assert a.moments == b.moments


def test_studies_without_markers_and_empty_folders_are_refused(folder, tmp_path):
    with pytest.raises(RangeError, match="no static trial"):
        list(load_people([folder], StudyFile("(?P<subject>P1).*")))
    with pytest.raises(FileFormatError, match="no file is named"):
        list(load_people([tmp_path], load_study_file(folder / "study.toml")))


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the reaching recordings are not at {DATA}")
def test_real_drinks_have_a_grasp_and_a_middle_with_the_hand_far_and_slow(tmp_path):
    toml = r"""
pattern = '(?P<subject>ADL008)(?P<condition>[FD])(?P<side>R)(?P<trial>\d)\.csv'
static = "{subject}_static.csv"
frame = {up = "z", forward = "y"}
names.side.R = "right"
[moments.D]
strokes = 4
grasp = {stroke = 1, at = "end"}
mid_drink = {between = [2, 3], at = "slowest"}
[moments.F]
strokes = 1
end_of_reach = {stroke = 1, at = "end"}
"""
    (tmp_path / "study.toml").write_text(toml)
    (person,) = load_people([DATA / "ADL008"], load_study_file(tmp_path / "study.toml"))
    assert len(person.movements) == 10 and not person.failed
    for movement in person.select("D"):
        at, motion = movement.moments, movement.motion
        hand = motion.landmarks["knuckle"].path
        away = np.linalg.norm(hand - hand[at["start"]], axis=1)
        assert at["start"] < at["grasp"] < at["mid_drink"] < at["end"]
        assert away[at["mid_drink"]] > 0.95 * away.max() > 2.0 * away[at["grasp"]]
        assert motion.hand_speed[at["mid_drink"]] < 0.05
    assert all("end_of_reach" in m.moments for m in person.select("F"))
