"""Marker protocols: built in and from TOML."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import upper_limb_anatomical
from selfmotion.capture.angles import angles_from_markers
from selfmotion.capture.person import calibrate_person
from selfmotion.capture.protocol import REACHING, load_protocol, protocol_names
from selfmotion.capture.scaling import with_adult_ranges
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError, UnknownNameError
from selfmotion.motion.files import load_markers
from selfmotion.motion.markers import MarkerSet

DATA = Path(__file__).parents[3] / "shared" / "data"

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


def test_protocols_that_come_along_load_or_say_what_the_laboratory_lacks():
    assert {"reaching", "pyomeca", "wheelchair"} <= {*protocol_names()}
    with pytest.raises(UnknownNameError, match="known: right"):
        load_protocol("pyomeca").for_side("left")
    with pytest.raises(FileFormatError, match=r"no landmark acromion \(pointed at.*knuckle"):
        load_protocol("wheelchair")
    with pytest.raises(UnknownNameError, match="pyomeca"):
        load_protocol("pyomecca")


def test_a_prefix_comes_off_beside_an_object_s_but_two_people_are_refused():
    lab = load_protocol("pyomeca")
    names = tuple(sorted(lab.markers()))
    places = np.ones((1, len(names) + 1, 3))
    found = lab.select(MarkerSet(np.zeros(1), ("box:A", *(f"P1:{n}" for n in names)), places))
    assert found.names == names and found.labels.subject == "P1" and found.frame == lab.frame
    two = ("P2:STER", *(f"P1:{n}" for n in names))
    with pytest.raises(RangeError, match="P1 and P2 beside each other"):
        lab.select(MarkerSet(np.zeros(1), two, places))
    with pytest.raises(UnknownNameError, match="none of the markers of protocol pyomeca"):
        lab.select(MarkerSet(np.zeros(1), ("A",), places[:, :1]))


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the recordings of {DATA.name} are not at hand")
def test_the_box_lifting_trial_gives_the_elbow_that_its_markers_show():
    folder = DATA / "pyomeca_tests"
    if not (folder / "markers_analogs.c3d").is_file():
        pytest.skip("pyomeca_tests is not at hand")
    lab = load_protocol("pyomeca")
    seen = load_markers(folder / "markers_analogs.c3d")
    arm = with_adult_ranges(upper_limb_anatomical())
    person = calibrate_person(arm, seen, [seen], protocol=lab)
    motion = angles_from_markers(person, seen)
    assert np.nanmedian(motion.ik.rms) < 0.015 and motion.ik.converged.mean() > 0.95
    assert 0.25 < person.lengths["upper_arm"] < 0.35
    elbow = motion.recording.joints.index("elbow_flexion")
    ours = motion.recording.array("q")[:, elbow]
    # By the markers alone: the acromion is off the shoulder's centre by a few degrees of this.
    mark = {name: lab.select(seen).point(name) for name in lab.markers()}
    middle = 0.5 * (mark["EPICl"] + mark["EPICm"])
    upper, fore = mark["ACRO_tip"] - middle, 0.5 * (mark["STYLr"] + mark["STYLu"]) - middle
    cosine = (upper * fore).sum(1) / np.linalg.norm(upper, axis=1) / np.linalg.norm(fore, axis=1)
    theirs = np.pi - np.arccos(cosine)
    known = np.isfinite(theirs) & np.isfinite(ours)
    assert np.corrcoef(ours[known], theirs[known])[0, 1] > 0.99
    assert np.abs(ours - theirs)[known].max() < np.deg2rad(20)
