"""Follow a path of the hand with the joints inside their limits, and find which part is feasible.

[DeBoon] scenarios 2 and 3 (J Biomech Eng): the palm on a circle of a device, its roll held. The
rows that are held are x, y, z and ψ; eqs 19 and 22 drop the constrained rows, which leaves x (or
y) and ψ free.

At each sample the posture minimises a cost that is quadratic in displacement from a rest posture,
velocity and acceleration of the joints (section 5), with the task and the limits met exactly:
``½ Σ h (q - c)²`` with h and c from the samples before.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.methods.ik_tasks import HandRows
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik

if TYPE_CHECKING:
    import pandas as pd

# Error of a sample that counts as met (m, with angles times the rotation scale), and steps tried.
MET, STEPS = 1e-6, 15
# A joint that moves further between samples has jumped (rad or m), unless told otherwise.
JUMP = 0.25
# Keeps a step finite where the task loses rank (squared rows over weight).
DAMPING = 1e-10


@dataclass(frozen=True, eq=False)
class PathCosts:
    """What the joints pay along a path; each weight is one number or one a joint.

    Attributes:
        displacement: weight of the squared distance from `rest`.
        velocity: weight of the squared joint velocity, s²; weights of `identify_weights` go here.
        acceleration: weight of the squared joint acceleration, s⁴.
        rest: (n,) rest posture (rad or m); left out: the first posture.
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
        NotFiniteError: an array holds NaN or infinite values.
        RangeError: time does not increase, or a weight is negative, or all are zero.

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
    times = np.arange(float(n_samples)) if time is None else as_float_array("time", time)
    require_shape("time", times, (n_samples,))
    require_finite("time", times)
    dt = np.diff(times, prepend=2 * times[0] - times[min(1, n_samples - 1)])
    if n_samples > 1 and not (dt > 0).all():
        raise RangeError(f"time must increase; it does not at sample {int(np.argmin(dt))}")
    array = as_float_array("target", target)
    single = array.shape == (len(task.rows),) or (n_samples == 1 and array.shape == (4, 4))
    targets = array[None] if single else array
    before = _first(task, targets[0], start)
    weights = [_weight(w, n) for w in _weights(costs or PathCosts())]
    rest = before if costs is None or costs.rest is None else as_float_array("rest", costs.rest)
    require_shape("rest", rest, (n,))
    q, error = np.empty((n_samples, n)), np.empty(n_samples)
    last, earlier = before, before
    for k in range(n_samples):
        step = dt[k] if n_samples > 1 else 1.0
        v, a = weights[1] / step**2, weights[2] / step**4
        h = weights[0] + v + a
        if not (h > 0).all():
            raise RangeError(
                "costs: each joint needs a positive displacement, velocity or acceleration weight"
            )
        centre = (weights[0] * rest + v * last + a * (2 * last - earlier)) / h
        q[k], error[k] = _nearest(task, targets[k], last, h, centre)
        earlier, last = last, q[k]
    largest = float(np.abs(np.diff(q, axis=0)).max()) if n_samples > 1 else 0.0
    return FollowedPath(
        task, times, freeze(q), error, error <= 10 * MET, largest, _status(error, largest, jump)
    )


def _nearest(
    task: HandRows, target: np.ndarray, q: np.ndarray, h: np.ndarray, centre: np.ndarray
) -> tuple[np.ndarray, float]:
    """Minimise ``½ Σ h (q - centre)²`` on the task inside the limits, from a posture near by."""
    scale = np.append(task.row_scale, task.rotation_scale)
    best, best_error = q, np.inf
    for _ in range(STEPS):
        e = task.error(q, target)[0]
        s = scale[: len(e)]
        error = float(np.linalg.norm(s * e))
        step = _step(s[:, None] * task.jacobian(q)[0], s * e, q, (h, centre), task)
        if error < best_error or error <= MET:
            best, best_error = q, error
        if error <= MET and np.abs(step).max() < 1e-7:
            break
        q = q + step * min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300))
    if best_error > MET:  # the local step failed: from the last posture by the robust solver
        found = solve_ik(task, target, start=best, options=IkOptions(restarts=0))
        if found.solved[0]:
            return found.q[0], MET
    return best, best_error


def _step(
    J: np.ndarray,
    e: np.ndarray,
    q: np.ndarray,
    cost: tuple[np.ndarray, np.ndarray],
    task: HandRows,
) -> np.ndarray:
    """Solve the step's quadratic programme: joints that pass a limit are set on it, in turn."""
    h, centre = cost
    lower, upper = task.arm.lower - q, task.arm.upper - q
    wanted = np.clip(centre - q, lower, upper)
    fixed, value = np.zeros(len(q), dtype=np.bool_), np.zeros(len(q))
    for _ in range(len(q)):
        free = ~fixed
        Jf, hf = J[:, free], h[free]
        right = e - J[:, fixed] @ value[fixed] - Jf @ wanted[free]
        y = np.linalg.solve((Jf / hf) @ Jf.T + DAMPING / h.min() * np.eye(len(e)), right)
        step = value.copy()
        step[free] = wanted[free] + Jf.T @ y / hf
        beyond = free & ((step < lower) | (step > upper))
        if not beyond.any():
            return step
        value = np.where(beyond, np.clip(step, lower, upper), value)
        fixed |= beyond
    return np.clip(value, lower, upper)


def device_circle(
    centre: ArrayLike, radius: float, plane: str, angles: ArrayLike
) -> Float[np.ndarray, "samples 3"]:
    """Give points on a device's circle (m), in the sagittal ("yz") or coronal ("xz") plane.

    Angles (rad) count from +y (sagittal) or +x (coronal) towards +z.

    Raises:
        RangeError: another plane, or a radius that is not positive.
    """
    if plane not in ("yz", "xz"):
        raise RangeError(f"plane = {plane!r}: allowed is 'yz' or 'xz'")
    if not radius > 0:
        raise RangeError(f"radius = {radius:g} m: must be above 0")
    a = as_float_array("angles", angles, ndim=1)
    points = np.tile(as_float_array("centre", centre, ndim=1), (len(a), 1))
    points[:, 1 if plane == "yz" else 0] += radius * np.cos(a)
    points[:, 2] += radius * np.sin(a)
    return points


def _first(task: HandRows, target: np.ndarray, start: ArrayLike | None) -> np.ndarray:
    if start is None:
        return solve_ik(task, target).q[0]
    q = as_float_array("start", start)
    require_shape("start", q, (task.arm.n_joints,))
    require_finite("start", q)
    return np.clip(q, task.arm.lower, task.arm.upper)


def _weights(costs: PathCosts) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
    return costs.displacement, costs.velocity, costs.acceleration


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
