"""These need the extra `opensim`; those with the reference model need its files too."""

import resource
from pathlib import Path

import numpy as np
import pytest

from selfmotion.errors import FileFormatError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.motion.files.c3d import read_c3d
from selfmotion.muscles.opensim_bridge import read_osim
from selfmotion.muscles.osim_reader import model_coordinates
from selfmotion.muscles.static_optimization import muscle_effort
from selfmotion.redundancy.refine import pose_from_quaternion
from tests.motion.c3d_files import written

from .osim_models import MIDDLE, TIME, small_arm, static_optimization

osim = pytest.importorskip("opensim", reason="needs the extra: pip install 'selfmotion[opensim]'")

REFERENCE = Path(__file__).parents[3].joinpath("shared", "data", "memikrr")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "small.osim"
    small_arm(osim, path)
    return path


@pytest.fixture(scope="module")
def reference():
    path = REFERENCE / "Model_Scaled_LQL.osim"
    if not path.is_file():
        pytest.skip("the reference model is not at hand")
    return path


def postures(model, count, seed):
    q = model.arm.random_postures(count, np.random.default_rng(seed))
    return model.arm.middle() + 0.6 * (q - model.arm.middle())


def check_kinematics(model, q):
    """Compare with the model's own frames, moment arms and forces, posture by posture."""
    g = model.geometry
    hand = forward_kinematics(model.arm.chain, q, model.arm.tip("hand"))
    lengths, arms = g.lengths_and_moment_arms(q)
    forces = model.forces.full_activation(lengths)
    limits = model.limits(q)
    muscles = g.model.getMuscles()
    free = list(model.arm.joints)
    for k in range(len(q)):
        g.pose(g.coordinates.value(q[k : k + 1])[0])
        T = g.model.getBodySet().get("hand").getTransformInGround(g.state)
        assert [T.p().get(i) for i in range(3)] == pytest.approx(hand[k, :3, 3], abs=1e-10)
        R = [[T.R().get(i, j) for j in range(3)] for i in range(3)]
        assert np.array(R) == pytest.approx(hand[k, :3, :3], abs=1e-10)
        for m in range(0, muscles.getSize(), max(muscles.getSize() // 6, 1)):
            muscle = muscles.get(m)
            own = muscle.calcInextensibleTendonActiveFiberForce(g.state, 1.0)
            assert forces[k, m] == pytest.approx(own, abs=1e-8)
            for name in free:  # OpenSim's moment arm: generalised force, coupled ones included
                coordinate = g.model.getCoordinateSet().get(name)
                own = muscle.computeMomentArm(g.state, coordinate)
                assert arms[k, m, free.index(name)] == pytest.approx(own, abs=1e-8)
        total = np.zeros(len(free))
        for i in range(g.model.getForceSet().getSize()):
            force = g.model.getForceSet().get(i)
            if force.getConcreteClassName() == "CoordinateLimitForce":
                name = force.getPropertyByName("coordinate").toString()
                g.model.realizeDynamics(g.state)
                total[free.index(name)] += force.getRecordValues(g.state).get(0)
        assert limits[k] == pytest.approx(total, abs=1e-9)


def check_effort(model, file, q, folder):
    """Compare with OpenSim's static optimisation, held still and amid a movement."""
    g, middle = model.geometry, TIME[MIDDLE]
    names = [c.getName() for c in model_coordinates(g.model)]
    swing = np.where(np.arange(q.shape[1]) < 5, 0.2, 0.05)
    for pace in (0.0, 2.0):  # rad/s
        qd = np.broadcast_to(swing * pace, q.shape)
        ours = muscle_effort(model, q, velocity=qd, acceleration=0.0 * q)
        held = [k for k in range(len(q)) if ours.status[k]]  # OpenSim does not converge elsewhere
        assert len(held) >= 2
        for k in held[: 1 if pace else 2]:
            motion = q[k] + swing * np.sin(pace * (TIME[:, None] - middle))
            values = dict(zip(names, g.coordinates.value(motion).T, strict=True))
            (folder / f"{pace}_{k}").mkdir()
            own = static_optimization(osim, file, values, folder / f"{pace}_{k}")
            effort = sum(own[m] ** 2 for m in model.muscles.names)
            assert ours.effort[k] == pytest.approx(effort, rel=1e-5)


def test_a_small_model_is_the_model_of_opensim(file):
    model = read_osim(file)
    assert model.arm.joints == ("shoulder_angle", "elbow_angle")
    assert [model.arm.chain.names[c.joint] for c in model.arm.chain.coupling.curves] == [
        "wrist_angle"
    ]
    check_kinematics(model, postures(model, 6, 0))


def test_effort_of_a_small_model_is_that_of_static_optimisation(file, tmp_path):
    model = read_osim(file)
    check_effort(model, file, postures(model, 4, 1), tmp_path)


def test_effort_of_thelen_muscles_is_that_of_static_optimisation(tmp_path):
    """A model that comes with OpenSim; it has no forces at coordinate limits."""
    path = REFERENCE.parent / "arm26_opensim" / "arm26.osim"
    if not path.is_file():
        pytest.skip("the model arm26 is not at hand")
    model = read_osim(path)
    check_effort(model, path, postures(model, 8, 3), tmp_path)


def test_the_reference_model_is_that_of_opensim(reference):
    model = read_osim(reference)
    assert model.arm.n_joints == 7 and len(model.muscles.names) == 50
    check_kinematics(model, postures(model, 2, 2))


def test_effort_of_the_reference_model_is_that_of_static_optimisation(reference, tmp_path):
    model = read_osim(reference)
    check_effort(model, reference, postures(model, 6, 3), tmp_path)


def test_a_published_wrist_pose_has_a_natural_posture(reference):
    model = read_osim(reference)
    finder = PostureFinder.of(model)
    row = np.loadtxt(REFERENCE / "wrist_poses_001_060.txt", max_rows=1)
    found = finder.find(pose_from_quaternion(row[1:5] / np.linalg.norm(row[1:5]), row[5:8]))
    assert found.status and found.provenance.choices["convention"] == "opensim"
    published = np.loadtxt(REFERENCE / "feasible_postures_001_060.txt", max_rows=40)
    assert len(published) and len(found.feasible_swivel) >= 1


def test_memory_does_not_grow_with_calls(file):
    model = read_osim(file)
    q = postures(model, 200, 4)
    model.geometry.lengths_and_moment_arms(q)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(85):  # 10^5 path evaluations
        model.geometry.lengths_and_moment_arms(q)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000  # kB


@pytest.mark.long
def test_memory_does_not_grow_in_a_hundred_thousand_calls(file):
    model = read_osim(file)
    q = postures(model, 100, 4)
    model.geometry.lengths_and_moment_arms(q)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(1000):
        for i in range(len(q)):
            model.geometry.lengths_and_moment_arms(q[i : i + 1])
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000  # kB


def test_what_is_no_model_is_refused_in_one_line(file, tmp_path):
    with pytest.raises(FileFormatError, match="there is no such file"):
        read_osim(tmp_path / "none.osim")
    broken = tmp_path / "broken.osim"
    broken.write_text("<OpenSimDocument><Model name='x'></OpenSimDocument>")
    with pytest.raises(FileFormatError) as error:
        read_osim(broken)
    assert "\n" not in str(error.value)
    with pytest.raises(UnknownNameError, match="unknown body for the landmark elbow"):
        read_osim(file, landmarks={"elbow": "femur"})


def test_a_model_is_read_in_a_process_that_has_used_c3d(file, tmp_path):
    """Both libraries bring one C++ type to Python (a vector of integers); ezc3d's then wins."""
    read_c3d(written(tmp_path, analog=2)[0])
    assert read_osim(file).arm.n_joints == 2
