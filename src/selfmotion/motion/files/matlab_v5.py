"""MATLAB's level 5 MAT-file (versions 5 to 7), read without trusting a single byte of it.

Layout: MathWorks, "MAT-File Format", chapter 1. SciPy has a reader, but its compiled part ends the
process (segmentation fault, SciPy 1.17) on damaged uncompressed files; here every length is checked
against the bytes that are there. SciPy serves as the oracle in the tests.
"""

import struct
import zlib
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from selfmotion.errors import FileFormatError

HEADER = 128
MATRIX, COMPRESSED = 14, 15
NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
NUMBERS |= {12: "i8", 13: "u8"}
ENCODINGS = {16: "utf-8", 17: "utf-16", 18: "utf-32"}
CELL, STRUCT, CHARACTER = 1, 2, 4
NUMERIC = range(6, 16)  # double, single and the integers
COMPLEX = 0x08
# Deeper nesting than this is a damaged file.
DEEPEST = 24
# A compressed variable may not unpack to more than this, bytes.
LARGEST_VARIABLE = 2**32


@dataclass
class _Bytes:
    """A stretch of the file and how far it has been read."""

    data: memoryview
    order: str  # "<" or ">"
    at: int = 0

    def element(self) -> tuple[int, memoryview]:
        """Read one data element: its type and its bytes."""
        (word,) = struct.unpack(self.order + "I", self._take(4))
        if word >> 16:  # small: type and length share the first word, data the second
            kind, length, room = word & 0xFFFF, word >> 16, 4
        else:
            kind, length = word, struct.unpack(self.order + "I", self._take(4))[0]
            # Compressed elements alone are not padded to 8 bytes.
            room = length if kind == COMPRESSED else -(-length // 8) * 8
        if length > room or length > len(self.data) - self.at:
            raise FileFormatError("cut off or damaged: an element is longer than the file")
        found = self.data[self.at : self.at + length]
        self.at = min(self.at + room, len(self.data))
        return kind, found

    def numbers(self) -> np.ndarray:
        """Read one element of numbers."""
        kind, raw = self.element()
        if kind not in NUMBERS:
            raise FileFormatError(f"damaged: data type {kind} where numbers are needed")
        dtype = np.dtype(self.order + NUMBERS[kind])
        if len(raw) % dtype.itemsize:
            raise FileFormatError("damaged: a fraction of a number")
        return np.frombuffer(raw, dtype)

    @property
    def done(self) -> bool:
        return self.at >= len(self.data)

    def _take(self, count: int) -> memoryview:
        if count > len(self.data) - self.at:
            raise FileFormatError("cut off")
        self.at += count
        return self.data[self.at - count : self.at]


def read_v5(raw: bytes) -> dict[str, Any]:
    """Read all variables: structs to dicts, cells to lists, text to str, numbers to float64.

    Sparse matrices, objects and functions become None.

    Raises:
        FileFormatError: cut off, damaged, or not level 5.
    """
    if len(raw) < HEADER or raw[126:128] not in (b"IM", b"MI"):
        raise FileFormatError("no MATLAB file of version 5 to 7.3 (save with -v7 or -v7.3)")
    stream = _Bytes(memoryview(raw), "<" if raw[126:128] == b"IM" else ">", HEADER)
    variables: dict[str, Any] = {}
    while not stream.done:
        kind, data = stream.element()
        if kind == COMPRESSED:
            kind, data = _Bytes(_unpacked(data), stream.order).element()
        if kind != MATRIX:
            raise FileFormatError(f"damaged: data type {kind} where a variable is needed")
        name, value = _matrix(_Bytes(data, stream.order), 0)
        if name and not name.startswith("__"):
            variables[name] = value
    return variables


def _unpacked(data: memoryview) -> memoryview:
    unpacker = zlib.decompressobj()
    try:
        out = unpacker.decompress(data, LARGEST_VARIABLE)
    except zlib.error as error:
        raise FileFormatError(f"cut off or damaged ({error})") from None
    if not unpacker.eof:
        raise FileFormatError("cut off: a compressed variable does not end")
    return memoryview(out)


def _matrix(stream: _Bytes, depth: int) -> tuple[str, Any]:
    """Read one array: its name and its value."""
    if depth > DEEPEST:
        raise FileFormatError(f"nested more than {DEEPEST} deep: damaged")
    if stream.done:
        return "", np.empty((0, 0))
    flags = stream.numbers()
    if flags.size < 1:
        raise FileFormatError("damaged: an array without flags")
    kind, options = int(flags[0]) & 0xFF, (int(flags[0]) >> 8) & 0xFF
    if kind not in (CELL, STRUCT, CHARACTER, *NUMERIC):
        return "", None
    shape = tuple(int(size) for size in stream.numbers())
    if len(shape) < 2 or min(shape) < 0:
        raise FileFormatError(f"damaged: dimensions {shape}")
    name = bytes(stream.element()[1]).decode("latin-1")
    if kind == CELL:
        return name, _members(stream, prod(shape), depth)
    if kind == STRUCT:
        return name, _structs(stream, prod(shape), depth)
    if kind == CHARACTER:
        return name, _text(stream)
    values = stream.numbers()
    if options & COMPLEX:
        return name, None
    if values.size != prod(shape):
        raise FileFormatError(f"damaged: {values.size} numbers for dimensions {shape}")
    return name, values.astype(np.float64).reshape(shape, order="F")


def _members(stream: _Bytes, count: int, depth: int) -> list[Any]:
    values = []
    for _ in range(count):
        kind, data = stream.element()  # raises at the end of the data, whatever `count` claims
        if kind != MATRIX:
            raise FileFormatError(f"damaged: data type {kind} where an array is needed")
        values.append(_matrix(_Bytes(data, stream.order), depth + 1)[1])
    return values


def _structs(stream: _Bytes, count: int, depth: int) -> Any:
    width = stream.numbers()
    if width.size != 1 or width[0] < 1:
        raise FileFormatError("damaged: field names without a length")
    raw, step = bytes(stream.element()[1]), int(width[0])
    cut = [raw[i : i + step].split(b"\0")[0] for i in range(0, len(raw), step)]
    names = [name.decode("latin-1") for name in cut]
    if not names:
        return {}
    structs = []
    for _ in range(count):
        structs.append(dict(zip(names, _members(stream, len(names), depth), strict=True)))
    return structs[0] if count == 1 else structs


def _text(stream: _Bytes) -> str:
    if stream.done:
        return ""
    kind, raw = stream.element()
    encoding = ENCODINGS.get(kind, "utf-16" if kind in (3, 4) else "latin-1")
    if encoding in ("utf-16", "utf-32"):
        encoding += "-le" if stream.order == "<" else "-be"
    return bytes(raw).decode(encoding, "replace")
