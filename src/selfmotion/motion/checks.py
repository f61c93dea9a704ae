"""The checks that a recording makes of its arrays when it is built."""

import numpy as np

from selfmotion.arrays import require_finite, require_shape
from selfmotion.errors import NotFiniteError, RangeError, ShapeError

# Samples looked at in one go when searching for NaN, so that K = 1e6 needs no large temporary.
CHUNK = 65_536
# No length, angle or speed is larger in any unit; products of such values still do not overflow.
LARGEST = 1e50
# Largest |xd - J qd| relative to |xd| at which both can belong to one movement. Measured
# velocities differ from J qd by a few per cent; a wrong unit, sign or column by 30 % and more.
CONSISTENCY = 0.1
# A step of time this many times the median step is a hole in the recording: times that were rounded
# or jitter stay below.
HOLE = 2.5


def check_time(time: np.ndarray) -> None:
    """Refuse an empty, non-finite or not strictly increasing time axis."""
    if time.size == 0:
        raise ShapeError("time: 0 samples; at least one is needed")
    require_finite("time", time)
    refuse_infinite("time", time)
    backward = np.flatnonzero(np.diff(time) <= 0.0)
    if backward.size:
        at = int(backward[0]) + 1
        raise RangeError(
            f"time[{at}] = {time[at]:g} after {time[at - 1]:g}: time must increase strictly"
        )


def require_even_steps(name: str, time: np.ndarray) -> None:
    """Refuse times with a hole, across which a filter made for one rate would smear.

    Example:
        >>> require_even_steps("reach", np.array([0.0, 0.01, 0.02, 0.40, 0.41]))
        Traceback (most recent call last):
        ...
        selfmotion.errors.RangeError: reach: time steps by 0.38 s after 0.02 s, elsewhere by 0.01 \
s: samples are missing, so that no low-pass can be made for its rate; put them in as gaps, or cut \
the recording there
    """
    steps = np.diff(time)
    if not steps.size:
        return
    usual, at = float(np.median(steps)), int(np.argmax(steps))
    if steps[at] > HOLE * usual:
        raise RangeError(
            f"{name}: time steps by {steps[at]:.4g} s after {time[at]:.6g} s, elsewhere by "
            f"{usual:.4g} s: samples are missing, so that no low-pass can be made for its rate; "
            "put them in as gaps, or cut the recording there"
        )


def check_shapes(arrays: dict[str, np.ndarray]) -> tuple[int, int]:
    """Check that all arrays agree and suffice; give the numbers of joints and task rows."""
    if not ("q" in arrays or "x" in arrays or {"qd", "jacobian"} <= arrays.keys()):
        found = ", ".join(name for name in arrays if name != "time") or "nothing"
        raise ShapeError(f"recording: q, or qd with jacobian, or x is needed; found {found}")
    samples = len(arrays["time"])
    n_joints = {k: arrays[k].shape[-1] for k in ("q", "qd", "jacobian") if k in arrays}
    n_rows = {k: arrays[k].shape[1] for k in ("x", "xd", "jacobian") if k in arrays}
    n, m = next(iter(n_joints.values()), 0), next(iter(n_rows.values()), 0)
    for name, array in arrays.items():
        shape = {"q": (samples, n), "qd": (samples, n), "jacobian": (samples, m, n)}
        require_shape(name, array, (samples,) if name == "time" else shape.get(name, (samples, m)))
        if array.size == 0:
            raise ShapeError(f"{name}: shape {array.shape} holds no values")
    return n, m


def full_names(field: str, given: tuple[str, ...], default: tuple[str, ...]) -> tuple[str, ...]:
    """Give the names, or the default where none are given; refuse too few, too many, or twice."""
    names = tuple(str(name) for name in given) or default
    if len(names) != len(default):
        raise ShapeError(f"{field}: {len(names)} names for {len(default)} {field}")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ShapeError(f"{field}: {', '.join(twice)} named more than once")
    return names


def refuse_infinite(name: str, array: np.ndarray) -> None:
    """Refuse infinite and absurd values, naming the first; NaN is a gap and passes."""
    for at in range(0, len(array), CHUNK):
        bad = np.abs(array[at : at + CHUNK]) > LARGEST
        if bad.any():
            first = np.argwhere(bad)[0]
            first[0] += at
            where = ", ".join(str(int(i)) for i in first)
            raise NotFiniteError(
                f"{name}[{where}] = {array[tuple(first)]:g}: values must be finite and below "
                f"{LARGEST:g} (NaN marks a gap)"
            )


def refuse_partial_gaps(name: str, array: np.ndarray) -> None:
    """Refuse a sample in which some values are NaN and others are not: that is no gap.

    A sensor that loses its sight loses the whole sample. One NaN among good values is a fault of
    the computation behind it, and dropping the sample would hide it.
    """
    for at in range(0, len(array), CHUNK):
        part = array[at : at + CHUNK]
        bad = np.isnan(part).reshape(len(part), -1)
        partial = bad.any(axis=1) & ~bad.all(axis=1)
        if partial.any():
            row = int(np.flatnonzero(partial)[0])
            inner = np.unravel_index(int(np.flatnonzero(bad[row])[0]), part.shape[1:])
            where = ", ".join(str(int(i)) for i in (at + row, *inner))
            raise NotFiniteError(
                f"{name}[{where}] = nan: values must be finite (a gap is NaN in the whole sample)"
            )


def velocity_residual(jacobian: np.ndarray, qd: np.ndarray, xd: np.ndarray) -> float:
    """Give |xd - J qd| relative to the larger of |xd| and |J qd|, over all samples that hold both.

    0: they belong together; 1 and more: they do not (unit, sign, order of joints, frame).
    """
    apart = size = 0.0
    for at in range(0, len(qd), CHUNK):
        here = slice(at, at + CHUNK)
        predicted = np.einsum("kij,kj->ki", jacobian[here], qd[here])
        whole = ~(np.isnan(predicted) | np.isnan(xd[here])).any(axis=1)
        ours, theirs = predicted[whole], xd[here][whole]
        apart += float(((theirs - ours) ** 2).sum())
        size += float(np.maximum((theirs**2).sum(axis=1), (ours**2).sum(axis=1)).sum())
    return float(np.sqrt(apart / size)) if size > 0.0 else 0.0
