"""Orientations of a segment over time, as inertial sensors and motion capture give them."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, no_type_check

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import SampleMask, as_float_array, freeze, require_shape
from selfmotion.errors import RangeError
from selfmotion.motion.checks import check_time
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.recording import Recording
from selfmotion.spatial import unit

if TYPE_CHECKING:
    import pandas as pd

# Departure from a rotation that is put down to the digits of a file; nearest rotations are taken.
ROUNDING = 1e-2


@dataclass(frozen=True)
class Screen:
    """Where pointing is projected to ([Tommasino2017] eq. 6): the defaults are the paper's.

    Attributes:
        pointer: (3,) direction that points, in the segment.
        right: (3,) the screen's first axis, in the ground.
        up: (3,) the screen's second axis, in the ground.
        distance: distance of the screen, m.
    """

    pointer: tuple[float, float, float] = (1.0, 0.0, 0.0)
    right: tuple[float, float, float] = (0.0, -1.0, 0.0)
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    distance: float = 1.0


# no_type_check: what files hold arrives here unchecked; bad shapes must meet the checks below.
@no_type_check
@dataclass(frozen=True, eq=False)
class Orientations:
    """How one segment is turned over time.

    Attributes:
        time: instants (K,), s, strictly increasing; sample numbers where `timed` is False.
        matrices: (K, 3, 3) rotations from the segment to the ground; NaN in gaps. What differs
            from a rotation by rounding is replaced by the nearest rotation.
        segment: what is turned: the sensor's name, if known.
        frame: the axes of the ground.
        labels: subject, side, condition, target, trial.
        source: file name, or ``"simulated"``.
        timed: whether `time` is in seconds.

    Raises:
        ShapeError: shapes disagree.
        RangeError: a matrix is no rotation, or `time` does not increase.

    Example:
        >>> still = Orientations(np.arange(2.0), np.stack([np.eye(3)] * 2))
        >>> still.quaternions().tolist()[0], still.pointing().tolist()[0]
        ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0])
    """

    time: Float[np.ndarray, " samples"]
    matrices: Float[np.ndarray, "samples 3 3"]
    segment: str = ""
    frame: Frame = UNKNOWN_FRAME
    labels: Labels = field(default_factory=Labels)
    source: str = "simulated"
    timed: bool = True

    def __post_init__(self) -> None:
        """Check everything, take the nearest rotations, and hold them read-only."""
        time = as_float_array("time", self.time, ndim=1)
        check_time(time)
        matrices = as_float_array("orientations", self.matrices, ndim=3)
        require_shape("orientations", matrices, (len(time), 3, 3))
        object.__setattr__(self, "time", freeze(time.view()))
        object.__setattr__(self, "matrices", freeze(nearest_rotations(matrices)))

    @property
    def n_samples(self) -> int:
        """Number of samples K."""
        return len(self.time)

    @property
    def rate(self) -> float | None:
        """Mean sampling rate, Hz; None without seconds or with one sample."""
        if not self.timed or self.n_samples < 2:
            return None
        return float((self.n_samples - 1) / (self.time[-1] - self.time[0]))

    @property
    def name(self) -> str:
        """What to call the recording in a message: its source, segment and labels."""
        return " ".join(word for word in (self.source, self.segment, str(self.labels)) if word)

    def gaps(self) -> SampleMask:
        """Mark the samples without orientation."""
        return np.isnan(self.matrices[:, 0, 0])

    def quaternions(self) -> Float[np.ndarray, "samples 4"]:
        """Give quaternions x, y, z, w; NaN in gaps."""
        return self._converted("as_quat", 4)

    def rotation_vectors(self) -> Float[np.ndarray, "samples 3"]:
        """Give rotation vectors, rad, of length up to pi; NaN in gaps."""
        return self._converted("as_rotvec", 3)

    def pointing(self, screen: Screen = Screen()) -> Float[np.ndarray, "samples 2"]:
        """Give the path (m) on a screen that the segment points at ([Tommasino2017] eq. 6).

        An orthographic projection: ``distance * [right; up] @ R @ pointer``.
        """
        axes = np.stack([unit("right", screen.right), unit("up", screen.up)])
        pointer = unit("pointer", screen.pointer)
        return screen.distance * (self.matrices @ pointer) @ axes.T

    def pointing_recording(self, screen: Screen = Screen()) -> Recording:
        """Give the pointing path as a recording, for what analyses paths."""
        return Recording(
            self.time,
            x=self.pointing(screen),
            labels=self.labels,
            frame=self.frame,
            source=self.source,
            timed=self.timed,
        )

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a sample: labels, time, qx, qy, qz, qw."""
        import pandas as pd

        columns: dict[str, object] = {k: v for k, v in self.labels.to_dict().items() if v}
        columns["time" if self.timed else "sample"] = self.time
        quaternions = self.quaternions()
        columns |= {f"q{axis}": quaternions[:, i] for i, axis in enumerate("xyzw")}
        return pd.DataFrame(columns)

    def _converted(self, method: str, width: int) -> np.ndarray:
        from scipy.spatial.transform import Rotation

        out = np.full((self.n_samples, width), np.nan)
        seen = ~self.gaps()
        if seen.any():
            out[seen] = getattr(Rotation.from_matrix(self.matrices[seen]), method)()
        return out


def nearest_rotations(matrices: ArrayLike) -> Float[np.ndarray, "samples 3 3"]:
    """Give the nearest rotation to each matrix; NaN where any entry is NaN.

    Raises:
        RangeError: a matrix is further from a rotation than rounding explains.
    """
    given = as_float_array("orientations", matrices, ndim=3)
    out = np.full(given.shape, np.nan)
    seen = np.isfinite(given).all(axis=(1, 2))
    if not seen.any():
        return out
    R = given[seen]
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2))
        good = (off < ROUNDING) & (np.linalg.det(R) > 0.0)
    if not good.all():
        at = int(np.flatnonzero(seen)[int(np.argmin(good))])
        raise RangeError(
            f"orientations[{at}]: no rotation matrix (transpose times matrix is off the identity "
            f"by {off[int(np.argmin(good))]:.2g}; allowed is {ROUNDING:g}, and no reflection)"
        )
    U, _, Vt = np.linalg.svd(R)
    out[seen] = U @ Vt
    return out


def matrices_from_quaternions(quaternions: ArrayLike) -> Float[np.ndarray, "samples 3 3"]:
    """Give the rotations of quaternions x, y, z, w (K, 4); NaN and all zeros are gaps.

    Raises:
        RangeError: a length differs from one by more than rounding.
    """
    from scipy.spatial.transform import Rotation

    q = as_float_array("quaternions", quaternions, ndim=2)
    require_shape("quaternions", q, (None, 4))
    out = np.full((len(q), 3, 3), np.nan)
    seen = np.isfinite(q).all(axis=1) & (q != 0.0).any(axis=1)
    with np.errstate(over="ignore"):
        length = np.linalg.norm(q, axis=1)
    odd = seen & ~(np.abs(length - 1.0) < ROUNDING)
    if odd.any():
        at = int(np.argmax(odd))
        raise RangeError(
            f"orientations[{at}]: a quaternion of length {length[at]:.6g}; allowed is 1, within "
            f"{ROUNDING:g}"
        )
    if seen.any():
        out[seen] = Rotation.from_quat(q[seen]).as_matrix()
    return out


def matrices_from_vectors(vectors: ArrayLike) -> Float[np.ndarray, "samples 3 3"]:
    """Give the rotations of rotation vectors (K, 3), rad; NaN in gaps.

    Raises:
        RangeError: a length is above one turn, so that it is no angle in radians.
    """
    from scipy.spatial.transform import Rotation

    r = as_float_array("rotation vectors", vectors, ndim=2)
    require_shape("rotation vectors", r, (None, 3))
    out = np.full((len(r), 3, 3), np.nan)
    seen = np.isfinite(r).all(axis=1)
    with np.errstate(over="ignore"):
        length = np.linalg.norm(r, axis=1)
    odd = seen & ~(length <= 2.0 * np.pi)
    if odd.any():
        at = int(np.argmax(odd))
        raise RangeError(
            f"orientations[{at}]: a rotation vector of length {length[at]:.6g} rad; allowed is up "
            "to 2 pi (for degrees name the columns rx_deg, ry_deg, rz_deg)"
        )
    if seen.any():
        out[seen] = Rotation.from_rotvec(r[seen]).as_matrix()
    return out
