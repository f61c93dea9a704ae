"""Many items through one function: in this process, on all cores, or on a cluster.

An item that fails says so in its outcome and the rest goes on. With a journal, every outcome is
on disk as soon as it is there: a run that was interrupted, however rudely, goes on where it was.
"""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar, cast

from selfmotion.errors import MissingExtraError, RangeError, SelfmotionError, Status

Payload = TypeVar("Payload")
DONE = Status(True, "done")


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
        RangeError: two items have the same key.
        MissingExtraError: a scheduler is named and dask.distributed is not installed.

    Example:
        >>> def half(x):
        ...     return {"half": x / 2}
        >>> [o.result for o in run_batch(half, [Item("a", 3.0), Item("b", 5.0)], Runner())]
        [{'half': 1.5}, {'half': 2.5}]
    """
    keys = [item.key for item in items]
    if len(set(keys)) != len(keys):
        twice = next(key for key in keys if keys.count(key) > 1)
        raise RangeError(f"batch: item {twice!r} stands twice; each key must be unique")
    done = _journalled(runner, items)
    for outcome in done.values():
        runner.on_done(outcome)
    todo = [item for item in items if item.key not in done]
    with _Journal(runner) as journal:
        for item, outcome in _completed(function, todo, runner):
            journal.add(item, outcome)
            done[item.key] = outcome
            runner.on_done(outcome)
    return [done[key] for key in keys]


def _attempt(
    function: Callable[[Payload], dict[str, Any]], number: int, item: Item
) -> tuple[int, Outcome]:
    """Run one item; whatever goes wrong belongs to that item alone."""
    try:
        return number, Outcome(item.key, function(item.payload))
    except (SelfmotionError, OSError) as error:
        return number, Outcome(item.key, None, Status(False, " ".join(str(error).split())))
    except Exception as error:  # a defect must not take the other items along
        reason = f"internal error: {type(error).__name__}: {error}"
        return number, Outcome(item.key, None, Status(False, " ".join(reason.split())))


def _completed(
    function: Callable[[Payload], dict[str, Any]], items: list[Item], runner: Runner
) -> Iterator[tuple[Item, Outcome]]:
    """Yield items with their outcomes in the order of completion."""
    if runner.scheduler is None and runner.jobs == 1:
        for number, item in enumerate(items):
            yield item, _attempt(function, number, item)[1]
        return
    import joblib

    calls = (joblib.delayed(_attempt)(function, i, item) for i, item in enumerate(items))
    with _backend(runner):
        outcomes = joblib.Parallel(return_as="generator_unordered")(calls)
        for number, outcome in cast(Iterator[tuple[int, Outcome]], outcomes):
            yield items[number], outcome


@contextmanager
def _backend(runner: Runner) -> Iterator[None]:
    """Choose joblib's backend: local processes of one thread, or a dask cluster."""
    import joblib

    if runner.scheduler is None:
        with joblib.parallel_config(backend="loky", n_jobs=runner.jobs, inner_max_num_threads=1):
            yield
        return
    try:
        from distributed import Client
    except ImportError:
        raise MissingExtraError(
            "scheduler: dask.distributed is not installed; pip install 'selfmotion[scale]'"
        ) from None
    try:
        client = Client(runner.scheduler, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise RangeError(f"scheduler {runner.scheduler!r}: no answer ({error})") from None
    with client, joblib.parallel_config(backend="dask", client=client):
        yield


def _journalled(runner: Runner, items: Sequence[Item]) -> dict[str, Outcome]:
    """Read what an earlier run completed; a last line that was cut off does not count."""
    if not runner.resume or runner.journal is None or not runner.journal.exists():
        return {}
    wanted = {item.key: item.fingerprint for item in items}
    done = {}
    for line in runner.journal.read_text(encoding="utf-8").splitlines():
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue
        if wanted.get(entry["key"]) == entry["fingerprint"] and entry["ok"]:
            done[entry["key"]] = Outcome(
                entry["key"], entry["result"], Status(True, entry["status"])
            )
    return done


class _Journal:
    """Append-only file of outcomes; each line is on disk before the next item counts."""

    def __init__(self, runner: Runner) -> None:
        self._path, self._resume = runner.journal, runner.resume
        self._stream = None

    def __enter__(self) -> "_Journal":
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = open(self._path, "a" if self._resume else "w", encoding="utf-8")
            if self._stream.tell() > 0:
                self._stream.write("\n")  # a line that was cut off must not swallow the next
        return self

    def __exit__(self, *exception: object) -> None:
        if self._stream is not None:
            self._stream.close()

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
        os.fsync(self._stream.fileno())
