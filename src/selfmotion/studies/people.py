"""The people of a study, each calibrated once, with their movements: markers to joint angles.

What needs people rather than files (predictors of posture, surfaces of orientations, workspaces)
takes them from here, one arm of one person at a time.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from selfmotion.batch.workers import map_in_order
from selfmotion.capture.angles import ArmMotion
from selfmotion.capture.person import Person
from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.motion.labels import Labels
from selfmotion.studies.study_file import StudyFile, find_trials
from selfmotion.studies.trial_run import (
    PersonTrials,
    calibrate,
    moments_of,
    plan_people,
    read_trial,
)

DEFAULT_ARM = "upper_limb_anatomical"


@dataclass(frozen=True, eq=False)
class MovementOfPerson:
    """One movement.

    Attributes:
        labels: subject, side, condition, target, trial.
        motion: joint angles, landmarks, swivel angle, errors.
        moments: name to sample of `motion`; ``start`` and ``end`` always, others by the study
            file's rules.
        missing: moment to the reason why it was not found.
    """

    labels: Labels
    motion: ArmMotion
    moments: Mapping[str, int]
    missing: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class RecordedPerson:
    """One arm of one person.

    Attributes:
        subject: name.
        side: right or left.
        person: the calibration, with the scaled arm.
        movements: all that could be used, in the order of their files.
        failed: (file, why) of those that could not.
    """

    subject: str
    side: str
    person: Person
    movements: tuple[MovementOfPerson, ...]
    failed: tuple[tuple[str, str], ...]

    def select(self, condition: str) -> tuple[MovementOfPerson, ...]:
        """Give the movements of one condition."""
        return tuple(m for m in self.movements if m.labels.condition == condition)


def load_people(
    folders: Sequence[Path],
    study: StudyFile,
    *,
    arm: str = DEFAULT_ARM,
    jobs: int = 1,
    on_refused: Callable[[str, str, str], None] | None = None,
) -> Iterator[RecordedPerson]:
    """Give the people of a study one arm at a time, ordered by subject and side.

    Args:
        folders: where the recordings are, below them too.
        study: how files are named and read; names the static trials.
        arm: name or model file of the arm that is fitted to them.
        jobs: people at once, a process each.
        on_refused: told subject, side and reason where a person cannot be calibrated; the others
            go on. Left out: that is an error.

    Raises:
        FileFormatError: no folder, or no file is named as the study file says.
        RangeError: the study's files hold no markers.
        SelfmotionError: a person cannot be calibrated, and nobody wants to be told.
    """
    if not study.static:
        raise RangeError("static: the study file names no static trial; people need marker files")
    plans = plan_people(find_trials(study, list(folders)))
    attempt = partial(_attempt, study=study, arm=arm)
    for plan, found in zip(plans, map_in_order(attempt, plans, jobs), strict=True):
        if isinstance(found, RecordedPerson):
            yield found
        elif on_refused is None:
            raise found
        else:
            on_refused(plan.subject, plan.side, str(found))


def load_person(
    plan: PersonTrials,
    study: StudyFile,
    *,
    arm: str = DEFAULT_ARM,
    on_stage: Callable[[str], None] = lambda sentence: None,
) -> RecordedPerson:
    """Calibrate one arm of a person and find the angles of all of its movements.

    Args:
        plan: the person's files.
        study: how they are read.
        arm: name or model file of the arm that is fitted.
        on_stage: is told what is being done.

    Raises:
        SelfmotionError: the person cannot be calibrated (the static trial is missing or broken).
    """
    if plan.calibration is None:
        raise RangeError(f"{plan.subject} {plan.side}: no static trial")
    on_stage("calibrating")
    person = calibrate(plan.calibration, study, arm)
    movements, failed = [], []
    for i, trial in enumerate(plan.trials):
        on_stage(f"joint angles, movement {i + 1} of {len(plan.trials)}")
        try:
            motion = read_trial(person, trial, study)
            found = moments_of(motion, study)
        except SelfmotionError as error:
            failed.append((trial.key, str(error)))
            continue
        movements.append(MovementOfPerson(trial.labels, motion, found.samples, found.missing))
    return RecordedPerson(plan.subject, plan.side, person, tuple(movements), tuple(failed))


def _attempt(plan: PersonTrials, study: StudyFile, arm: str) -> RecordedPerson | SelfmotionError:
    try:
        return load_person(plan, study, arm=arm)
    except SelfmotionError as error:
        return error
