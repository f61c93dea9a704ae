"""Files are written whole or not at all: aside first, then renamed into place."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from selfmotion.errors import FileFormatError


def write_whole(path: str | Path, write: Callable[[BinaryIO], object]) -> Path:
    """Let `write` fill a file beside `path`, then rename it to `path`.

    A reader sees the old file or the new one, never a part; after an error the old one stands.

    Raises:
        FileFormatError: the folder does not exist or cannot be written.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "weights.txt")
        >>> write_whole(where, lambda stream: stream.write(b"0.1 0.9")).read_text()
        '0.1 0.9'
    """
    path = Path(path)
    aside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with open(aside, "wb") as stream:
            write(stream)
        os.replace(aside, path)
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be written ({error.strerror or error})") from None
    finally:
        aside.unlink(missing_ok=True)
    return path
