"""A whole study: every file to joint motion, every person's weights, tables and tests.

Trials run in a batch with a journal, so that an interrupted run goes on where it was; a broken
file has a row that says why, and the rest goes on.
"""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion._version import __version__
from selfmotion.batch import Item, Outcome, Runner, run_batch
from selfmotion.errors import FileFormatError, SelfmotionError
from selfmotion.methods.identification import MotionArrays, identify_weights_from_arrays
from selfmotion.methods.uncontrolled_manifold import manifold_variance
from selfmotion.methods.velocity_split import split
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.methods.weights.options import DEFAULT_OPTIONS, Method
from selfmotion.methods.weights.series import estimate_each
from selfmotion.motion.files.npz import read_npz
from selfmotion.motion.recording import Recording, Study
from selfmotion.provenance import Provenance, hash_arrays, hash_file
from selfmotion.studies.kept_estimates import KeptEstimates
from selfmotion.studies.study_file import StudyFile, Trial, find_trials
from selfmotion.studies.study_statistics import Key, compare_all
from selfmotion.studies.study_summary import StudySummary, summarise
from selfmotion.studies.trial_run import CURVE, CURVE_POINTS, TrialJob, plan_people, run_trial

JOURNAL = "journal.jsonl"
ESTIMATES = "estimates.jsonl"
MOVEMENTS = "movements"
# Few targets make flat likelihoods, on which the estimator needs more than its usual 100 steps.
MAX_ITERATIONS = 200
# Condition of the weights of all conditions together.
POOLED = "all conditions"


@dataclass(frozen=True, eq=False)
class StudyRun:
    """What came of a study.

    Attributes:
        trials: one row a file: labels, whether it could be used, why not, measures.
        groups: one row a person, side and condition: task and null-space shares, synergy.
        weights: one row a person, side, condition and joint.
        tests: paired tests, or the sentence why there is none.
        changes: mean change of each log-weight over people, with t-intervals.
        swivel: angle over 0 to 100 % of each movement, one row a trial and percent (deg).
        summary: over people: swivel angle at its moments, shares, weights, quality.
        estimates: of each person, side and condition.
        pooled: of each person and side with all conditions together; empty where there is one.
        movements: all movements that could be used.
        provenance: files, versions and choices.
    """

    trials: pd.DataFrame
    groups: pd.DataFrame
    weights: pd.DataFrame
    tests: pd.DataFrame
    changes: pd.DataFrame
    swivel: pd.DataFrame
    summary: StudySummary
    estimates: Mapping[Key, WeightEstimate]
    pooled: Mapping[Key, WeightEstimate]
    movements: Study
    provenance: Provenance

    @property
    def n_failed(self) -> int:
        """Number of files that could not be used."""
        return int(np.count_nonzero(~self.trials["ok"].to_numpy(dtype=bool)))


@dataclass(frozen=True)
class StudyPlan:
    """What to run.

    Attributes:
        folders: where the recordings are.
        study: how they are named and read.
        arm: name or model file.
        method: estimator of the weights.
        out: folder of movements and journal; None: a temporary one, and nothing to resume.
        seed: of the sign flips, where not all can be tried.
    """

    folders: tuple[Path, ...]
    study: StudyFile
    arm: str
    method: Method = "ml"
    out: Path | None = None
    seed: int = 0


def run_study(
    plan: StudyPlan,
    runner: Runner | None = None,
    *,
    on_start: Callable[[int], Callable[[Outcome], None]] | None = None,
) -> StudyRun:
    """Run a study from its files to its statistics.

    Args:
        plan: what to run.
        runner: processes, cluster, resume; its journal is set here.
        on_start: is told the number of trials and gives what to call as each is completed.

    Raises:
        FileFormatError: no file, or none that could be used.

    Example:
        >>> from selfmotion.arms import planar
        >>> from selfmotion.motion.files.angles_csv import write_angles_csv
        >>> from selfmotion.studies.study_file import StudyFile
        >>> rng, t = np.random.default_rng(0), np.linspace(0.0, 1.0, 60)[:, None]
        >>> folder = Path(tempfile.mkdtemp())
        >>> for k in range(2):
        ...     q = 0.5 + 0.3 * np.sin(3.0 * t + rng.uniform(0.0, 6.0, 3))
        ...     one = Recording(t[:, 0], q=q, joints=planar().joints)
        ...     _ = write_angles_csv(folder / f"P1_{k}.csv", [one])
        >>> study = StudyFile(r"(?P<subject>P1)_(?P<trial>[0-9])[.]csv", cutoff=0)
        >>> run = run_study(StudyPlan((folder,), study, "planar"))
        >>> run.n_failed, run.groups["trials"].tolist()
        (0, [2])
    """
    trials = find_trials(plan.study, plan.folders)
    done = on_start(len(trials)) if on_start else lambda outcome: None
    chosen = runner or Runner()
    if plan.out is not None:
        return _run(
            plan, trials, replace(chosen, journal=plan.out / JOURNAL, on_done=done), plan.out
        )
    with tempfile.TemporaryDirectory() as folder:
        return _run(plan, trials, replace(chosen, journal=None, on_done=done), Path(folder))


def _run(plan: StudyPlan, trials: Sequence[Trial], runner: Runner, folder: Path) -> StudyRun:
    jobs = trial_jobs(plan, trials, folder / MOVEMENTS)
    hashes: dict[Path, str] = {}
    items = [Item(job.trial.key, job, _fingerprint(plan, job, hashes)) for job in jobs]
    outcomes = run_batch(run_trial, items, runner)
    table, curves = trial_table(trials, outcomes)
    usable = [job.target for job, o in zip(jobs, outcomes, strict=True) if o.status.ok]
    if not usable:
        first = outcomes[0]
        raise FileFormatError(
            f"none of {len(outcomes)} files could be used; the first: {first.key}: {first.status}"
        )
    movements = Study(tuple(r for path in usable for r in read_npz(path)))
    path = None if plan.out is None else plan.out / ESTIMATES
    kept = KeptEstimates.open(path, resume=runner.resume)
    estimates = estimate_groups(movements, plan.method, kept)
    pooled = estimate_pooled(movements, plan.method, kept)
    groups = group_table(movements, estimates)
    tests, changes = compare_all(estimates, rng=np.random.default_rng(plan.seed))
    inputs = {t.key: hashes[t.path] for t in trials if t.path in hashes}
    choices = {
        "arm": plan.arm,
        "method": plan.method,
        "static": plan.study.static,
        "protocol": plan.study.protocol if plan.study.static else None,
        "cutoff_hz": plan.study.smoothing,
        "centres": plan.study.centres if plan.study.static else None,
        "task": plan.study.task or None,
        "landmark": plan.study.landmark,
        "rest_share": plan.study.rest_share,
    }
    return StudyRun(
        table,
        groups,
        weights_by_group({**estimates, **pooled}),
        tests,
        changes,
        curves,
        summarise(table, groups, pooled or estimates),
        estimates,
        pooled,
        movements,
        Provenance("run_study", inputs=inputs, seed=plan.seed, choices=choices),
    )


def trial_jobs(plan: StudyPlan, trials: Sequence[Trial], folder: Path) -> list[TrialJob]:
    """Say what is to be done with each trial; trials of one arm of a person share a calibration."""
    jobs = [
        TrialJob(t, plan.study, plan.arm, folder / (t.key + ".npz"), person.calibration)
        for person in plan_people(trials)
        for t in person.trials
    ]
    order = {trial.key: i for i, trial in enumerate(trials)}
    return sorted(jobs, key=lambda job: order[job.trial.key])


def trial_table(
    trials: Sequence[Trial], outcomes: Sequence[Outcome]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Give one row a file, in order: labels, status, measures; and the swivel curves, long."""
    rows, curves = [], []
    percent = np.linspace(0.0, 100.0, CURVE_POINTS)
    for trial, outcome in zip(trials, outcomes, strict=True):
        state = {"file": trial.key, "ok": outcome.status.ok, "status": outcome.status.sentence}
        measures = dict(outcome.result or {})
        curve = measures.pop(CURVE, None)
        rows.append(trial.labels.to_dict() | state | measures)
        if curve is not None:
            angle = np.array(curve, dtype=float)
            values = {"file": trial.key, "percent": percent, "swivel_deg": angle}
            curves.append(pd.DataFrame(trial.labels.to_dict() | values))
    whole = pd.concat(curves, ignore_index=True) if curves else pd.DataFrame()
    return pd.DataFrame(rows), whole


def estimate_groups(
    movements: Study, method: Method, kept: KeptEstimates | None = None
) -> dict[Key, WeightEstimate]:
    """Identify the weights of each person, side and condition, all trials pooled.

    Estimates that are kept from an interrupted run are taken from there, and new ones are kept.
    """
    groups = movements.group("subject", "side", "condition")
    return _estimates({_key(k): tuple(part) for k, part in groups.items()}, method, kept)


def estimate_pooled(
    movements: Study, method: Method, kept: KeptEstimates | None = None
) -> dict[Key, WeightEstimate]:
    """Identify the weights of each person and side with all conditions together.

    More targets excite more of the ratios. The condition of their keys is `POOLED`; a person with
    one condition only has no entry, since that would be the same numbers again.
    """
    groups = {
        _key((*k, POOLED)): tuple(part)
        for k, part in movements.group("subject", "side").items()
        if len({r.labels.condition for r in part}) > 1
    }
    return _estimates(groups, method, kept)


def _key(labels: Sequence[str | None]) -> Key:
    subject, side, condition = (str(value or "") for value in labels)
    return subject, side, condition


def _estimates(
    groups: Mapping[Key, tuple[Recording, ...]], method: Method, kept: KeptEstimates | None
) -> dict[Key, WeightEstimate]:
    limit = None if method == "paper" else MAX_ITERATIONS
    options = replace(DEFAULT_OPTIONS, hash_inputs=False, max_iterations=limit)
    store = kept or KeptEstimates()

    def identify(part: Study) -> WeightEstimate:
        # One array each for all trials: many short trials run several times faster so.
        joined = MotionArrays(
            qd=np.concatenate([r.array("qd") for r in part]),
            jacobian=np.concatenate([r.array("jacobian") for r in part]),
            trial=np.repeat(np.arange(len(part)), [r.n_samples for r in part]),
            q=np.concatenate([r.array("q") for r in part]) if method == "feedback" else None,
            joints=part.joints,
            name=part[0].name,
        )
        arrays = [a for a in (joined.qd, joined.jacobian, joined.trial, joined.q) if a is not None]
        known = f"{__version__} {method} {options} {joined.joints}"
        fingerprint = f"{hash_arrays(*map(np.asarray, arrays))} {known}"
        found = store.recall(fingerprint)
        if found is None:
            found = identify_weights_from_arrays(joined, method=method, options=options)
            store.keep(fingerprint, found)
        return found

    names = {"\n".join(key): key for key in groups}
    found = estimate_each({name: groups[key] for name, key in names.items()}, identify, method)
    return {names[name]: estimate for name, estimate in found.items()}


def weights_by_group(estimates: Mapping[Key, WeightEstimate]) -> pd.DataFrame:
    """Give one row a person, side, condition and joint."""
    tables = []
    for (subject, side, condition), estimate in estimates.items():
        table = estimate.to_frame()
        for place, (name, value) in enumerate(
            (("subject", subject), ("side", side), ("condition", condition))
        ):
            table.insert(place, name, value)
        table["status"] = estimate.status.sentence
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def group_table(movements: Study, estimates: Mapping[Key, WeightEstimate]) -> pd.DataFrame:
    """Give one row a person, side and condition: shares of velocity, and synergy over repeats.

    `task_share_others` takes the weights of the same arm in its other conditions, one after the
    other: movements to which those weights were not fitted.
    """
    rows = []
    for labels, part in movements.group("subject", "side", "condition").items():
        key = _key(labels)
        estimate = estimates[key]
        row: dict[str, object] = dict(zip(("subject", "side", "condition"), key, strict=True))
        row |= {"trials": len(part), "samples": part.n_samples}
        for name, weights in (("", estimate.full_weights), ("_identity", None)):
            row |= {
                f"task_share{name}": _mean_share(part, weights),
                f"unexplained{name}": getattr(estimate, f"unexplained{name}"),
            }
        others = [
            _mean_share(part, other.full_weights)
            for k, other in estimates.items()
            if k[:2] == key[:2] and k != key
        ]
        known = [share for share in others if np.isfinite(share)]
        row["task_share_others"] = float(np.mean(known)) if known else float("nan")
        row |= _synergy(part) | {"status": estimate.status.sentence}
        rows.append(row)
    return pd.DataFrame(rows)


def _mean_share(part: Study, weights: np.ndarray | None) -> float:
    if weights is not None and not np.isfinite(weights).all():
        return float("nan")
    return float(np.nanmean([split(recording, weights=weights).task_share for recording in part]))


def _synergy(part: Study) -> dict[str, object]:
    """Give the mean over the movement of the synergy index and its z-transform."""
    try:
        found = manifold_variance(part)
    except SelfmotionError as error:
        return {"synergy": float("nan"), "synergy_z": float("nan"), "synergy_status": str(error)}
    whole = found.synergy_z[np.isfinite(found.synergy_z)]
    return {
        "synergy": float(np.nanmean(found.synergy)),
        "synergy_z": float(whole.mean()) if whole.size else float("nan"),
        "synergy_status": "",
    }


def _fingerprint(plan: StudyPlan, job: TrialJob, hashes: dict[Path, str]) -> str:
    """Give what a trial's result depends on: files, study file, arm; and whether it is there."""
    files = [job.trial.path]
    if job.calibration is not None:
        files += [job.calibration.static, *job.calibration.movements]
    for path in files:
        if path not in hashes:
            hashes[path] = hash_file(path) if path.is_file() else "missing"
    settings = {**asdict(plan.study), "arm": plan.arm}
    made = "" if job.target.is_file() else " (not there)"
    version = Provenance("run_study").version
    return f"{version} {' '.join(hashes[p] for p in files)} {settings}{made}"
