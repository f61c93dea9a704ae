r"""A generated person, seen through markers, whose weights and elasticity are known.

The wrist goes along a bowed minimum-jerk path to a target and back; shoulder girdle, shoulder and
elbow follow by λ0-PMP ([Tommasino2017] eqs 4 and 7) with damping W = τ₀ K, which is eq. 2 of
[Khoramshahi2022] with the weights W and a posture-driven part,

    q̇ = J#(W) ẋ + N(W) (noise - (q - q*) / τ₀).

So one set of numbers is behind the weights and behind the postures, and a report on this person can
be held against it. The wrist's own joints turn with the reach and move nothing else.

Markers do not tell the girdle's anatomical zero: calibration counts the girdle's angles from where
movements start. So that truth and report count alike, the girdle's rest is the one with which the
law has the girdle at zero at the start: in equilibrium, K (q - q*) = Jᵀ f for all six joints.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from selfmotion.capture.simulated_markers import (
    RATE,
    MarkerFaults,
    SimulatedCapture,
    capture_of,
    simulated_arm,
)
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.elasticity.posture import donders_postures
from selfmotion.methods.passive.held_joints import hold_joints
from selfmotion.methods.passive.joint_law import TRACE, JointLaw
from selfmotion.motion.labels import Labels
from selfmotion.redundancy.projection import project
from selfmotion.redundancy.task import Position
from selfmotion.studies.donders_postures import LAW_JOINTS
from selfmotion.studies.simulated_people import ReachingProtocol, smooth_noise

SUBJECT = "P1"
# The joints that carry the wrist: stiffness (N m/rad; trace 4 for the law's four), rest (degrees).
JOINTS = ("scapula_protraction", "scapula_elevation", *LAW_JOINTS)
STIFFNESS = (3.0, 3.5, 0.6, 1.3, 1.1, 1.0)
REST_DEG = (5.04, -0.37, 45.0, 25.0, -20.0, 80.0)
# Postures (degrees) that put the wrist at the start and at each target; the person's own differ.
START_DEG = (0.0, 0.0, 15.0, 20.0, -15.0, 85.0)
TARGETS_DEG = {
    "forward": (12.0, 6.0, 60.0, 12.0, -25.0, 35.0),
    "cross": (12.0, 4.0, 65.0, 0.0, -20.0, 50.0),
    "high": (0.0, 15.0, 100.0, 20.0, -10.0, 60.0),
    "side": (-8.0, 8.0, 40.0, 65.0, 10.0, 50.0),
    "drink": (5.0, 8.0, 55.0, 30.0, -40.0, 130.0),
}
# Deviation, flexion and pronation of the wrist (degrees) at the start and at targets.
WRIST_START_DEG, WRIST_END_DEG = (3.0, -5.0, 100.0), (8.0, -15.0, 80.0)
# Seconds: from rest to rest, and when the way out and the way back begin.
LENGTH, WAY, OUT, BACK = 2.4, 0.8, 0.3, 1.3
STUDY = r"""# Whose file is which, and where in a movement the hand is at its goal.
pattern = '(?P<subject>P\d+)_(?P<condition>[a-z]+)_(?P<trial>\d+)\.csv'
static = "{subject}_static.csv"
frame = {up = "z", forward = "y"}
"""


@dataclass(frozen=True)
class PersonProtocol:
    """How often the person reaches, and how much reaches vary.

    Attributes:
        repeats: of each target.
        damping_time: τ₀ (s).
        noise: standard deviation of null-space noise at peak hand speed (rad/s).
        scatter: standard deviation of start and target between repeats (m).
        bow: of the path, as a share of its length.
        markers: noise of each marker's coordinates (m).
    """

    repeats: int = 5
    damping_time: float = 3.0
    noise: float = 0.15
    scatter: float = 0.015
    bow: float = 0.1
    markers: float = 0.0002


@dataclass(frozen=True, eq=False)
class SimulatedPerson:
    """Markers of a person with what generated them.

    Attributes:
        capture: static trial, movements, true angles and arm.
        weights: (6,) of `JOINTS`, the largest 1.
        law: stiffness and rest posture of `LAW_JOINTS`.
    """

    capture: SimulatedCapture
    weights: Float[np.ndarray, " joints"]
    law: JointLaw

    def truth(self) -> str:
        """Write what is known as TOML."""
        parts = {
            "weights": zip(JOINTS, self.weights, strict=True),
            "stiffness": zip(LAW_JOINTS, np.diag(self.law.stiffness), strict=True),
            "rest_deg": zip(LAW_JOINTS, np.degrees(self.law.rest), strict=True),
        }
        lines = ["# What generated these movements: to hold the report of `person` against."]
        for name, pairs in parts.items():
            lines += ["", f"[{name}]", *(f"{joint} = {value:.6g}" for joint, value in pairs)]
        return "\n".join(lines) + "\n"


def simulate_person(
    protocol: PersonProtocol | None = None, *, rng: np.random.Generator
) -> SimulatedPerson:
    """Generate a person who reaches to five targets and back.

    Args:
        protocol: how often, and how much reaches vary; left out: five times each.
        rng: source of randomness.

    Example:
        >>> seen = simulate_person(PersonProtocol(repeats=1), rng=np.random.default_rng(1))
        >>> [m.labels.condition for m in seen.capture.movements]
        ['forward', 'cross', 'high', 'side', 'drink']
    """
    p = protocol or PersonProtocol()
    whole = simulated_arm()
    wrist = dict(
        zip(whole.joints[len(JOINTS) :], np.radians(WRIST_START_DEG).tolist(), strict=True)
    )
    reacher = _Reacher(hold_joints(whole, wrist), p)
    faults = MarkerFaults(noise=p.markers)
    capture = capture_of(whole, _movements(reacher, rng), faults=faults, rng=rng)
    stiffness, rest = np.array(STIFFNESS), np.radians(REST_DEG)
    own = slice(len(JOINTS) - len(LAW_JOINTS), None)
    law = JointLaw(np.diag(stiffness[own]) * TRACE / stiffness[own].sum(), rest[own])
    return SimulatedPerson(capture, stiffness / stiffness.max(), law)


def write_person(person: SimulatedPerson, folder: Path) -> list[Path]:
    """Write markers as Vicon Nexus does, at half their rate, the study file and the truth."""
    from selfmotion.motion.files.vicon_csv import write_vicon_csv
    from selfmotion.writing import write_whole

    rules = "".join(
        f'\n[moments.{target}]\nend_of_reach = {{at = "farthest"}}\n' for target in TARGETS_DEG
    )
    files = [
        write_whole(folder / "study.toml", STUDY + rules),
        write_whole(folder / "truth.toml", person.truth()),
    ]
    static = person.capture.static.window(0, 5)
    for name, markers in [("static", static)] + [
        (f"{m.labels.condition}_{m.labels.trial}", m) for m in person.capture.movements
    ]:
        places = markers.positions[::2].round(5)
        time = np.arange(len(places)) * 2.0 / RATE
        thinned = replace(markers, time=time, positions=places, labels=Labels(SUBJECT))
        files.append(write_vicon_csv(folder / f"{SUBJECT}_{name}.csv", thinned, unit="m"))
    return files


def _movements(
    reacher: "_Reacher", rng: np.random.Generator
) -> Iterator[tuple[Labels, Float[np.ndarray, "samples joints"]]]:
    """Give labels and angles (K, 9) of all reaches."""
    start, *ends = reacher.task.value(np.radians([START_DEG, *TARGETS_DEG.values()]))
    wrist, turned = np.radians(WRIST_START_DEG), np.radians(WRIST_END_DEG)
    hand = wrist + _share()[:, None] * (turned - wrist)
    repeats = reacher.protocol.repeats
    q = reacher.reach(start, np.repeat(ends, repeats, axis=0), rng)
    for i, target in enumerate(TARGETS_DEG):
        for trial in range(repeats):
            labels = Labels(SUBJECT, "right", target, None, str(trial + 1))
            yield labels, np.concatenate([q[:, i * repeats + trial], hand], axis=1)


def _share() -> Float[np.ndarray, " samples"]:
    """Give the share of the way over time: minimum jerk out, a pause, and back."""
    time = np.arange(0.0, LENGTH, 1.0 / RATE)
    out, back = (np.clip((time - begin) / WAY, 0.0, 1.0) for begin in (OUT, BACK))
    phase = out - back
    return phase**3 * (10.0 - 15.0 * phase + 6.0 * phase**2)


@dataclass(frozen=True, eq=False)
class _Reacher:
    """The arm that carries the wrist, and how it moves."""

    arm: Arm
    protocol: PersonProtocol

    @property
    def task(self) -> Position:
        return Position(self.arm, "wrist")

    def reach(
        self, start: np.ndarray, ends: np.ndarray, rng: np.random.Generator
    ) -> Float[np.ndarray, "samples trials joints"]:
        """Integrate eq. 2 by the midpoint rule, from the posture of the law at the start."""
        p, step = self.protocol, 1.0 / RATE
        path = self._paths(start, ends, rng)
        hand = np.diff(path, axis=0) / step
        speed = np.linalg.norm(hand, axis=2, keepdims=True)
        steps = ReachingProtocol(n_samples=len(hand), step=step)
        noise = p.noise * smooth_noise(len(ends), len(JOINTS), steps, rng)
        noise *= speed / speed.max(axis=0)
        law = JointLaw(np.diag(STIFFNESS), np.radians(REST_DEG))
        q = np.empty((*path.shape[:2], len(JOINTS)))
        q[0] = donders_postures(self.task, law, path[0]).q
        for k in range(len(hand)):
            middle = q[k] + 0.5 * step * self._velocity(q[k], hand[k], noise[k])
            q[k + 1] = q[k] + step * self._velocity(middle, hand[k], noise[k])
        return q

    def _paths(
        self, start: np.ndarray, ends: np.ndarray, rng: np.random.Generator
    ) -> Float[np.ndarray, "samples trials 3"]:
        """Give paths of the wrist, bowed one way going out and another coming back."""
        scatter = self.protocol.scatter
        first, last = (x + scatter * rng.standard_normal(ends.shape) for x in (start, ends))
        share = _share()[:, None, None]
        bows = self.protocol.bow * np.cross(last - first, rng.standard_normal((2, *ends.shape)))
        outward = np.arange(len(share))[:, None, None] < BACK * RATE
        bow = np.where(outward, bows[0], bows[1])
        return first + share * (last - first) + 4.0 * share * (1.0 - share) * bow

    def _velocity(self, q: np.ndarray, hand: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """Give joint velocities (rad/s) of all trials."""
        p = project(self.task.jacobian(q), np.array(STIFFNESS))
        free = noise - (q - np.radians(REST_DEG)) / self.protocol.damping_time
        return np.einsum("tij,tj->ti", p.inverse, hand) + np.einsum("tij,tj->ti", p.null, free)
