"""Share samples between threads; kernels let go of Python's lock while they run."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from selfmotion.errors import RangeError


def share(work: Callable[[int, int], None], n_items: int, threads: int, *, least: int) -> None:
    """Call ``work(first, after_last)`` on parts of n_items, in threads if there are enough.

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
    edges = np.linspace(0, n_items, used + 1).astype(int).tolist()
    with ThreadPoolExecutor(used - 1) as pool:
        others = pool.map(work, edges[1:-1], edges[2:])
        work(edges[0], edges[1])
        list(others)
