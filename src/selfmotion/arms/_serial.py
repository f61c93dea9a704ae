"""Serial chains from short lists: axes and offsets, or Denavit-Hartenberg rows."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform
from selfmotion.kinematics.chain import Chain, Coupling
from selfmotion.spatial import rotation_about, transform

X, Y, Z = np.eye(3)


@dataclass(frozen=True, eq=False)
class Joint:
    """A revolute joint of a serial chain.

    Attributes:
        name: of the joint.
        axis: (3,) unit axis in its own frame.
        limits: lower and upper angle (rad).
        offset: (4, 4) its frame at angle 0 in the body before (m).
    """

    name: str
    axis: np.ndarray
    limits: tuple[float, float]
    offset: Transform


def at(translation: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> Transform:
    """Give an offset from a translation (m) and a rotation matrix."""
    return transform(rotation, translation)


def craig(*, twist: float, d: float = 0.0, angle: float = 0.0, a: float = 0.0) -> Transform:
    """Give ``Rx(twist) Tx(a) Tz(d) Rz(angle)``: a modified Denavit-Hartenberg row (Craig).

    The joint then turns about the z axis of the frame that this reaches.
    """
    first = transform(rotation_about(X, twist)) @ transform(translation=(a, 0.0, d))
    return first @ transform(rotation_about(Z, angle))


def serial_chain(joints: Sequence[Joint], *, order: Sequence[str] | None = None) -> Chain:
    """Chain joints one after the other.

    Args:
        joints: from the ground outwards.
        order: names of the coordinates as q lists them; left out: the order of the joints.
    """
    names = tuple(joint.name for joint in joints)
    coordinates = names if order is None else tuple(order)
    limits = {joint.name: joint.limits for joint in joints}
    coupling = Coupling.identity(names)
    if coordinates != names:
        matrix = np.array([[float(name == c) for c in coordinates] for name in names])
        coupling = Coupling(coordinates, matrix, np.zeros(len(names)))
    return Chain(
        names,
        np.arange(len(names)) - 1,
        np.zeros(len(names), dtype=np.int64),
        np.array([joint.axis for joint in joints]),
        np.array([joint.offset for joint in joints]),
        np.array([limits[name][0] for name in coordinates]),
        np.array([limits[name][1] for name in coordinates]),
        coupling,
    )
