"""Generated people who reach with known IK weights: the first experiment of [Khoramshahi2022].

DOI 10.1371/journal.pone.0278228, section 4.2. The recordings of 17 people are not at hand; these
are of the same kind. Each person has weights drawn around the published contributions, and moves
by eq. 2,

    q̇ = J#(W) ẋ + N(W) (b∘(q - q_ref) + noise),

with ẋ a minimum-jerk reach whose end, timing and bow vary from trial to trial. The posture-driven
part and the noise are what makes the null space busy; both are stronger in the viscous condition,
as the paper found. Since the weights are known, an estimator's bias can be measured.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.arms import exoskeleton
from selfmotion.kinematics.arm import Arm
from selfmotion.motion.labels import Frame, Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.redundancy.projection import project
from selfmotion.redundancy.task import Position

# Published contributions (section 5), as weights: w ∝ 1/β, largest = 1.
CONDITION_WEIGHTS = {
    "Natural": (1.0, 0.04 / 0.27, 0.04 / 0.65, 1.0),
    "Viscous": (1.0, 0.09 / 0.68, 0.09 / 0.14, 1.0),
}
# Posture from which all reaches start, and postures that put the hand at each target (rad). The
# elbow stays bent by 50° and more: near the straight elbow, joint velocities grow without bound.
START = (0.10, 0.0, 0.10, 1.50)
TARGET_POSTURES = {
    "high": (0.25, 0.10, 1.30, 0.95),
    "forward": (0.15, 0.05, 0.80, 1.00),
    "inward": (0.05, 0.75, 0.70, 1.15),
}
# Corner frequency of the null-space noise (Hz), of the order of voluntary movement.
NOISE_CORNER = 2.0


@dataclass(frozen=True)
class ReachingProtocol:
    """How many people reach how often, and how much they vary.

    Attributes:
        n_people: people.
        n_trials: reaches of each person to each target in each condition.
        n_samples: samples of a reach.
        step: time between samples (s).
        spread_person: standard deviation between people of a log-weight, in all conditions.
        spread_condition: the same, drawn anew in each condition.
        spread_length: standard deviation between people of arm length, as a share of it.
        target_scatter: standard deviation of the end point between trials (m).
        posture_rate: how fast the null space is drawn to the rest posture (1/s), by condition.
        noise: standard deviation of null-space noise at peak hand speed (rad/s), by condition.
    """

    n_people: int = 17
    n_trials: int = 20
    n_samples: int = 100
    step: float = 0.009
    spread_person: float = 0.30
    spread_condition: float = 0.35
    spread_length: float = 0.05
    target_scatter: float = 0.015
    posture_rate: tuple[tuple[str, float], ...] = (("Natural", 0.15), ("Viscous", 0.30))
    noise: tuple[tuple[str, float], ...] = (("Natural", 0.08), ("Viscous", 0.20))


@dataclass(frozen=True, eq=False)
class ReachingPerson:
    """One person.

    Attributes:
        name: as in the labels of the recordings.
        arm: the person's arm; lengths differ between people.
        weights: condition to true weights (4), the largest of the first three 1.
    """

    name: str
    arm: Arm
    weights: dict[str, Float[np.ndarray, " joints"]]


@dataclass(frozen=True, eq=False)
class SimulatedReaching:
    """Recordings of generated people with what generated them."""

    study: Study
    people: tuple[ReachingPerson, ...]


def simulate_reaching(
    protocol: ReachingProtocol | None = None, *, rng: np.random.Generator
) -> SimulatedReaching:
    """Generate people, and their reaches in each condition.

    Args:
        protocol: numbers and variability; left out: those of the experiment.
        rng: source of randomness.

    Example:
        >>> small = ReachingProtocol(n_people=1, n_trials=2)
        >>> len(simulate_reaching(small, rng=np.random.default_rng(1)).study)
        12
    """
    p = protocol or ReachingProtocol()
    people = tuple(_draw_person(i, p, rng) for i in range(p.n_people))
    recordings: list[Recording] = []
    for person in people:
        for condition in CONDITION_WEIGHTS:
            recordings += _reaches(person, condition, p, rng)
    return SimulatedReaching(Study(tuple(recordings)), people)


def _draw_person(i: int, p: ReachingProtocol, rng: np.random.Generator) -> ReachingPerson:
    typical_arm = exoskeleton()
    scale = 1.0 + p.spread_length * rng.standard_normal()
    lengths = [scale * length for length in typical_arm.lengths.values()]
    # Elevation counts positive away from the trunk, as in the paper, for a right arm.
    arm = exoskeleton(lengths, elevation_axis=(-1.0, 0.0, 0.0))
    trait = p.spread_person * rng.standard_normal(3)
    weights = {}
    for condition, typical in CONDITION_WEIGHTS.items():
        log_w = np.log(typical[:3]) + trait + p.spread_condition * rng.standard_normal(3)
        # The fourth joint is over-specified: its weight means nothing and is 1 by convention.
        weights[condition] = np.append(np.exp(log_w - log_w.max()), 1.0)
    return ReachingPerson(f"P{i + 1:02d}", arm, weights)


def _reaches(
    person: ReachingPerson, condition: str, p: ReachingProtocol, rng: np.random.Generator
) -> list[Recording]:
    """Generate all reaches of one person in one condition, side by side."""
    task = Position(person.arm)
    targets = [name for name in TARGET_POSTURES for _ in range(p.n_trials)]
    goals = task.value(np.array([TARGET_POSTURES[name] for name in targets]))
    start = np.array(START) + 0.03 * rng.standard_normal((len(targets), 4))
    goals = goals + p.target_scatter * rng.standard_normal(goals.shape)
    hand = hand_velocity(task.value(start), goals, p, rng)
    speed = np.linalg.norm(hand, axis=2)
    noise = dict(p.noise)[condition] * smooth_noise(hand.shape[1], 4, p, rng)
    noise *= (speed / speed.max(axis=0))[..., None]
    law = _Law(task, person.weights[condition], dict(p.posture_rate)[condition])
    q, qd, J = _integrate(law, start, hand, noise, p.step)
    time = p.step * np.arange(p.n_samples)
    return [
        Recording(
            time,
            q=q[:, i],
            qd=qd[:, i],
            xd=np.einsum("kij,kj->ki", J[:, i], qd[:, i]),
            jacobian=J[:, i],
            joints=person.arm.joints,
            labels=Labels(person.name, "right", condition, target, str(i % p.n_trials + 1)),
            frame=Frame(up="z", forward="x", name="shoulder"),
        )
        for i, target in enumerate(targets)
    ]


@dataclass(frozen=True, eq=False)
class _Law:
    """How a person turns hand velocity into joint velocity (eq. 2)."""

    task: Position
    weights: np.ndarray
    rate: float

    def velocity(
        self, q: np.ndarray, hand: np.ndarray, noise: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Give joint velocities (trials, n) and Jacobians (trials, 3, n)."""
        J = self.task.jacobian(q)
        p = project(J, self.weights)
        free = noise - self.rate * (q - np.array(START))
        return np.einsum("tij,tj->ti", p.inverse, hand) + np.einsum("tij,tj->ti", p.null, free), J


def _integrate(
    law: _Law, start: np.ndarray, hand: np.ndarray, noise: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Integrate by the midpoint rule; velocities and Jacobians are those at the samples."""
    q, qd = np.empty(noise.shape), np.empty(noise.shape)
    J = np.empty((*hand.shape, noise.shape[2]))
    posture = start
    for k in range(len(hand)):
        q[k] = posture
        qd[k], J[k] = law.velocity(posture, hand[k], noise[k])
        after = min(k + 1, len(hand) - 1)
        halfway = posture + 0.5 * step * qd[k]
        middle, _ = law.velocity(
            halfway, 0.5 * (hand[k] + hand[after]), 0.5 * (noise[k] + noise[after])
        )
        posture = posture + step * middle
    return q, qd, J


def hand_velocity(
    start: Float[np.ndarray, "trials 3"],
    goals: Float[np.ndarray, "trials 3"],
    p: ReachingProtocol,
    rng: np.random.Generator,
) -> Float[np.ndarray, "samples trials 3"]:
    """Give minimum-jerk hand velocities (m/s) with a bow that differs from trial to trial."""
    time = p.step * np.arange(p.n_samples)[:, None]
    length = p.step * p.n_samples
    onset = rng.uniform(0.02, 0.10, len(start)) * length
    duration = rng.uniform(0.75, 0.88, len(start)) * length
    s = np.clip((time - onset) / duration, 0.0, 1.0)
    along = 30.0 * s**2 * (1.0 - s) ** 2 / duration  # derivative of the minimum-jerk polynomial
    way = goals - start
    # The bow returns to the straight line: its velocity integrates to zero over the reach.
    sideways = np.cross(way, rng.standard_normal(way.shape))
    bow = 0.15 * sideways * rng.standard_normal((len(start), 1))
    return along[..., None] * way + (along * np.cos(np.pi * s))[..., None] * bow


def smooth_noise(
    n_trials: int, n_joints: int, p: ReachingProtocol, rng: np.random.Generator
) -> Float[np.ndarray, "samples trials joints"]:
    """Give noise of unit variance whose spectrum falls off above `NOISE_CORNER`."""
    keep = np.exp(-2.0 * np.pi * NOISE_CORNER * p.step)
    white = rng.standard_normal((p.n_samples, n_trials, n_joints))
    out = np.empty_like(white)
    out[0] = white[0]
    for k in range(1, p.n_samples):
        out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep**2) * white[k]
    return out
