"""A tree of revolute and prismatic joints, and how its joints follow free coordinates.

`Chain` says where joints are; `Coupling` says how the N joints follow the n coordinates that a
person (or a model) moves freely, as the shoulder girdle follows shoulder elevation.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, cast

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import ModelError, RangeError, ShapeError, unknown_name
from selfmotion.spatial import rotation_taking_z_to

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

    from selfmotion.kinematics.serial_path import SerialPath

REVOLUTE, PRISMATIC = 0, 1
GROUND = -1  # parent of the first joints, and the body that never moves


@dataclass(frozen=True, eq=False)
class CoupledCurve:
    """One joint that follows one coordinate along a piecewise polynomial.

    Attributes:
        joint: index of the joint (row) that follows.
        coordinate: index of the free coordinate (column) that leads.
        curve: joint value (rad or m) as a function of the coordinate; outside its last knots
            the end pieces are extended.
    """

    joint: int
    coordinate: int
    curve: "PPoly"


@dataclass(frozen=True, eq=False)
class Coupling:
    """Joint values from free coordinates: ``matrix @ q + offset``, plus curves.

    Attributes:
        coordinates: names of the n free coordinates.
        matrix: (N, n) linear part.
        offset: (N,) joint values at q = 0 (rad or m), curves left out.
        curves: joints that follow a curve; their row of `matrix` and `offset` is zero.
    """

    coordinates: tuple[str, ...]
    matrix: Float[np.ndarray, "all_joints coords"]
    offset: Float[np.ndarray, " all_joints"]
    curves: tuple[CoupledCurve, ...] = ()

    @classmethod
    def identity(cls, names: tuple[str, ...]) -> "Coupling":
        """Let every joint be a free coordinate of the same name."""
        return cls(names, freeze(np.eye(len(names))), freeze(np.zeros(len(names))))

    @cached_property
    def is_identity(self) -> bool:
        """Whether joints and coordinates are the same."""
        return (
            not self.curves
            and self.matrix.shape[0] == self.matrix.shape[1]
            and np.array_equal(self.matrix, np.eye(len(self.matrix)))
            and not self.offset.any()
        )

    def value(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples all_joints"]:
        """Give the values of all joints (rad or m) for samples of the free coordinates."""
        if self.is_identity:
            return q
        out = q @ self.matrix.T + self.offset
        for c in self.curves:
            out[:, c.joint] = c.curve(q[:, c.coordinate])
        return out

    def derivative(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples all_joints coords"]:
        """Give the derivative of all joints with respect to the free coordinates."""
        out = np.repeat(self.matrix[None], len(q), axis=0)
        for c in self.curves:
            out[:, c.joint, c.coordinate] = c.curve.derivative()(q[:, c.coordinate])
        return out


@dataclass(frozen=True, eq=False)
class Chain:
    """A tree of joints; each joint carries one body, whose frame turns or slides with it.

    The body of joint i has the frame ``T_parent_i = offsets[i] @ motion(axes[i], value)``, with
    the motion a rotation about, or a slide along, the axis.

    Attributes:
        names: the N joints in an order in which parents come first.
        parent: (N,) index of the parent joint, `GROUND` for none.
        joint_type: (N,) `REVOLUTE` or `PRISMATIC`.
        axes: (N, 3) unit axes in the joint's own frame.
        offsets: (N, 4, 4) frame of the joint in its parent's body at value 0 (m).
        lower: (n,) lower limits of the free coordinates (rad or m).
        upper: (n,) upper limits.
        coupling: how joints follow free coordinates; left out: each joint is one.

    Raises:
        ShapeError: the arrays disagree in length.
        RangeError: a lower limit is above its upper limit.
        ModelError: an axis has no direction, or a parent comes after its child.
    """

    names: tuple[str, ...]
    parent: Int[np.ndarray, " all_joints"]
    joint_type: Int[np.ndarray, " all_joints"]
    axes: Float[np.ndarray, "all_joints 3"]
    offsets: Float[np.ndarray, "all_joints 4 4"]
    lower: Float[np.ndarray, " coords"]
    upper: Float[np.ndarray, " coords"]
    coupling: Coupling = cast(Coupling, None)  # filled in below, where the names are known

    def __post_init__(self) -> None:
        """Check the parts against each other and make the arrays read-only."""
        n_joints = len(self.names)
        if self.coupling is None:
            object.__setattr__(self, "coupling", Coupling.identity(tuple(self.names)))
        n = len(self.coupling.coordinates)
        shapes: dict[str, tuple[int, ...]] = {
            "parent": (n_joints,),
            "joint_type": (n_joints,),
            "axes": (n_joints, 3),
            "offsets": (n_joints, 4, 4),
            "lower": (n,),
            "upper": (n,),
        }
        for name, shape in shapes.items():
            dtype = np.int64 if name in ("parent", "joint_type") else np.float64
            array = np.array(getattr(self, name), dtype=dtype)
            require_shape(name, array, shape)
            if name not in ("lower", "upper"):
                require_finite(name, array)
            object.__setattr__(self, name, freeze(array))
        require_shape("coupling.matrix", self.coupling.matrix, (n_joints, n))
        self._check_tree()
        self._check_limits()

    def _check_tree(self) -> None:
        for i, name in enumerate(self.names):
            if not GROUND <= self.parent[i] < i:
                raise ModelError(f"joint {name!r}: its parent must come before it in the list")
            if self.joint_type[i] not in (REVOLUTE, PRISMATIC):
                raise ModelError(
                    f"joint {name!r} has type {self.joint_type[i]}; "
                    "a chain has revolute and prismatic joints only"
                )
            if abs(np.linalg.norm(self.axes[i]) - 1.0) > 1e-9:
                raise ModelError(
                    f"joint {name!r}: axis {self.axes[i].tolist()} must have unit length"
                )

    def _check_limits(self) -> None:
        for name, low, high in zip(self.coordinates, self.lower, self.upper, strict=True):
            if not low <= high:
                raise RangeError(
                    f"{name}: lower limit {low:g} is not below or at upper limit {high:g}"
                )

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the n free coordinates, in the order of q."""
        return self.coupling.coordinates

    @property
    def n_coordinates(self) -> int:
        """Number of free coordinates, the length of q."""
        return len(self.coupling.coordinates)

    def index(self, coordinate: str) -> int:
        """Give the position of a free coordinate in q.

        Raises:
            UnknownNameError: no coordinate has this name.
        """
        if coordinate not in self.coordinates:
            raise unknown_name("joint", coordinate, self.coordinates)
        return self.coordinates.index(coordinate)

    def joint_values(self, q: ArrayLike) -> Float[np.ndarray, "samples all_joints"]:
        """Check samples of q, (n,) or (K, n), and give the values of all N joints.

        Raises:
            ShapeError: q does not have one column for each free coordinate.
            NotFiniteError: q holds NaN or infinite values.
        """
        return self.coupling.value(self.as_samples(q))

    def as_samples(self, q: ArrayLike) -> Float[np.ndarray, "samples coords"]:
        """Check q, (n,) or (K, n), and give it as (K, n).

        Raises:
            ShapeError: q does not have one column for each free coordinate.
            NotFiniteError: q holds NaN or infinite values.
        """
        array = self.shaped(q)
        require_finite("q", array)
        return array

    def shaped(self, q: ArrayLike) -> Float[np.ndarray, "samples coords"]:
        """Give q, (n,) or (K, n), as (K, n); whoever calls looks for NaN.

        Raises:
            ShapeError: q does not have one column for each free coordinate.
        """
        array = as_float_array("q", q)
        if array.ndim not in (1, 2) or array.shape[-1] != self.n_coordinates:
            raise ShapeError(
                f"q has shape {array.shape}; expected ({self.n_coordinates},) or "
                f"(samples, {self.n_coordinates}) for {', '.join(self.coordinates)}"
            )
        return np.atleast_2d(array)

    @cached_property
    def rewritten(self) -> dict[int, "SerialPath"]:
        """What `SerialPath.of` has made of the joints up to some of them."""
        return {}

    @cached_property
    def z_frames(self) -> "ZFrames":
        """The same chain with every joint axis along z, as the kernels want it."""
        return ZFrames.of(self)


@dataclass(frozen=True, eq=False)
class ZFrames:
    """A chain rewritten so that each joint turns about, or slides along, its own z axis.

    A rotation about z touches two columns of a rotation matrix only, and the world axis of a
    joint is then a column that is already there: this is what makes the kernels short and fast.

    Attributes:
        parent: (N,) as in the chain.
        joint_type: (N,) as in the chain.
        rotations: (N, 3, 3) rotation from the parent's z-frame to this joint's at value 0.
        translations: (N, 3) origin of this joint in the parent's z-frame (m).
        to_body: (N, 3, 3) rotation from the chain's body frame to the z-frame's coordinates:
            ``R_world_body = R_world_z @ to_body``.
    """

    parent: Int[np.ndarray, " all_joints"]
    joint_type: Int[np.ndarray, " all_joints"]
    rotations: Float[np.ndarray, "all_joints 3 3"]
    translations: Float[np.ndarray, "all_joints 3"]
    to_body: Float[np.ndarray, "all_joints 3 3"]

    @classmethod
    def of(cls, chain: Chain) -> "ZFrames":
        """Rewrite a chain."""
        n_joints = len(chain.names)
        rotations, translations = np.empty((n_joints, 3, 3)), np.empty((n_joints, 3))
        to_body = np.empty((n_joints, 3, 3))
        for i in range(n_joints):
            A = rotation_taking_z_to(chain.axes[i])
            p = chain.parent[i]
            left = np.eye(3) if p == GROUND else to_body[p]
            rotations[i] = left @ chain.offsets[i, :3, :3] @ A
            translations[i] = left @ chain.offsets[i, :3, 3]
            to_body[i] = A.T
        return cls(
            chain.parent,
            chain.joint_type,
            *(freeze(np.ascontiguousarray(a)) for a in (rotations, translations, to_body)),
        )


@dataclass(frozen=True, eq=False)
class Tip:
    """A frame fixed to the body of a joint (or to the ground): a landmark, a hand, a marker.

    Attributes:
        joint: index of the joint whose body carries it, or `GROUND`.
        transform: (4, 4) its frame in that body (m).
    """

    joint: int
    transform: Transform = field(default_factory=lambda: np.eye(4))
