"""Recorded motion: recordings and studies, filters, and the readers of files."""

from selfmotion.motion.labels import UNKNOWN_FRAME, Frame, Labels
from selfmotion.motion.recording import GapWarning, Recording, Study, sample_numbers

__all__ = ["UNKNOWN_FRAME", "Frame", "GapWarning", "Labels", "Recording", "Study", "sample_numbers"]
