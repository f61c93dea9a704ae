"""Progress on stderr: only on a terminal, only when asked, counted on completion."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress(total: int, label: str, *, quiet: bool = False) -> Iterator[Callable[..., None]]:
    """Give a function to call as each item is completed; what it is called with is ignored.

    Args:
        total: number of items.
        label: what is being done, in a word or two.
        quiet: show nothing.

    Example:
        >>> with progress(2, "fitting", quiet=True) as done:
        ...     done()
        ...     done("an outcome")
    """
    if quiet or total < 2 or not sys.stderr.isatty():
        yield lambda *outcome: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(
        *columns, TimeElapsedColumn(), console=Console(stderr=True), transient=True
    ) as bar:
        task = bar.add_task(label, total=total)
        yield lambda *outcome: bar.advance(task)
