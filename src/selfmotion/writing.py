"""Files are written whole or not at all: write aside, then rename.

A reader never sees half a file, and a run that is killed leaves the earlier file as it was.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give a path beside `path` to write to; it takes the place of `path` when all went well.

    Args:
        path: the file wanted; its folder is made if it does not exist.

    Yields:
        A path in the same folder and with the same suffix, so that writers which look at the
        suffix do the same as they would for `path`.

    Example:
        >>> import tempfile
        >>> folder = Path(tempfile.mkdtemp())
        >>> with whole_file(folder / "notes.txt") as aside:
        ...     _ = aside.write_text("done")
        >>> [file.name for file in folder.iterdir()]
        ['notes.txt']
    """
    target = Path(path).resolve()  # a link stays, what it points to is replaced
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.is_dir():
        raise IsADirectoryError(21, "a folder stands where the file should go", str(path))
    if target.exists() and not target.is_file():
        raise OSError(22, "not a file that could be replaced", str(path))
    try:
        handle, name = tempfile.mkstemp(".tmp" + target.suffix, f".{target.stem}-", target.parent)
    except OSError as error:  # name what was asked for, not the file aside
        raise type(error)(error.errno, error.strerror, str(path)) from None
    os.close(handle)
    aside = Path(name)
    try:
        yield aside
        aside.chmod(0o666 & ~_umask())
        os.replace(aside, target)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write text (UTF-8) or bytes to a file, whole or not at all, and give its path."""
    data = content.encode("utf-8") if isinstance(content, str) else content
    with whole_file(path) as aside:
        aside.write_bytes(data)
    return Path(path)


def _umask() -> int:
    """Give the process's file mask: a temporary file is private, a result should not be."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
