"""What a predictor of the swivel angle sees of a person, what it gives, and the interface.

A predictor is fitted on other people's observations and says a swivel angle for a new one. Those
that need no fitting (criteria, such as least effort) search the postures of the person's own arm
that hold the same hand pose; those that need it see labels, the hand pose, and what the criteria
said. The next predictor is a file with a class of this interface, and a line in `catalogue`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import Transform
from selfmotion.errors import ShapeError, Status
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.redundancy.manifold import SelfMotionManifold

FOUND = Status(True, "found")


@dataclass(frozen=True)
class Prediction:
    """A swivel angle (rad; NaN where there is none) and whether it could be found."""

    angle: float
    status: Status = FOUND


@dataclass(frozen=True, eq=False)
class Stretch:
    """Postures along one feasible interval, evenly and densely spaced.

    Attributes:
        q: (K, 7) postures (rad).
        swivel: (K,) swivel angle about the scene's shoulder (rad), without jumps of a turn.
    """

    q: Float[np.ndarray, "samples 7"]
    swivel: Float[np.ndarray, " samples"]


@dataclass(frozen=True, eq=False)
class Scene:
    """The person's arm and what it holds; places and directions in the arm's ground frame.

    Attributes:
        model: the arm at the person's size, with muscles.
        T_hand: (4, 4) pose of the hand (m).
        shoulder: (3,) the centre that swivel angles turn about (m).
        mouth: (3,) where the mouth is (m).
        start: (7,) posture from which the movement started (rad).
        stretches: the feasible postures, one entry an interval.
        manifold: the same as they were traced; None: not kept.
    """

    model: MusculoskeletalArm
    T_hand: Transform
    shoulder: Float[np.ndarray, "3"]
    mouth: Float[np.ndarray, "3"]
    start: Float[np.ndarray, "7"]
    stretches: tuple[Stretch, ...]
    manifold: SelfMotionManifold | None = None


@dataclass(frozen=True, eq=False)
class Observation:
    """One moment of one movement of one person.

    Left arms are seen in the mirror. Axes: right, forward (of the trunk, level), up.

    Attributes:
        subject: the person.
        side: right or left.
        task: the condition of the movement.
        moment: as in grasp.
        trial: the repetition.
        natural: the person's own swivel angle (rad).
        start: the same at the start of the movement (rad).
        wrist: (3,) from shoulder to wrist, as a share of the arm's length.
        hand: (3, 3) the hand's axes as columns: towards the thumb, from fingers to wrist, out of
            the back of the hand.
        criteria: name of each criterion to what it predicts.
        scene: the arm and its postures; None where the criteria are computed already.
    """

    subject: str
    side: str
    task: str
    moment: str
    trial: str
    natural: float
    start: float
    wrist: Float[np.ndarray, "3"]
    hand: Float[np.ndarray, "3 3"]
    criteria: Mapping[str, Prediction] = field(default_factory=dict)
    scene: Scene | None = None

    @property
    def kind(self) -> str:
        """Task and moment, as in "drink, grasp"."""
        return f"{self.task}, {self.moment}"

    def the_scene(self) -> Scene:
        """Give the scene.

        Raises:
            ShapeError: the observation has none.
        """
        if self.scene is None:
            raise ShapeError(f"{self.subject}, {self.kind}: the observation holds no arm")
        return self.scene


class Predictor(Protocol):
    """Says a swivel angle for an observation."""

    @property
    def name(self) -> str:
        """Name it goes by in tables."""
        ...

    def fit(self, training: Sequence[Observation]) -> "Predictor":
        """Give the predictor fitted on other people; one that needs no fitting gives itself."""
        ...

    def swivel(self, observation: Observation) -> Prediction:
        """Predict the angle; never looks at the observation's own natural angle."""
        ...


def angle_between(a: float | np.ndarray, b: float | np.ndarray) -> np.ndarray:
    """Give the signed difference of angles, brought into half a turn either way (rad).

    Example:
        >>> round(float(angle_between(3.0, -3.0)), 4)
        -0.2832
    """
    return np.asarray(np.arctan2(np.sin(np.subtract(a, b)), np.cos(np.subtract(a, b))))


def mean_angle(angles: Sequence[float] | np.ndarray) -> float:
    """Give the mean direction of angles (rad); NaN of none.

    Example:
        >>> round(abs(mean_angle([3.1, -3.1])), 4)
        3.1416
    """
    known = np.asarray(angles, dtype=np.float64)
    known = known[np.isfinite(known)]
    if not known.size:
        return float("nan")
    return float(np.arctan2(np.sin(known).mean(), np.cos(known).mean()))
