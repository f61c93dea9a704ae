"""Progress on stderr: only on a terminal, only when asked, counted on completion."""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

COMPILING = "compiling for this machine: a minute or two, the first time only"
# Seconds between looks whether numba is there to be listened to.
LOOK = 0.2


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


@contextmanager
def stages(*, quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """Give a function that is told what is being done now; it shows that with the time so far.

    For one long piece of work, where there is nothing to count.

    Args:
        quiet: show nothing.

    Example:
        >>> with stages(quiet=True) as tell:
        ...     tell("calibrating")
    """
    if quiet or not sys.stderr.isatty():
        yield lambda sentence: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task("starting", total=None)
        yield lambda sentence: shown.update(task, description=sentence)


@contextmanager
def compilation_note(*, quiet: bool = False) -> Iterator[None]:
    """Say once, on a terminal, that kernels are being compiled: nothing else moves meanwhile.

    numba is imported by the commands that need it, and not before, so a thread waits for it.
    """
    if quiet or not sys.stderr.isatty():
        yield
        return
    over = threading.Event()
    waiting = threading.Thread(target=_note_compilation, args=(over,), daemon=True)
    waiting.start()
    try:
        yield
    finally:
        over.set()


def _note_compilation(over: threading.Event) -> None:
    while not hasattr(sys.modules.get("numba.core.event"), "register"):
        if over.wait(LOOK):
            return
    event: Any = sys.modules["numba.core.event"]

    class Note(event.Listener):
        def on_start(self, event: object) -> None:
            if not over.is_set():
                over.set()
                print("selfmotion:", COMPILING, file=sys.stderr)

        def on_end(self, event: object) -> None:
            pass

    event.register("numba:compile", Note())
