"""Who moved, how, and in which axes: the labels and the frame of a recording."""

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float

from selfmotion.errors import RangeError

AXES = ("x", "y", "z", "-x", "-y", "-z")


@dataclass(frozen=True)
class Labels:
    """What is known about one recording; None where it is not known.

    Attributes:
        subject: the person.
        side: the arm, ``"right"`` or ``"left"``.
        condition: the experimental condition or task (``"natural"``, ``"drink"``).
        target: the target of the movement.
        trial: the repetition; samples of one trial are not independent of each other.
    """

    subject: str | None = None
    side: str | None = None
    condition: str | None = None
    target: str | None = None
    trial: str | None = None

    def to_dict(self) -> dict[str, str | None]:
        """Give the labels by name, in their fixed order."""
        return {name: getattr(self, name) for name in LABEL_NAMES}

    def __str__(self) -> str:
        """Join what is known, as in ``subject P01, condition natural``."""
        known = [f"{name} {value}" for name, value in self.to_dict().items() if value is not None]
        return ", ".join(known)


LABEL_NAMES: tuple[str, ...] = tuple(f.name for f in fields(Labels))


@dataclass(frozen=True)
class Frame:
    """The directions of a coordinate frame: part of the data, never guessed.

    Attributes:
        up: the axis against gravity, one of ``x y z -x -y -z``; None if not known.
        forward: the axis that the person faces; None if not known.
        name: what the frame is fixed to.
    """

    up: str | None = "z"
    forward: str | None = "y"
    name: str = "world"

    def __post_init__(self) -> None:
        """Check that both axes exist and that they are perpendicular."""
        for word, axis in (("up", self.up), ("forward", self.forward)):
            if axis is not None and axis not in AXES:
                raise RangeError(f"frame {word} = {axis!r}: allowed is one of {', '.join(AXES)}")
        if self.up and self.forward and self.up[-1] == self.forward[-1]:
            raise RangeError(
                f"frame up = {self.up!r}, forward = {self.forward!r}: they must be perpendicular"
            )

    @property
    def known(self) -> bool:
        """Tell whether both axes are known."""
        return self.up is not None and self.forward is not None

    def rotation_to(self, other: "Frame") -> Float[np.ndarray, "3 3"]:
        """Give the rotation that takes coordinates in this frame to `other`.

        Raises:
            RangeError: an axis of either frame is not known.

        Example:
            >>> opensim = Frame(up="y", forward="x")
            >>> (opensim.rotation_to(Frame(up="z", forward="y")) @ [0.0, 1.0, 0.0]).tolist()
            [0.0, 0.0, 1.0]
        """
        return other._anatomical().T @ self._anatomical()

    def _anatomical(self) -> Float[np.ndarray, "3 3"]:
        """Give the rows right, forward, up in the coordinates of this frame."""
        if self.up is None or self.forward is None:
            raise RangeError(
                f"frame {self.name!r}: its up and forward axes are not known, so nothing can be "
                "turned into it or out of it; state them (frame=..., --up and --forward)"
            )
        up, forward = _axis_vector(self.up), _axis_vector(self.forward)
        return np.stack([np.cross(forward, up), forward, up])


UNKNOWN_FRAME = Frame(up=None, forward=None, name="unknown")


def _axis_vector(axis: str) -> np.ndarray:
    vector = np.zeros(3)
    vector["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return vector
