"""Names and axes in Motion-BIDS: entities of a file name, and SpatialAxes."""

import re
from pathlib import Path

import numpy as np

from selfmotion.errors import RangeError
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels

SUFFIX = "_motion.tsv"
MISSING = "n/a"
# What a letter of SpatialAxes says of an axis: along which direction it lies, and with what sign.
LETTERS = {"A": ("forward", ""), "P": ("forward", "-"), "S": ("up", ""), "I": ("up", "-")}
LETTERS |= {"R": ("right", ""), "L": ("right", "-")}


def sibling(path: Path, ending: str) -> Path:
    """Give the path of a file that belongs to a ``*_motion.tsv``."""
    return path.with_name(path.name.removesuffix(SUFFIX) + ending)


def labels_of(path: Path) -> Labels:
    """Read labels from the entities of a BIDS file name.

    Example:
        >>> str(labels_of(Path("sub-07_task-reach_tracksys-omc_run-2_motion.tsv")))
        'subject 07, condition reach, trial 2'
    """
    pairs = (part.partition("-") for part in path.name.split("_"))
    entities = {key: value for key, dash, value in pairs if dash and value}
    return Labels(
        subject=entities.get("sub"), condition=entities.get("task"), trial=entities.get("run")
    )


def frame_of(letters: str, name: str = "world") -> Frame:
    """Read SpatialAxes: the directions of x, y and z as A, P, L, R, S, I.

    Raises:
        RangeError: two axes point the same way, or the three are left-handed.

    Example:
        >>> frame_of("ALS").up, frame_of("ALS").forward, frame_of("RAS").forward
        ('z', 'x', 'y')
    """
    if not re.fullmatch("[APLRSI]{3}", letters.upper()):
        return UNKNOWN_FRAME
    found: dict[str, str] = {}
    for axis, letter in zip("xyz", letters.upper(), strict=True):
        word, sign = LETTERS[letter]
        found[word] = sign + axis
    if len(found) != 3:
        raise RangeError(f"SpatialAxes {letters!r}: each of A/P, L/R and S/I is needed once")
    frame = Frame(found["up"], found["forward"], name)
    if spatial_axes(frame) != letters.upper():
        raise RangeError(f"SpatialAxes {letters!r}: left-handed axes are not supported")
    return frame


def spatial_axes(frame: Frame) -> str:
    """Write a frame as SpatialAxes."""
    # Columns: x, y, z of the frame along right, forward, up.
    turn = frame.rotation_to(Frame(up="z", forward="y"))
    return "".join(
        "RAS"[i] if turn[i, j] > 0.0 else "LPI"[i]
        for j, i in enumerate(np.abs(turn).argmax(axis=0).tolist())
    )
