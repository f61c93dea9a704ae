"""Predicted against natural swivel angles of recorded people, one person left out at a time.

[Li2022] sections IV-B and IV-C (doi 10.1109/TNSRE.2022.3198400), with more predictors and on
anyone's recordings. One arm of one person is a piece of work (`prediction_observe`). Then each
person is predicted by what was fitted on all others; both arms of a person are left out together.

Deviation from the paper: where the elbow is nearly on the line from shoulder to wrist
(`LEAST_RADIUS`), the swivel angle turns by degrees for each millimetre and says nothing; such
moments are left out and counted. The paper chose poses with a wide feasible range instead.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from selfmotion._version import __version__
from selfmotion.batch import Item, Outcome, Runner, run_batch
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.methods.predictors.catalogue import BASELINE, FITTED, START, Computed
from selfmotion.methods.predictors.observation import Observation, Predictor, angle_between
from selfmotion.provenance import Provenance, hash_file
from selfmotion.studies.prediction_observe import (
    BASE,
    SENSITIVITY,
    PersonJob,
    from_record,
    observe_person,
)
from selfmotion.studies.study_file import StudyFile, Trial, find_trials
from selfmotion.studies.trial_run import PersonTrials, plan_people

# Elbows nearer to the line from shoulder to wrist have no swivel angle to speak of (m).
LEAST_RADIUS = 0.02
JOURNAL = "journal.jsonl"
# What is fitted anew for each variant: it needs few criteria.
OF_VARIANTS = (BASELINE, f"{START}, bias", f"{START}, bias per task", "regression on hand pose")
# Fitting on others needs as many of them.
LEAST_PEOPLE = 3


@dataclass(frozen=True)
class PredictionPlan:
    """What to run.

    Attributes:
        folders: where the recordings are.
        study: how they are named and read, with the moments.
        sensitivity: whether other shoulder centres and limits are tried too.
        out: folder of the journal; None: none is kept.
    """

    folders: tuple[Path, ...]
    study: StudyFile
    sensitivity: bool = False
    out: Path | None = None


@dataclass(frozen=True, eq=False)
class PredictionRun:
    """What came of it.

    Attributes:
        observations: one row a moment and variant: labels, natural angle, pose, whether it counts.
        predictions: one row a moment, variant and predictor: predicted angle, error (rad), status.
        fits: one row an arm and variant: lengths, error of the fit, wrist offsets.
        failed: (what, why): people, files and moments that could not be used.
        provenance: files and choices.
    """

    observations: pd.DataFrame
    predictions: pd.DataFrame
    fits: pd.DataFrame
    failed: tuple[tuple[str, str], ...]
    provenance: Provenance


def predict_people(
    plan: PredictionPlan,
    runner: Runner | None = None,
    *,
    on_start: Callable[[int], Callable[[Outcome], None]] | None = None,
) -> PredictionRun:
    """Run all predictors on the people of a study.

    Args:
        plan: what to run.
        runner: processes, cluster, resume; its journal is set here.
        on_start: is told the number of arms and gives what to call as each is completed.

    Raises:
        RangeError: the study file names no static trial or no moments, or fewer than three people
            could be used.
        FileFormatError: no file is named as the study file says, or none could be used.
    """
    items = plan_items(plan)
    chosen = replace(runner or Runner(), on_done=on_start(len(items)) if on_start else _nothing)
    journal = None if plan.out is None else plan.out / JOURNAL
    outcomes = run_batch(observe_person, items, replace(chosen, journal=journal))
    failed = [(o.key, o.status.sentence) for o in outcomes if o.result is None]
    results = [o.result for o in outcomes if o.result is not None]
    if not results:
        raise FileFormatError(f"no person could be used; the first: {': '.join(failed[0])}")
    failed += [(what, why) for r in results for what, why in r["failed"]]
    records = [record for r in results for record in r["observations"]]
    people = {record["subject"] for record in records}
    if len(people) < LEAST_PEOPLE:
        raise RangeError(
            f"{len(people)} people could be used; leaving one out needs at least {LEAST_PEOPLE}"
        )
    predictions = pd.concat(
        [_variant(v, [r for r in records if r["variant"] == v]) for v in _names(records)],
        ignore_index=True,
    )
    return PredictionRun(
        observation_table(records),
        predictions,
        pd.DataFrame([fit for r in results for fit in r["fits"]]),
        tuple(failed),
        _provenance(plan, items),
    )


def plan_items(plan: PredictionPlan) -> list[Item]:
    """Give one item for each arm of each person.

    Movements of other conditions have no moments, but people are calibrated with them too.

    Raises:
        RangeError: the study file names no static trial or no moments.
    """
    study = plan.study
    if not study.static:
        raise RangeError("static: the study file names no static trial; people need marker files")
    if not any(c.rules for c in study.moments.values()):
        raise RangeError(
            "moments: the study file names none; predict needs a table [moments.CONDITION]"
        )
    trials = find_trials(study, plan.folders)
    if not any(_has_moments(t, study) for t in trials):
        raise FileFormatError(
            f"moments.{next(iter(study.moments))}: no file is of this condition (found: "
            f"{', '.join(sorted({str(t.labels.condition) for t in trials}))})"
        )
    variants = (BASE, *SENSITIVITY) if plan.sensitivity else (BASE,)
    items = []
    for everything in plan_people(trials):
        own = tuple(t for t in everything.trials if _has_moments(t, study))
        if not own:
            continue
        person = replace(everything, trials=own)
        job = PersonJob(person, study, variants)
        key = f"{person.subject} {person.side}"
        hashes = _file_hashes(person)
        items.append(Item(key, job, _hash((__version__, asdict(study), variants, hashes))))
    return items


def left_out(
    observations: Sequence[Observation], predictors: Sequence[Predictor]
) -> dict[str, list[tuple[float, bool, str]]]:
    """Predict each observation by what was fitted on other people.

    Args:
        observations: of several people, criteria computed.
        predictors: of `catalogue`, or others of their interface.

    Returns:
        Predictor to (angle in rad, whether it was found, sentence) for each observation.

    Example:
        >>> from selfmotion.methods.predictors.constant import Constant
        >>> people = {"A": 0.2, "B": 0.4, "C": 0.9}
        >>> seen = [
        ...     Observation(name, "right", "reach", "end", "1", natural=angle, start=0.0,
        ...                 wrist=np.zeros(3), hand=np.eye(3))
        ...     for name, angle in people.items()
        ... ]
        >>> [round(angle, 2) for angle, _, _ in left_out(seen, [Constant()])["constant per task"]]
        [0.65, 0.55, 0.3]
    """
    found: dict[str, list[tuple[float, bool, str]]] = {}
    for predictor in predictors:
        rows: list[tuple[float, bool, str]] = [(np.nan, False, "")] * len(observations)
        for person in dict.fromkeys(o.subject for o in observations):
            fitted = predictor.fit([o for o in observations if o.subject != person])
            for i, o in enumerate(observations):
                if o.subject == person:
                    said = fitted.swivel(o)
                    rows[i] = (said.angle, said.status.ok, said.status.sentence)
        found[predictor.name] = rows
    return found


def observation_table(records: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """Give one row a moment and variant."""
    rows = []
    for r in records:
        low = [i[0] for i in r["intervals"]]
        high = [i[1] for i in r["intervals"]]
        rows.append(
            {k: r[k] for k in ("variant", "subject", "side", "task", "moment", "trial")}
            | {"kind": f"{r['task']}, {r['moment']}", "natural": r["natural"], "start": r["start"]}
            | {f"wrist_{axis}_m": v for axis, v in zip("xyz", r["wrist_m"], strict=True)}
            | {k: r[k] for k in ("elbow_radius_m", "natural_inside", "fit_error_m")}
            | {k: r[k] for k in ("effort_ratio", "coordinate_error")}
            | {
                "feasible_width": float(np.subtract(high, low).sum()),
                "feasible_low": min(low, default=np.nan),
                "feasible_high": max(high, default=np.nan),
                "counts": r["elbow_radius_m"] >= LEAST_RADIUS,
            }
        )
    return pd.DataFrame(rows)


def _variant(name: str, records: Sequence[dict[str, Any]]) -> pd.DataFrame:
    kept = [r for r in records if r["elbow_radius_m"] >= LEAST_RADIUS]
    observations = [from_record(r) for r in kept]
    criteria = list(observations[0].criteria) if observations else []
    fitted = [p for p in FITTED if name == BASE.name or p.name in OF_VARIANTS]
    said = left_out(observations, [*(Computed(k) for k in criteria), *fitted])
    rows = [
        {
            "variant": name,
            "predictor": predictor,
            "subject": o.subject,
            "side": o.side,
            "task": o.task,
            "moment": o.moment,
            "trial": o.trial,
            "kind": o.kind,
            "natural": o.natural,
            "predicted": angle,
            "error": float(angle_between(angle, o.natural)),
            "ok": ok,
            "status": sentence,
        }
        for predictor, column in said.items()
        for o, (angle, ok, sentence) in zip(observations, column, strict=True)
    ]
    return pd.DataFrame(rows)


def _names(records: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(r["variant"] for r in records))


def _provenance(plan: PredictionPlan, items: Sequence[Item]) -> Provenance:
    choices = {
        "model": "myoarm, scaled to each person",
        "limits": BASE.limits,
        "least_elbow_radius_m": LEAST_RADIUS,
        "sensitivity": plan.sensitivity,
    }
    inputs = {item.key: _files_hash(item.payload.plan) for item in items}
    return Provenance("predict", inputs=inputs, choices=choices)


def _files_hash(plan: PersonTrials) -> str:
    """Hash the contents of a person's files; missing ones count as empty."""
    return _hash([digest for _, digest in _file_hashes(plan)])


def _file_hashes(plan: PersonTrials) -> tuple[tuple[str, str], ...]:
    files = [t.path for t in plan.trials]
    if plan.calibration is not None:
        files += [plan.calibration.static, *plan.calibration.movements]
    files = list(dict.fromkeys(files))
    return tuple((p.name, hash_file(p) if p.is_file() else "") for p in files)


def _has_moments(trial: Trial, study: StudyFile) -> bool:
    return (trial.labels.condition or "") in study.moments


def _hash(parts: object) -> str:
    import hashlib

    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def _nothing(outcome: Outcome) -> None:
    pass
