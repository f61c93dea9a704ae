"""Experiment 2 of [Khoramshahi2022] section 4.3: the elbow on the screen, in four conditions.

DOI 10.1371/journal.pone.0278228, Fig 9 and Table 1. The same analysis runs on generated people
and on the published recordings (S2 Dataset), whose velocities and Jacobians the reader makes from
angles and hand path.

In Locked the elbow never moves: two joints are left for two task rows, no redundancy remains, and
no data can tell hip from shoulder. Algorithm 1 prints numbers nevertheless; maximum likelihood
says that nothing is identified. In Coupled the motion fills a plane, and weights may run to zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.arms import hip_shoulder_elbow
from selfmotion.errors import ShapeError
from selfmotion.methods.identification import Method
from selfmotion.motion.recording import Study
from selfmotion.studies.results import Recovery
from selfmotion.studies.simulated_screen import ScreenProtocol, simulate_screen
from selfmotion.studies.weight_tables import (
    LONG_RUN,
    SHORT_RUN,
    Key,
    identify_each,
    mean_contribution,
    recovery,
    weight_table,
)

GAMMA = 0.9
# Only here does a person choose all three joints, so that true weights exist.
FREE_CONDITION = "Natural"


@dataclass(frozen=True, eq=False)
class ScreenResult:
    """What experiment 2 gives.

    Attributes:
        study: the recordings, with qd and jacobian.
        generated: whether the people are generated.
        weights: table of all estimators (`weight_tables.weight_table`).
        beta: estimator to condition to mean β (3).
        truth: (subject, "Natural") to true weights; empty for recorded people.
        recovery: identified against true; None for recorded people.
        miss: median distance to the target at the end of its time, by condition (m); None for
            recorded people.
    """

    study: Study
    generated: bool
    weights: pd.DataFrame
    beta: dict[str, dict[str, Float[np.ndarray, " joints"]]]
    truth: dict[Key, Float[np.ndarray, " joints"]]
    recovery: Recovery | None
    miss: dict[str, float] | None

    @property
    def conditions(self) -> tuple[str, ...]:
        """The conditions, as in the labels."""
        return tuple(str(c) for c in self.study.values("condition"))


def experiment_2(
    *,
    rng: np.random.Generator,
    protocol: ScreenProtocol | None = None,
    paper_iterations: int = SHORT_RUN,
) -> ScreenResult:
    """Generate people at the screen, and analyse them as the paper does."""
    made = simulate_screen(hip_shoulder_elbow(), protocol, rng=rng)
    people = [str(s) for s in made.study.values("subject")]
    truth = {(name, FREE_CONDITION): w for name, w in zip(people, made.weights, strict=True)}
    result = analyse_screen(made.study, truth=truth, paper_iterations=paper_iterations)
    names = result.conditions
    miss = {name: float(np.median(row)) for name, row in zip(names, made.miss, strict=True)}
    return replace(result, miss=miss)


def analyse_screen(
    study: Study,
    *,
    truth: Mapping[Key, Float[np.ndarray, " joints"]] | None = None,
    paper_iterations: int = LONG_RUN,
) -> ScreenResult:
    """Identify weights for each person and condition.

    Args:
        study: recordings with q, qd and jacobian, labelled by subject and condition.
        truth: true weights of generated people.
        paper_iterations: where Algorithm 1 is stopped at the latest.

    Raises:
        ShapeError: the chain does not have three joints.
    """
    if len(study.joints) != 3:
        raise ShapeError(f"experiment 2: {len(study.joints)} joints; the chain has 3")
    methods: tuple[Method, ...] = ("ml", "paper", "feedback")
    estimates = {
        m: identify_each(study, method=m, null_ratio=GAMMA, paper_iterations=paper_iterations)
        for m in methods
    }
    tables = {m: weight_table(one) for m, one in estimates.items()}
    ratios = ((2, 0), (1, 0))
    return ScreenResult(
        study=study,
        generated=truth is not None,
        weights=pd.concat(tables.values(), ignore_index=True),
        beta={m: mean_contribution(table, study.joints) for m, table in tables.items()},
        truth=dict(truth or {}),
        recovery=recovery(list(estimates.values()), truth, ratios) if truth else None,
        miss=None,
    )
