"""Observations of one arm of one person: hand poses, feasible postures, what criteria predict.

This is the piece of work of a batch. What it gives is plain numbers, so that a journal can hold it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from selfmotion.errors import RangeError, SelfmotionError, Status
from selfmotion.methods.predictors.catalogue import CRITERIA, EFFORT, EFFORT_PASSIVE, START
from selfmotion.methods.predictors.least_cost import NOTHING_FEASIBLE
from selfmotion.methods.predictors.observation import (
    Observation,
    Prediction,
    Predictor,
    Scene,
    angle_between,
)
from selfmotion.methods.predictors.scenes import make_scene
from selfmotion.muscles.static_optimization import EffortOptions, muscle_effort
from selfmotion.redundancy.manifold import ManifoldFinder
from selfmotion.studies.people import RecordedPerson, load_person
from selfmotion.studies.prediction_poses import (
    FittedPerson,
    Moment,
    fit_person,
    moments_of_person,
)
from selfmotion.studies.study_file import StudyFile
from selfmotion.studies.trial_run import PersonTrials

# Criteria that the variants are compared by.
FEW = (EFFORT_PASSIVE, "mid-range", START)


@dataclass(frozen=True)
class Variant:
    """One way to see the same recordings.

    Attributes:
        name: name it goes by.
        centres: study (as the study file says, functional if it says nothing), landmarks (from
            the bony landmarks) or acromion (the marker itself).
        shift: of the shoulder centre: outwards, forward, up (m).
        limits: adult, model or wide; see `prediction_poses.fit_person`.
        criteria: names of the criteria computed; empty: all.
    """

    name: str
    centres: str = "study"
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limits: str = "adult"
    criteria: tuple[str, ...] = FEW


BASE = Variant("as recorded", criteria=())
SENSITIVITY = (
    Variant("shoulder +10 mm outwards", shift=(0.01, 0.0, 0.0)),
    Variant("shoulder -10 mm outwards", shift=(-0.01, 0.0, 0.0)),
    Variant("shoulder +10 mm forward", shift=(0.0, 0.01, 0.0)),
    Variant("shoulder -10 mm forward", shift=(0.0, -0.01, 0.0)),
    Variant("shoulder +10 mm up", shift=(0.0, 0.0, 0.01)),
    Variant("shoulder -10 mm up", shift=(0.0, 0.0, -0.01)),
    Variant("shoulder from landmarks", centres="landmarks"),
    Variant("shoulder at the acromial marker", centres="acromion"),
    Variant("limits of the model", limits="model"),
    Variant("hardly any limits", limits="wide"),
)


@dataclass(frozen=True)
class PersonJob:
    """One arm of one person.

    Attributes:
        plan: the person's files.
        study: how they are read.
        variants: ways to see them; the first is the main one.
    """

    plan: PersonTrials
    study: StudyFile
    variants: tuple[Variant, ...] = (BASE,)


def observe_person(job: PersonJob) -> dict[str, Any]:
    """Observe one arm of one person in all variants.

    Returns:
        Plain numbers: ``observations`` (see `to_record`), ``failed`` files and moments with the
        reason, and what the fit says by variant.

    Raises:
        SelfmotionError: the person cannot be calibrated, or no moment could be seen.
    """
    person = load_person(job.plan, job.study)
    records: list[dict[str, Any]] = []
    fits: list[dict[str, Any]] = []
    failed = list(person.failed)
    loaded = {"study": person}
    for variant in job.variants:
        centres = "study" if variant.centres == "study" else "landmarks"
        if centres not in loaded:
            loaded[centres] = load_person(job.plan, replace(job.study, centres=centres))
        seen, lost = _moments(loaded[centres], variant)
        if variant is job.variants[0]:
            failed += lost
        if not seen:
            raise RangeError(
                f"{person.subject} {person.side}: none of the study file's moments was found"
            )
        fitted = fit_person(
            seen, knuckle_radial=person.person.protocol.knuckle_radial, limits=variant.limits
        )
        fits.append({"variant": variant.name, **describe(person, fitted)})
        made = observe(person, seen, fitted, variant)
        records += [{"variant": variant.name, **to_record(o)} for o in made]
    return {"observations": records, "failed": [list(pair) for pair in failed], "fits": fits}


def observe(
    person: RecordedPerson, seen: Sequence[Moment], fitted: FittedPerson, variant: Variant
) -> list[tuple[Observation, dict[str, Any]]]:
    """Give each moment but the starts as an observation, with what is known of its pose."""
    finder = ManifoldFinder.of(fitted.model.arm)
    poses, inside = fitted.hand_poses(), fitted.inside()
    starts = {(m.task, m.trial): i for i, m in enumerate(seen) if m.moment == "start"}
    wanted = [p for p in CRITERIA if not variant.criteria or p.name in variant.criteria]
    arm = fitted.model.arm
    axes = np.stack([np.cross(arm.forward, arm.up), arm.forward, arm.up])
    out = []
    for i, moment in enumerate(seen):
        if moment.moment == "start":
            continue
        first = starts[moment.task, moment.trial]
        scene = make_scene(
            fitted.model,
            poses[i],
            shoulder=fitted.shoulder[i],
            mouth=fitted.shoulder[i] + axes.T @ moment.points["mouth"],
            start=np.clip(fitted.q[first], arm.lower, arm.upper),
            finder=finder,
        )
        reach = arm.lengths["upper_arm"] + arm.lengths["forearm"]
        bare = Observation(
            person.subject,
            person.side,
            moment.task,
            moment.moment,
            moment.trial,
            moment.natural(),
            seen[first].natural(),
            moment.points["wrist"] / reach,
            axes @ poses[i, :3, :3],
            scene=scene,
        )
        said = {p.name: _attempt(p, bare) for p in wanted}
        about = {
            "wrist_m": moment.points["wrist"].tolist(),
            "elbow_radius_m": moment.elbow_radius(),
            "natural_inside": bool(inside[i]),
            "intervals": [[float(s.swivel.min()), float(s.swivel.max())] for s in scene.stretches],
            "fit_error_m": float(fitted.error[i]),
            **against_law(scene, fitted.q[i], said.get(EFFORT, NOTHING_FEASIBLE)),
        }
        out.append((replace(bare, criteria=said, scene=None), about))
    return out


def against_law(scene: Scene, natural: Float[np.ndarray, "7"], law: Prediction) -> dict[str, Any]:
    """Say how the law's posture differs from the person's: coordinates, and what effort is more.

    Returns:
        ``coordinate_error``: (7) of the law's posture less the fitted one (rad); ``effort_ratio``:
        effort of the fitted posture over that of the law's. None where either is not to be had.
    """
    if not np.isfinite(law.angle) or not scene.stretches:
        return {"coordinate_error": None, "effort_ratio": None}
    q = np.concatenate([stretch.q for stretch in scene.stretches])
    swivel = np.concatenate([stretch.swivel for stretch in scene.stretches])
    nearest = q[np.argmin(np.abs(angle_between(swivel, law.angle)))]
    found = muscle_effort(scene.model, np.stack([natural, nearest]), options=EffortOptions())
    ratio = float(found.effort[0] / found.effort[1]) if all(found.status) else None
    return {"coordinate_error": (nearest - natural).tolist(), "effort_ratio": ratio}


def describe(person: RecordedPerson, fitted: FittedPerson) -> dict[str, Any]:
    """Say what the fit of a person came to."""
    lengths = fitted.model.arm.lengths
    return {
        "subject": person.subject,
        "side": person.side,
        "upper_arm_m": lengths["upper_arm"],
        "forearm_m": lengths["forearm"],
        "fit_error_m": float(np.median(fitted.error)),
        "deviation_offset_rad": float(fitted.offset[0]),
        "flexion_offset_rad": float(fitted.offset[1]),
        "postures_inside": float(fitted.inside().mean()),
    }


def to_record(seen: tuple[Observation, Mapping[str, Any]]) -> dict[str, Any]:
    """Turn an observation into what JSON can hold."""
    o, about = seen
    return {
        "subject": o.subject,
        "side": o.side,
        "task": o.task,
        "moment": o.moment,
        "trial": o.trial,
        "natural": o.natural,
        "start": o.start,
        "wrist": o.wrist.tolist(),
        "hand": o.hand.tolist(),
        "criteria": {k: [p.angle, p.status.ok, p.status.sentence] for k, p in o.criteria.items()},
        **about,
    }


def from_record(record: Mapping[str, Any]) -> Observation:
    """Turn it back."""
    criteria = {k: Prediction(v[0], Status(v[1], v[2])) for k, v in record["criteria"].items()}
    return Observation(
        subject=record["subject"],
        side=record["side"],
        task=record["task"],
        moment=record["moment"],
        trial=record["trial"],
        natural=record["natural"],
        start=record["start"],
        wrist=np.array(record["wrist"]),
        hand=np.array(record["hand"]),
        criteria=criteria,
    )


def _attempt(predictor: Predictor, observation: Observation) -> Prediction:
    try:
        return predictor.swivel(observation)
    except SelfmotionError as error:
        return Prediction(float("nan"), Status(False, str(error)))


def _moments(
    person: RecordedPerson, variant: Variant
) -> tuple[list[Moment], list[tuple[str, str]]]:
    seen, lost = moments_of_person(person)
    if variant.centres == "acromion":
        # The protocol's place of the centre, counted from the marker, taken back.
        back = -np.array(person.person.protocol.shoulder)
        return [m.with_shoulder(tuple(back.tolist())) for m in seen], lost
    return [m.with_shoulder(variant.shift) for m in seen], lost
