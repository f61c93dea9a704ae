"""Both published layouts and flat files, v5 and v7.3, from generated files with known content."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import loadmat, savemat
from tests.motion import matlab_files as made

from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.motion import Labels
from selfmotion.motion.files import load
from selfmotion.motion.files.mat import by_target, read_mat
from selfmotion.motion.files.matlab import read_matlab

BOUNDED = settings(
    deadline=None,
    derandomize=True,
    max_examples=40,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
VERSIONS = ("v5", "v7.3")


@pytest.mark.parametrize("version", VERSIONS)
def test_both_versions_give_the_same_plain_python(tmp_path, version):
    struct = {"a": np.arange(6.0).reshape(2, 3)}
    value = {
        "cells": made.cell([1.5, "text", made.cell([np.eye(2)]), struct]),
        "block": np.arange(24.0).reshape(2, 3, 4),
        "row": np.arange(3.0),
    }
    tree: Any = read_matlab(made.write_mat(tmp_path / "a.mat", value, version))
    assert set(tree) == {"block", "cells", "row"}
    assert tree["cells"][1] == "text" and tree["cells"][0].item() == 1.5
    np.testing.assert_array_equal(tree["cells"][2][0], np.eye(2))
    np.testing.assert_array_equal(tree["cells"][3]["a"], np.arange(6.0).reshape(2, 3))
    np.testing.assert_array_equal(tree["block"], value["block"])
    assert tree["row"].shape == (1, 3)


def plain(value: Any) -> Any:
    """Bring what SciPy's reader gives to plain Python."""
    if value.dtype.names:
        names = value.dtype.names
        structs = [{n: plain(e[n]) for n in names} for e in value.ravel(order="F")]
        return structs[0] if len(structs) == 1 else structs
    if value.dtype == object:
        return [plain(e) for e in value.ravel(order="F")]
    return (str(value.item()) if value.size else "") if value.dtype.kind == "U" else value


@pytest.mark.parametrize("compressed", [True, False])
def test_version_5_against_scipy(tmp_path, compressed):
    structs = np.empty((2, 2), dtype=[("a", object), ("name", object)])
    for i in np.ndindex(2, 2):
        structs[i]["a"], structs[i]["name"] = np.arange(3) + 10 * i[0] + i[1], f"é{i}"
    value = {
        "double": np.random.default_rng(0).normal(size=(2, 3, 4)),
        "small": np.array([[1, 200, 3]], dtype=np.uint8),
        "negative": np.array([[-5]], dtype=np.int64),
        "single": np.array([[0.5, -1.5]], dtype=np.float32),
        "logical": np.array([[True, False]]),
        "empty": np.zeros((0, 3)),
        "text": "Grüße",
        "none": "",
        "structs": structs,
        "cells": made.cell([np.eye(2), "x", made.cell([]), {"deep": made.cell([1.0])}]),
        **made.as_structs_2(made.experiment_2(people=1, samples=5)),
    }
    path = tmp_path / "a.mat"
    savemat(path, value, do_compression=compressed)
    ours: Any = read_matlab(path)
    theirs = {k: plain(v) for k, v in loadmat(path).items() if not k.startswith("__")}
    np.testing.assert_equal(ours, theirs)


def test_sparse_and_complex_are_left_out_and_version_4_refused(tmp_path):
    path = tmp_path / "a.mat"
    savemat(path, {"sparse": scipy.sparse.eye_array(3).tocsc(), "complex": 1j * np.eye(2)})
    assert read_matlab(path).get("complex") is None
    savemat(path, {"qd": np.eye(4)}, format="4")
    with pytest.raises(FileFormatError, match="save with -v7"):
        read_matlab(path)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("layout", [made.as_structs_1, made.as_lists_1])
def test_experiment_1(tmp_path, version, layout):
    samples = 100 if layout is made.as_structs_1 else 12  # a cell a sample is slow in HDF5
    truth = made.experiment_1(samples=samples)
    path = made.write_mat(tmp_path / "S1.mat", layout(truth), version)
    data = read_mat(path)
    assert data.layout == "experiment 1" and len(data.study) == 2 * 2 * (2 + 3 + 2)
    assert data.study.joints[3] == "elbow_flexion" and len(load(path)) == len(data.study)
    for i, person in enumerate(truth):
        for condition, content in person.items():
            for t, target in enumerate(content["trials"]):
                for k, trial in enumerate(target):
                    name = {"subject": f"P{i + 1:02d}", "condition": condition.lower()}
                    (rec,) = data.study.select(**name, target=str(t + 1), trial=str(k + 1))
                    for part, array in trial.items():
                        np.testing.assert_array_equal(rec.array(part), array)
                    np.testing.assert_allclose(rec.time, np.arange(samples) * 0.009)
            labels = Labels(subject=f"P{i + 1:02d}", condition=condition.lower())
            np.testing.assert_array_equal(data.authors_weights[labels], content["weights"])
            if layout is made.as_structs_1:
                pooled = np.concatenate([t["qd"] for target in content["trials"] for t in target])
                np.testing.assert_array_equal(data.ik_data[labels].array("qd"), pooled)
                assert not data.ik_data[labels].timed
    assert any("authors' weights found for 4" in sentence for sentence in data.matched)
    assert any("2 subjects, 2 conditions, 3 targets, 3 trials" in s for s in data.matched)


def test_experiment_1_says_what_it_concluded(tmp_path):
    path = made.write_mat(tmp_path / "S1.mat", made.as_structs_1(made.experiment_1()), "v5")
    said = " | ".join(read_mat(path).matched)
    assert "qd = 'JointVelocity' (28 of 28 movements)" in said
    assert "first 3 of 4 task rows are used" in said
    assert "time step 0.009 s, as documented; not in the file" in said


@pytest.mark.parametrize("version", VERSIONS)
def test_experiment_2(tmp_path, version):
    truth = made.experiment_2()
    data = read_mat(made.write_mat(tmp_path / "S2.mat", made.as_structs_2(truth), version))
    assert data.layout == "experiment 2" and len(data.study) == 8
    assert data.study.joints == ("hip", "shoulder", "elbow")
    for i, person in enumerate(truth):
        chain = data.chains[f"P{i + 1:02d}"]
        np.testing.assert_allclose(chain.lengths, made.LENGTHS * (1 + 0.1 * i), rtol=1e-6)
        np.testing.assert_allclose(chain.offsets, made.OFFSETS, atol=1e-6)
        np.testing.assert_allclose(chain.base, made.BASE, atol=1e-6)
        assert chain.convention.relative and chain.convention.signs == (1, 1, 1)
        for condition, motion in person.items():
            labels = Labels(subject=f"P{i + 1:02d}", condition=condition.lower())
            (rec,) = data.study.select(subject=labels.subject, condition=labels.condition)
            np.testing.assert_array_equal(rec.array("q"), motion["q"])
            np.testing.assert_allclose(rec.array("jacobian"), motion["jacobian"], atol=1e-6)
            made_by_joints = np.einsum("kij,kj->ki", rec.array("jacobian"), rec.array("qd"))
            np.testing.assert_allclose(rec.array("xd"), made_by_joints, atol=2e-4)
            np.testing.assert_array_equal(data.human_elbow[labels], motion["human"])
            np.testing.assert_array_equal(data.authors_weights[labels], motion["weights"])
            assert data.targets[labels].shape == (240, 2)
    assert any("relative angles, signs + + +" in sentence for sentence in data.matched)


@pytest.mark.parametrize(("relative", "signs"), [(False, (1, 1, 1)), (True, (1, -1, 1))])
def test_experiment_2_finds_the_convention_of_the_angles(tmp_path, relative, signs):
    """Told in other angles, the hand is the same and the Jacobian follows by the chain rule."""
    truth = made.experiment_2(people=1)
    to_others = np.diag(np.array(signs, dtype=float)) @ (
        np.eye(3) if relative else np.tril(np.ones((3, 3)))
    )
    for motion in truth[0].values():
        motion["q"] = motion["q"] @ to_others.T
        motion["human"] = motion["q"][:, 2]
        motion["jacobian"] = motion["jacobian"] @ np.linalg.inv(to_others)
    data = read_mat(made.write_mat(tmp_path / "S2.mat", made.as_structs_2(truth), "v5"))
    chain = data.chains["P01"]
    assert (chain.convention.relative, chain.convention.signs) == (relative, signs)
    for rec, motion in zip(data.study, truth[0].values(), strict=True):
        np.testing.assert_allclose(rec.array("jacobian"), motion["jacobian"], atol=1e-6)


def test_experiment_2_by_target(tmp_path):
    truth = made.experiment_2(people=1)
    content = made.as_structs_2(truth)
    shown = np.repeat([[0.0, 1.0], [2.0, 1.0], [0.0, 1.0]], 80, axis=0)
    for condition in made.CONDITIONS_2[:3]:
        content["S2_data"][0, 0][condition]["target"] = shown
    content["S2_data"][0, 0]["Assistive"]["target"] = shown[:7]  # not one a sample: stays whole
    data = read_mat(made.write_mat(tmp_path / "S2.mat", content, "v5"))
    pieces = by_target(data)
    assert [r.labels.trial for r in pieces] == ["1", "2", "3"] * 3 + [None]
    assert {r.n_samples for r in pieces} == {80, 240}
    assert np.shares_memory(pieces[1].array("jacobian"), data.study[0].array("jacobian"))


def test_experiment_2_refuses_what_is_no_planar_chain(tmp_path):
    truth = made.experiment_2(people=1)
    for motion in truth[0].values():
        motion["x"] = np.random.default_rng(0).normal(size=motion["x"].shape)
    with pytest.raises(RangeError, match=r"planar chain: the best fit .* misses the positions"):
        read_mat(made.write_mat(tmp_path / "S2.mat", made.as_structs_2(truth), "v5"))


def test_experiment_2_refuses_an_elbow_that_never_moves(tmp_path):
    truth = [{"Locked": made.experiment_2(people=1)[0]["Locked"]}]
    with pytest.raises(RangeError, match="a joint hardly moves"):
        read_mat(made.write_mat(tmp_path / "S2.mat", made.as_structs_2(truth), "v5"))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("names", [("qd", "jacobian", "xd"), ("Q_dot", "Jac", "dX")])
@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0)])
@pytest.mark.parametrize("inside_struct", [True, False])
def test_flat(tmp_path, version, names, order, inside_struct):
    t = made.trial_1(np.random.default_rng(1), samples=20)
    value: dict[str, Any] = dict(
        zip(names, (t["qd"], t["jacobian"].transpose(order), t["xd"]), strict=True)
    )
    value["trial"] = np.repeat([1.0, 2.0], 10)
    path = tmp_path / "a.mat"
    data = read_mat(made.write_mat(path, {"data": value} if inside_struct else value, version))
    assert data.layout == "flat" and [r.labels.trial for r in data.study] == ["1", "2"]
    np.testing.assert_array_equal(data.study[1].array("jacobian"), t["jacobian"][10:])
    assert not data.study[0].timed


def flat(**changes: Any) -> dict[str, Any]:
    t = made.trial_1(np.random.default_rng(1), samples=20)
    return {k: v for k, v in (t | changes).items() if v is not None}


def with_nan(name: str) -> dict[str, Any]:
    array = flat()[name].copy()
    array.flat[5] = np.nan
    return {name: array}


def edited(edit: Any) -> dict[str, Any]:
    """Experiment 1, layout A, with the first trial changed."""
    people = made.as_structs_1(made.experiment_1(people=1))
    edit(people["S1_data"][0, 0]["Natural"]["Target1"][0, 0])
    return people


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (flat(dq=np.zeros((20, 4))), "'qd' and 'dq' both look like qd"),
        (flat(xd=-flat()["xd"]), "xd differs from jacobian @ qd by 200 %"),
        (flat(jacobian=np.zeros((20, 3, 5))), "20 samples and 4 joints are needed"),
        (flat(jacobian=np.zeros((20, 12))), "Jacobian has shape (20, 12): three axes"),
        (flat(jacobian=np.zeros((21, 3, 4))), "no common number of samples"),
        (flat(qd=None, q=None), "no joint velocities beside the Jacobian"),
        (flat(qd=None), "'q' holds velocities, so the file is ambiguous"),
        (flat(**with_nan("qd")), "qd[1, 1] = nan"),
        ({"apples": np.ones((3, 3))}, "no field looks like a Jacobian or joint angles"),
        ({"text": "hello"}, "no field looks like a Jacobian or joint angles"),
        (edited(lambda t: t["JointVelocity"].__imul__(2)), "P01/Natural/Target1/#1"),
        (edited(lambda t: t.update(qdot=t["JointVelocity"])), "both look like qd"),
        (edited(lambda t: t.update(Jacobian=t["Jacobian"][:, :, :99])), "Jacobian"),
        (
            {**made.as_structs_1(made.experiment_1(1)), **made.as_lists_1(made.experiment_1(1))},
            "all hold movements: keep one",
        ),
    ],
)  # fmt: skip
def test_refused_in_one_line(tmp_path, value, message):
    path = made.write_mat(tmp_path / "a.mat", value, "v5")
    with pytest.raises(SelfmotionError, match=re.escape(message)) as raised:
        read_mat(path)
    assert str(raised.value).startswith(f"{path}: ") and "\n" not in str(raised.value)


def test_no_matlab_file(tmp_path):
    import h5py

    plain = tmp_path / "plain.mat"
    with h5py.File(plain, "w") as file:
        file["qd"] = np.zeros((5, 2))
    with pytest.raises(FileFormatError, match="not written by MATLAB"):
        read_mat(plain)
    text = tmp_path / "text.mat"
    text.write_text("no numbers here, only text that pretends to be a MATLAB file" * 20)
    for path in (text, tmp_path / "absent.mat"):
        with pytest.raises(FileFormatError, match=re.escape(str(path))):
            load(path)


@pytest.fixture(scope="module", params=("v5", "v6", "v7.3"))
def whole(request, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "a.mat"
    people = made.experiment_1(people=1, trials=1)
    for content in people[0].values():
        content["trials"] = [
            [{k: v[:6] for k, v in t.items()} for t in g] for g in content["trials"]
        ]
    return made.write_mat(path, made.as_structs_1(people), request.param).read_bytes()


def test_truncation_is_one_line(whole, tmp_path):
    path = tmp_path / "cut.mat"
    for length in np.linspace(0, len(whole) - 1, 40).astype(int):
        path.write_bytes(whole[:length])
        refused_or_read(path)


@BOUNDED
@given(data=st.data())
def test_damaged_bytes_never_raise_anything_else(whole, tmp_path, data):
    damaged = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 6))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path = Path(tmp_path, "damaged.mat")
    path.write_bytes(damaged)
    refused_or_read(path)


def refused_or_read(path: Path) -> None:
    try:
        read_mat(path)
    except SelfmotionError as error:
        assert "\n" not in str(error)
