"""Study files: what they must say, and which files of a folder are movements."""

import pytest

from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame
from selfmotion.studies.moments import ConditionMoments
from selfmotion.studies.study_file import StudyFile, find_trials, load_study_file, unused_moments

PATTERN = r"(?P<subject>P\d)_(?P<condition>[a-z]+)(_(?P<trial>\d))?\.csv"
STATIC = "{subject}_static.csv"


def touch(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("")


def test_a_static_trial_is_no_movement_though_the_pattern_fits_its_name(tmp_path):
    touch(tmp_path, "a/P1_static.csv", "a/P1_reach_1.csv", "b/P2_static.csv", "b/P2_reach_1.csv")
    trials = find_trials(StudyFile(PATTERN, STATIC), [tmp_path])
    assert [t.key for t in trials] == ["a/P1_reach_1.csv", "b/P2_reach_1.csv"]
    assert [t.static for t in trials] == [
        tmp_path / "a/P1_static.csv",
        tmp_path / "b/P2_static.csv",
    ]


def test_without_static_trials_every_file_is_a_movement(tmp_path):
    touch(tmp_path, "P1_static.csv", "P1_reach_1.csv")
    assert len(find_trials(StudyFile(PATTERN), [tmp_path])) == 2


def test_a_study_of_static_trials_alone_is_refused(tmp_path):
    touch(tmp_path, "P1_static.csv", "P2_static.csv")
    with pytest.raises(FileFormatError, match="is a static trial"):
        find_trials(StudyFile(PATTERN, STATIC), [tmp_path])


def test_static_trials_may_lie_in_another_folder(tmp_path):
    touch(tmp_path, "still/P1_static.csv", "moving/P1_reach_1.csv")
    study = StudyFile(PATTERN, "../still/{subject}_static.csv")
    (trial,) = find_trials(study, [tmp_path])
    assert trial.key == "moving/P1_reach_1.csv"
    assert trial.static is not None and trial.static.samefile(tmp_path / "still/P1_static.csv")


def test_a_group_that_took_no_part_stands_for_nothing(tmp_path):
    touch(tmp_path, "P1_reach.csv")
    (trial,) = find_trials(StudyFile(PATTERN, "{subject}{trial}_static.csv"), [tmp_path])
    assert trial.static == tmp_path / "P1_static.csv"


@pytest.mark.parametrize(
    "static",
    ["{person}.csv", "{subject.csv", "{}.csv", "{0}.csv", "{subject.x}.csv", "{subject:d}.csv"]
    + ["{subject!r}.csv", "/tmp/{subject}.csv", "a\0.csv"],
)
def test_a_static_trial_that_cannot_be_named_is_refused(static):
    with pytest.raises(RangeError, match="static = .*as in") as refused:
        StudyFile(PATTERN, static)
    assert "\n" not in str(refused.value)


def test_one_name_in_two_folders_is_refused(tmp_path):
    touch(tmp_path, "a/P1_reach_1.csv", "b/P1_reach_1.csv")
    with pytest.raises(RangeError, match="both P1_reach_1.csv"):
        find_trials(StudyFile(PATTERN), [tmp_path / "a", tmp_path / "b"])
    assert len(find_trials(StudyFile(PATTERN), [tmp_path])) == 2


def test_a_link_to_nothing_is_a_trial_that_fails(tmp_path):
    (tmp_path / "P1_reach_1.csv").symlink_to(tmp_path / "nowhere")
    (tmp_path / "P2_reach_1.csv").mkdir()
    (trial,) = find_trials(StudyFile(PATTERN), [tmp_path])
    assert trial.key == "P1_reach_1.csv"


def test_moments_of_conditions_that_nobody_did_are_named(tmp_path):
    touch(tmp_path, "P1_reach_1.csv")
    rules = {"reach": ConditionMoments(), "Reach": ConditionMoments()}
    study = StudyFile(PATTERN, moments=rules)
    (sentence,) = unused_moments(study, find_trials(study, [tmp_path]))
    assert sentence == "moments.Reach: no file has this condition (there are: reach)"


def test_axes_are_never_assumed(tmp_path):
    where = tmp_path / "study.toml"
    where.write_text(f"pattern = '{PATTERN}'")
    assert load_study_file(where).frame == UNKNOWN_FRAME
    where.write_text(f"pattern = '{PATTERN}'\nframe = {{up = 'y', forward = 'x'}}")
    assert load_study_file(where).frame == Frame("y", "x")
    where.write_text(f"pattern = '{PATTERN}'\nframe = {{forward = 'x'}}")
    with pytest.raises(SelfmotionError, match="nothing of up"):
        load_study_file(where)


def test_the_mark_that_windows_editors_write_does_no_harm(tmp_path):
    where = tmp_path / "study.toml"
    where.write_text(f"pattern = '{PATTERN}'", encoding="utf-8-sig")
    assert load_study_file(where).pattern == PATTERN
