"""Marker protocols: built in and from TOML."""

import pytest

from selfmotion.capture.protocol import REACHING, load_protocol
from selfmotion.errors import FileFormatError, SelfmotionError, UnknownNameError

TOML = """
lateral = ["LSH", "RSH"]
frame = {up = "y", forward = "x"}
knuckle_radial = 0.01

[clusters]
trunk = ["T1", "T2", "T3"]
shoulder = ["{S}A1", "{S}A2", "{S}A3"]
upper_arm = ["{S}B1", "{S}B2", "{S}B3"]
forearm = ["{S}C1", "{S}C2", "{S}C3"]
hand = ["{S}D1", "{S}D2", "{S}D3"]

[landmarks]
sternum = "T1"
acromion = "{S}ACR"
lateral_epicondyle = "{S}EL"
medial_epicondyle = "{S}EM"
radial_styloid = "{S}RS"
ulnar_styloid = "{S}US"
knuckle = "{S}MC"
"""


def test_letters_are_filled_in_for_both_sides():
    left = REACHING.for_side("left")
    assert left.clusters["trunk"][1] == "RSHO1" and left.clusters["hand"][0] == "LHAN1"
    assert left.lateral == REACHING.lateral
    with pytest.raises(UnknownNameError, match="known: right, left"):
        REACHING.for_side("both")


def test_a_laboratory_describes_its_own(tmp_path):
    where = tmp_path / "lab.toml"
    where.write_text(TOML)
    lab = load_protocol(where)
    assert lab.name == "lab" and lab.frame.up == "y" and lab.knuckle_radial == 0.01
    assert lab.for_side("right").clusters["upper_arm"] == ("RB1", "RB2", "RB3")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("lateral = ", "sideways = "),
        ('lateral = ["LSH", "RSH"]', 'lateral = ["LSH"]'),
        ("[clusters]", "[groups]"),
        ('sternum = "T1"', ""),
        ('up = "y"', 'up = "w"'),
        ('up = "y"', 'down = "y"'),
        ("[clusters]", "[clusters"),
        ("knuckle_radial = 0.01", "shoulder = [1, 2]"),
    ],
)
def test_broken_protocols_are_refused_in_one_line(tmp_path, old, new):
    where = tmp_path / "lab.toml"
    where.write_text(TOML.replace(old, new))
    with pytest.raises(SelfmotionError) as refused:
        load_protocol(where)
    assert "\n" not in str(refused.value)


def test_unknown_names():
    with pytest.raises(UnknownNameError, match="reaching"):
        load_protocol("reachin")
    with pytest.raises(FileFormatError, match="cannot be opened"):
        load_protocol("nowhere.toml")
