"""Marker inverse kinematics on real recordings, where they are at hand."""

from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import upper_limb_anatomical
from selfmotion.capture.angles import angles_from_markers
from selfmotion.capture.person import CaptureOptions, calibrate_person
from selfmotion.capture.scaling import with_adult_ranges
from selfmotion.motion.files.vicon_csv import read_vicon_csv
from selfmotion.motion.labels import Frame

DATA = Path(__file__).parents[3].joinpath("shared", "data", "ue_adl")
pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"the reaching recordings are not at {DATA}"
)


def read(name: str):
    return read_vicon_csv(DATA / name[:6] / f"{name}.csv", frame=Frame())


@pytest.mark.parametrize(("subject", "letter", "side"), [(4, "R", "right"), (3, "L", "left")])
def test_landmarks_are_met_within_15_mm_inside_the_limits(subject, letter, side):
    static = read(f"ADL00{subject}_static")
    trials = [read(f"ADL00{subject}{task}{letter}1") for task in "FADC"]
    person = calibrate_person(with_adult_ranges(upper_limb_anatomical()), static, trials, side=side)
    rms = []
    for trial in trials:
        ik = angles_from_markers(person, trial).ik
        rms.append(ik.rms)
        assert (ik.q >= person.arm.lower).all() and (ik.q <= person.arm.upper).all()
        # Joint angles of a person move smoothly: no jump between two frames at 100 Hz.
        assert np.rad2deg(np.abs(np.diff(ik.q, axis=0)).max()) < 15.0
    assert np.median(np.concatenate(rms)) < 0.015


def test_functional_centres_bring_the_clusters_together():
    static = read("ADL005_static")
    trials = [read(f"ADL005{task}R{i}") for task in "FADC" for i in (1, 3)]
    apart = {}
    for centres in ("functional", "landmarks"):
        person = calibrate_person(
            with_adult_ranges(upper_limb_anatomical()),
            static,
            trials,
            options=CaptureOptions(centres=centres),
        )
        apart[centres] = angles_from_markers(person, trials[0]).elbow_disagreement()
    assert apart["functional"] < 0.5 * apart["landmarks"]
