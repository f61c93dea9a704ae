"""Experiment 1 of [Khoramshahi2022] section 4.2: reaching with and without a viscous field.

DOI 10.1371/journal.pone.0278228. The same analysis runs on generated people, whose weights are
known, and on the published recordings (S1 Dataset). Two deviations: the test of Fig 6 is made on
log-ratios, because weights scaled to a maximum of one are compositional and would give a result
that depends on the reference joint; and beside Algorithm 1 the weights are identified by maximum
likelihood, which is what the test and the null-space velocities rest on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.errors import ShapeError
from selfmotion.methods.hotelling import HotellingTest, hotelling_paired
from selfmotion.methods.identification import Method
from selfmotion.methods.velocity_split import VelocityBands
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.motion.recording import Study
from selfmotion.studies.results import NullSpeeds, Recovery
from selfmotion.studies.simulated_people import ReachingProtocol, simulate_reaching
from selfmotion.studies.velocity_profiles import bands_by, null_speeds
from selfmotion.studies.weight_tables import (
    LONG_RUN,
    SHORT_RUN,
    Key,
    identify_each,
    mean_contribution,
    recovery,
    weight_table,
)

# The paper's rule of thumb for real movements.
GAMMA = 0.9
# Log-ratios to the first joint that the test of Fig 6 compares.
TESTED_RATIOS = ((1, 0), (2, 0))


@dataclass(frozen=True, eq=False)
class ReachingResult:
    """What experiment 1 gives.

    Attributes:
        study: the recordings.
        generated: whether the people are generated.
        weights: table of all estimators (`weight_tables.weight_table`).
        beta: estimator to condition to mean β (n).
        test: Hotelling's paired test of the log-ratios, or None with too few people.
        velocities: joint velocities of one person, by target and condition (Fig 5).
        shown: the person of `velocities`.
        null: null-space velocities toward the first target (Fig 7).
        truth: (subject, condition) to true weights; empty for recorded people.
        recovery: identified against true; None for recorded people.
    """

    study: Study
    generated: bool
    weights: pd.DataFrame
    beta: dict[str, dict[str, Float[np.ndarray, " joints"]]]
    test: HotellingTest | None
    velocities: dict[tuple[str, ...], VelocityBands]
    shown: str
    null: NullSpeeds
    truth: dict[Key, Float[np.ndarray, " joints"]]
    recovery: Recovery | None

    @property
    def conditions(self) -> tuple[str, ...]:
        """The two conditions, as in the labels."""
        return tuple(str(c) for c in self.study.values("condition"))


def experiment_1(
    *,
    rng: np.random.Generator,
    protocol: ReachingProtocol | None = None,
    paper_iterations: int = SHORT_RUN,
) -> ReachingResult:
    """Generate people who reach, and analyse them as the paper does."""
    made = simulate_reaching(protocol, rng=rng)
    truth = {(p.name, c): w for p in made.people for c, w in p.weights.items()}
    return analyse_reaching(made.study, truth=truth, rng=rng, paper_iterations=paper_iterations)


def analyse_reaching(
    study: Study,
    *,
    rng: np.random.Generator,
    truth: Mapping[Key, Float[np.ndarray, " joints"]] | None = None,
    methods: Sequence[Method] = ("ml", "paper", "feedback"),
    paper_iterations: int = LONG_RUN,
) -> ReachingResult:
    """Identify weights for each person and condition, test the conditions, split velocities.

    Args:
        study: recordings with q, qd and jacobian, labelled by subject, condition, target, trial.
        rng: source of randomness of the permutation check.
        truth: true weights of generated people.
        methods: the estimators, ``ml`` among them.
        paper_iterations: where Algorithm 1 is stopped at the latest.

    Raises:
        ShapeError: the recordings do not have two conditions and at least three joints.
    """
    conditions = tuple(str(c) for c in study.values("condition"))
    if len(conditions) != 2 or len(study.joints) < 3:
        raise ShapeError(
            f"experiment 1: {len(conditions)} condition(s) and {len(study.joints)} joint(s); "
            "two conditions and at least 3 joints are needed"
        )
    estimates = {
        m: identify_each(study, method=m, null_ratio=GAMMA, paper_iterations=paper_iterations)
        for m in methods
    }
    tables = {m: weight_table(one) for m, one in estimates.items()}
    full = {key: e.full_weights for key, e in estimates["ml"].items()}
    target = study.values("target")[0]
    first = study if target is None else study.select(target=target)
    person = str(study.values("subject")[0])
    return ReachingResult(
        study=study,
        generated=truth is not None,
        weights=pd.concat(tables.values(), ignore_index=True),
        beta={m: mean_contribution(table, study.joints) for m, table in tables.items()},
        test=_test(estimates["ml"], conditions, rng),
        velocities=bands_by(study.select(subject=person), "target", "condition"),
        shown=person,
        null=null_speeds(first, full),
        truth=dict(truth or {}),
        recovery=recovery(list(estimates.values()), truth, TESTED_RATIOS) if truth else None,
    )


def _test(
    estimates: Mapping[Key, WeightEstimate],
    conditions: tuple[str, ...],
    rng: np.random.Generator,
) -> HotellingTest | None:
    """Compare the log-ratios of the two conditions, person by person."""
    subjects = dict.fromkeys(subject for subject, _ in estimates)
    pairs = [
        [_log_ratios(estimates[s, c]) for c in conditions]
        for s in subjects
        if all((s, c) in estimates for c in conditions)
    ]
    values = np.array(pairs)  # people, conditions, ratios
    known = values[np.isfinite(values).all(axis=(1, 2))] if len(values) else values
    if len(known) <= len(TESTED_RATIOS):
        return None
    return hotelling_paired(known[:, 0], known[:, 1], rng=rng)


def _log_ratios(estimate: WeightEstimate) -> list[float]:
    names = estimate.joints
    return [estimate.log_ratio(names[i], names[j])[0] for i, j in TESTED_RATIOS]


def null_rms(null: NullSpeeds) -> dict[tuple[str, str], float]:
    """Put Fig 7 into numbers: mean rms null-space speed (rad/s) by condition and weights."""
    keys = dict.fromkeys(zip(null.table["condition"], null.table["weights"], strict=True))
    return {
        (str(condition), str(kind)): float(
            null.table.loc[
                (null.table["condition"] == condition) & (null.table["weights"] == kind), "rms"
            ].mean()
        )
        for condition, kind in keys
    }
