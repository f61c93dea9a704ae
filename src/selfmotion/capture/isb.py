"""Joint angles as the International Society of Biomechanics recommends them.

Wu et al. 2005, doi 10.1016/j.jbiomech.2004.05.042: thoracohumeral angles Y-X'-Y'' (plane of
elevation, elevation, axial rotation; section 2.4.7, with the humerus of 2.3.4, its first option)
and elbow angles Z-X'-Y'' (flexion, carrying angle, pronation; 2.4.8 with 2.3.6). Each sequence
has a posture in which two of its axes fall together; the distance from it comes beside the angles.

Deviations: the trunk's frame is that of the calibration (right, forward, up at rest) and not that
of four bony points of the thorax; elevation is given positive, where the report has it negative.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.capture.protocol import SIDES
from selfmotion.errors import unknown_name

if TYPE_CHECKING:
    import pandas as pd

NAMES = (
    "plane_of_elevation",
    "elevation",
    "axial_rotation",
    "elbow_flexion",
    "carrying_angle",
    "pronation",
)
NEEDED = (
    "shoulder",
    "lateral_epicondyle",
    "medial_epicondyle",
    "radial_styloid",
    "ulnar_styloid",
)


@dataclass(frozen=True, eq=False)
class IsbAngles:
    """Angles after Wu et al. 2005; NaN where a landmark was not seen.

    Attributes:
        angles: (K, 6) rad, in the order of `NAMES`; left arms as their mirror image.
        shoulder_lock: (K,) distance of the elevation from gimbal lock, at 0 and 180 degrees (rad).
        elbow_lock: (K,) distance of the carrying angle from gimbal lock, at ±90 degrees (rad).
    """

    angles: Float[np.ndarray, "samples 6"]
    shoulder_lock: Float[np.ndarray, " samples"]
    elbow_lock: Float[np.ndarray, " samples"]

    def to_frame(self) -> "pd.DataFrame":
        """Give a table in degrees, one row a sample."""
        import pandas as pd

        columns = {f"{n}_deg": np.rad2deg(self.angles[:, i]) for i, n in enumerate(NAMES)}
        columns["shoulder_lock_deg"] = np.rad2deg(self.shoulder_lock)
        columns["elbow_lock_deg"] = np.rad2deg(self.elbow_lock)
        return pd.DataFrame(columns)


def isb_angles(
    landmarks: Mapping[str, np.ndarray], trunk: Float[np.ndarray, "samples 3 3"], *, side: str
) -> IsbAngles:
    """Give the angles of Wu et al. 2005 from landmarks.

    Args:
        landmarks: shoulder, both epicondyles and both styloids, (K, 3) each, m, in the laboratory.
        trunk: (K, 3, 3) the trunk's axes right, forward, up as columns, in the laboratory.
        side: right or left.

    Raises:
        UnknownNameError: a landmark is missing, or the side is neither.
        ShapeError: sizes that do not agree.

    Example:
        A hanging arm, elbow bent by a quarter turn, thumb up:

        >>> points = {"shoulder": [0, 0, 0], "lateral_epicondyle": [0.04, 0, -0.3],
        ...           "medial_epicondyle": [-0.04, 0, -0.3], "radial_styloid": [0, 0.25, -0.27],
        ...           "ulnar_styloid": [0, 0.25, -0.33]}
        >>> found = isb_angles({k: np.array([v]) for k, v in points.items()},
        ...                    np.eye(3)[None], side="right")
        >>> np.rad2deg(found.angles[0, 3]).round().item()
        83.0
    """
    if side not in SIDES:
        raise unknown_name("side", side, tuple(SIDES))
    for name in NEEDED:
        if name not in landmarks:
            raise unknown_name("landmark", name, tuple(landmarks))
    axes = as_float_array("trunk", trunk, ndim=3)
    require_shape("trunk", axes, (None, 3, 3))
    # Into the axes of the report: x forward, y up, z right (outwards, for a mirrored left arm).
    outwards = 1.0 if side == "right" else -1.0
    P = {}
    for name in NEEDED:
        path = as_float_array(name, landmarks[name], ndim=2)
        require_shape(name, path, (len(axes), 3))
        local = np.einsum("kji,kj->ki", axes, path)
        P[name] = np.stack([local[:, 1], local[:, 2], outwards * local[:, 0]], axis=1)
    elbow = 0.5 * (P["lateral_epicondyle"] + P["medial_epicondyle"])
    y_h = _unit(P["shoulder"] - elbow)
    x_h = _unit(
        np.cross(P["shoulder"] - P["medial_epicondyle"], P["lateral_epicondyle"] - P["shoulder"])
    )
    humerus = np.stack([x_h, y_h, np.cross(x_h, y_h)], axis=2)
    y_f = _unit(elbow - P["ulnar_styloid"])
    x_f = _unit(np.cross(y_f, P["radial_styloid"] - P["ulnar_styloid"]))
    forearm = np.stack([x_f, y_f, np.cross(x_f, y_f)], axis=2)
    shoulder, elevation = _yxy(humerus)
    joint = humerus.mT @ forearm
    elbow_angles = _zxy(joint)
    return IsbAngles(
        np.concatenate([shoulder, elbow_angles], axis=1),
        np.minimum(elevation, np.pi - elevation),
        np.pi / 2 - np.abs(elbow_angles[:, 1]),
    )


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def _yxy(R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Take R = Ry(a) Rx(-b) Ry(c) apart, with the elevation b in 0 to pi."""
    b = np.arccos(np.clip(R[:, 1, 1], -1.0, 1.0))
    a = np.arctan2(-R[:, 0, 1], -R[:, 2, 1])
    c = np.arctan2(-R[:, 1, 0], R[:, 1, 2])
    return np.stack([a, b, c], axis=1), b


def _zxy(R: np.ndarray) -> np.ndarray:
    """Take R = Rz(a) Rx(b) Ry(c) apart."""
    b = np.arcsin(np.clip(R[:, 2, 1], -1.0, 1.0))
    a = np.arctan2(-R[:, 0, 1], R[:, 1, 1])
    c = np.arctan2(-R[:, 2, 0], R[:, 2, 2])
    return np.stack([a, b, c], axis=1)
