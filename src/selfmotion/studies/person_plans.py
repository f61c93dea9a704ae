"""A person's reaches planned by λ0-PMP, with and without the person's own weights as damping.

The planner's damping says how unwilling a joint is to move, which is what inverse-kinematics
weights say too. The law is fitted to all postures of the person; paths and postures at the end are
measured beside the recorded ones.
"""

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.methods.donders import JointElasticity
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive_motion import PlanSettings
from selfmotion.studies.donders_postures import LAW_JOINTS, PersonPostures
from selfmotion.studies.people import MovementOfPerson, RecordedPerson
from selfmotion.studies.reach_measures import (
    MEASURES,
    TIME_SHARE,
    measures_of,
    plan_reach,
    recorded_reach,
)

# Moments at which a way to something ends, the first that a movement has.
GOALS = ("end_of_reach", "grasp", "mid_drink")
OWN_LAW, OWN_WEIGHTS, ALIKE = "fitted law", "fitted law, weights as damping", "all joints alike"


def plan_with_weights(
    person: RecordedPerson,
    postures: PersonPostures | None,
    fitted: JointElasticity | None,
    weights: Float[np.ndarray, " joints"],
) -> pd.DataFrame:
    """Plan every movement from its start to where the wrist was at its first goal.

    Args:
        person: with movements.
        postures: of the same person.
        fitted: the person's law.
        weights: (n,) of the whole arm.

    Returns:
        One row a movement and model: `reach_measures.MEASURES` (of the swivel angle the size of
        the error) and ``status``.

    Raises:
        RangeError: there is no law, or no movement with a moment of `GOALS`.
    """
    if postures is None or fitted is None:
        raise RangeError("plans: there is no law to plan with")
    law = fitted.law()
    joints = person.person.arm.joints
    own = weights[[joints.index(joint) for joint in LAW_JOINTS]]
    models = _models(law, own)
    rows = []
    for movement in person.movements:
        goal = next((m for m in GOALS if m in movement.moments), None)
        if goal is None:
            continue
        label = {"task": str(movement.labels.condition), "trial": str(movement.labels.trial)}
        for name, chosen, damping in models:
            rows.append(label | {"model": name} | _row(movement, goal, postures, chosen, damping))
    if not rows:
        raise RangeError(f"plans: no movement has one of the moments {', '.join(GOALS)}")
    table = pd.DataFrame(rows, columns=["task", "trial", "model", *MEASURES, "status"])
    return table.assign(swivel_error_deg=table["swivel_error_deg"].astype(float).abs())


def _models(
    law: JointLaw, weights: Float[np.ndarray, " joints"]
) -> tuple[tuple[str, JointLaw, np.ndarray | None], ...]:
    """Give name, law and damping over τ₀ (N m/rad) of each model."""
    whole, n = np.trace(law.stiffness), law.n_joints
    return (
        (OWN_LAW, law, None),
        (OWN_WEIGHTS, law, whole * weights / weights.sum()),
        (ALIKE, JointLaw(np.eye(n) * whole / n, law.rest), None),
    )


def _row(
    movement: MovementOfPerson,
    goal: str,
    postures: PersonPostures,
    law: JointLaw,
    damping: Float[np.ndarray, " joints"] | None,
) -> dict[str, object]:
    """Measure one plan; what could not be planned has a status alone."""
    try:
        reach = recorded_reach(movement, postures, goal)
        tau = TIME_SHARE * reach.duration
        settings = PlanSettings(damping=None if damping is None else tau * damping)
        return measures_of(reach, postures, plan_reach(reach, postures, law, settings))
    except SelfmotionError as error:
        return {"status": str(error)}
