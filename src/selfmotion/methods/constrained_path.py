"""Follow a path of the hand with the joints inside their limits, and find which part is feasible.

[DeBoon] scenarios 2 and 3 (J Biomech Eng): the palm on a circle of a device, its roll held. The
rows that are held are x, y, z and ψ; eqs 19 and 22 drop the constrained rows, which leaves x (or
y) and ψ free.

At each sample the posture minimises a cost that is quadratic in displacement from a rest posture,
velocity and acceleration of the joints (section 5), with the task and the limits met exactly:
``½ Σ h (q - c)²`` with h and c from the samples before.
"""

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching import ik_kernels
from selfmotion.methods.reaching.ik_arrays import Options, Rows
from selfmotion.methods.reaching.ik_seeds import model_of
from selfmotion.methods.reaching.ik_tasks import HandRows

if TYPE_CHECKING:
    import pandas as pd

# Error of a sample that counts as met (m, with angles times the rotation scale), and steps tried.
MET, STEPS = 1e-6, 20
# A joint that moves further between samples has jumped (rad or m), unless told otherwise.
JUMP = 0.25
# Planes of a device's circle, by their axes.
PLANES = MappingProxyType({"yz": (1, 2), "xz": (0, 2), "xy": (0, 1)})


@dataclass(frozen=True, eq=False)
class PathCosts:
    """What the joints pay along a path; each weight is one number or one a joint.

    Attributes:
        displacement: weight of the squared distance from `rest`.
        velocity: weight of the squared joint velocity, s²; weights of `identify_weights` go here.
        acceleration: weight of the squared joint acceleration, s⁴.
        rest: (n,) rest posture (rad or m), NaN for joints whose rest is where they are at first;
            left out: all of them.
    """

    displacement: ArrayLike = 0.0
    velocity: ArrayLike = 1.0
    acceleration: ArrayLike = 0.0
    rest: ArrayLike | None = None


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """Joint trajectories along a path.

    Attributes:
        task: what was held.
        time: (K,) s.
        q: (K, n) postures inside the limits (rad or m).
        error: (K,) what is missing to the target: m, with angles times the rotation scale.
        met: (K,) whether the target was met.
        largest_step: largest change of a joint between samples (rad or m).
        status: whether all targets were met without a jump.
    """

    task: HandRows
    time: Float[np.ndarray, " samples"]
    q: Float[np.ndarray, "samples coords"]
    error: Float[np.ndarray, " samples"]
    met: Bool[np.ndarray, " samples"]
    largest_step: float
    status: Status

    def to_frame(self) -> "pd.DataFrame":
        """Give a table: time (s), joints (rad or m), error (mm), whether the target was met."""
        import pandas as pd

        frame = pd.DataFrame(self.q, columns=pd.Index(self.task.arm.joints))
        frame.insert(0, "time", self.time)
        frame["error_mm"], frame["met"] = 1e3 * self.error, self.met
        return frame


@dataclass(frozen=True, eq=False)
class Arc:
    """A feasible part of a closed path.

    Attributes:
        first: parameter at which it begins (rad).
        last: parameter at which it ends, above `first` (rad); a full turn has ``first + 2 pi``.
        path: joint trajectories along it, from the start posture that came furthest.
    """

    first: float
    last: float
    path: FollowedPath


def follow(
    task: HandRows,
    target: ArrayLike,
    *,
    time: ArrayLike | None = None,
    start: ArrayLike | None = None,
    costs: PathCosts | None = None,
    jump: float = JUMP,
) -> FollowedPath:
    """Follow a timed path of targets, each posture from the one before.

    Args:
        task: rows held.
        target: (K, m) values of the rows (m, rad) or (K, 4, 4) frames.
        time: (K,) increasing times (s); left out: one second a sample.
        start: (n,) posture at which the joints are before the first sample (rad or m); left out:
            a posture that meets the first target.
        costs: what the joints pay; left out: velocity of all joints alike.
        jump: a larger change of a joint between samples is a jump (rad or m).

    Raises:
        ShapeError: time, start or a weight does not fit.
        NotFiniteError: an array holds NaN (other than `rest`) or infinite values.
        RangeError: no target, time does not increase, or a weight is negative, or all are zero.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import load_arm
        >>> task = HandRows(load_arm("upper_limb"), ("x", "y", "z"))
        >>> line = np.linspace([0.1, 0.4, -0.2], [0.3, 0.4, 0.0], 20)
        >>> follow(task, line).status.ok
        True
    """
    goals = task.goals(target)
    n_samples, n = len(goals.position), task.arm.n_joints
    if not n_samples:
        raise RangeError("target: 0 samples; at least one is needed")
    times = np.arange(float(n_samples)) if time is None else as_float_array("time", time)
    require_shape("time", times, (n_samples,))
    require_finite("time", times)
    dt = np.diff(times, prepend=2 * times[0] - times[min(1, n_samples - 1)])
    if n_samples == 1:
        dt = np.ones(1)
    if not (dt > 0).all():
        raise RangeError(f"time must increase; it does not at sample {int(np.argmin(dt))}")
    array = as_float_array("target", target)
    single = array.shape == (len(task.rows),) or (n_samples == 1 and array.shape == (4, 4))
    first = array if single else array[0]
    before = _first(task, first, start)
    pay = costs or PathCosts()
    weights = np.array([_weight(w, n) for w in (pay.displacement, pay.velocity, pay.acceleration)])
    if not (weights.sum(axis=0) > 0).all():
        raise RangeError("costs: each joint needs a displacement, velocity or acceleration weight")
    rest = _rest(pay.rest, before)
    q, error = np.empty((n_samples, n)), np.empty(n_samples)
    axes = np.array(task.axes, dtype=np.int64)
    rows = Rows(axes, task.mode, task.rotation_scale, np.ones(n))
    tolerances = Options(MET, MET / task.rotation_scale, STEPS, 0, False)
    ik_kernels.follow_batch(
        model_of(task), rows, goals, weights, rest, before, dt, tolerances, q, error
    )
    largest = float(np.abs(np.diff(q, axis=0)).max()) if n_samples > 1 else 0.0
    return FollowedPath(
        task,
        times,
        freeze(q),
        freeze(error),
        freeze(error <= 10 * MET),
        largest,
        _status(error, largest, jump),
    )


def device_circle(
    centre: ArrayLike, radius: float, plane: str, angles: ArrayLike
) -> Float[np.ndarray, "samples 3"]:
    """Give points on a device's circle (m), in the plane "yz", "xz" or "xy" through its centre.

    Angles (rad) count from the plane's first axis towards its second; the paper's planes are the
    sagittal "yz" and the coronal "xz".

    Raises:
        RangeError: another plane, or a radius that is not positive.
    """
    if plane not in PLANES:
        raise RangeError(f"plane = {plane!r}: allowed is {', '.join(PLANES)}")
    if not radius > 0:
        raise RangeError(f"radius = {radius:g} m: must be above 0")
    a = as_float_array("angles", angles, ndim=1)
    points = np.tile(as_float_array("centre", centre, ndim=1), (len(a), 1))
    first, second = PLANES[plane]
    points[:, first] += radius * np.cos(a)
    points[:, second] += radius * np.sin(a)
    return points


def _first(task: HandRows, target: np.ndarray, start: ArrayLike | None) -> np.ndarray:
    if start is None:
        return solve_ik(task, target).q[0].copy()  # one type for the kernel: writable
    q = as_float_array("start", start)
    require_shape("start", q, (task.arm.n_joints,))
    require_finite("start", q)
    return np.clip(q, task.arm.lower, task.arm.upper)


def _rest(rest: ArrayLike | None, before: np.ndarray) -> np.ndarray:
    if rest is None:
        return before
    posture = as_float_array("rest", rest)
    require_shape("rest", posture, before.shape)
    posture = np.where(np.isnan(posture), before, posture)
    require_finite("rest", posture)
    return posture


def _weight(weight: ArrayLike, n: int) -> np.ndarray:
    w = as_float_array("weight", weight)
    if w.shape not in ((1,), (n,)):
        raise ShapeError(f"weight has shape {w.shape}; expected one number or ({n},)")
    if not (np.isfinite(w).all() and (w >= 0).all()):
        raise RangeError(f"weight = {w.tolist()}: allowed is 0 and above")
    return np.broadcast_to(w, (n,))


def _status(error: np.ndarray, largest: float, jump: float) -> Status:
    missed = int((error > 10 * MET).sum())
    if missed:
        first = int(np.argmax(error > 10 * MET))
        sentence = f"{missed} of {len(error)} samples not reached, the first is sample {first}"
        return Status(False, f"{sentence} ({1e3 * error[first]:.3g} mm short)")
    if largest > jump:
        return Status(False, f"all samples reached, but a joint jumps by {largest:.3g}")
    return Status(True, "followed without a jump")
