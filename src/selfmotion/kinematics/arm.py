"""An arm: a chain with landmarks, segment masses and the directions of its ground frame."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import freeze, require_finite, require_shape
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.chain import Chain, Tip

# Landmarks that every arm has.
LANDMARKS = ("shoulder", "elbow", "wrist", "hand")


@dataclass(frozen=True, eq=False)
class Arm:
    """A chain as an arm: where its landmarks are and how its segments weigh.

    Attributes:
        name: as in the command line's ``--arm``.
        chain: the joints.
        landmarks: name to `Tip`; always shoulder, elbow, wrist and hand.
        lengths: segment name to length (m), as far as the arm was built from lengths.
        mass: (S,) mass of the body of each joint (kg).
        com: (S, 3) its centre of mass in the body frame (m).
        inertia: (S, 3, 3) its inertia about the centre of mass, body axes (kg m²).
        gravity: (3,) acceleration of gravity in the ground frame (m/s²).
        up: (3,) upward direction in the ground frame.
        forward: (3,) direction in which the person looks.
        source: where model, limits and masses come from.
        task: the kind of task that is meant where none is named: position, planar or pointing.
    """

    name: str
    chain: Chain
    landmarks: Mapping[str, Tip]
    lengths: Mapping[str, float]
    mass: Float[np.ndarray, " all_joints"]
    com: Float[np.ndarray, "all_joints 3"]
    inertia: Float[np.ndarray, "all_joints 3 3"]
    gravity: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    up: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    forward: Float[np.ndarray, "3"] = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    source: str = ""
    task: str = "position"

    def __post_init__(self) -> None:
        """Check shapes, masses and landmarks; make arrays read-only."""
        n_joints = len(self.chain.names)
        shapes: dict[str, tuple[int, ...]] = {
            "mass": (n_joints,),
            "com": (n_joints, 3),
            "inertia": (n_joints, 3, 3),
            "gravity": (3,),
            "up": (3,),
            "forward": (3,),
        }
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), dtype=np.float64)
            require_shape(name, array, shape)
            require_finite(name, array)
            object.__setattr__(self, name, freeze(array))
        if (self.mass < 0).any():
            i = int(np.argmin(self.mass))
            raise RangeError(f"mass of {self.chain.names[i]!r} is {self.mass[i]:g} kg; at least 0")
        for landmark in LANDMARKS:
            if landmark not in self.landmarks:
                raise unknown_name("landmark", landmark, tuple(self.landmarks))
        object.__setattr__(self, "landmarks", MappingProxyType(dict(self.landmarks)))
        object.__setattr__(self, "lengths", MappingProxyType(dict(self.lengths)))

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the free coordinates, in the order of q."""
        return self.chain.coordinates

    @property
    def n_joints(self) -> int:
        """Length of q."""
        return self.chain.n_coordinates

    @property
    def lower(self) -> Float[np.ndarray, " coords"]:
        """Lower joint limits (rad or m)."""
        return self.chain.lower

    @property
    def upper(self) -> Float[np.ndarray, " coords"]:
        """Upper joint limits (rad or m)."""
        return self.chain.upper

    def tip(self, landmark: str) -> Tip:
        """Give a landmark by name.

        Raises:
            UnknownNameError: the arm has no such landmark.
        """
        if landmark not in self.landmarks:
            raise unknown_name("landmark", landmark, tuple(self.landmarks))
        return self.landmarks[landmark]

    def with_limits(self, limits: Mapping[str, tuple[float, float]]) -> "Arm":
        """Give the same arm with other limits (rad or m) for the joints named.

        Raises:
            UnknownNameError: a joint does not exist.
            RangeError: a lower limit is above its upper limit.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        for joint, (low, high) in limits.items():
            i = self.chain.index(joint)
            lower[i], upper[i] = low, high
        return replace(self, chain=replace(self.chain, lower=lower, upper=upper))

    def middle(self) -> Float[np.ndarray, " coords"]:
        """Give the posture in the middle of the joint limits (rad or m)."""
        return 0.5 * (self.lower + self.upper)

    def random_postures(
        self, n_samples: int, rng: np.random.Generator
    ) -> Float[np.ndarray, "samples coords"]:
        """Draw postures evenly inside the joint limits (rad or m)."""
        return rng.uniform(self.lower, self.upper, (n_samples, self.n_joints))


def weightless(n_joints: int) -> dict[str, np.ndarray]:
    """Give zero mass, com and inertia for an arm of which only kinematics are known."""
    return {
        "mass": np.zeros(n_joints),
        "com": np.zeros((n_joints, 3)),
        "inertia": np.zeros((n_joints, 3, 3)),
    }
