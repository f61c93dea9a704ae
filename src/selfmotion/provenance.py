"""Where a result comes from: version, input hashes, seed and the choices that shaped it."""

import hashlib
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion._version import __version__


@dataclass(frozen=True)
class Provenance:
    """What one needs to get the same numbers again.

    Attributes:
        method: the verb that made the result, as in ``identify_weights``.
        version: version of the library.
        inputs: name of each input to the first 16 hexadecimal digits of its SHA-256.
        seed: seed of the random generator, or None where nothing is random.
        choices: option names to their values (method, convention, model, ...).
    """

    method: str
    version: str = __version__
    inputs: dict[str, str] = field(default_factory=dict)
    seed: int | None = None
    choices: dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Give a dictionary that JSON can hold."""
        return asdict(self)


def hash_arrays(*arrays: np.ndarray) -> str:
    """Hash the bytes, shapes and types of arrays: 16 hexadecimal digits of SHA-256."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).view(np.uint8).data)
    return digest.hexdigest()[:16]


def hash_file(path: str | Path) -> str:
    """Hash a file's bytes: 16 hexadecimal digits of SHA-256."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()[:16]
