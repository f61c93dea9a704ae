"""Many items through one function: in this process, on all cores, or on a cluster.

An item that fails says so in its outcome and the rest goes on; so does one that takes its worker
process down. With a journal, every outcome is in the file as soon as it is there: a run that was
interrupted, however rudely, goes on where it was.
"""

import json
import logging
import os
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar, cast

from selfmotion.errors import MissingExtraError, RangeError, SelfmotionError, Status

Payload = TypeVar("Payload")
DONE = Status(True, "done")
# Seconds between two syncs of the journal to the disk: what a power cut can cost.
SYNC_EVERY = 1.0
# Seconds that what is sent to a worker at once should take at least and at most, and its length.
QUICK, SLOW, MOST_AT_ONCE = 0.1, 1.0, 1000
WORKER_DIED = "its worker process died: out of memory, or a crash in compiled code"
# Each worker has a core for itself; libraries below must not start more threads.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")
    + ("VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS", "NUMEXPR_NUM_THREADS"),
    "1",
)


@dataclass(frozen=True)
class Item:
    """One piece of work.

    Attributes:
        key: its name, once in a batch.
        payload: what the function takes; picklable.
        fingerprint: hash of everything that the result depends on; a journalled outcome counts
            only if it has the same.
    """

    key: str
    payload: Any
    fingerprint: str = ""


@dataclass(frozen=True)
class Outcome:
    """What came of an item: the function's dictionary, or None and the reason why."""

    key: str
    result: dict[str, Any] | None
    status: Status = DONE


@dataclass(frozen=True)
class Runner:
    """Where a batch runs, and where its outcomes are kept meanwhile.

    Attributes:
        jobs: processes of one thread each; 1 runs in this process, -1 on every core.
        scheduler: address of a dask.distributed scheduler (extra `scale`); wins over `jobs`.
        journal: file of outcomes, one JSON line each; left out: none is kept.
        resume: take from the journal what is there already; else the journal starts anew.
    """

    jobs: int = 1
    scheduler: str | None = None
    journal: Path | None = None
    resume: bool = False
    on_done: Callable[[Outcome], None] = field(default=lambda outcome: None)

    def __post_init__(self) -> None:
        """Check the number of jobs."""
        if self.jobs < 1 and self.jobs != -1:
            raise RangeError(f"jobs = {self.jobs}: allowed is 1 and above, or -1 for every core")


def run_batch(
    function: Callable[[Payload], dict[str, Any]], items: Sequence[Item], runner: Runner
) -> list[Outcome]:
    """Run a function over items and give the outcomes in the items' order.

    Args:
        function: importable by name; takes a payload, returns what JSON can hold.
        items: with distinct keys.
        runner: where to run, and the journal.

    Returns:
        One outcome an item; `runner.on_done` has seen each as it was completed.

    Raises:
        RangeError: two items have the same key, or the scheduler does not answer.
        MissingExtraError: a scheduler is named and dask.distributed is not installed.

    Example:
        >>> def half(x):
        ...     return {"half": x / 2}
        >>> [o.result for o in run_batch(half, [Item("a", 3.0), Item("b", 5.0)], Runner())]
        [{'half': 1.5}, {'half': 2.5}]
    """
    for _ in _distinct(items):
        pass
    done = {outcome.key: outcome for outcome in iterate_batch(function, items, runner)}
    return [done[item.key] for item in items]


def iterate_batch(
    function: Callable[[Payload], dict[str, Any]], items: Iterable[Item], runner: Runner
) -> Generator[Outcome, None, None]:
    """Run a function over items and give each outcome as it is completed.

    For more items than fit into memory: items are taken when a worker is free, and of those that
    are done only the key is kept.

    Args:
        function: importable by name; takes a payload, returns what JSON can hold.
        items: with distinct keys; a generator serves.
        runner: where to run, and the journal.

    Yields:
        The outcomes, first those that an earlier run has left in the journal.

    Raises:
        RangeError, MissingExtraError: as in `run_batch`.

    Example:
        >>> def half(x):
        ...     return {"half": x / 2}
        >>> numbers = (Item(str(k), float(k)) for k in range(100_000))
        >>> sum(o.result["half"] for o in iterate_batch(half, numbers, Runner()))
        2499975000.0
    """
    with _Journal(runner) as journal:
        known: deque[Item] = deque()
        todo = _unknown(_distinct(items), journal, known)
        for item, outcome in _completed(function, todo, runner):
            yield from _told(known, journal, runner)
            journal.add(item, outcome)
            runner.on_done(outcome)
            yield outcome
        yield from _told(known, journal, runner)


def _unknown(items: Iterable[Item], journal: "_Journal", known: deque[Item]) -> Iterator[Item]:
    """Pass on the items that the journal does not have; put the others aside."""
    for item in items:
        if journal.has(item):
            known.append(item)
        else:
            yield item


def _told(known: deque[Item], journal: "_Journal", runner: Runner) -> Iterator[Outcome]:
    while known:
        outcome = journal.outcome(known.popleft())
        runner.on_done(outcome)
        yield outcome


def _distinct(items: Iterable[Item]) -> Iterator[Item]:
    seen: set[str] = set()
    for item in items:
        if item.key in seen:
            raise RangeError(f"batch: item {item.key!r} stands twice; each key must be unique")
        seen.add(item.key)
        yield item


def _attempt(function: Callable[[Payload], dict[str, Any]], item: Item) -> Outcome:
    """Run one item; whatever goes wrong belongs to that item alone."""
    try:
        return Outcome(item.key, function(item.payload))
    except (SelfmotionError, OSError) as error:
        return Outcome(item.key, None, Status(False, " ".join(str(error).split())))
    except Exception as error:  # a defect must not take the other items along
        reason = f"internal error: {type(error).__name__}: {error}"
        return Outcome(item.key, None, Status(False, " ".join(reason.split())))


def _attempt_all(
    function: Callable[[Payload], dict[str, Any]], items: list[Item]
) -> tuple[list[Outcome], float]:
    """Run some items in a worker; give also the seconds it took."""
    begin = time.perf_counter()
    return [_attempt(function, item) for item in items], time.perf_counter() - begin


def _completed(
    function: Callable[[Payload], dict[str, Any]], items: Iterator[Item], runner: Runner
) -> Iterator[tuple[Item, Outcome]]:
    """Yield items with their outcomes in the order of completion."""
    if runner.scheduler is None and runner.jobs == 1:
        for item in items:
            yield item, _attempt(function, item)
        return
    with _pool(runner) as pool:
        yield from _Sending(function, pool).run(items)


@dataclass(frozen=True)
class _Pool:
    """Workers: how to send them something, how many there are, what is raised if one dies."""

    submit: Callable[..., Future]
    workers: Callable[[], int]
    deaths: tuple[type[BaseException], ...]


class _Sending:
    """Keeps every worker busy and little in the queue; sends again what a dead worker had."""

    def __init__(self, function: Callable[[Any], dict[str, Any]], pool: _Pool) -> None:
        self._function, self._pool = function, pool
        self._sent: dict[Future, list[Item]] = {}
        self._suspects: deque[Item] = deque()
        self._size = 1

    def run(self, items: Iterator[Item]) -> Iterator[tuple[Item, Outcome]]:
        more = True
        while more or self._sent or self._suspects:
            while self._suspects and not self._sent:
                yield self._alone(self._suspects.popleft())
            while more and not self._suspects and len(self._sent) < 2 * self._pool.workers():
                some = list(islice(items, self._size))
                more = bool(some)
                if some:
                    self._send(some)
            for future in wait(self._sent, return_when=FIRST_COMPLETED).done:
                yield from self._received(future)

    def _send(self, items: list[Item]) -> None:
        try:
            self._sent[self._pool.submit(_attempt_all, self._function, items)] = items
        except self._pool.deaths:
            self._suspects.extend(items)

    def _received(self, future: Future) -> Iterator[tuple[Item, Outcome]]:
        items = self._sent.pop(future)
        try:
            outcomes, seconds = future.result()
        except self._pool.deaths:
            self._suspects.extend(items)
            return
        self._size = _next_size(len(items), seconds, self._size)
        yield from zip(items, outcomes, strict=True)

    def _alone(self, item: Item) -> tuple[Item, Outcome]:
        """Run an item whose worker died with nothing beside it, so that it is known whose fault."""
        try:
            ((outcome,), _) = self._pool.submit(_attempt_all, self._function, [item]).result()
        except self._pool.deaths:
            outcome = Outcome(item.key, None, Status(False, WORKER_DIED))
        return item, outcome


def _next_size(length: int, seconds: float, size: int) -> int:
    """Give how many items to send at once, so that sending costs little and little is lost."""
    if seconds < QUICK and length >= size:
        return min(2 * size, MOST_AT_ONCE)
    return max(1, size // 2) if seconds > SLOW else size


@contextmanager
def _pool(runner: Runner) -> Iterator[_Pool]:
    """Choose the workers: local processes of one thread, or a dask cluster."""
    if runner.scheduler is not None:
        with _cluster(runner.scheduler) as pool:
            yield pool
        return
    from joblib import cpu_count
    from joblib.externals.loky import get_reusable_executor

    n = cpu_count() if runner.jobs == -1 else runner.jobs

    def submit(*call: Any) -> Future:  # after the death of a worker this is a new pool
        return get_reusable_executor(n, env=ONE_THREAD).submit(*call)

    yield _Pool(submit, lambda: n, (BrokenExecutor,))


@contextmanager
def _cluster(address: str) -> Iterator[_Pool]:
    """Send to a dask cluster, which by itself sends again what a worker had that died."""
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise MissingExtraError(
            "scheduler: dask.distributed is not installed; pip install 'selfmotion[scale]'"
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
            yield _Pool(submit, workers, (KilledWorker,))
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


class _Journal:
    """File of outcomes, a line each; outcomes stay in the file, the memory holds where."""

    def __init__(self, runner: Runner) -> None:
        self._path, self._resume = runner.journal, runner.resume
        self._places: dict[str, tuple[str, int]] = {}
        self._stream, self._reader = None, None
        self._synced = 0.0

    def __enter__(self) -> "_Journal":
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            if self._resume and self._path.exists():
                self._reader = open(self._path, "rb")
                self._find_places()
            self._stream = open(self._path, "a" if self._resume else "w", encoding="utf-8")
            if self._stream.tell() > 0:
                self._stream.write("\n")  # a line that was cut off must not swallow the next
        return self

    def __exit__(self, *exception: object) -> None:
        if self._stream is not None:
            self._stream.close()
        if self._reader is not None:
            self._reader.close()

    def _find_places(self) -> None:
        """Note where each completed item stands; a last line that was cut off does not count."""
        assert self._reader is not None
        place = 0
        for line in self._reader:
            entry = _entry(line)
            if entry is not None and entry["ok"]:
                self._places[entry["key"]] = (entry["fingerprint"], place)
            place += len(line)

    def has(self, item: Item) -> bool:
        """Tell whether an earlier run has completed this very item."""
        return item.key in self._places and self._places[item.key][0] == item.fingerprint

    def outcome(self, item: Item) -> Outcome:
        """Give what the earlier run made of it."""
        assert self._reader is not None
        self._reader.seek(self._places[item.key][1])
        entry = _entry(self._reader.readline())
        assert entry is not None
        return Outcome(item.key, entry["result"], Status(True, entry["status"]))

    def add(self, item: Item, outcome: Outcome) -> None:
        if self._stream is None:
            return
        entry = {
            "key": item.key,
            "fingerprint": item.fingerprint,
            "ok": outcome.status.ok,
            "status": outcome.status.sentence,
            "result": outcome.result,
        }
        self._stream.write(json.dumps(entry) + "\n")
        self._stream.flush()
        if time.monotonic() - self._synced > SYNC_EVERY:
            os.fsync(self._stream.fileno())
            self._synced = time.monotonic()


def _entry(line: bytes) -> dict[str, Any] | None:
    """Read a line of the journal; None where a crash has cut it off."""
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    return entry if isinstance(entry, dict) else None
