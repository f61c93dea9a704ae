"""Planned reaches of recorded people beside what they did: paths of the wrist, end postures.

Paths are those of the wrist about the shoulder: what the trunk and the girdle did is taken out of
both. The law is fitted to the other repeats. `reach_measures` says how reaches are planned.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError
from selfmotion.methods.donders import JointElasticity, has_collapsed
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.task_planners import MinimumJerk
from selfmotion.methods.passive_motion import PlanSettings
from selfmotion.studies.donders_postures import PersonPostures
from selfmotion.studies.people import MovementOfPerson, RecordedPerson
from selfmotion.studies.reach_measures import (
    MEASURES,
    RECORDED,
    by_length,
    measures_of,
    plan_reach,
    recorded_reach,
)

if TYPE_CHECKING:
    import pandas as pd

# The moment at which a reach ends, by its name in the study file.
END = "end_of_reach"
PASSIVE, EQUAL = "λ0-PMP, fitted law", "λ0-PMP, equal stiffness"
LAW_JERK, PLAIN_JERK = "minimum jerk, fitted law", "minimum jerk, pseudo-inverse"
MODELS = (PASSIVE, EQUAL, LAW_JERK, PLAIN_JERK)


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
    reach = recorded_reach(movement, postures, END)
    mean = np.median(reach.q, axis=0)
    alike = JointLaw(np.eye(len(mean)) * np.trace(law.stiffness) / len(mean), mean)
    rows = [{"model": RECORDED} | measures_of(reach, postures)]
    planned = {}
    for name, own, settings in _models(law, alike):
        try:
            motion = plan_reach(reach, postures, own, settings)
        except NotFiniteError as error:
            raise NotFiniteError(f"{name}: {error}") from None
        rows.append({"model": name} | measures_of(reach, postures, motion))
        planned[name] = by_length(motion.x[0])
    return rows, Reach(reach.task, reach.trial, by_length(reach.path), planned)


def _models(law: JointLaw, alike: JointLaw) -> tuple[tuple[str, JointLaw, PlanSettings], ...]:
    passive = PlanSettings()
    jerk = replace(passive, planner=MinimumJerk())
    # Without elasticity and with all joints as costly: the least joint velocity.
    plain = replace(jerk, model="pmp1", damping=np.ones(law.n_joints))
    return (
        (PASSIVE, law, passive),
        (EQUAL, alike, passive),
        (LAW_JERK, law, jerk),
        (PLAIN_JERK, law, plain),
    )
