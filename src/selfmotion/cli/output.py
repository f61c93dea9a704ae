"""What a command gives back: one JSON document whose type is also its JSON Schema.

The type of a document is a `Document` with the command's own keys::

    class SplitDocument(Document, tag="selfmotion/split/1", kw_only=True):
        recordings: list[Share]

NaN and infinite numbers are written as null: the type of a number that may be unknown is `Number`.
"""

import inspect
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from selfmotion._version import __version__
from selfmotion.cli.running import DONE, SOME_FAILED
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

Number: TypeAlias = float | None
Vector: TypeAlias = list[float | None]
Matrix: TypeAlias = list[list[float | None]]


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of the records inside a document."""


class Document(Part, frozen=True, tag_field="schema", kw_only=True):
    """Base of what a command prints with --json; any record with these keys will do.

    The key `schema` comes from the subclass's `tag`, such as ``selfmotion/weights/1``; its number
    rises when a key changes its meaning or goes.
    """

    version: str = __version__
    provenance: Provenance


@dataclass(frozen=True)
class Contract:
    """What docs/cli promises of a command; its module holds one as `CONTRACT`.

    Attributes:
        document: the type of what --json prints, and so its JSON Schema.
        example: the words after `selfmotion` that give the golden example, in the top folder.
    """

    document: type[Part]
    example: tuple[str, ...]


def numbers(array: ArrayLike) -> Any:
    """Turn an array of any shape into nested lists of numbers, None where one is not finite.

    Example:
        >>> numbers([[1.0, float("nan")], [2.5, float("inf")]])
        [[1.0, None], [2.5, None]]
    """
    values = np.asarray(array, dtype=np.float64)
    if np.isfinite(values).all():
        return values.tolist()
    known = values.astype(object)
    known[~np.isfinite(values)] = None
    return known.tolist()


def encode(document: Part, *, indent: int = 0) -> bytes:
    """Give a document as JSON (UTF-8, a line break at the end); not finite becomes null."""
    text = msgspec.json.encode(document, enc_hook=_plain)
    return (msgspec.json.format(text, indent=indent) if indent else text) + b"\n"


def schema(document_type: type[Part]) -> bytes:
    """Give the JSON Schema of a command's document, from the very type that is written."""
    tree = msgspec.json.schema(document_type)
    for definition in tree["$defs"].values():
        definition["description"] = inspect.cleandoc(definition.get("description", ""))
        # A document is written with all its keys, so a reader may count on each of them.
        definition["required"] = list(definition["properties"])
        for entry in definition["properties"].values():
            entry.pop("default", None)
    tree = {"$schema": "https://json-schema.org/draft/2020-12/schema", **tree}
    return msgspec.json.format(msgspec.json.encode(tree)) + b"\n"


def finish(document: Part, text: str, *, json: bool, failed: int = 0) -> int:
    """Print a result for a program or for a person, and give the exit code.

    Args:
        document: printed with `json`, indented on a terminal.
        text: printed otherwise.
        json: whether --json was asked for.
        failed: number of items that failed.
    """
    if json:
        sys.stdout.flush()
        sys.stdout.buffer.write(encode(document, indent=2 if sys.stdout.isatty() else 0))
    else:
        print(text)
    return SOME_FAILED if failed else DONE


def save(document: Part, folder: Path, name: str) -> Path:
    """Write a document as NAME.json into a folder, whole or not at all; give its path."""
    return write_whole(folder / f"{name}.json", encode(document, indent=2))


def _plain(value: object) -> object:
    """Give what JSON can hold for types that msgspec does not know."""
    if isinstance(value, np.ndarray):
        return numbers(value) if value.dtype.kind == "f" else value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"a document cannot hold {type(value).__name__}")
