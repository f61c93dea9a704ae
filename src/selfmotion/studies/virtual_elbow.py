"""A planar arm on a screen whose elbow may not be the person's own: [Khoramshahi2022] section 4.3.

DOI 10.1371/journal.pone.0278228, eq. 25. Hip and shoulder of the chain are always the person's;
the elbow is the person's (Natural), still (Locked), moves with the shoulder (Coupled), or helps
(Assistive):

    q̇3 = J#_3 v - N_3 K (q - q̂),   v̇ = -α (v - ẋ)                             (eq. 25)

with v the low-passed hand velocity and J#_3, N_3 the third rows for W = diag(1, 1, 0.15).

**The person is ours**, since the paper's recordings are not at hand: somebody who sees hand and
target on the screen, plans a minimum-jerk path from where the hand is, corrects what he or she
sees go wrong, and moves the joints that obey by the weighted, damped inverse kinematics of
eq. 4 with weights of his or her own, drawn lightly to a posture of comfort. In Coupled the person
has learnt that the elbow follows the shoulder; in Assistive the elbow's help is not foreseen, only
seen. Delays are not modelled.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from selfmotion.redundancy.projection import project

CONDITIONS = ("Natural", "Locked", "Coupled", "Assistive")
# How the chain on the screen follows the person's own hip, shoulder and elbow (columns). In
# Assistive the controller adds the elbow's motion.
OBEYS = {
    "Natural": np.eye(3),
    "Locked": np.diag([1.0, 1.0, 0.0]),
    "Coupled": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]),
    "Assistive": np.diag([1.0, 1.0, 0.0]),
}


@dataclass(frozen=True, eq=False)
class AssistiveElbow:
    """The controller of eq. 25 with the paper's numbers.

    Attributes:
        weights: W of J# and N.
        filter_rate: α (1/s).
        posture_gain: diagonal of K (1/s).
        rest: q̂ (rad).
        limits: range of the virtual elbow (rad).

    Example:
        >>> elbow = AssistiveElbow()
        >>> J = np.array([[[1.0, 1.0, 1.0]]])
        >>> q = np.array([[0.0, -2.7, 1.0]])  # at the rest posture N K (q - q̂) is zero
        >>> elbow.velocity(J, q, np.array([[1.0]])).round(4).tolist()  # (1/0.15) / (2 + 1/0.15)
        [0.7692]
    """

    weights: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([1.0, 1.0, 0.15]))
    filter_rate: float = 40.0
    posture_gain: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([2.0, 0.2, 0.0]))
    rest: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([0.0, -2.7, 0.0]))
    limits: tuple[float, float] = (0.0, float(np.pi))

    def velocity(
        self,
        jacobian: Float[np.ndarray, "runs rows 3"],
        q: Float[np.ndarray, "runs 3"],
        filtered: Float[np.ndarray, "runs rows"],
    ) -> Float[np.ndarray, " runs"]:
        """Give the elbow velocity (rad/s) that eq. 25 asks for, limits aside."""
        p = project(jacobian, self.weights)
        help_ = np.einsum("kj,kj->k", p.inverse[:, 2], filtered)
        return help_ - np.einsum("kj,kj->k", p.null[:, 2], self.posture_gain * (q - self.rest))

    def filter(
        self,
        filtered: Float[np.ndarray, "runs rows"],
        hand: Float[np.ndarray, "runs rows"],
        step: float,
    ) -> Float[np.ndarray, "runs rows"]:
        """Advance v by one step (s), exactly for a hand velocity held over the step."""
        return hand + (filtered - hand) * np.exp(-self.filter_rate * step)

    def within_limits(
        self,
        elbow: Float[np.ndarray, " runs"],
        velocity: Float[np.ndarray, " runs"],
        step: float,
    ) -> Float[np.ndarray, " runs"]:
        """Cut a velocity so that the elbow does not leave its limits in one step."""
        low, high = self.limits
        return np.clip(velocity, (low - elbow) / step, (high - elbow) / step)


@dataclass(frozen=True)
class ScreenPerson:
    """How the simulated person moves; the weights are drawn for each person.

    Attributes:
        typical_weights: of hip, shoulder and elbow; Table 1's preference for the elbow, and
            for the shoulder before the hip.
        spread: standard deviation of a log-weight between people.
        comfort: posture that the joints are drawn to (rad).
        comfort_rate: how fast (1/s).
        correction: gain on the error that is seen (1/s).
        reaction: time before a movement to a new target starts (s).
        speed: mean speed of the planned hand path (m/s); at least `shortest` seconds.
        shortest: least duration of a planned movement (s).
        damping: μ of the damped inverse kinematics (m²).
        noise: standard deviation of joint velocity, as a share of the speed commanded.
    """

    typical_weights: tuple[float, float, float] = (1.0, 0.6, 0.015)
    spread: float = 0.35
    comfort: tuple[float, float, float] = (0.0, -2.2, 1.2)
    comfort_rate: float = 0.3
    correction: float = 2.0
    reaction: float = 0.25
    speed: float = 0.25
    shortest: float = 0.9
    damping: float = 0.01
    noise: float = 0.08


def commanded_velocity(
    own: Float[np.ndarray, "runs rows 3"],
    weights: Float[np.ndarray, "runs 3"],
    wanted: Float[np.ndarray, "runs rows"],
    drawn: Float[np.ndarray, "runs 3"],
    damping: float,
) -> Float[np.ndarray, "runs 3"]:
    """Give the velocities u (rad/s) of the person's own joints.

    They minimise ``‖wanted - own u‖² + damping (u - drawn)ᵀ W (u - drawn)``: eq. 4 with damping,
    about the velocity toward comfort.

    Args:
        own: the hand's Jacobian as the person knows it: ``jacobian @ OBEYS[condition]``.
        weights: the person's own.
        wanted: hand velocity that the person wants to see (m/s).
        drawn: joint velocity toward comfort (rad/s).
        damping: μ (m²).
    """
    n = own.shape[2]
    transposed = np.swapaxes(own, 1, 2)
    cost = damping * weights[:, :, None] * np.eye(n)
    pull = transposed @ wanted[..., None] + cost @ drawn[..., None]
    return np.linalg.solve(transposed @ own + cost, pull)[..., 0]
