"""Recorded reaches of a person, plans of them, and how far a plan is from what was recorded.

A reach is planned from the recorded posture at its start to the place where the wrist was at its
end, in the time that the person took, on the arm from shoulder to wrist at the person's size. Time
constants are a fifth of the duration, and the spring follows eq. 10, as [Tommasino2017] has them.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.errors import NotFiniteError
from selfmotion.methods.curvature import path_areas
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.methods.passive_motion import PlanSettings, plan
from selfmotion.methods.predictors.observation import angle_between
from selfmotion.studies.donders_postures import LAW_JOINTS, PersonPostures
from selfmotion.studies.people import MovementOfPerson

# Time constants over the duration of a movement.
TIME_SHARE = 0.2
# Points along each path, at equal shares of its length.
N_POINTS = 50
# What is measured of a reach, by column.
MEASURES = (
    "length_mm",
    "bow_mm",
    "apart_mm",
    "a_net",
    "swivel_error_deg",
    "posture_error_deg",
    "end_error_mm",
)
RECORDED = "recorded"


@dataclass(frozen=True, eq=False)
class RecordedReach:
    """One movement from its start to a moment, where the arm was seen.

    Attributes:
        task: condition.
        trial: repeat.
        q: (K, n) angles of the law's joints (rad).
        path: (K, 3) of the wrist (m), of the arm with the girdle held.
        duration: time taken (s).
    """

    task: str
    trial: str
    q: Float[np.ndarray, "samples joints"]
    path: Float[np.ndarray, "samples 3"]
    duration: float


def recorded_reach(
    movement: MovementOfPerson, postures: PersonPostures, goal: str
) -> RecordedReach:
    """Cut a reach out of a movement.

    Args:
        movement: with the moment `goal`.
        postures: of the same person.
        goal: the moment at which the reach ends.

    Raises:
        NotFiniteError: the arm was not seen at the start or at the goal.
    """
    recording = movement.motion.recording
    shown = [recording.joints.index(joint) for joint in LAW_JOINTS]
    part = slice(movement.moments["start"], movement.moments[goal] + 1)
    q, time = recording.array("q")[part][:, shown], recording.time[part]
    seen = np.asarray(np.isfinite(q)).all(axis=1).reshape(-1)
    if not (seen[0] and seen[-1]):
        raise NotFiniteError(
            f"{recording.source}: the arm was not seen at {'start' if seen[-1] else goal}"
        )
    labels, q = movement.labels, q[seen]
    duration = float(time[-1] - time[0])
    task, trial = str(labels.condition), str(labels.trial)
    return RecordedReach(task, trial, q, postures.task.value(q), duration)


def plan_reach(
    reach: RecordedReach, postures: PersonPostures, law: JointLaw, settings: PlanSettings
) -> PlannedMotion:
    """Plan a recorded reach, paced by the time that it took.

    Raises:
        NotFiniteError: the plan came to no end; the message says why.
        SelfmotionError: as `passive_motion.plan`.
    """
    tau = TIME_SHARE * reach.duration
    paced = replace(law, damping_time=tau, spring_time=tau)
    timed = replace(settings, duration=reach.duration)
    motion = plan(postures.task, paced, reach.q[0], reach.path[-1], timed)
    if not np.isfinite(motion.q).all():
        raise NotFiniteError(motion.statuses[0].sentence)
    return motion


def measures_of(
    reach: RecordedReach, postures: PersonPostures, motion: PlannedMotion | None = None
) -> dict[str, object]:
    """Measure a plan beside the recorded reach; left out: the recorded reach itself.

    Returns:
        `MEASURES` and ``status``. Distances between paths are root mean squares at equal shares of
        their lengths; errors are those at the end.
    """
    path = reach.path if motion is None else motion.x[0]
    q_end = reach.q[-1] if motion is None else motion.q[0, -1]
    own, other = by_length(path), by_length(reach.path)
    swivel = postures.swivel(np.stack([q_end, reach.q[-1]]))
    areas = path_areas(path, reach.path[0], reach.path[-1], up=postures.arm.up)
    return {
        "length_mm": 1e3 * float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()),
        "bow_mm": 1e3 * bow(own),
        "apart_mm": 1e3 * float(np.sqrt(((own - other) ** 2).sum(axis=1).mean())),
        "a_net": (1.0 if postures.side == "right" else -1.0) * areas.net,
        "swivel_error_deg": float(np.degrees(angle_between(*swivel))),
        "posture_error_deg": float(np.degrees(np.sqrt(((q_end - reach.q[-1]) ** 2).mean()))),
        "end_error_mm": 0.0 if motion is None else 1e3 * float(motion.end_error[0]),
        "status": RECORDED if motion is None else motion.statuses[0].sentence,
    }


def by_length(path: Float[np.ndarray, "samples 3"]) -> Float[np.ndarray, "points 3"]:
    """Give `N_POINTS` points at equal shares of a path's length.

    Example:
        >>> by_length(np.array([[0.0, 0, 0], [3, 0, 0], [4, 0, 0]]))[[0, -1], 0].tolist()
        [0.0, 4.0]
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], N_POINTS)
    return np.stack([np.interp(at, along, column) for column in path.T], axis=1)


def bow(path: Float[np.ndarray, "points 3"]) -> float:
    """Give the greatest distance of a path from the straight line between its ends (m).

    Example:
        >>> bow(np.array([[0.0, 0, 0], [0.1, 0.02, 0], [0.2, 0, 0]]))
        0.02
    """
    way = path[-1] - path[0]
    along = way / np.linalg.norm(way)
    off = path - path[0]
    return float(np.linalg.norm(off - np.outer(off @ along, along), axis=1).max())
