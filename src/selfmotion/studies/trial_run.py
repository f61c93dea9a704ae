"""One trial of a study: from its file to joint angles, velocities and Jacobian of the movement.

A worker process holds the last calibrated person, so that a person's trials, which come one after
the other, share the calibration.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.arms import load_arm
from selfmotion.capture.angles import ArmMotion, angles_from_markers
from selfmotion.capture.attach import attach_arm
from selfmotion.capture.movement_check import check_movement
from selfmotion.capture.person import CaptureOptions, Person, calibrate_person
from selfmotion.capture.protocol import load_protocol
from selfmotion.capture.scaling import ADULT_RANGES_DEG, with_adult_ranges
from selfmotion.capture.views import CENTRES
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.kinematics.arm import Arm
from selfmotion.motion.files import load, load_markers
from selfmotion.motion.files.npz import write_npz
from selfmotion.motion.labels import Frame
from selfmotion.motion.recording import Recording
from selfmotion.motion.segment import equally_spaced
from selfmotion.motion.strokes import movement_span
from selfmotion.redundancy.task import Task, task_for
from selfmotion.studies.moments import ConditionMoments, FoundMoments, find_moments
from selfmotion.studies.study_file import StudyFile, Trial

# Movements of a person with which the joint centres are found, spread over all of theirs.
CALIBRATION_TRIALS = 8
# A line from shoulder to wrist this close to the vertical gives no swivel angle over time (rad).
LEAST_FROM_VERTICAL = np.deg2rad(15.0)
# Landmark error of a movement (median of its frames) beyond which its angles mean nothing (m).
LARGEST_ERROR = 0.04
# Key of a trial's measures that holds the swivel angle over the movement, and its points.
CURVE, CURVE_POINTS = "swivel_curve_deg", 101


@dataclass(frozen=True)
class Calibration:
    """What one arm of a person is calibrated with.

    Attributes:
        static: the static trial.
        movements: marker files, in order.
        side: right or left.
    """

    static: Path
    movements: tuple[Path, ...]
    side: str


@dataclass(frozen=True)
class PersonTrials:
    """The trials of one arm of a person.

    Attributes:
        subject: name.
        side: right or left.
        trials: in the order of their files.
        calibration: what the person is calibrated with; None where the files hold joint angles.
    """

    subject: str
    side: str
    trials: tuple[Trial, ...]
    calibration: Calibration | None


@dataclass(frozen=True, eq=False)
class TrialJob:
    """One piece of work for a study run.

    Attributes:
        trial: the file and its labels.
        study: how it is read.
        arm: name or model file.
        target: the .npz to write.
        calibration: of the person, for marker files.
    """

    trial: Trial
    study: StudyFile
    arm: str
    target: Path
    calibration: Calibration | None = None


def run_trial(job: TrialJob) -> dict[str, Any]:
    """Read a trial, find its joint angles, cut the movement out and write it as .npz.

    Returns:
        What the study's table says of the trial (plain numbers).

    Raises:
        SelfmotionError: the file cannot be read or used; one line that says why.
    """
    if job.calibration is None:
        found, moving = _from_angles(job)
    else:
        found, moving = _from_markers(job, job.calibration)
    job.target.parent.mkdir(parents=True, exist_ok=True)
    write_npz(job.target, [moving])
    return found | {
        "movement_s": float(moving.time[-1] - moving.time[0]) if moving.timed else None,
        "samples": moving.n_samples,
    }


def _from_angles(job: TrialJob) -> tuple[dict[str, Any], Recording]:
    study = load(job.trial.path)
    if len(study) != 1:
        raise FileFormatError(
            f"{job.trial.path}: holds {len(study)} recordings; a study takes one a file"
        )
    recording = replace(study[0], labels=job.trial.labels, source=job.trial.key)
    if recording.jacobian is None:
        arm = load_arm(job.arm)
        cutoff = job.study.smoothing
        recording = attach_arm(recording, arm, task=_task(arm, job.study), cutoff=cutoff)
    return {}, _movement(recording, job.study.rest_share)


def _from_markers(job: TrialJob, plan: Calibration) -> tuple[dict[str, Any], Recording]:
    person = calibrate(plan, job.study, job.arm)
    motion = read_trial(person, job.trial, job.study)
    task = _task(person.arm, job.study)
    moving = _movement(attach_arm(motion.recording, person.arm, task=task), job.study.rest_share)
    return _measures(person, motion, moments_of(motion, job.study)), moving


def plan_people(trials: Sequence[Trial]) -> tuple[PersonTrials, ...]:
    """Sort trials into arms of people, each with the movements that calibrate it."""
    people: dict[tuple[str, Path | None, str], list[Trial]] = {}
    for trial in trials:
        key = (str(trial.labels.subject), trial.static, trial.labels.side or "right")
        people.setdefault(key, []).append(trial)
    plans = []
    for (subject, static, side), own in people.items():
        step = max(1, -(-len(own) // CALIBRATION_TRIALS))
        some = tuple(trial.path for trial in own[::step])
        plan = None if static is None else Calibration(static, some, side)
        plans.append(PersonTrials(subject, side, tuple(own), plan))
    return tuple(plans)


def read_trial(person: Person, trial: Trial, study: StudyFile) -> ArmMotion:
    """Find the joint angles of a calibrated person in one marker file.

    Raises:
        SelfmotionError: the file cannot be read or used.
        RangeError: no posture of the person's arm comes near the landmarks.
    """
    markers = load_markers(trial.path, frame=_frame(study))
    labelled = replace(markers, labels=trial.labels, source=trial.key)
    motion = angles_from_markers(person, labelled)
    error = float(np.nanmedian(motion.ik.rms))
    if error > LARGEST_ERROR:
        raise RangeError(
            f"{trial.path}: the arm misses the landmarks by {1e3 * error:.3g} mm (median), at most "
            f"{1e3 * LARGEST_ERROR:g} mm are allowed; are the labels of the markers right?"
        )
    return motion


def moments_of(motion: ArmMotion, study: StudyFile) -> FoundMoments:
    """Find the moments that the study file names for the movement's condition."""
    rules = study.moments.get(motion.recording.labels.condition or "", ConditionMoments())
    hand = motion.landmarks["knuckle"].path
    speed = motion.hand_speed
    return find_moments(rules, hand, motion.recording.time, speed, rest_share=study.rest_share)


def _task(arm: Arm, study: StudyFile) -> Task:
    return task_for(arm, study.task or None, study.landmark)


def _movement(recording: Recording, rest_share: float) -> Recording:
    """Cut out the samples from the first to the last movement of the hand."""
    if not rest_share:
        return recording
    xd = recording.array("xd")
    speed = np.linalg.norm(xd[:, :3], axis=1)
    first, last = movement_span(speed, share=rest_share)
    return recording.window(first, last + 1)


def _measures(person: Person, motion: ArmMotion, moments: FoundMoments) -> dict[str, Any]:
    at_limit = motion.ik.at_limit.mean(axis=0)
    return {
        "rms_landmark_mm": _number(1e3 * np.nanmedian(motion.ik.rms)),
        **_agreement(motion),
        "frames": len(motion.ik.q),
        "frames_without_markers": int(np.isnan(motion.ik.q[:, 0]).sum()),
        "frames_not_converged": int((~motion.ik.converged & ~np.isnan(motion.ik.q[:, 0])).sum()),
        "worst_at_limit": max(
            zip(at_limit.tolist(), person.arm.joints, strict=True), default=(0.0, "")
        )[1]
        if at_limit.max() > 0.0
        else "",
        "share_at_limit": float(at_limit.max()),
        "moments_missing": "; ".join(f"{k}: {why}" for k, why in moments.missing.items()),
        **_at_moments(motion, moments.samples),
        CURVE: _swivel_curve(motion, moments.samples["start"], moments.samples["end"]),
    } | {f"length_{k}_mm": 1e3 * v for k, v in person.lengths.items()}


def _agreement(motion: ArmMotion) -> dict[str, Any]:
    """Say how far clusters disagree on joint centres, and how much rigid lengths vary."""
    marks = {k: motion.landmarks[k].path for k in (*CENTRES, "knuckle")}
    apart = {
        f"{k}_disagreement_mm": 1e3 * float(np.nanmedian(motion.landmarks[k].disagreement))
        for k in CENTRES
    }
    ends = {"upper_arm": ("shoulder", "elbow"), "forearm": ("elbow", "wrist")}
    varies = {
        f"{k}_sd_mm": 1e3 * float(np.nanstd(np.linalg.norm(marks[b] - marks[a], axis=1)))
        for k, (a, b) in ends.items()
    }
    return {k: _number(v) for k, v in (apart | varies).items()}


def _at_moments(motion: ArmMotion, moments: Mapping[str, int]) -> dict[str, Any]:
    """Give the swivel angle, and how far the elbow is off the line from shoulder to wrist."""
    found: dict[str, Any] = {}
    first, last = moments["start"], moments["end"]
    for name, k in moments.items():
        S, E, W = (motion.landmarks[joint].path[k] for joint in ("shoulder", "elbow", "wrist"))
        along = (W - S) / np.linalg.norm(W - S)
        off = np.linalg.norm(np.cross(E - S, along))
        found[f"swivel_{name}_deg"] = _number(float(np.rad2deg(motion.swivel[k])))
        found[f"elbow_off_{name}_mm"] = _number(1e3 * float(off))
        found[f"percent_{name}"] = 100.0 * (k - first) / max(last - first, 1)
    return found


def _swivel_curve(motion: ArmMotion, first: int, last: int) -> list[float | None]:
    """Give the swivel angle (deg) over 0 to 100 % of the movement; None where it is not defined.

    With the hand above the shoulder the line between them is vertical, and there is no vertical
    plane through it to count from.
    """
    S, W = (motion.landmarks[joint].path[first : last + 1] for joint in ("shoulder", "wrist"))
    level = np.linalg.norm((W - S)[:, :2], axis=1) / np.linalg.norm(W - S, axis=1)
    angle = np.rad2deg(motion.swivel[first : last + 1])
    known = np.where(level < np.sin(LEAST_FROM_VERTICAL), np.nan, angle)
    time = motion.recording.time[first : last + 1]
    curve = equally_spaced(time, known[:, None], n_samples=CURVE_POINTS)
    return [_number(value) for value in curve[:, 0].tolist()]


@lru_cache(maxsize=2)
def calibrate(plan: Calibration, study: StudyFile, arm: str) -> Person:
    """Calibrate a person once for all of their trials.

    A movement that is of no use for that is left out; it is reported as a trial, not here. Where
    none is of use, the static trial says what is wrong, or each trial does.
    """
    protocol = load_protocol(study.protocol)
    frame = _frame(study)
    static = load_markers(plan.static, frame=frame)
    movements = []
    for path in plan.movements:
        try:
            movement = load_markers(path, frame=frame)
            check_movement(static, movement, side=plan.side, protocol=protocol)
        except SelfmotionError:
            continue
        movements.append(movement)
    return calibrate_person(
        person_arm(arm, adult=not study.person_ranges),
        static,
        movements,
        side=plan.side,
        protocol=protocol,
        options=CaptureOptions(cutoff=study.smoothing, centres=study.centres),
    )


def _frame(study: StudyFile) -> Frame:
    """Give the laboratory's axes: those of the study file, else those of the marker protocol."""
    return study.frame if study.frame.known else load_protocol(study.protocol).frame


def person_arm(name: str, *, adult: bool) -> Arm:
    """Load an arm, with the joint ranges of adults where these are known for its joints."""
    arm = load_arm(name)
    if adult and set(ADULT_RANGES_DEG) <= set(arm.joints):
        return with_adult_ranges(arm)
    return arm


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
