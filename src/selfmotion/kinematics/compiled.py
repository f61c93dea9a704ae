"""Compile kernels so that their cache on disk notices an edit in any file that takes part.

numba keeps machine code on disk beside the file of a function and drops it when that file
changes; a change in a function that it calls in another file goes unnoticed, and old code runs.
Here the text of those other files belongs to the key.

The key is set on an attribute of numba's that is not public (``_source_stamp``, the same from
0.57 to 0.68); where a later numba has it no longer, kernels are compiled at each start.
"""

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit


def compiled(*called: ModuleType | str, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Give a decorator that compiles a function on its first call and keeps the code on disk.

    Args:
        called: other modules (or paths of files) with functions that it calls, or types that it
            takes; the function's own file always counts.
        **options: those of `numba.njit`.

    Example:
        >>> @compiled()
        ... def twice(x):
        ...     return 2 * x
        >>> twice(21)
        42
    """
    source = _hash(tuple(str(m.__file__ if isinstance(m, ModuleType) else m) for m in called))

    def decorate(function: Callable[..., Any]) -> Any:
        try:
            made = njit(cache=True, **options)(function)
        except RuntimeError:  # no folder can be written to, or there is no file
            return njit(**options)(function)
        index = getattr(getattr(made, "_cache", None), "_cache_file", None)
        stamp = getattr(index, "_source_stamp", None)
        if stamp is None:
            return njit(**options)(function)
        index._source_stamp = (stamp, source)  # pyright: ignore[reportOptionalMemberAccess]
        return made

    return decorate


@functools.lru_cache(maxsize=64)
def _hash(files: tuple[str, ...]) -> str:
    """Give a hash of the text of some files."""
    return hashlib.sha256(b"".join(Path(file).read_bytes() for file in files)).hexdigest()
