"""The center-out experiment of [Tommasino2017]: nine targets, simulated people, what they do.

A person is a joint law with motor noise. In each trial the eight targets are visited once in
pseudo-random order, each movement out followed by the one back; the next movement starts in the
posture in which the last ended. Noise enters where people have it: the place aimed at, the posture
along the self-motion, and the shape of each movement.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.arms import wrist
from selfmotion.errors import RangeError
from selfmotion.methods.elasticity.posture import donders_postures, null_basis
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.methods.passive_motion import PlanSettings, plan
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.redundancy.task import Pointing

NAMES = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")
DIRECTIONS = ("outbound", "inbound")
# The paper sets the targets at 15°, and norms areas by this distance squared (m at d = 1 m).
RADIUS = np.pi / 12
CENTRE = np.zeros(2)
# Lowest harmonics of a movement that vary from one repetition to the next.
HARMONICS = 3


@dataclass(frozen=True)
class MotorNoise:
    """How much a person varies from one movement to the next (standard deviations).

    Attributes:
        aim: place aimed at (m at 1 m: 0.005 is 0.3°).
        posture: posture along the self-motion at the start of each trial (rad).
        shape: deviation of a joint on the way, largest harmonic (rad).
        tempo: duration, as a share of it.
    """

    aim: float = 0.005
    posture: float = np.radians(1.5)
    shape: float = np.radians(0.5)
    tempo: float = 0.05


@dataclass(frozen=True)
class CenterOut:
    """The protocol.

    Attributes:
        n_trials: trials a person; each has 16 movements.
        duration: of a movement (s).
        rate: sampling rate (Hz).
        time_share: both time constants as a share of the duration (the paper's fifth); None: as
            the law has them.
        settings: model and spring of the planner.
    """

    n_trials: int = 10
    duration: float = 0.4
    rate: float = 120.0
    time_share: float | None = 0.2
    settings: PlanSettings = PlanSettings()

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.n_trials < 2:
            raise RangeError(f"n_trials = {self.n_trials}: at least 2, so that there is a spread")
        if not (self.duration > 0.0 and self.rate > 0.0):
            raise RangeError(f"duration = {self.duration:g} s, rate = {self.rate:g} Hz: above 0")
        if self.time_share is not None and not self.time_share > 0.0:
            raise RangeError(f"time_share = {self.time_share:g}: must be above 0")

    def paced(self, law: JointLaw, n_steps: int | None = None) -> tuple[JointLaw, PlanSettings]:
        """Give law and settings with the time constants and steps of the protocol."""
        steps = max(20, round(self.duration * self.rate)) if n_steps is None else n_steps
        settings = replace(self.settings, duration=self.duration, n_steps=steps)
        if self.time_share is None:
            return law, settings
        tau = self.time_share * self.duration
        return replace(law, damping_time=tau, spring_time=tau), settings


def target_places() -> Float[np.ndarray, "8 2"]:
    """Give the eight outer targets (m at 1 m), in the order of `NAMES`."""
    angle = np.arange(8) * np.pi / 4.0
    return RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def predicted(law: JointLaw, protocol: CenterOut | None = None) -> PlannedMotion:
    """Plan the 16 movements of a law: eight out from its posture at the centre, eight back.

    Returns:
        Movements named as in ``E outbound``; first all outbound, then all inbound.

    Raises:
        RangeError: the law has no stable posture at the centre.
    """
    protocol = CenterOut() if protocol is None else protocol
    law, settings = protocol.paced(law, n_steps=200)
    task = Pointing(wrist())
    out = plan(task, law, _centre_posture(task, law), target_places(), settings)
    back = plan(task, law, out.end, CENTRE, settings)
    return _both(out, back)


def simulate(
    law: JointLaw,
    rng: np.random.Generator,
    *,
    protocol: CenterOut | None = None,
    noise: MotorNoise | None = None,
    subject: str = "S1",
) -> Study:
    """Let a simulated person do the experiment.

    Args:
        law: stiffness and rest posture of the wrist.
        rng: source of all that varies.
        protocol: trials, duration, sampling.
        noise: how much the person varies; `MotorNoise(0, 0, 0, 0)` gives a machine.
        subject: label.

    Returns:
        ``16 n_trials`` recordings in the order performed; target and direction (as condition) and
        trial are labels.

    Raises:
        RangeError: the law has no stable posture at the centre.

    Example:
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> study = simulate(law, np.random.default_rng(0), protocol=CenterOut(n_trials=2))
        >>> len(study), study[0].labels.condition, study[1].labels.condition
        (32, 'outbound', 'inbound')
    """
    protocol = CenterOut() if protocol is None else protocol
    noise = MotorNoise() if noise is None else noise
    law, settings = protocol.paced(law)
    task = Pointing(wrist())
    n = protocol.n_trials
    order = np.stack([rng.permutation(8) for _ in range(n)])
    places = target_places()
    q = np.repeat(_centre_posture(task, law)[None], n, axis=0)
    q = q + null_basis(task.jacobian(q))[:, :, 0] * rng.normal(0.0, noise.posture, (n, 1))
    recordings: list[list[Recording]] = [[] for _ in range(n)]
    for visit in range(8):  # all trials at once
        for direction in DIRECTIONS:
            goal = places[order[:, visit]] if direction == "outbound" else np.zeros((n, 2))
            aimed = goal + rng.normal(0.0, noise.aim, (n, 2))
            planned = plan(task, law, q, aimed, settings)
            q = planned.end
            for k in range(n):
                labels = Labels(
                    subject=subject,
                    side="right",
                    condition=direction,
                    target=NAMES[order[k, visit]],
                    trial=str(k + 1),
                )
                recordings[k].append(_performed(task, planned, k, labels, (noise, rng)))
    return Study(tuple(r for trial in recordings for r in trial))


def simulated_law(rng: np.random.Generator) -> JointLaw:
    """Draw a person: around the law of the paper's Fig. 3, joints coupled, rest posture varied."""
    A = rng.normal(0.0, 0.12, (3, 3))
    K = np.diag([0.5, 1.5, 2.0]) + 0.5 * (A + A.T)
    return JointLaw(4.0 * K / np.trace(K), rng.normal([np.radians(5.0), 0.0, 0.0], np.radians(5.0)))


def _centre_posture(task: Pointing, law: JointLaw) -> np.ndarray:
    found = donders_postures(task, law, CENTRE)
    if not found.least[0]:
        raise RangeError(f"law: no stable posture at the central target ({found.status})")
    return found.q[0]


def _both(out: PlannedMotion, back: PlannedMotion) -> PlannedMotion:
    """Put outbound and inbound movements into one result."""

    def put(name: str) -> np.ndarray:
        return np.concatenate([getattr(out, name), getattr(back, name)])

    return replace(
        out,
        q=put("q"),
        qd=put("qd"),
        x=put("x"),
        xd=put("xd"),
        targets=put("targets"),
        spring=put("spring"),
        end_error=put("end_error"),
        statuses=out.statuses + back.statuses,
        names=tuple(f"{name} {direction}" for direction in DIRECTIONS for name in NAMES),
    )


def _performed(
    task: Pointing,
    planned: PlannedMotion,
    k: int,
    labels: Labels,
    variation: tuple[MotorNoise, np.random.Generator],
) -> Recording:
    """Give one movement as the person performs it: other tempo, wavering on the way."""
    noise, rng = variation
    time, q = planned.time, planned.q[k]
    waves = np.arange(1, HARMONICS + 1)
    size = rng.normal(0.0, 1.0, (HARMONICS, q.shape[1])) * noise.shape / waves[:, None]
    u = (time / time[-1])[:, None]
    # Each wave begins and ends at rest: sin² has no slope at the ends.
    q = q + np.sin(np.pi * u) * np.sin(np.pi * u * waves) @ size
    stretch = float(np.exp(rng.normal(0.0, noise.tempo)))
    return Recording(time * stretch, q=q, x=task.value(q), joints=planned.joints, labels=labels)
