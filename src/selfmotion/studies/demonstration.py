"""The demonstration: generated people who reach, analysed like anybody's recordings."""

from dataclasses import dataclass

import numpy as np

from selfmotion.methods.uncontrolled_manifold import ManifoldVariance, manifold_variance
from selfmotion.motion.recording import Recording, Study
from selfmotion.studies.reaching_study import ReachingResult, analyse_reaching
from selfmotion.studies.simulated_people import (
    ReachingProtocol,
    SimulatedReaching,
    simulate_reaching,
)

# Enough people for a test of two log-ratios, few enough to be done in seconds.
PROTOCOL = ReachingProtocol(n_people=8, n_trials=10)


@dataclass(frozen=True, eq=False)
class Demonstration:
    """What the demonstration shows.

    Attributes:
        made: the people, their true weights and their recordings.
        reaching: weights, test, null-space velocity, recovery.
        manifold: (subject, condition, target) to the variance over repetitions.
    """

    made: SimulatedReaching
    reaching: ReachingResult
    manifold: dict[tuple[str | None, ...], ManifoldVariance]

    @property
    def study(self) -> Study:
        """The recordings."""
        return self.made.study


def demonstrate(*, seed: int = 0, protocol: ReachingProtocol = PROTOCOL) -> Demonstration:
    """Generate people and analyse them.

    Args:
        seed: of everything random.
        protocol: how many people, how often.

    Example:
        >>> small = ReachingProtocol(n_people=3, n_trials=4)
        >>> sorted(demonstrate(protocol=small).reaching.beta["ml"])
        ['Natural', 'Viscous']
    """
    people, checks = np.random.default_rng(seed).spawn(2)
    made = simulate_reaching(protocol, rng=people)
    truth = {(p.name, c): w for p in made.people for c, w in p.weights.items()}
    groups = made.study.group("subject", "condition", "target")
    return Demonstration(
        made,
        analyse_reaching(made.study, truth=truth, rng=checks, methods=("ml",)),
        {key: manifold_variance(part) for key, part in groups.items()},
    )


def angles_only(study: Study) -> Study:
    """Keep time, joint angles and labels, as a laboratory exports them, for ``exoskeleton``.

    Generated people count shoulder elevation positive away from the trunk, the arm
    ``exoskeleton`` the other way round.
    """
    sign = np.array([-1.0, 1.0, 1.0, 1.0])
    return Study(
        tuple(
            Recording(
                r.time,
                q=(r.array("q") * sign).round(6),
                joints=r.joints,
                labels=r.labels,
                frame=r.frame,
            )
            for r in study
        )
    )
