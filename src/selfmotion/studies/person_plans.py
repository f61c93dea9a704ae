"""A person's reaches planned by λ0-PMP, with and without the person's own weights as damping.

The planner's damping says how unwilling a joint is to move, which is what inverse-kinematics
weights say too. The law is fitted to all postures of the person; paths and postures at the end are
measured beside the recorded ones.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.methods.donders import JointElasticity
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive_motion import PlanSettings, plan
from selfmotion.methods.predictors.observation import angle_between
from selfmotion.studies.donders_paths import TIME_SHARE, by_length
from selfmotion.studies.donders_postures import LAW_JOINTS, PersonPostures
from selfmotion.studies.people import RecordedPerson

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
        One row a movement and model: ``apart_mm`` between planned and recorded path (root mean
        square, at equal shares of length), ``posture_error_deg`` over joints and
        ``swivel_error_deg`` at the end, and ``status``.

    Raises:
        RangeError: there is no law, or no movement with a moment of `GOALS`.
    """
    if postures is None or fitted is None:
        raise RangeError("plans: there is no law to plan with")
    law, task = fitted.law(), postures.task
    joints = person.person.arm.joints
    own = weights[[joints.index(joint) for joint in LAW_JOINTS]]
    alike = JointLaw(np.eye(len(own)) * np.trace(law.stiffness) / len(own), law.rest)
    damped = np.trace(law.stiffness) * own / own.sum()
    rows = []
    for movement in person.movements:
        if not any(m in movement.moments for m in GOALS):
            continue
        q, time = _reach(movement, joints)
        duration = float(time[-1] - time[0])
        tau = TIME_SHARE * duration
        models = (
            (OWN_LAW, law, None),
            (OWN_WEIGHTS, law, tau * damped),
            (ALIKE, alike, None),
        )
        path = task.value(q)
        for name, chosen, damping in models:
            paced = replace(chosen, damping_time=tau, spring_time=tau)
            settings = PlanSettings(duration=duration, damping=damping)
            row: dict[str, object] = {
                "task": movement.labels.condition,
                "trial": movement.labels.trial,
                "model": name,
            }
            try:
                made = plan(task, paced, q[0], path[-1], settings)
            except SelfmotionError as error:
                rows.append(row | {"status": str(error)})
                continue
            end = made.q[0, -1]
            swivel = postures.swivel(np.stack([end, q[-1]]))
            apart = by_length(made.x[0]) - by_length(path)
            rows.append(
                row
                | {
                    "apart_mm": 1e3 * float(np.sqrt((apart**2).sum(axis=1).mean())),
                    "posture_error_deg": float(np.degrees(np.sqrt(((end - q[-1]) ** 2).mean()))),
                    "swivel_error_deg": abs(float(np.degrees(angle_between(*swivel)))),
                    "status": made.statuses[0].sentence,
                }
            )
    if not rows:
        raise RangeError(f"plans: no movement has one of the moments {', '.join(GOALS)}")
    return pd.DataFrame(rows)


def _reach(movement, joints: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Give postures of the law's joints and times, from the start to the goal."""
    recording = movement.motion.recording
    goal = next(m for m in GOALS if m in movement.moments)
    part = slice(movement.moments["start"], movement.moments[goal] + 1)
    shown = [joints.index(joint) for joint in LAW_JOINTS]
    q, time = recording.array("q")[part][:, shown], recording.time[part]
    seen = np.isfinite(q).all(axis=1)
    if seen.sum() < 3:
        raise RangeError(f"{recording.name}: the arm was hardly seen on its way")
    return q[seen], time[seen]
