"""Planned reaches of recorded people beside what they did: paths of the wrist, end postures.

Each reach is planned from the recorded posture at its start to the place where the wrist was at
its end, in the time that the person took, on the arm from shoulder to wrist at the person's size.
So paths are those of the wrist about the shoulder: what the trunk and the girdle did is taken out
of both. The law is fitted to the other repeats. Time constants are a fifth of the duration, and
the spring follows eq. 10, as [Tommasino2017] has them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError
from selfmotion.methods.curvature import path_areas
from selfmotion.methods.donders import JointElasticity, has_collapsed
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.task_planners import MinimumJerk
from selfmotion.methods.passive_motion import PlanSettings, plan
from selfmotion.methods.predictors.observation import angle_between
from selfmotion.studies.donders_postures import LAW_JOINTS, PersonPostures
from selfmotion.studies.people import MovementOfPerson, RecordedPerson

if TYPE_CHECKING:
    import pandas as pd

# The moment at which a reach ends, by its name in the study file.
END = "end_of_reach"
# Time constants over the duration of a movement.
TIME_SHARE = 0.2
# Points along each path, at equal shares of its length.
N_POINTS = 50
PASSIVE, EQUAL = "λ0-PMP, fitted law", "λ0-PMP, equal stiffness"
LAW_JERK, PLAIN_JERK = "minimum jerk, fitted law", "minimum jerk, pseudo-inverse"
MODELS = (PASSIVE, EQUAL, LAW_JERK, PLAIN_JERK)

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


@dataclass(frozen=True, eq=False)
class Reach:
    """One recorded reach and its plans; places about the shoulder in the thorax's axes.

    Attributes:
        task: condition.
        trial: repeat.
        recorded: (N, 3) path of the wrist, equally spaced (m).
        planned: model to its path (N, 3) (m).
    """

    task: str
    trial: str
    recorded: Float[np.ndarray, "points 3"]
    planned: Mapping[str, Float[np.ndarray, "points 3"]]


def plan_reaches(
    person: RecordedPerson, postures: PersonPostures, laws: Mapping[str, JointElasticity]
) -> tuple["pd.DataFrame", tuple[Reach, ...], list[tuple[str, str]]]:
    """Plan every reach of a person and measure it beside the recorded one.

    Args:
        person: with the moment `END` in some movements.
        postures: of the same person.
        laws: repeat to the law fitted without it; one that has collapsed plans nothing, since
            the arm would fling its loose joint about at rates beyond any integration.

    Returns:
        A table, one row a movement and model (and one with the model ``recorded``), the paths, and
        (reach, why) of those that could not be planned.
    """
    import pandas as pd

    rows, reaches, lost = [], [], []
    for movement in person.movements:
        fit = laws.get(str(movement.labels.trial))
        if END not in movement.moments or fit is None:
            continue
        label = {"subject": person.subject, "side": person.side}
        label |= {"task": str(movement.labels.condition), "trial": str(movement.labels.trial)}
        try:
            if has_collapsed(fit.stiffness):
                raise RangeError(f"the law fitted to the other repeats: {fit.status}")
            measured, reach = _one(movement, postures, fit.law())
        except SelfmotionError as error:
            lost.append((f"{person.subject}, {label['task']} {label['trial']}", str(error)))
            continue
        rows += [label | row for row in measured]
        reaches.append(reach)
    columns = ["subject", "side", "task", "trial", "model", *MEASURES, "status"]
    return pd.DataFrame(rows, columns=columns), tuple(reaches), lost


def _one(
    movement: MovementOfPerson, postures: PersonPostures, law: JointLaw
) -> tuple[list[dict[str, object]], Reach]:
    """Plan one reach with each model."""
    recording = movement.motion.recording
    shown = [recording.joints.index(joint) for joint in LAW_JOINTS]
    part = slice(movement.moments["start"], movement.moments[END] + 1)
    q, time = recording.array("q")[part][:, shown], recording.time[part]
    seen = np.asarray(np.isfinite(q)).all(axis=1).reshape(-1)
    if not (seen[0] and seen[-1]):
        raise NotFiniteError(
            f"{recording.source}: the arm was not seen at {'start' if seen[-1] else END}"
        )
    q, time = q[seen], time[seen]
    task = postures.task
    path = task.value(q)
    duration = float(time[-1] - time[0])
    mean = np.median(q, axis=0)
    alike = JointLaw(np.eye(len(mean)) * np.trace(law.stiffness) / len(mean), mean)
    side = 1.0 if postures.side == "right" else -1.0
    rows = [_measures("recorded", path, path, (postures, q[-1], q[-1], side))]
    planned = {}
    for name, own, settings in _models(law, alike, duration):
        tau = TIME_SHARE * duration
        paced = replace(own, damping_time=tau, spring_time=tau)
        motion = plan(task, paced, q[0], path[-1], settings)
        if not np.isfinite(motion.q).all():
            raise NotFiniteError(f"{name}: {motion.statuses[0].sentence}")
        row = _measures(name, motion.x[0], path, (postures, motion.q[0, -1], q[-1], side))
        row |= {"end_error_mm": 1e3 * float(motion.end_error[0])}
        rows.append(row | {"status": motion.statuses[0].sentence})
        planned[name] = by_length(motion.x[0])
    labels = movement.labels
    return rows, Reach(str(labels.condition), str(labels.trial), by_length(path), planned)


def _models(
    law: JointLaw, alike: JointLaw, duration: float
) -> tuple[tuple[str, JointLaw, PlanSettings], ...]:
    passive = PlanSettings(duration=duration)
    jerk = replace(passive, planner=MinimumJerk())
    # Without elasticity and with all joints as costly: the least joint velocity.
    plain = replace(jerk, model="pmp1", damping=np.ones(law.n_joints))
    return (
        (PASSIVE, law, passive),
        (EQUAL, alike, passive),
        (LAW_JERK, law, jerk),
        (PLAIN_JERK, law, plain),
    )


def _measures(
    model: str,
    path: Float[np.ndarray, "samples 3"],
    recorded: Float[np.ndarray, "others 3"],
    ends: tuple[PersonPostures, np.ndarray, np.ndarray, float],
) -> dict[str, object]:
    """Measure one path beside the recorded one, and one end posture."""
    postures, q_end, q_recorded, side = ends
    own, other = by_length(path), by_length(recorded)
    swivel = postures.swivel(np.stack([q_end, q_recorded]))
    areas = path_areas(path, recorded[0], recorded[-1], up=postures.arm.up)
    away = q_end - q_recorded
    return {
        "model": model,
        "length_mm": 1e3 * float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()),
        "bow_mm": 1e3 * bow(own),
        "apart_mm": 1e3 * float(np.sqrt(((own - other) ** 2).sum(axis=1).mean())),
        "a_net": side * areas.net,
        "swivel_error_deg": float(np.degrees(angle_between(*swivel))),
        "posture_error_deg": float(np.degrees(np.sqrt((away**2).mean()))),
        "end_error_mm": 0.0,
        "status": "recorded",
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
