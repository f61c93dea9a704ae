"""Markers that are not what they are taken for are refused, not turned into angles."""

from dataclasses import replace

import numpy as np
import pytest

from selfmotion.arms import upper_limb_anatomical
from selfmotion.capture.angles import angles_from_markers
from selfmotion.capture.movement_check import check_movement
from selfmotion.capture.person import calibrate_person
from selfmotion.capture.simulated_markers import simulate_markers
from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.motion.labels import Frame
from selfmotion.motion.markers import MarkerSet

SEEN = simulate_markers(rng=np.random.default_rng(3))


def scaled(markers: MarkerSet, factor: float) -> MarkerSet:
    return replace(markers, positions=factor * markers.positions)


def renamed(markers: MarkerSet, first: str, second: str) -> MarkerSet:
    names = {first: second, second: first}
    return replace(markers, names=tuple(names.get(n, n) for n in markers.names))


def sides_swapped(markers: MarkerSet) -> MarkerSet:
    swap = {f"{a}SHO{i}": f"{b}SHO{i}" for a, b in ("RL", "LR") for i in (1, 2, 3, 4)}
    return replace(markers, names=tuple(swap.get(n, n) for n in markers.names))


def calibrate(static: MarkerSet, movements: tuple[MarkerSet, ...]):
    return calibrate_person(upper_limb_anatomical(), static, movements)


@pytest.mark.parametrize(
    ("static", "movement", "sentence"),
    [
        (1e-3, 1.0, "off their shape"),
        (1.0, 1e3, "off their shape"),
        (1.0, 1e-3, "off their shape"),
        (1e3, 1e3, "units right"),
        (1e-3, 1e-3, "at least 50 mm"),
    ],
)
def test_wrong_units_are_refused(static, movement, sentence):
    with pytest.raises(SelfmotionError, match=sentence):
        calibrate(scaled(SEEN.static, static), (scaled(SEEN.movements[0], movement),))


@pytest.mark.parametrize("first", ["RUAR1", "RLAR1", "RHAN1"])
def test_swapped_markers_of_a_cluster_are_refused(first):
    wrong = renamed(SEEN.movements[0], first, first[:-1] + "2")
    with pytest.raises(RangeError, match=f"{first}.* off their shape"):
        calibrate(SEEN.static, (wrong,))
    person = calibrate(SEEN.static, SEEN.movements[:2])
    with pytest.raises(RangeError, match=f"{first}.* off their shape"):
        angles_from_markers(person, wrong)


def test_swapped_sides_and_a_wrong_up_axis_are_refused():
    swapped = [sides_swapped(m) for m in (SEEN.static, SEEN.movements[0])]
    fallen = [replace(m, frame=Frame("-z", "y")) for m in (SEEN.static, SEEN.movements[0])]
    for static, movement in (swapped, fallen):
        with pytest.raises(RangeError, match="LSHO3 is to the right of RSHO3"):
            calibrate(static, (movement,))


def test_a_movement_is_checked_alone():
    check_movement(SEEN.static, SEEN.movements[0])
    with pytest.raises(RangeError, match="off their shape"):
        check_movement(SEEN.static, scaled(SEEN.movements[0], 1e3))
    with pytest.raises(RangeError, match="to the right of"):
        check_movement(sides_swapped(SEEN.static), sides_swapped(SEEN.movements[0]))


def test_people_who_face_aside_are_measured():
    aside = [replace(m, frame=Frame("z", "x")) for m in (SEEN.static, SEEN.movements[0])]
    turned = calibrate(aside[0], (aside[1],))
    plain = calibrate(SEEN.static, SEEN.movements[:1])
    assert turned.lengths == pytest.approx(plain.lengths)
