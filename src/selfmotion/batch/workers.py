"""Where a batch runs beside this process: local processes, or a dask cluster.

The local processes are joblib's, kept for the next batch: a worker has compiled its functions once.
Whatever needs processes takes them from here, since two users of joblib's pool that ask for
different ones break each other.
"""

import logging
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from selfmotion.errors import MissingExtraError, RangeError

Payload = TypeVar("Payload")
Answer = TypeVar("Answer")
# Each worker has a core for itself; libraries below must not start more threads.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")
    + ("VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS", "NUMEXPR_NUM_THREADS"),
    "1",
)


@dataclass(frozen=True)
class Pool:
    """Workers: how to send them something, how many there are, what is raised if one dies."""

    submit: Callable[..., Future]
    workers: Callable[[], int]
    deaths: tuple[type[BaseException], ...]


def map_in_order(
    function: Callable[[Payload], Answer], payloads: Iterable[Payload], jobs: int
) -> Iterator[Answer]:
    """Run a function on local processes and give what it returns in the order of its payloads.

    Args:
        function: importable by name; takes and returns what pickle can send.
        payloads: taken as workers become free, so that few answers wait at a time.
        jobs: processes; 1 runs in this one, -1 on every core.

    Raises:
        Exception: whatever the function raises.
    """
    if jobs == 1:
        yield from map(function, payloads)
        return
    pool = local_processes(jobs)
    sent: deque[Future[Answer]] = deque()
    for payload in payloads:
        sent.append(pool.submit(function, payload))
        if len(sent) > pool.workers():
            yield sent.popleft().result()
    yield from (future.result() for future in sent)


def local_processes(jobs: int) -> Pool:
    """Give processes of one thread each, -1 for every core."""
    from joblib import cpu_count
    from joblib.externals.loky import get_reusable_executor

    n = cpu_count() if jobs == -1 else jobs

    def submit(*call: Any) -> Future:  # after the death of a worker this is a new pool
        return get_reusable_executor(n, env=ONE_THREAD).submit(*call)

    return Pool(submit, lambda: n, (BrokenExecutor,))


@contextmanager
def dask_cluster(address: str) -> Iterator[Pool]:
    """Send to a dask cluster, which by itself sends again what a worker had that died."""
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise MissingExtraError(
            'scheduler: dask.distributed is not installed; pip install "selfmotion[scale]"'
        ) from None
    try:
        client = Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise RangeError(f"scheduler {address!r}: no answer ({error})") from None
    submit = client.get_executor(pure=False).submit

    def workers() -> int:  # asked for each time: workers come and go
        return sum(cast(dict[str, int], client.ncores()).values()) or 1

    with _quiet("distributed", "distributed.client"), client:
        try:
            yield Pool(submit, workers, (KilledWorker,))
        except (CancelledError, OSError):  # what dask raises when its scheduler does not answer
            raise RangeError(
                f"scheduler {address!r}: lost in mid-run; what was completed stands in the journal"
            ) from None


@contextmanager
def _quiet(*loggers: str) -> Iterator[None]:
    """Keep the tracebacks that a library logs away from the reader of our one line."""
    before = {log: log.level for log in map(logging.getLogger, loggers)}
    for log in before:
        log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for log, level in before.items():
            log.setLevel(level)
