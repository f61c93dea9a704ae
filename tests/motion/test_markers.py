"""Marker sets: what they refuse, and that nothing is half there."""

import numpy as np
import pytest

from selfmotion.errors import RangeError, ShapeError, UnknownNameError
from selfmotion.motion.labels import Frame
from selfmotion.motion.markers import MarkerSet, without_prefix


def three_markers() -> MarkerSet:
    positions = np.arange(36, dtype=float).reshape(4, 3, 3)
    return MarkerSet(np.arange(4) / 10, ("A", "B", "C"), positions, Frame())


def test_a_marker_with_one_missing_coordinate_is_missing_as_a_whole():
    positions = np.ones((2, 1, 3))
    positions[1, 0, 2] = np.nan
    seen = MarkerSet(np.arange(2.0), ("A",), positions)
    assert np.isnan(seen.positions[1]).all() and seen.missing().tolist() == [[False], [True]]
    assert positions[1, 0, 0] == 1.0  # the caller's array is not touched


def test_points_windows_and_selections_hold_the_same_numbers():
    seen = three_markers()
    part = seen.select(["C", "A"]).window(1, 3)
    assert part.names == ("C", "A")
    np.testing.assert_array_equal(part.point("A"), seen.point("A")[1:3])
    assert list(seen.to_frame().columns[:4]) == ["time", "A_x", "A_y", "A_z"]


def test_turning_there_and_back_changes_nothing():
    seen = three_markers()
    other = Frame(up="y", forward="-z")
    back = seen.in_frame(other).in_frame(Frame())
    np.testing.assert_allclose(back.positions, seen.positions, atol=1e-14)


@pytest.mark.parametrize(
    ("names", "positions", "error"),
    [
        (("A", "A"), np.zeros((2, 2, 3)), ShapeError),
        (("A", ""), np.zeros((2, 2, 3)), ShapeError),
        ((), np.zeros((2, 0, 3)), ShapeError),
        (("A",), np.zeros((3, 1, 3)), ShapeError),
    ],
)
def test_refusals(names, positions, error):
    with pytest.raises(error):
        MarkerSet(np.arange(2.0), names, positions)


def test_unknown_markers_frames_and_windows_are_refused():
    seen = three_markers()
    with pytest.raises(UnknownNameError, match="known: A, B, C"):
        seen.point("D")
    with pytest.raises(RangeError):
        seen.window(3, 3)
    with pytest.raises(RangeError, match="not known"):
        MarkerSet(np.zeros(1), ("A",), np.zeros((1, 1, 3))).in_frame(Frame())


def test_prefixes():
    assert without_prefix(["P:A", "*1"]) == (("A", "*1"), "P")
    assert without_prefix(["P:A", "Q:A"]) == (("P:A", "Q:A"), None)
    assert without_prefix(["A"]) == (("A",), None)
