"""Run a command's items as a batch: options to runner, with the journal in the --out folder."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from selfmotion.errors import RangeError

if TYPE_CHECKING:
    from selfmotion.batch import Item, Outcome


@dataclass(frozen=True)
class BatchChoices:
    """Where a batch runs.

    Attributes:
        name: of the command; the journal is NAME.journal.jsonl.
        out: folder of the journal; none: no journal.
        jobs: processes.
        scheduler: address of a dask cluster.
        resume: keep what an interrupted run has completed.
        quiet: show no progress.
    """

    name: str
    out: Path | None = None
    jobs: int = 1
    scheduler: str | None = None
    resume: bool = False
    quiet: bool = False

    def __post_init__(self) -> None:
        """Check that there is something to go on with."""
        if self.resume and self.out is None:
            raise RangeError("--resume: name the folder of the interrupted run with --out DIR")


def run_items(
    function: Callable[[Any], dict[str, Any]], items: "Sequence[Item]", choices: BatchChoices
) -> "list[Outcome]":
    """Run a function over items, with progress on a terminal."""
    from selfmotion.batch import Runner, run_batch
    from selfmotion.cli.progress import progress

    journal = None if choices.out is None else choices.out / f"{choices.name}.journal.jsonl"
    with progress(len(items), choices.name, quiet=choices.quiet) as done:
        runner = Runner(
            jobs=choices.jobs,
            scheduler=choices.scheduler,
            journal=journal,
            resume=choices.resume,
            on_done=done,
        )
        return run_batch(function, items, runner)


def fingerprint(*parts: object) -> str:
    """Hash what an item's result depends on: anything whose repr says all of it."""
    from selfmotion._version import __version__

    text = repr((__version__, *parts))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def hash_if_file(name: str) -> str:
    """Give the hash of a model's file, or nothing where it is a name."""
    from selfmotion.provenance import hash_file

    return hash_file(name) if Path(name).is_file() else ""
