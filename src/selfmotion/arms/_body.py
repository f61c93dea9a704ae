"""Segment lengths, masses and inertias of an adult, and joint ranges, from published tables.

Masses, centres and radii of gyration are those of de Leva P (1996), Adjustments to
Zatsiorsky-Seluyanov's segment inertia parameters, J Biomech 29:1223-1230 (doi
10.1016/0021-9290(95)00178-6), Table 4. Deviation: the two radii across a segment (sagittal and
transverse) differ by 2 to 11 percentage points and are replaced by the root of their mean square,
so that a segment is round about its long axis and no model needs to know where the palm faces.

Joint ranges are those of Boone DC, Azen SP (1979), Normal range of motion of joints in male
subjects, J Bone Joint Surg Am 61:756-759, all ages.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.inertia import RigidBody, merge_bodies

SegmentName = Literal["trunk_and_head", "upper_arm", "forearm", "hand"]

DEGREE = np.pi / 180.0


@dataclass(frozen=True)
class SegmentTable:
    """A row of de Leva's Table 4.

    Attributes:
        mass: share of body mass.
        com: distance of the centre of mass from the proximal end, as a share of the length.
        across: radii of gyration about the two axes across the segment, shares of the length.
        along: radius of gyration about the long axis, a share of the length.
        length: share of the stature.
    """

    mass: float
    com: float
    across: tuple[float, float]
    along: float
    length: float


# The trunk is from mid-hip to mid-shoulder and carries the head's mass as if it were its own;
# the hand is from the wrist centre to the third metacarpal head.
_TABLES: Mapping[str, Mapping[str, SegmentTable]] = MappingProxyType(
    {
        "male": {
            "trunk_and_head": SegmentTable(
                0.4346 + 0.0694, 1 - 0.4310, (0.384, 0.358), 0.197, 515.5 / 1741
            ),
            "upper_arm": SegmentTable(0.0271, 0.5772, (0.285, 0.269), 0.158, 281.7 / 1741),
            "forearm": SegmentTable(0.0162, 0.4574, (0.276, 0.265), 0.121, 268.9 / 1741),
            "hand": SegmentTable(0.0061, 0.7900, (0.628, 0.513), 0.401, 86.2 / 1741),
        },
        "female": {
            "trunk_and_head": SegmentTable(
                0.4257 + 0.0668, 1 - 0.3782, (0.379, 0.361), 0.182, 497.9 / 1735
            ),
            "upper_arm": SegmentTable(0.0255, 0.5754, (0.278, 0.260), 0.148, 275.1 / 1735),
            "forearm": SegmentTable(0.0138, 0.4559, (0.261, 0.257), 0.094, 264.3 / 1735),
            "hand": SegmentTable(0.0056, 0.7474, (0.531, 0.454), 0.335, 78.0 / 1735),
        },
    }
)


def mean_share(segment: SegmentName) -> float:
    """Give a segment's share of the body mass, the mean of de Leva's women and men."""
    return 0.5 * (_TABLES["female"][segment].mass + _TABLES["male"][segment].mass)


# Degrees from the anatomical zero.
BOONE_AZEN: Mapping[str, float] = MappingProxyType(
    {
        "shoulder_flexion": 166.7,
        "shoulder_extension": 62.3,
        "shoulder_abduction": 184.0,
        "shoulder_inward_rotation": 68.8,
        "shoulder_outward_rotation": 103.7,
        "elbow_flexion": 142.9,
        "elbow_extension": 0.6,
        "pronation": 75.8,
        "supination": 82.1,
        "wrist_flexion": 76.4,
        "wrist_extension": 74.9,
        "radial_deviation": 21.5,
        "ulnar_deviation": 36.0,
    }
)


@dataclass(frozen=True)
class Body:
    """A person's body as far as segment masses and default lengths need it.

    Attributes:
        mass: body mass (kg).
        stature: standing height (m).
        sex: which of de Leva's two tables.

    Raises:
        RangeError: mass or stature is not a positive number.
        UnknownNameError: sex is not in the tables.
    """

    mass: float = 70.0
    stature: float = 1.75
    sex: Literal["male", "female"] = "male"

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("mass", "stature"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise RangeError(f"{name} = {value:g}: must be a positive number")
        if self.sex not in _TABLES:
            raise unknown_name("sex", self.sex, tuple(_TABLES))

    def length(self, segment: SegmentName) -> float:
        """Give a segment's length (m) from the stature."""
        return _TABLES[self.sex][segment].length * self.stature

    def segment(
        self,
        name: SegmentName,
        *,
        start: ArrayLike,
        end: ArrayLike,
        reference_length: float | None = None,
    ) -> RigidBody:
        """Give a segment's mass, centre and inertia in the frame of its end points.

        Args:
            name: the segment.
            start: (3,) proximal joint centre (m).
            end: (3,) distal joint centre (m), or a point in the segment's direction.
            reference_length: length (m) that the table's shares refer to; left out: the distance
                between the points. The hand is measured to the third metacarpal head, which a
                model's palm point is not: give the stature's length there.
        """
        row = _TABLES[self.sex][name]
        a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        distance = float(np.linalg.norm(b - a))
        if not distance > 0.0:
            raise RangeError(f"{name}: its two ends are one point, so it has no direction")
        length = distance if reference_length is None else reference_length
        axis = (b - a) / distance
        mass = row.mass * self.mass
        across = 0.5 * (row.across[0] ** 2 + row.across[1] ** 2)
        along = row.along**2
        shape = across * np.eye(3) + (along - across) * np.outer(axis, axis)
        return RigidBody(mass, a + row.com * length * axis, mass * length**2 * shape)

    def hand(self, *, wrist: ArrayLike, towards: ArrayLike) -> RigidBody:
        """Give the hand from the wrist centre (3,) in the direction of another point (3,)."""
        length = self.length("hand")
        return self.segment("hand", start=wrist, end=towards, reference_length=length)


class Loads(TypedDict):
    """Mass (S), com (S, 3) and inertia (S, 3, 3) of an `Arm`, by the names of its fields."""

    mass: np.ndarray
    com: np.ndarray
    inertia: np.ndarray


def loads(n_joints: int, segments: Sequence[tuple[int, RigidBody]]) -> Loads:
    """Give mass, com and inertia of an `Arm` from segments and the joints that carry them."""
    mass, com, inertia = np.zeros(n_joints), np.zeros((n_joints, 3)), np.zeros((n_joints, 3, 3))
    for joint in {joint for joint, _ in segments}:
        body = merge_bodies([segment for i, segment in segments if i == joint])
        mass[joint], com[joint], inertia[joint] = body.mass, body.com, body.inertia
    return {"mass": mass, "com": com, "inertia": inertia}


def check_lengths(names: Sequence[str], lengths: ArrayLike) -> dict[str, float]:
    """Check segment lengths (m), one for each name, and give them by name.

    Raises:
        ShapeError: there are more or fewer lengths than segments.
        RangeError: a length is not a positive number.
    """
    values = as_float_array("lengths", lengths, ndim=1)
    require_shape("lengths", values, (len(names),))
    for name, value in zip(names, values, strict=True):
        if not (np.isfinite(value) and value > 0):
            raise RangeError(f"length of {name} = {value:g} m: must be a positive number")
    return dict(zip(names, values.tolist(), strict=True))
