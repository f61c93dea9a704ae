"""What a caller states of a file that does not say it itself: units, rate and frame.

What the file says counts; a statement that contradicts it is refused.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from selfmotion.errors import FileFormatError, RangeError
from selfmotion.motion.labels import UNKNOWN_FRAME, Frame
from selfmotion.motion.recording import Recording, Study

# A rate that differs from that of the file's times by less is the same (share).
SAME_RATE = 0.01


def refuse_other_unit(path: str | Path, what: str, found: str, stated: str | None) -> None:
    """Refuse a stated unit that is not the one in which a format holds its numbers.

    Raises:
        FileFormatError: the two differ.

    Example:
        >>> refuse_other_unit("reach.npz", "angles", "rad", "deg")
        Traceback (most recent call last):
        ...
        selfmotion.errors.FileFormatError: reach.npz: its angles are in rad, but deg was stated
    """
    if stated is not None and stated != found:
        raise FileFormatError(f"{path}: its {what} are in {found}, but {stated} was stated")


def with_rate(study: Study, rate: float | None) -> Study:
    """Give recordings without seconds a time by the sampling rate (Hz).

    Raises:
        RangeError: the rate is not positive, or differs from that of the file's own times.

    Example:
        >>> counted = Recording(np.arange(3.0), q=np.zeros((3, 1)), timed=False)
        >>> with_rate(Study((counted,)), 50.0)[0].time.tolist()
        [0.0, 0.02, 0.04]
    """
    if rate is None:
        return study
    if not 0.0 < rate < np.inf:
        raise RangeError(f"rate = {rate:g} Hz: must be positive and finite")
    return Study(tuple(_timed(recording, rate) for recording in study))


def require_rate(name: str, found: float | None, stated: float | None) -> None:
    """Refuse a stated rate that the file's own times contradict.

    Raises:
        RangeError: they differ by more than `SAME_RATE`.
    """
    if stated is None or found is None or abs(stated - found) <= SAME_RATE * found:
        return
    raise RangeError(f"{name}: its times have {found:.6g} Hz, but {stated:g} Hz was stated")


def with_frame(study: Study, frame: Frame | None) -> Study:
    """Give recordings the axes that their file does not tell.

    Raises:
        RangeError: the file tells others.
    """
    if frame is None:
        return study
    return Study(
        tuple(replace(r, frame=merged_frame(r.name, r.frame, frame)) for r in study.recordings)
    )


def merged_frame(name: str, found: Frame, stated: Frame) -> Frame:
    """Put together what a file tells of its axes and what the caller states.

    Raises:
        RangeError: they contradict each other, or an axis would be both up and forward.

    Example:
        >>> merged_frame("reach.c3d", Frame("z", None), Frame(None, "y"))
        Frame(up='z', forward='y', name='stated')
    """
    for word in ("up", "forward"):
        told, said = getattr(found, word), getattr(stated, word)
        if told is not None and said is not None and told != said:
            raise RangeError(f"{name}: its {word} axis is {told}, but {said} was stated")
    if found.known or stated == UNKNOWN_FRAME:
        return found
    return Frame(found.up or stated.up, found.forward or stated.forward, "stated")


def _timed(recording: Recording, rate: float) -> Recording:
    if recording.timed:
        require_rate(recording.name, recording.rate, rate)
        return recording
    # Velocities of such a file are by sample or by second; the file does not say which.
    if recording.qd is not None or recording.xd is not None:
        raise RangeError(
            f"{recording.name}: rate = {rate:g} Hz was stated, but its velocities come without "
            "times, so that their unit is not known; put time (s) or dt into the file"
        )
    return replace(recording, time=recording.time / rate, timed=True)
