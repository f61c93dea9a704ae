"""Every number of [Tommasino2017] beside ours, for `reproduce tommasino2017`.

DOI 10.3389/fnbot.2017.00065. Fig. 3 is computed again; Figs 5 to 8 run on simulated people, each
fitted to their own postures with the population as a prior, because the recordings and Tables 1
and 2 are not at hand and postures within ±15° do not tell the stiffness of pronation.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.arms import wrist
from selfmotion.errors import RangeError
from selfmotion.methods.curvature import LEVEL
from selfmotion.methods.donders import ElasticityPrior, JointElasticity, fit_elasticity
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.methods.passive.settings import PlanSettings
from selfmotion.motion.recording import Study
from selfmotion.provenance import Provenance
from selfmotion.redundancy.task import Pointing
from selfmotion.studies.center_out import (
    NAMES,
    CenterOut,
    MotorNoise,
    predicted,
    simulate,
    simulated_law,
)
from selfmotion.studies.published import KIND, SAME, TREND, Ours, Published, beside
from selfmotion.studies.tommasino2017 import (
    LABELS,
    Comparison,
    Movements,
    compare,
    hysteresis,
    measure_planned,
)

if TYPE_CHECKING:
    import pandas as pd

# Constant of the spring in Fig. 3 (N m/rad).
FIG_3_SPRING = 22.5
# Directions in which Fig. 3 shows hysteresis.
DIAGONALS = ("NE", "NW", "SW", "SE")
# Samples a fit uses, at most: thousands of neighbours at 120 Hz tell little more.
MAX_POSTURES = 1500
# What is known of the simulated people beforehand: standard deviations of their laws.
STIFFNESS_SD, REST_SD = 0.12, np.radians(5.0)

TOMMASINO2017 = (
    Published("damping", "eq. 9", "diagonal of W = τ₀ Kᴶ", (0.04, 0.12, 0.16), "N·m·s/rad"),
    Published("spring", "Fig 3", "constant k of the task's spring", (FIG_3_SPRING,), "N·m/rad"),
    Published("hysteresis", "Fig 3", "NE, NW, SW, SE show hysteresis", (True,)),
    Published("bell", "Fig 3", "speed has one peak, within the movement", (True,)),
    Published("curved", "Section 3", "share of movements with A_sum ≠ 0", (1.0,)),
    Published("net", "Fig 5", "movements of 16 with A_net ≠ 0, subjects 1 and 2", (2.0, 4.0)),
    Published("loops", "Fig 5", "targets of 8 with hysteresis, subjects 1 and 2", (1.0, 5.0)),
    Published(
        "captured",
        "Fig 6",
        "share of the 16 movements that the model captures, subjects 1 to 6",
        (0.37, 1.0, 0.70, 0.62, 0.50, 0.56),
    ),
)


@dataclass(frozen=True, eq=False)
class Person:
    """One simulated person of the experiment.

    Attributes:
        law: the law that made the movements.
        study: the recordings.
        fit: what the postures say of the law.
        comparison: movements beside those that the fitted law predicts.
    """

    law: JointLaw
    study: Study
    fit: JointElasticity
    comparison: Comparison


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The paper, computed again.

    Attributes:
        table: each published number beside ours.
        figure_3: the planned movements of the paper's Fig. 3.
        people: the simulated people of Figs 5 to 8.
        provenance: seed and protocol.
    """

    table: "pd.DataFrame"
    figure_3: PlannedMotion
    people: tuple[Person, ...]
    provenance: Provenance

    def to_frame(self) -> "pd.DataFrame":
        """Give the table."""
        return self.table


def figure_3_law() -> JointLaw:
    """Give the law of the paper's Fig. 3 (eq. 9)."""
    return JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))


def population_prior() -> ElasticityPrior:
    """Give what is known of the simulated people before they move."""
    return ElasticityPrior(
        figure_3_law().stiffness,
        np.full((3, 3), STIFFNESS_SD),
        figure_3_law().rest,
        np.full(3, REST_SD),
        "population of simulated people",
    )


def fit_person(study: Study, *, prior: ElasticityPrior | None = None) -> JointElasticity:
    """Fit the law of a person to all postures of a study, movements as dependent groups.

    Args:
        study: recordings with joint angles of the wrist.
        prior: as for `fit_elasticity`.
    """
    q = np.concatenate([recording.array("q") for recording in study])
    trials = np.repeat(np.arange(len(study)), [recording.n_samples for recording in study])
    every = max(1, len(q) // MAX_POSTURES)
    return fit_elasticity(q[::every], trials=trials[::every], prior=prior)


def experiment(
    rng: np.random.Generator, *, protocol: CenterOut | None = None, noise: MotorNoise | None = None
) -> Person:
    """Draw a person, let them do the experiment, fit their law and compare."""
    law = simulated_law(rng)
    study = simulate(law, rng, protocol=protocol, noise=noise)
    fit = fit_person(study, prior=population_prior())
    return Person(law, study, fit, compare(study, fit.law(), protocol))


def reproduce_tommasino2017(
    seed: int = 0, *, n_people: int = 6, protocol: CenterOut | None = None
) -> Reproduction:
    """Compute the numbers of [Tommasino2017] again.

    Args:
        seed: of the simulated people.
        n_people: the paper's six.
        protocol: trials, duration and settings.

    Raises:
        RangeError: fewer than one person.
    """
    if n_people < 1:
        raise RangeError(f"n_people = {n_people}: at least 1")
    figure_3 = predicted(figure_3_law(), CenterOut(settings=PlanSettings(spring=FIG_3_SPRING)))
    people = tuple(
        experiment(np.random.default_rng([seed, i]), protocol=protocol) for i in range(n_people)
    )
    ours = (*_of_figure_3(figure_3), *_of_people(people))
    provenance = Provenance(
        "reproduce_tommasino2017", seed=seed, choices={"n_people": n_people, "prior": "population"}
    )
    return Reproduction(beside(TOMMASINO2017, ours), figure_3, people, provenance)


def _of_figure_3(motion: PlannedMotion) -> tuple[Ours, ...]:
    found = measure_planned(motion)
    ratio = diagonal_ratio(found)
    loops = {name: abs(hysteresis(found, name)[0]) for name in NAMES}
    wide = bool(
        min(loops[n] for n in DIAGONALS) > 3.0 * max(loops[n] for n in NAMES if n not in DIAGONALS)
    )
    speed = motion.speed
    rising = np.diff(speed, axis=1) > 1e-12
    single = bool(((rising[:, 1:] & ~rising[:, :-1]).sum(axis=1) == 0).all())
    W = figure_3_law().damping
    J = Pointing(wrist()).jacobian(np.zeros(3))[0]
    task_damping = np.linalg.eigvalsh(np.linalg.inv(J @ np.linalg.solve(W, J.T)))
    return (
        Ours("damping", tuple(W.diagonal().tolist()), SAME, "by eq. 7"),
        Ours(
            "spring",
            (float(task_damping[-1]) / figure_3_law().damping_time,),
            SAME,
            "by eq. 10 with b_max at the centre: the paper contradicts itself by a factor of ten; "
            "Fig 3 is drawn with the printed constant",
        ),
        Ours(
            "hysteresis",
            (wide,),
            TREND,
            f"diagonal movements curve {ratio:.1f} times as much as cardinal ones",
        ),
        Ours("bell", (single,), TREND, "by the growing spring of eq. 8"),
    )


def _of_people(people: tuple[Person, ...]) -> tuple[Ours, ...]:
    found = [person.comparison for person in people]
    curved = np.mean([one.sum_tests.p < LEVEL for one in found])
    other = "other people, of whom the number depends; before correction, as in the paper"
    return (
        *(
            Ours(key, tuple(float((tests.p < LEVEL).sum()) for tests in some[:2]), KIND, other)
            for key, some in (
                ("net", [one.net_tests for one in found]),
                ("loops", [one.hysteresis_tests for one in found]),
            )
        ),
        Ours(
            "captured",
            tuple(one.captured for one in found),
            KIND,
            "made by the model that is fitted to them; fewer trials and more noise capture more",
        ),
        Ours(
            "curved",
            (float(curved),),
            KIND,
            "A_sum cannot be negative: the test cannot fail and says nothing",
        ),
    )


def diagonal_ratio(movements: Movements) -> float:
    """Give mean |A_net| of diagonal movements over that of cardinal ones."""
    size = np.array([abs(movements.net[movements.of(*label.split())]).mean() for label in LABELS])
    diagonal = np.array([label.split()[0] in DIAGONALS for label in LABELS])
    return float(size[diagonal].mean() / size[~diagonal].mean())
