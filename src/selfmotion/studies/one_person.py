"""One person through all four methods, and what follows only from having them all.

From the recordings of one arm: joint angles, inverse-kinematics weights ([Khoramshahi2022]), the
elasticity behind the postures ([Tommasino2017]), the workspace ([DeBoon]) and the natural posture
([Li2022]). Together: the person's weights as damping in the planner, the ranges that the person
used as bounds of the natural posture, and what a splinted elbow would change.

Stated choices: the task of the weights is the wrist's place, which leaves the wrist's own joints
out; a joint whose weight is not identified counts as the geometric mean of those that are; ranges
"used" are those in which a joint spent all but 0.1 s at either end over all movements, which is
what these tasks needed and not what the person can do.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.capture.attach import attach_arm
from selfmotion.capture.ranges import FEWEST, JointRange, joint_range
from selfmotion.errors import SelfmotionError
from selfmotion.methods.donders import JointElasticity
from selfmotion.methods.identification import identify_weights
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.methods.predictors.observation import angle_between
from selfmotion.methods.velocity_split import split
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.workspace import Workspace, WorkspaceOptions, workspace
from selfmotion.motion.recording import Recording, Study
from selfmotion.provenance import Provenance
from selfmotion.redundancy.task import Position
from selfmotion.studies.donders_postures import postures_of
from selfmotion.studies.donders_predictions import fit_law
from selfmotion.studies.donders_surfaces import surface_table
from selfmotion.studies.people import RecordedPerson
from selfmotion.studies.people_means import means_by
from selfmotion.studies.person_plans import plan_with_weights
from selfmotion.studies.prediction_poses import FittedPerson, Moment, fit_person, moments_of_person
from selfmotion.studies.splint_change import SPLINT, SplintChange, splint_change

# Room beyond what was used in the other movements, when ranges bound the natural posture (rad).
ROOM = np.radians(5.0)
# Slices of the workspace, above the arm's origin (m): about table, chest, shoulder and face.
HEIGHTS = (-0.4, -0.2, 0.0, 0.2)
FINENESS = WorkspaceOptions(n_points=4096, shifts=4, slice_points=256)


@dataclass(frozen=True, eq=False)
class OnePerson:
    """Everything about one arm of one person; a part that could not be had is None or empty.

    Attributes:
        person: the recordings, calibrated.
        capture: one row a movement: landmark error (mm), swivel angle at its moments (degrees).
        weights: of all movements together.
        shares: one row a task: task and null-space share, with these weights and all alike.
        law: elasticity of shoulder and elbow.
        surfaces: thickness of Donders' surfaces by segment and task.
        ranges: joint to what was used.
        reach: workspace: free, and in the ranges used.
        splinted: workspace: free, and with the splint.
        plans: one row a movement and model: distance of planned from recorded path and posture.
        postures: one row a moment: natural, predicted by effort, and predicted in the ranges used.
        change: what the splint changes.
        missing: part to why it could not be had; movement or file to why it could not be used.
        provenance: what made it.
    """

    person: RecordedPerson
    capture: pd.DataFrame
    weights: WeightEstimate | None
    shares: pd.DataFrame
    law: JointElasticity | None
    surfaces: pd.DataFrame
    ranges: Mapping[str, JointRange]
    reach: Workspace | None
    splinted: Workspace | None
    plans: pd.DataFrame
    postures: pd.DataFrame
    change: SplintChange | None
    missing: tuple[tuple[str, str], ...]
    provenance: Provenance

    @property
    def name(self) -> str:
        """Who, and which arm."""
        return f"{self.person.subject}, {self.person.side} arm"


def analyse_one(
    person: RecordedPerson,
    *,
    threads: int = 1,
    on_stage: Callable[[str], None] = lambda sentence: None,
) -> OnePerson:
    """Run all four methods on one arm of a person.

    A part that fails leaves its reason in `missing`; the others go on.

    Args:
        person: from `people.load_people`.
        threads: for the workspace.
        on_stage: is told what is being done.
    """
    missing: list[tuple[str, str]] = list(person.failed)

    def attempt(part: str, make: Callable):
        on_stage(part)
        try:
            return make()
        except SelfmotionError as error:
            missing.append((part, str(error)))
            return None

    arm = person.person.arm
    recordings = [m.motion.recording for m in person.movements]
    weights = attempt("weights", lambda: _weights(person))
    known = filled_weights(weights, arm.n_joints)
    postures = attempt("postures", lambda: postures_of(person))
    law = None
    if postures is not None:
        law = attempt("elasticity", lambda: fit_law(postures, postures.on_path))
    ranges = attempt("ranges", lambda: used_ranges(recordings, arm.joints)) or {}
    used = {k: _inside(arm, k, r) for k, r in ranges.items()}
    splint = {k: v for k, v in SPLINT.items() if k in arm.joints}
    options = replace(FINENESS, threads=threads)
    empty = pd.DataFrame()
    return OnePerson(
        person,
        capture_table(person),
        weights,
        _shares(person, weights),
        law,
        empty if postures is None else surface_table(postures),
        ranges,
        attempt(
            "workspace", lambda: workspace(arm, limited=arm.with_limits(used), options=options)
        ),
        attempt(
            "splinted workspace",
            lambda: workspace(
                arm, limited=arm.with_limits(splint), heights=HEIGHTS, options=options
            ),
        ),
        _or(attempt("plans", lambda: plan_with_weights(person, postures, law, known)), empty),
        _or(attempt("natural posture", lambda: _postures(person, missing)), empty),
        attempt("splint", lambda: splint_change(arm, recordings, known)),
        tuple(missing),
        Provenance("person", choices={"arm": arm.name, "task": "position of the wrist"}),
    )


def _or(table: pd.DataFrame | None, otherwise: pd.DataFrame) -> pd.DataFrame:
    return otherwise if table is None else table


def capture_table(person: RecordedPerson) -> pd.DataFrame:
    """Give one row a movement: landmark error (mm) and swivel angle at its moments (degrees)."""
    rows = []
    for m in person.movements:
        row = {"task": m.labels.condition, "trial": m.labels.trial}
        row |= {"rms_landmark_mm": 1e3 * float(np.nanmedian(m.motion.ik.rms))}
        angles = {k: float(np.degrees(m.motion.swivel[i])) for k, i in m.moments.items()}
        rows.append(row | {f"swivel_{k}_deg": v for k, v in angles.items()})
    return pd.DataFrame(rows)


def _attached(person: RecordedPerson) -> list[Recording]:
    """Give the movements, from start to end, with the wrist's place as their task."""
    arm = person.person.arm
    out = []
    for m in person.movements:
        moving = attach_arm(m.motion.recording, arm, task=Position(arm, "wrist"))
        out.append(moving.window(m.moments["start"], m.moments["end"] + 1))
    return out


def _weights(person: RecordedPerson) -> WeightEstimate:
    return identify_weights(Study(tuple(_attached(person))))


def identified(estimate: WeightEstimate | None) -> bool:
    """Tell whether an estimate settled and tells the weight of any joint."""
    return estimate is not None and estimate.status.ok and bool(np.isfinite(estimate.weights).any())


def filled_weights(estimate: WeightEstimate | None, n: int) -> Float[np.ndarray, " joints"]:
    """Give a weight to every joint: those not identified take the geometric mean of the others.

    Without any, all are alike.
    """
    if not identified(estimate):
        return np.ones(n)
    assert estimate is not None
    known = np.isfinite(estimate.weights) & (estimate.weights > 0)
    mean = float(np.exp(np.log(estimate.weights[known]).mean()))
    return np.where(known, estimate.weights, mean)


def _shares(person: RecordedPerson, weights: WeightEstimate | None) -> pd.DataFrame:
    rows = []
    for recording in _attached(person):
        alike = split(recording)
        own = split(recording, weights=weights) if identified(weights) else None
        rows.append(
            {
                "task": recording.labels.condition,
                "task_share": np.nan if own is None else own.task_share,
                "task_share_alike": alike.task_share,
            }
        )
    columns = ["task_share", "task_share_alike"]
    return means_by(pd.DataFrame(rows, columns=["task", *columns]), ["task"], columns)


def used_ranges(recordings: list[Recording], joints: tuple[str, ...]) -> dict[str, JointRange]:
    """Give the range of each joint over all movements together, very short ones left out."""
    used = [r for r in recordings if np.isfinite(r.array("q")).all(axis=1).sum() >= FEWEST]
    return {joint: joint_range(joint, used) for joint in joints}


def _inside(arm, joint: str, found: JointRange) -> tuple[float, float]:
    i = arm.chain.index(joint)
    return max(found.low, float(arm.lower[i])), min(found.high, float(arm.upper[i]))


def _postures(person: RecordedPerson, missing: list[tuple[str, str]]) -> pd.DataFrame:
    """Predict the swivel angle at each moment by least effort, with and without used ranges."""
    moments, lost = moments_of_person(person)
    missing += lost
    fitted = fit_person(moments, knuckle_radial=person.person.protocol.knuckle_radial)
    finder = PostureFinder.of(fitted.model)
    rows = []
    for i, (moment, T) in enumerate(zip(moments, fitted.hand_poses(), strict=True)):
        if moment.moment == "start":
            continue
        free, bounded = finder.find(T), _bounded(fitted, moments, i).find(T)
        natural = moment.natural()
        rows.append(
            {
                "task": moment.task,
                "moment": moment.moment,
                "trial": moment.trial,
                "natural_deg": float(np.degrees(natural)),
                "effort_deg": float(np.degrees(free.swivel)),
                "bounded_deg": float(np.degrees(bounded.swivel)),
                "effort_error_deg": float(np.degrees(angle_between(free.swivel, natural))),
                "bounded_error_deg": float(np.degrees(angle_between(bounded.swivel, natural))),
                "status": str(bounded.status),
            }
        )
    return pd.DataFrame(rows)


def sizes_of_errors(postures: pd.DataFrame) -> pd.DataFrame:
    """Add the sizes of the errors as columns ``effort`` and ``bounded`` (degrees)."""
    return postures.assign(
        effort=postures["effort_error_deg"].abs(), bounded=postures["bounded_error_deg"].abs()
    )


def _bounded(fitted: FittedPerson, moments: list[Moment], i: int) -> PostureFinder:
    """Give a finder whose limits are what the person used in all other movements."""
    here = moments[i]
    others = [
        k for k, m in enumerate(moments) if (m.task, m.trial) != (here.task, here.trial)
    ] or list(range(len(moments)))
    arm = fitted.model.arm
    low = np.maximum(fitted.q[others].min(axis=0) - ROOM, arm.lower)
    high = np.minimum(fitted.q[others].max(axis=0) + ROOM, arm.upper)
    pairs = zip(arm.joints, np.minimum(low, high).tolist(), high.tolist(), strict=True)
    limits = {joint: (a, b) for joint, a, b in pairs}
    return PostureFinder.of(replace(fitted.model, arm=arm.with_limits(limits)))
