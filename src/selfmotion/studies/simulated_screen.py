"""Generated people at the screen of [Khoramshahi2022] section 4.3: 28 targets in four conditions.

DOI 10.1371/journal.pone.0278228. The chain, its elbow and the person are in `virtual_elbow`; here
they run through the protocol. Only in Natural does the person choose all three joints, so only
there can identified weights be held against true ones.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.kinematics.arm import Arm
from selfmotion.motion.labels import Frame, Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.redundancy.task import Planar
from selfmotion.studies.virtual_elbow import (
    CONDITIONS,
    OBEYS,
    AssistiveElbow,
    ScreenPerson,
    commanded_velocity,
)

# Corner frequency of the noise of the person's joint velocities (Hz).
NOISE_CORNER = 2.0


@dataclass(frozen=True)
class ScreenProtocol:
    """The experiment's numbers.

    Attributes:
        n_people: people.
        n_targets: targets, one after the other, the same for all.
        seconds: how long each is shown (s).
        step: time step of the simulation (s).
        record_every: so many steps make one sample of a recording.
        locked: angle of the locked elbow, and of every elbow at the start (rad).
        hip: postures that place the targets have the hip in this range (rad).
        shoulder: and the shoulder in this one (rad).
        person: how people move.
    """

    n_people: int = 10
    n_targets: int = 28
    seconds: float = 6.0
    step: float = 0.02
    record_every: int = 2
    locked: float = 1.2
    hip: tuple[float, float] = (-0.35, 0.25)
    shoulder: tuple[float, float] = (-2.6, -1.5)
    person: ScreenPerson = ScreenPerson()


@dataclass(frozen=True, eq=False)
class SimulatedScreen:
    """Recordings of generated people with what generated them.

    Attributes:
        study: one recording for each person, condition and target.
        weights: (people, 3) the weights by which the people choose among their own joints.
        targets: (targets, 2) positions (m).
        arm: the chain on the screen.
        miss: (conditions, people) median distance to the target at the end of its time (m).
    """

    study: Study
    weights: Float[np.ndarray, "people 3"]
    targets: Float[np.ndarray, "targets 2"]
    arm: Arm
    miss: Float[np.ndarray, "conditions people"]


def simulate_screen(
    arm: Arm, protocol: ScreenProtocol | None = None, *, rng: np.random.Generator
) -> SimulatedScreen:
    """Generate people, and their movements on the screen in each condition.

    Args:
        arm: the hip-shoulder-elbow chain.
        protocol: numbers and variability; left out: those of the experiment.
        rng: source of randomness.
    """
    p = protocol or ScreenProtocol()
    spread = p.person.spread * rng.standard_normal((p.n_people, 3))
    weights = np.exp(np.log(p.person.typical_weights) + spread)
    weights /= weights.max(axis=1, keepdims=True)
    postures = np.column_stack(
        [
            rng.uniform(*p.hip, p.n_targets),
            rng.uniform(*p.shoulder, p.n_targets),
            np.full(p.n_targets, p.locked),  # so that the locked chain reaches every target
        ]
    )
    targets = Planar(arm).value(postures)
    runs = _Runs(arm, weights, targets, p, rng)
    study = Study(tuple(runs.recordings()))
    ends = np.array([r.array("x")[-1] for r in study]).reshape(-1, p.n_targets, 2)
    miss = np.median(np.linalg.norm(ends - targets, axis=2), axis=1)
    return SimulatedScreen(study, weights, targets, arm, miss.reshape(len(CONDITIONS), -1))


class _Runs:
    """All people in all conditions, side by side (condition by condition), step by step."""

    def __init__(
        self,
        arm: Arm,
        weights: np.ndarray,
        targets: np.ndarray,
        protocol: ScreenProtocol,
        rng: np.random.Generator,
    ) -> None:
        n_people, n_conditions = len(weights), len(CONDITIONS)
        self.conditions = [c for c in CONDITIONS for _ in range(n_people)]
        self.people = [f"P{i + 1:02d}" for i in range(n_people)] * n_conditions
        self.obeys = np.array([OBEYS[c] for c in self.conditions])
        self.natural = np.array([c == "Natural" for c in self.conditions])
        self.assisted = np.array([c == "Assistive" for c in self.conditions])
        self.weights = np.tile(weights, (n_conditions, 1))
        self.arm, self.targets, self.p, self.rng = arm, targets, protocol, rng
        self.task, self.elbow = Planar(arm), AssistiveElbow()
        self.noise = np.zeros((len(self.people), 3))
        self.filtered = np.zeros((int(self.assisted.sum()), 2))
        self.hand = np.zeros((len(self.people), 2))  # velocity at the last step (m/s)
        self.fade = float(np.exp(-2.0 * np.pi * NOISE_CORNER * protocol.step))

    def recordings(self) -> list[Recording]:
        """Run, and give one recording for each person, condition and target."""
        p, n_runs = self.p, len(self.people)
        per_target = int(round(p.seconds / p.step))
        n_samples = per_target * len(self.targets)
        q, qd = np.empty((2, n_samples, n_runs, 3))
        x, J = np.empty((n_samples, n_runs, 2)), np.empty((n_samples, n_runs, 2, 3))
        posture = np.array([*p.person.comfort[:2], p.locked])
        posture = posture + 0.03 * self.rng.standard_normal((n_runs, 3)) * np.array([1, 1, 0])
        plan = _Plan.toward(self.targets[0], self.task.value(posture), p.person)
        for k in range(n_samples):
            x[k], J[k] = self.task.value(posture), self.task.jacobian(posture)
            if k % per_target == 0:
                plan = _Plan.toward(self.targets[k // per_target], x[k], p.person)
            q[k] = posture
            qd[k] = self._velocity(posture, x[k], J[k], plan.at((k % per_target) * p.step))
            posture = posture + p.step * qd[k]
        xd = np.einsum("kpij,kpj->kpi", J, qd)
        time = p.step * np.arange(0, per_target, p.record_every)
        made = []
        for i in range(n_runs):
            for target in range(len(self.targets)):
                at = slice(target * per_target, (target + 1) * per_target, p.record_every)
                labels = Labels(
                    subject=self.people[i], condition=self.conditions[i], target=str(target + 1)
                )
                made.append(
                    Recording(
                        time,
                        q=q[at, i],
                        qd=qd[at, i],
                        x=x[at, i],
                        xd=xd[at, i],
                        jacobian=J[at, i],
                        joints=self.arm.joints,
                        labels=labels,
                        frame=Frame(up="y", forward="x", name="screen"),
                    )
                )
        return made

    def _velocity(
        self, q: np.ndarray, x: np.ndarray, J: np.ndarray, plan: tuple[np.ndarray, np.ndarray]
    ) -> np.ndarray:
        """Give the velocities of the chain on the screen at one instant."""
        person = self.p.person
        where, speed = plan
        wanted = speed + person.correction * (where - x)
        drawn = -person.comfort_rate * (q - np.array(person.comfort))
        drawn[~self.natural, 2] = 0.0
        own = commanded_velocity(J @ self.obeys, self.weights, wanted, drawn, person.damping)
        fresh = self.rng.standard_normal(own.shape)
        self.noise = self.fade * self.noise + np.sqrt(1.0 - self.fade**2) * fresh
        own *= 1.0 + person.noise * self.noise
        chain = (self.obeys @ own[..., None])[..., 0]
        helped = self.assisted
        self.filtered = self.elbow.filter(self.filtered, self.hand[helped], self.p.step)
        chain[helped, 2] = self.elbow.velocity(J[helped], q[helped], self.filtered)
        chain[:, 2] = self.elbow.within_limits(q[:, 2], chain[:, 2], self.p.step)
        self.hand = np.einsum("kij,kj->ki", J, chain)
        return chain


@dataclass(frozen=True, eq=False)
class _Plan:
    """A minimum-jerk path from where the hand is to a target."""

    start: np.ndarray
    goal: np.ndarray
    duration: np.ndarray
    reaction: float

    @classmethod
    def toward(cls, goal: np.ndarray, hand: np.ndarray, person: ScreenPerson) -> "_Plan":
        distance = np.linalg.norm(goal - hand, axis=1)
        return cls(
            hand, goal, np.maximum(person.shortest, distance / person.speed), person.reaction
        )

    def at(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """Give planned position (m) and velocity (m/s) at a time since the target appeared."""
        s = np.clip((elapsed - self.reaction) / self.duration, 0.0, 1.0)[:, None]
        way = self.goal - self.start
        along = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        return self.start + along * way, 30.0 * s**2 * (1.0 - s) ** 2 / self.duration[:, None] * way


def short_protocol(n_people: int = 3, n_targets: int = 6) -> ScreenProtocol:
    """Give a protocol small enough to try things out."""
    return replace(ScreenProtocol(), n_people=n_people, n_targets=n_targets)
