"""Many items through one function: in this process, on all cores, or on a cluster.

An item that fails says so in its outcome and the rest goes on; so does one that takes its worker
process down. With a journal, every outcome is in the file as soon as it is there: a run that was
interrupted, however rudely, goes on where it was.
"""

import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from selfmotion.batch.item import Item, Outcome
from selfmotion.batch.journal import Journal
from selfmotion.batch.workers import Pool, dask_cluster, local_processes
from selfmotion.errors import RangeError, SelfmotionError, Status

Payload = TypeVar("Payload")
# Seconds that what is sent to a worker at once should take at least and at most, and its length.
QUICK, SLOW, MOST_AT_ONCE = 0.1, 1.0, 1000
WORKER_DIED = "its worker process died: out of memory, or a crash in compiled code"


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
    with Journal(runner.journal, resume=runner.resume) as journal:
        known: deque[Item] = deque()
        todo = _unknown(_distinct(items), journal, known)
        for item, outcome in _completed(function, todo, runner):
            yield from _told(known, journal, runner)
            journal.add(item, outcome)
            runner.on_done(outcome)
            yield outcome
        yield from _told(known, journal, runner)


def _unknown(items: Iterable[Item], journal: Journal, known: deque[Item]) -> Iterator[Item]:
    """Pass on the items that the journal does not have; put the others aside."""
    for item in items:
        if journal.has(item):
            known.append(item)
        else:
            yield item


def _told(known: deque[Item], journal: Journal, runner: Runner) -> Iterator[Outcome]:
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
    if runner.scheduler is None:
        yield from _Sending(function, local_processes(runner.jobs)).run(items)
        return
    with dask_cluster(runner.scheduler) as pool:
        yield from _Sending(function, pool).run(items)


class _Sending:
    """Keeps every worker busy and little in the queue; sends again what a dead worker had."""

    def __init__(self, function: Callable[[Any], dict[str, Any]], pool: Pool) -> None:
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
