"""Share samples between threads; kernels let go of Python's lock while they run."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock

import numpy as np

from selfmotion.errors import RangeError

# Parts that a thread takes on average: where another program holds up one, the others go on.
PARTS = 4


def share(work: Callable[[int, int], None], n_items: int, threads: int, *, least: int) -> None:
    """Call ``work(first, after_last)`` on parts of n_items, in threads if there are enough.

    Each thread, the calling one among them, takes the next part as soon as it is free.

    Args:
        work: what is done with a part.
        n_items: how many items there are.
        threads: how many threads may run.
        least: items below which a further thread costs more than it saves.

    Raises:
        RangeError: fewer than one thread.
    """
    if threads < 1:
        raise RangeError(f"threads = {threads}: allowed is 1 and above")
    used = max(1, min(threads, n_items // least))
    if used == 1:
        work(0, n_items)
        return
    parts = min(PARTS * used, n_items // least)
    edges = np.linspace(0, n_items, parts + 1).astype(int).tolist()
    todo, lock = iter(zip(edges[:-1], edges[1:], strict=True)), Lock()

    def take() -> None:
        while True:
            with lock:
                part = next(todo, None)
            if part is None:
                return
            work(*part)

    with ThreadPoolExecutor(used - 1) as pool:
        others = [pool.submit(take) for _ in range(used - 1)]
        take()
        for other in others:
            other.result()
