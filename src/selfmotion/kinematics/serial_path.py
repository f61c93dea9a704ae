"""The joints between the ground and one tip, rewritten so that kernels have little to multiply.

Any constant rotation between two joints that turn about z is ``Rz(a) Rx(b) Rz(c)``. The outer two
turns merge with the angles of the joints on either side, so that what remains between joints is
one twist about x and one shift: every chain becomes a modified Denavit-Hartenberg chain.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from selfmotion.arrays import freeze
from selfmotion.errors import ModelError
from selfmotion.kinematics.chain import GROUND, PRISMATIC, Chain, CoupledCurve, Tip

# Below this sine of the twist its axis is not defined, and all of the turn is about z.
NO_TWIST = 1e-12


@dataclass(frozen=True, eq=False)
class SerialPath:
    """The P joints that carry a tip, in order from the ground.

    Joint i contributes ``Trans(shift_i) Rx(twist_i) Rz(angle_i) Trans(0, 0, slide_i)`` with
    ``angle_i = angle_offset_i + value_i`` and slide 0 for a revolute joint, and
    ``angle_i = angle_offset_i``, ``slide_i = value_i`` for a prismatic one. All of it stands on
    ``Rz(base_angle)``, and ends in `tip_rotation` and `tip_position`.

    Attributes:
        joints: (P,) indices of the joints in the chain.
        prismatic: (P,) whether the joint slides.
        twist: (P,) angle about x before the joint (rad).
        shift: (P, 3) shift before the joint (m).
        angle_offset: (P,) angle of the joint at value 0 (rad).
        base_angle: first turn about z (rad).
        tip_rotation: (3, 3) of the tip in the last joint's frame.
        tip_position: (3,) of the tip in the last joint's frame (m).
        matrix: (P, n) and `offset` (P,): joint values as ``matrix @ q + offset``.
        offset: see `matrix`.
        curves: joints of the path that follow a curve; `joint` counts along the path.
    """

    joints: Int[np.ndarray, " path"]
    prismatic: Int[np.ndarray, " path"]
    twist: Float[np.ndarray, " path"]
    shift: Float[np.ndarray, "path 3"]
    angle_offset: Float[np.ndarray, " path"]
    base_angle: float
    tip_rotation: Float[np.ndarray, "3 3"]
    tip_position: Float[np.ndarray, "3"]
    matrix: Float[np.ndarray, "path coords"]
    offset: Float[np.ndarray, " path"]
    curves: tuple[CoupledCurve, ...]

    @cached_property
    def steps(self) -> Float[np.ndarray, "path 6"]:
        """Angle offset, cosine and sine of the twist, and shift, for each joint."""
        twist = np.cos(self.twist), np.sin(self.twist)
        return freeze(np.column_stack([self.angle_offset, *twist, self.shift]))

    @cached_property
    def base(self) -> Float[np.ndarray, "2"]:
        """Cosine and sine of the first turn."""
        return freeze(np.array([np.cos(self.base_angle), np.sin(self.base_angle)]))

    @classmethod
    def of(cls, chain: Chain, tip: Tip) -> "SerialPath":
        """Rewrite the joints that carry a tip.

        Raises:
            ModelError: the tip is fixed to the ground, so that no joint moves it.
        """
        if tip.joint == GROUND:
            raise ModelError("the tip is fixed to the ground: no joint moves it")
        path = cls.up_to(chain, int(tip.joint))
        R, p = tip_in_path(chain, tip)
        return replace(path, tip_rotation=R, tip_position=p)

    @classmethod
    def up_to(cls, chain: Chain, last: int) -> "SerialPath":
        """Rewrite the joints up to one of them, once; the tip is the frame of the last one."""
        if last not in chain.rewritten:
            chain.rewritten[last] = cls._up_to(chain, last)
        return chain.rewritten[last]

    @classmethod
    def _up_to(cls, chain: Chain, last: int) -> "SerialPath":
        joints = joints_to(chain, last)
        z = chain.z_frames
        n_path = len(joints)
        twist, angle = np.zeros(n_path), np.zeros(n_path)
        shift = np.zeros((n_path, 3))
        base = 0.0
        for i, j in enumerate(joints):
            before, twist[i], after = _turn_twist_turn(z.rotations[j])
            shift[i] = _about_z(-before) @ z.translations[j]
            if i == 0:
                base = before
            else:
                angle[i - 1] += before
            angle[i] += after
        position = {j: i for i, j in enumerate(joints)}
        curves = tuple(
            CoupledCurve(position[c.joint], c.coordinate, c.curve)
            for c in chain.coupling.curves
            if c.joint in position
        )
        return cls(
            freeze(np.array(joints)),
            freeze((chain.joint_type[joints] == PRISMATIC).astype(np.int64)),
            freeze(twist),
            freeze(shift),
            freeze(angle),
            base,
            freeze(np.eye(3)),
            freeze(np.zeros(3)),
            freeze(np.ascontiguousarray(chain.coupling.matrix[joints])),
            freeze(np.ascontiguousarray(chain.coupling.offset[joints])),
            curves,
        )


def tip_in_path(chain: Chain, tip: Tip) -> tuple[np.ndarray, np.ndarray]:
    """Give rotation and position (m) of a tip in the frame of the last joint of its path."""
    left = chain.z_frames.to_body[tip.joint]
    R = np.ascontiguousarray(left @ tip.transform[:3, :3])
    return freeze(R), freeze(left @ tip.transform[:3, 3])


def joints_to(chain: Chain, last: int) -> list[int]:
    """Give the joints from the ground to one of them."""
    joints, i = [], last
    while i != GROUND:
        joints.append(i)
        i = int(chain.parent[i])
    return joints[::-1]


def _about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _turn_twist_turn(R: np.ndarray) -> tuple[float, float, float]:
    """Give angles a, b, c with ``R = Rz(a) Rx(b) Rz(c)`` (rad), quarter turns kept exact."""
    sine = float(np.hypot(R[0, 2], R[1, 2]))
    if sine < NO_TWIST:  # the axes are parallel, or opposite
        if R[2, 2] > 0:
            return 0.0, 0.0, float(np.arctan2(R[1, 0], R[0, 0]))
        return 0.0, float(np.pi), float(np.arctan2(-R[1, 0], R[0, 0]))
    a = float(np.arctan2(R[0, 2], -R[1, 2]))
    # A small twist leaves its axis uncertain: the last turn undoes what the first may be off.
    first = _about_z(-a)[0] @ R
    return a, float(np.arctan2(sine, R[2, 2])), float(np.arctan2(-first[1], first[0]))
