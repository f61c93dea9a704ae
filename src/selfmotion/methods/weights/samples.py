"""Recorded samples as the identification of IK weights streams through them, never copied.

A :class:`Samples` holds the arrays of every recording side by side with a plan: chunks of at most
`CHUNK` samples, none of which reaches over the border of a cluster (a trial, or a stretch of one).
All sums are taken chunk by chunk and added up in the order of the chunks, so that no result
depends on the number of threads.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numba
import numpy as np

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.errors import RangeError, ShapeError
from selfmotion.motion.recording import Recording

CHUNK = 4096
"""Samples a chunk: what is held of intermediate results at any time is one chunk a thread."""
THREAD_WORTH = 32_768
"""Below so many samples starting threads costs more than it saves."""
SHORT_RUN = 16
"""Interleaved trial numbers with shorter runs than this are sorted (the only case of a copy)."""


@dataclass(frozen=True, eq=False)
class Part:
    """Arrays of one recording, or of several trials in one array.

    Attributes:
        name: what to call it in a message.
        qd: joint velocities (K, n), rad/s (m/s for prismatic joints).
        jacobian: task Jacobian (K, m, n).
        q: posture (K, n), or (0, n) where it is not needed.
        xd: task velocity (K, m), or (0, m) where it is not known.
        runs: first and last-plus-one sample of each stretch that belongs to one trial.
        trials: number of the trial of each run.
    """

    name: str
    qd: np.ndarray
    jacobian: np.ndarray
    q: np.ndarray
    xd: np.ndarray
    runs: np.ndarray
    trials: np.ndarray


@dataclass(frozen=True, eq=False)
class Samples:
    """All samples of one estimate, with the plan of chunks.

    Attributes:
        joints: joint names (n).
        parts: the arrays.
        keep: per part, a code a sample (see `kernels`); filled by the survey.
        bounds: per part, first and last-plus-one sample of each chunk.
        cluster: number of the cluster of each chunk, over all parts.
        n_trials: number of trials.
        n_clusters: number of clusters.
        stretches: clusters that each trial was cut into, in the order of time; 1: none was cut.
    """

    joints: tuple[str, ...]
    parts: tuple[Part, ...]
    keep: tuple[np.ndarray, ...]
    bounds: tuple[np.ndarray, ...]
    cluster: np.ndarray
    n_trials: int
    n_clusters: int
    stretches: int = 1

    @property
    def n_all(self) -> int:
        """Samples in all, the dropped ones included."""
        return sum(len(part.qd) for part in self.parts)

    @property
    def n_rows(self) -> int:
        """Task rows m."""
        return self.parts[0].jacobian.shape[1]


def part_from_arrays(
    name: str,
    qd: np.ndarray,
    jacobian: np.ndarray,
    *,
    q: np.ndarray | None = None,
    xd: np.ndarray | None = None,
    trial: np.ndarray | None = None,
) -> Part:
    """Check shapes and take read-only views.

    C-contiguous float64 arrays are not copied. Interleaved trial numbers are sorted first.

    Raises:
        ShapeError: the arrays do not fit together; names the array, its shape and what fits.
    """
    qd = as_float_array(f"{name}: qd", qd, ndim=2)
    jacobian = as_float_array(f"{name}: jacobian", jacobian, ndim=3)
    K, n = qd.shape
    if n == 0:
        raise ShapeError(f"{name}: qd has shape {qd.shape}; at least one joint is needed")
    require_shape(f"{name}: jacobian", jacobian, (K, None, n))
    posture = np.empty((0, n)) if q is None else as_float_array(f"{name}: q", q, ndim=2)
    task = np.empty((0, jacobian.shape[1]))
    if q is not None:
        require_shape(f"{name}: q", posture, (K, n))
    if xd is not None:
        task = as_float_array(f"{name}: xd", xd, ndim=2)
        require_shape(f"{name}: xd", task, (K, jacobian.shape[1]))
    numbers = _trial_numbers(name, trial, K)
    order = _order(numbers)
    arrays = [qd, jacobian, posture, task]
    if order is not None:
        numbers = numbers[order]
        arrays = [array[order] if len(array) else array for array in arrays]
    views = [array.view() for array in arrays]
    for view in views:  # one array type for the compiled kernels, whatever comes in
        view.setflags(write=False)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(numbers)) + 1, [K]])
    runs = np.stack([edges[:-1], edges[1:]], axis=1)
    return Part(name, views[0], views[1], views[2], views[3], runs, numbers[runs[:, 0]])


def _trial_numbers(name: str, trial: np.ndarray | None, K: int) -> np.ndarray:
    if K == 0:
        raise ShapeError(f"{name}: 0 samples; at least two are needed")
    if trial is None:
        return np.zeros(K, dtype=np.int64)
    labels = np.asarray(trial)
    if labels.shape != (K,):
        raise ShapeError(f"{name}: trial has shape {labels.shape}; allowed is ({K},)")
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def _order(numbers: np.ndarray) -> np.ndarray | None:
    n_runs = np.count_nonzero(np.diff(numbers)) + 1
    if n_runs > numbers.max() + 1 and len(numbers) < SHORT_RUN * n_runs:
        return np.argsort(numbers, kind="stable")
    return None


def plan_chunks(joints: tuple[str, ...], parts: Sequence[Part], *, min_clusters: int) -> Samples:
    """Cut parts into chunks and say which cluster each chunk belongs to.

    A cluster is a trial. With fewer trials than `min_clusters` each trial is cut into equal
    stretches of time, as few and so as long as gives enough clusters for a standard error:
    neighbouring stretches depend on each other, the less so the longer they are.
    """
    offset = 0
    trials = []
    for part in parts:  # trials of different parts are different trials
        trials.append(part.trials + offset)
        offset = int(trials[-1].max()) + 1
    n_trials = len(np.unique(np.concatenate(trials)))
    stretches = -(-min_clusters // n_trials) if n_trials < min_clusters else 1
    bounds, cluster = [], []
    for part, numbers in zip(parts, trials, strict=True):
        rows = []
        for (start, stop), number in zip(part.runs, numbers, strict=True):
            cuts = np.unique(np.linspace(start, stop, stretches + 1).astype(np.int64))
            for piece in range(len(cuts) - 1):
                for at in range(cuts[piece], cuts[piece + 1], CHUNK):
                    rows.append((at, min(at + CHUNK, cuts[piece + 1])))
                    cluster.append(number * stretches + piece)
        bounds.append(np.array(rows, dtype=np.int64))
    labels = np.unique(np.array(cluster), return_inverse=True)[1]
    keep = tuple(np.zeros(len(part.qd), dtype=np.uint8) for part in parts)
    clusters = int(labels.max()) + 1
    return Samples(joints, tuple(parts), keep, tuple(bounds), labels, n_trials, clusters, stretches)


def samples_from_recordings(
    recordings: Iterable[Recording], *, with_posture: bool, min_clusters: Callable[[int], int]
) -> Samples:
    """Take the arrays of recordings, each of which is one trial.

    Args:
        recordings: with `qd` and `jacobian`.
        with_posture: whether `q` is needed.
        min_clusters: the number of joints to the number of clusters wanted.

    Raises:
        ShapeError: a field is missing, or recordings disagree in joints or task rows.
    """
    wanted = ("qd", "jacobian", "q") if with_posture else ("qd", "jacobian")
    parts: list[Part] = []
    joints: tuple[str, ...] = ()
    for recording in recordings:
        name = recording.name
        missing = [field for field in wanted if field not in recording.held]
        if missing:
            raise ShapeError(f"{name}: {' and '.join(missing)} needed to identify weights")
        q = recording.q if with_posture else None
        qd, jacobian = recording.array("qd"), recording.array("jacobian")
        parts.append(part_from_arrays(name, qd, jacobian, q=q, xd=recording.xd))
        joints = joints or recording.joints
        if recording.joints != joints:
            raise ShapeError(
                f"{name}: joints {', '.join(recording.joints)}; "
                f"the first recording has {', '.join(joints)}"
            )
        rows = parts[0].jacobian.shape[1]
        require_shape(f"{name}: jacobian", jacobian, (None, rows, len(joints)))
    if not parts:
        raise RangeError("identify_weights: 0 recordings; at least one is needed")
    return plan_chunks(joints, parts, min_clusters=min_clusters(len(joints)))


def sweep(samples: Samples, work: Callable[[int, slice, slice], None]) -> None:
    """Run `work(part, chunks of the part, chunks of all)` over everything, on numba's threads."""
    tasks: list[tuple[int, slice, slice]] = []
    offset = 0
    for number, bounds in enumerate(samples.bounds):
        step = max(1, THREAD_WORTH // CHUNK)
        for at in range(0, len(bounds), step):
            stop = min(at + step, len(bounds))
            tasks.append((number, slice(at, stop), slice(offset + at, offset + stop)))
        offset += len(bounds)
    threads = min(numba.get_num_threads(), len(tasks))
    if threads < 2 or samples.n_all < THREAD_WORTH:
        _run(work, tasks)
        return
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(lambda first: _run(work, tasks[first::threads]), range(threads)):
            pass


def _run(
    work: Callable[[int, slice, slice], None], tasks: Sequence[tuple[int, slice, slice]]
) -> None:
    for number, chunks, everywhere in tasks:
        work(number, chunks, everywhere)


def by_cluster(samples: Samples, per_chunk: np.ndarray) -> np.ndarray:
    """Add up chunks (C, ...) into clusters (G, ...), in order."""
    total = np.zeros((samples.n_clusters, *per_chunk.shape[1:]))
    np.add.at(total, samples.cluster, per_chunk)
    return total
