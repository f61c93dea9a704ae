import math

import pytest

from selfmotion.cli.options import angles_by_name
from selfmotion.errors import RangeError


def test_ranges_are_typed_in_degrees_and_given_in_radians() -> None:
    found = angles_by_name("--limit", ["elbow_flexion=64.2:114", "wrist_flexion = -90:90"])
    assert found["elbow_flexion"] == pytest.approx((1.1205013798, 1.9896753473), abs=1e-9)
    assert found["wrist_flexion"] == (-math.pi / 2, math.pi / 2)


@pytest.mark.parametrize(
    ("texts", "reason"),
    [
        (["elbow_flexion"], "write joint=low:high in degrees"),
        (["=1:2"], "write joint=low:high in degrees"),
        (["elbow_flexion=1"], "write joint=low:high in degrees"),
        (["elbow_flexion=a:2"], "write joint=low:high in degrees"),
        (["elbow_flexion=1:nan"], "write joint=low:high in degrees"),
        (["elbow_flexion=2:1"], "low bound 2 is above the high 1"),
        (["elbow_flexion=1:2", "elbow_flexion=1:3"], "already has a range"),
    ],
)
def test_a_range_of_another_form_is_refused(texts: list[str], reason: str) -> None:
    with pytest.raises(RangeError, match=reason) as caught:
        angles_by_name("--limit", texts)
    assert str(caught.value).startswith("--limit '")
