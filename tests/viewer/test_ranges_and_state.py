import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import FileFormatError, RangeError, UnknownNameError
from selfmotion.viewer.ranges import Ranges, Splint
from selfmotion.viewer.state import StudioState, load_state, save_state

ARM = load_arm("myoarm")


def test_ranges_stay_inside_those_of_the_model():
    ranges = Ranges(ARM)
    ranges.set("elbow_flexion", -50.0, 90.0)
    i = ARM.chain.index("elbow_flexion")
    limited = ranges.limited()
    assert limited.lower[i] == pytest.approx(ARM.lower[i])
    assert limited.upper[i] == pytest.approx(np.radians(90.0))


def test_the_splint_takes_what_it_takes_and_gives_it_back():
    ranges = Ranges(ARM, splint=Splint())
    i = ARM.chain.index("elbow_flexion")
    assert np.degrees(ranges.limited().lower[i]) == pytest.approx(64.2)
    ranges.splint = None
    assert ranges.limited().lower[i] == pytest.approx(ARM.lower[i])


def test_bad_ranges_are_refused_in_a_line():
    ranges = Ranges(ARM, splint=Splint())
    with pytest.raises(UnknownNameError, match="knee"):
        ranges.set("knee", 0.0, 1.0)
    with pytest.raises(RangeError, match="200 to 210 degrees"):
        ranges.set("elbow_flexion", 200.0, 210.0)
    ranges.set("elbow_flexion", 0.0, 20.0)
    with pytest.raises(RangeError, match="splint leaves nothing"):
        ranges.limited()


def test_a_state_opens_as_it_was_saved(tmp_path):
    state = StudioState(
        hand=(
            (1.0, 0.0, 0.0, 0.0),
            (0.0, 1.0, 0.0, 0.0),
            (0.0, 0.0, 1.0, 0.5),
            (0.0, 0.0, 0.0, 1.0),
        ),
        limits_deg={"elbow_flexion": (10.0, 90.0)},
        splint=True,
        swivel_deg=30.0,
    )
    assert load_state(save_state(tmp_path / "a.json", state)) == state


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no state of a studio"),
        ("[1, 2]", "no state of a studio"),
        ('{"schema": "other"}', "schema 'other'"),
        ('{"elbow": 3}', "unknown field `elbow`"),
        ('{"splint": "yes"}', "splint"),
        ('{"hand": [[1,0,0,0],[0,2,0,0],[0,0,1,0],[0,0,0,1]]}', "hand"),
        ('{"hand": [[1,0,0,0]]}', "hand"),
    ],
)
def test_what_is_no_state_is_refused(tmp_path, text, told):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(FileFormatError, match=told) as caught:
        load_state(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
