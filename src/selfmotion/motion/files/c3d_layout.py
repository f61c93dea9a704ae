"""The layout of a C3D file, checked before ezc3d reads it.

ezc3d trusts what it reads: a damaged header can make it stop the whole process, and a file that
was cut off gives fewer frames without a word. So the header and the parameter section are walked
here first. Nothing is interpreted beyond what that needs.
"""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from selfmotion.errors import FileFormatError

BLOCK = 512
KEY = 0x50
INTEL, DEC, MIPS = 84, 85, 86
SIZES = {-1: 1, 1: 1, 2: 2, 4: 4}  # bytes of one value, by type code of a parameter
UNCOUNTED = 65_535  # the last frame where a word does not hold the number of frames
# Parameters that ezc3d uses without asking whether they are there (ANALOG's: if there is one).
NEEDED = (("POINT", "USED"), ("POINT", "SCALE"), ("POINT", "RATE"), ("ANALOG", "USED"))
# Types of parameters that ezc3d takes for granted, in the groups that it looks into.
KINDS = {"USED": (2,), "RATE": (4,), "SCALE": (4,), "GEN_SCALE": (4,)}
KINDS |= {"LABELS": (-1,), "UNITS": (-1,), "DESCRIPTIONS": (-1,)}
# Parameters that must hold a value for each analog channel, or one for all.
PER_CHANNEL = ("SCALE", "OFFSET", "GEN_SCALE", "RATE")
READ_GROUPS = frozenset({"POINT", "ANALOG", "FORCE_PLATFORM"})
LARGEST_FRAME = 1 << 22  # bytes of one frame; no laboratory has a quarter of a million channels


@dataclass(frozen=True)
class C3dLayout:
    """What the header says.

    Attributes:
        points: trajectories in each frame.
        frames: frames, or None where the header cannot count them.
    """

    points: int
    frames: int | None


def check_layout(path: str | Path) -> C3dLayout:
    """Walk header and parameters, and compare the size of the file with what they promise.

    Raises:
        FileFormatError: no C3D file, a damaged one, or one that was cut off.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    if len(data) < 2 * BLOCK or data[1] != KEY:
        raise FileFormatError(f"{path}: no C3D file (its second byte is not 0x50, or it is short)")
    start = (data[0] - 1) * BLOCK
    if start < 0 or start + 4 > len(data):
        raise FileFormatError(f"{path}: parameters at block {data[0]}, beyond the end of the file")
    processor = data[start + 3]
    if processor not in (INTEL, DEC, MIPS):
        raise FileFormatError(f"{path}: processor type {processor}; allowed are 84, 85 and 86")
    order = ">" if processor == MIPS else "<"
    values = _walk(path, data, start, order)
    fields = struct.unpack(order + "5H4s2H", data[2:20])
    points, analog, first, last, _, scale, data_block, subframes = fields
    used = _word(values.get(("POINT", "USED")), order)
    if used != points:
        raise FileFormatError(f"{path}: {points} points in the header, {used} in POINT:USED")
    _check_analog(path, values, order, analog, subframes)
    frames = last - first + 1 if last != UNCOUNTED and first > 0 else None
    if frames is not None and frames < 1:
        raise FileFormatError(f"{path}: frames {first} to {last} in the header")
    # The sign's byte: the last of a little-endian float, the second of DEC's, the first of MIPS'.
    sign = scale[{INTEL: 3, DEC: 1, MIPS: 0}[processor]] & 0x80
    frame_bytes = (4 * points + analog) * (4 if sign else 2)
    if frame_bytes > LARGEST_FRAME or data_block < 2:
        raise FileFormatError(f"{path}: its header is damaged (sizes that cannot be)")
    held = max(len(data) - (data_block - 1) * BLOCK, 0) // max(frame_bytes, 1)
    if frames is not None and held < frames:
        raise FileFormatError(
            f"{path}: holds {held} of {frames} frames: the file is cut off, or its header is wrong"
        )
    return C3dLayout(points, frames)


def _check_analog(
    path: str | Path,
    values: Mapping[tuple[str, str], tuple[int, bytes]],
    order: str,
    analog: int,
    subframes: int,
) -> None:
    """Refuse analog channels that lack what ezc3d takes for granted, though we read none."""
    used = _word(values.get(("ANALOG", "USED")), order) or 0
    if analog != used * subframes:
        raise FileFormatError(
            f"{path}: {analog} analog values a frame in the header; ANALOG:USED {used} times "
            f"{subframes} are {used * subframes}"
        )
    for name in PER_CHANNEL if used else ():
        kind, body = values.get(("ANALOG", name), (1, b""))
        needed = 1 if name in ("GEN_SCALE", "RATE") else min(used, 255)
        if len(body) < needed * SIZES[kind]:
            raise FileFormatError(
                f"{path}: ANALOG:{name} lacks values for {used} channels: it is damaged"
            )


def _walk(
    path: str | Path, data: bytes, start: int, order: str
) -> dict[tuple[str, str], tuple[int, bytes]]:
    """Go through groups and parameters; give the parameters by group and name."""
    groups: dict[int, str] = {}
    found: dict[tuple[int, str], tuple[int, bytes]] = {}
    for number, name, at, end in _records(path, data, start + 4, order):
        if number < 0:
            groups[-number] = name
            _check_description(path, data, at, end, name)
            continue
        found[number, name] = _parameter(path, data, at, end, name)
    orphans = sorted({number for number, _ in found} - set(groups))
    if orphans:
        raise FileFormatError(f"{path}: parameters of a group {orphans[0]} that is not there")
    named = {(groups[number], name): value for (number, name), value in found.items()}
    for (group, name), (kind, _) in named.items():
        if group in READ_GROUPS and kind not in KINDS.get(name, (kind,)):
            raise FileFormatError(f"{path}: {group}:{name} is of type {kind}: it is damaged")
    held = {"POINT", *groups.values()}
    for group, name in NEEDED:
        if group in held and (group, name) not in named:
            raise FileFormatError(f"{path}: no {group}:{name}, so no complete C3D file")
    return named


def _records(
    path: str | Path, data: bytes, at: int, order: str
) -> Iterator[tuple[int, str, int, int]]:
    """Give group number, name, start and end of the body of each record."""
    damaged = FileFormatError(f"{path}: its parameter section is damaged or cut off")
    while True:
        if at + 2 > len(data):
            raise damaged
        length, number = struct.unpack("bb", data[at : at + 2])
        if length == 0 or number == 0:
            return
        body = at + 2 + abs(length)
        if body + 2 > len(data):
            raise damaged
        name = data[at + 2 : body].decode("latin-1").strip().upper()
        (offset,) = struct.unpack(order + "H", data[body : body + 2])
        end = body + offset if offset else len(data)
        odd = not name or not name.isprintable() or number < -127
        if odd or end > len(data) or 0 < offset < 3:
            raise damaged
        yield number, name, body + 2, end
        if offset == 0:
            return
        at = end


def _parameter(path: str | Path, data: bytes, at: int, end: int, name: str) -> tuple[int, bytes]:
    """Give type and bytes of a parameter, which must lie within its record."""
    if at + 2 <= end:
        kind, dimensions = struct.unpack("bB", data[at : at + 2])
        size = SIZES.get(kind, 0)
        body = at + 2 + dimensions
        for extent in data[at + 2 : body]:
            size *= extent
        # ezc3d ends the process over a text without dimensions, which the format allows.
        whole = dimensions > 0 if kind == -1 else kind in SIZES
        if whole and dimensions <= 7 and body + size <= end:
            _check_description(path, data, body + size, end, name)
            return kind, data[body : body + size]
    raise FileFormatError(f"{path}: parameter {name[:40]} is damaged")


def _check_description(path: str | Path, data: bytes, at: int, end: int, name: str) -> None:
    """Refuse a description that leaves its record; some writers leave it out altogether."""
    if at < end and at + 1 + data[at] > end:
        raise FileFormatError(f"{path}: the description of {name[:40]} is damaged")


def _word(value: tuple[int, bytes] | None, order: str) -> int | None:
    """Read an integer parameter."""
    if value is None or value[0] != 2 or len(value[1]) < 2:
        return None
    return struct.unpack(order + "H", value[1][:2])[0]
