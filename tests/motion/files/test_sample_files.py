"""Real recordings, where they are at hand: each reads, or is refused with a reason."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from selfmotion.errors import SelfmotionError
from selfmotion.motion import Frame
from selfmotion.motion.files import load, load_markers
from selfmotion.motion.files.angles_csv import read_angles_csv
from selfmotion.motion.files.describe import describe
from selfmotion.motion.files.orientation import read_orientations
from selfmotion.motion.files.storage import read_storage

DATA = Path(__file__).parents[4] / "shared" / "data"
MISSING = f"the recordings of {DATA.name} are not at hand"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=MISSING)
# One reader is enough for many files alike: of the reaching data every tenth.
STRIDE = 10


@cache
def files() -> tuple[Path, ...]:
    found = sorted(p for p in DATA.rglob("*") if p.is_file())
    reaching = [p for p in found if "ue_adl" in p.parts and p.suffix.lower() == ".csv"]
    return tuple([p for p in found if p not in reaching] + reaching[::STRIDE])


def sample(*parts: str) -> Path:
    path = DATA.joinpath(*parts)
    if not path.is_file():
        pytest.skip(f"{'/'.join(parts)} is not at hand")
    return path


@pytest.mark.parametrize("path", files() if DATA.is_dir() else (), ids=lambda p: p.name)
def test_every_file_reads_or_is_refused_with_a_reason(path):
    for read in (load, load_markers, read_orientations, describe):
        try:
            found = read(path)
        except SelfmotionError as error:
            assert str(path) in str(error) and "\n" not in str(error)
            assert len(str(error).replace(str(path), "")) > 15
        else:
            assert found is not None


def test_every_kind_of_file_is_among_them():
    """A kind that nobody tried would be neither read nor refused."""
    kinds = {path.suffix.lower() for path in DATA.rglob("*") if path.is_file()}
    assert kinds == {path.suffix.lower() for path in files()}


@pytest.mark.parametrize(
    ("parts", "samples", "names", "rate"),
    [
        (("arm26_opensim", "arm26_elbow_flex.trc"), 121, 3, 120.0),
        (("pyomeca_tests", "markers.trc"), 93, 51, 100.0),
        (("pyomeca_tests", "markers_analogs.c3d"), 580, 51, 100.0),
        (("pyomeca_tests", "markers.csv"), 580, None, 100.0),
        (("kineticstoolkit_wheelchair", "sample_static.c3d"), 700, 41, 69.9),
        (("kineticstoolkit_wheelchair", "sample_probing_acromion_R.c3d"), 140, 41, 69.5),
    ],
)
def test_markers_are_as_documented(parts, samples, names, rate):
    seen = load_markers(sample(*parts))
    assert seen.n_samples == samples and names in (None, seen.n_markers)
    assert seen.rate == pytest.approx(rate, rel=1e-4)
    # Metres: a laboratory, and neither a kilometre nor a millimetre wide.
    spread = np.nanmax(seen.positions, axis=(0, 1)) - np.nanmin(seen.positions, axis=(0, 1))
    assert 0.1 < spread.max() < 10.0


def test_two_formats_of_one_trial_agree():
    c3d = load_markers(sample("pyomeca_tests", "markers_analogs.c3d"))
    csv = load_markers(sample("pyomeca_tests", "markers.csv"))
    shared = [name for name in csv.names if name in c3d.names]
    assert len(shared) > 40
    a, b = c3d.select(shared), csv.select(shared)
    both = ~(a.missing() | b.missing())
    assert both.mean() > 0.95
    # The CSV keeps six digits of a millimetre, the C3D a scaled word or a float.
    assert np.abs(a.positions - b.positions)[both].max() < 1e-4
    assert c3d.frame.up == "z" and c3d.frame.forward is None


@pytest.mark.parametrize(
    ("parts", "samples", "joints"),
    [
        (("arm26_opensim", "arm26_InverseKinematics.mot"), 121, 2),
        (("pyomeca_tests", "inverse_kin.mot"), 88, 25),
        (("memikrr", "coordinates.mot"), 6, 21),
        (("tsm_shoulder_rmr", "Results", "IK solutions", "ABD01.mot"), 1091, 17),
    ],
)
def test_coordinates_are_as_documented(parts, samples, joints):
    recording = load(sample(*parts))[0]
    assert (recording.n_samples, recording.n_joints) == (samples, joints)
    assert np.abs(recording.array("q")).max() < 2 * np.pi


def test_degrees_become_radians_and_lengths_stay():
    path = sample("pyomeca_tests", "inverse_kin.mot")
    recording, table = load(path)[0], read_storage(path)
    lengths = [*(f"thorax_t{a}" for a in "xyz"), *(f"box_trans{a}" for a in "XYZ")]
    scale = [1.0 if name in lengths else np.pi / 180 for name in recording.joints]
    np.testing.assert_allclose(recording.array("q"), table.values * scale, rtol=1e-15)


@pytest.mark.parametrize("name", ["activation", "force"])
def test_muscle_tables_are_no_motion(name):
    path = sample("arm26_opensim", f"arm26_StaticOptimization_{name}.sto")
    with pytest.raises(SelfmotionError, match="holds no coordinates"):
        load(path)
    assert read_storage(path).values.shape == (121, 6)
    assert describe(path).holds == "a table: Static Optimization"


def test_a_table_whose_time_and_unit_are_stated():
    path = sample("ue_adl", "ADL001", "ADL001FR1angles.csv")
    with pytest.raises(SelfmotionError, match="Finger Velocity.*no joint angle by its name"):
        load(path, unit="deg", rate=100.0)
    names = ("elbow flexion-extension", "forearm pronation-supination")
    recording = read_angles_csv(path, unit="deg", rate=100.0, joints=names)[0]
    assert recording.joints == names and recording.rate == pytest.approx(100.0)
    assert 0.5 < np.abs(recording.array("q")).max() < np.pi


def test_headers_that_overstate_are_noted():
    found = describe(sample("pyomeca_tests", "markers.trc"))
    assert "its header says NumFrames 652; 93 are there" in found.notes
    assert found.units["lengths"] == "mm" and not found.frame.known
    moved = describe(sample("pyomeca_tests", "inverse_kin.mot"))
    assert "its header says nRows 250; 88 are there" in moved.notes
    assert moved.units["angles"] == "deg (inDegrees=yes)"


def test_the_callers_frame_is_kept():
    path = sample("ue_adl", "ADL001", "ADL001FR1.csv")
    assert load_markers(path, frame=Frame("z", "y")).frame == Frame("z", "y")
