"""`selfmotion weights` and `split`: results, refusals, files and reports."""

import json

import numpy as np
import pytest

from selfmotion.cli.app import main

TRUE = np.array([1.0, 0.8, 0.6, 0.4, 0.2])


def motion(rng, n_samples=200, n=5, m=3):
    """Give velocities of least weighted square, without null-space motion, and Jacobians."""
    J = rng.standard_normal((n_samples, m, n))
    xd = rng.standard_normal((n_samples, m, 1))
    w = TRUE[:n]
    qd = (J.mT / w[:, None] @ np.linalg.solve(J / w @ J.mT, xd))[..., 0]
    return qd, J


@pytest.fixture
def recorded(tmp_path):
    qd, J = motion(np.random.default_rng(3))
    path = tmp_path / "reach.npz"
    np.savez(path, qd=qd, jacobian=J, trial=np.repeat(np.arange(10), 20))
    return path


def run_json(capsys, *words):
    code = main([*map(str, words), "--json"])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("method", ["ml", "paper"])
def test_true_weights_come_back(recorded, capsys, method):
    code, found = run_json(capsys, "weights", recorded, "--method", method)
    assert code == 0
    np.testing.assert_allclose(found["weights"], TRUE, atol=1e-5)
    np.testing.assert_allclose(found["contribution"], 1 / TRUE / (1 / TRUE).sum(), atol=1e-5)
    assert found["n_trials"] == 10 and found["method"] == method


def test_each_trial_gets_an_estimate(recorded, capsys):
    code, found = run_json(capsys, "weights", recorded, "--per", "trial")
    assert code == 0
    assert len(found["items"]) == 10
    for item in found["items"]:
        np.testing.assert_allclose(item["weights"], TRUE, atol=1e-6)


def test_over_specified_joint_is_null_with_a_reason(tmp_path, capsys):
    rng = np.random.default_rng(5)
    qd, J = motion(rng, n=4, m=2)
    # A fifth joint alone moves a third direction: no other joint can stand in for it.
    J5 = np.zeros((len(J), 3, 5))
    J5[:, :2, :4], J5[:, 2, 4] = J, 1.0
    qd5 = np.column_stack([qd, rng.standard_normal(len(qd))])
    path = tmp_path / "over.npz"
    np.savez(path, qd=qd5, jacobian=J5, trial=np.repeat(np.arange(10), 20))
    code, found = run_json(capsys, "weights", path)
    assert code == 0
    assert found["weights"][4] is None
    assert "over-specified" in found["unidentifiable"]["joint_5"]


def test_files_and_report_are_written(recorded, tmp_path, capsys):
    out, report = tmp_path / "out", tmp_path / "weights.html"
    assert main(["weights", str(recorded), "--out", str(out), "--report", str(report)]) == 0
    assert json.loads((out / "weights.json").read_text())["joints"][0] == "joint_1"
    assert (out / "weights.csv").read_text().startswith("part,joint,weight")
    page = report.read_text(encoding="utf-8")
    assert "What the data can tell" in page and "<svg" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    capsys.readouterr()


def test_shares_of_split_add_up_and_weights_can_be_given(recorded, tmp_path, capsys):
    code, found = run_json(capsys, "split", recorded, "--weights", "1,0.8,0.6,0.4,0.2")
    assert code == 0
    for share in found["recordings"]:
        assert share["task_share"] == pytest.approx(1.0, abs=1e-12)
        assert share["null_share"] == pytest.approx(0.0, abs=1e-12)
    _, equal = run_json(capsys, "split", recorded, "--weights", "equal")
    assert all(0.5 < r["task_share"] < 0.999 for r in equal["recordings"])
    main(["weights", str(recorded), "--out", str(tmp_path)])
    capsys.readouterr()
    _, again = run_json(capsys, "split", recorded, "--weights", tmp_path / "weights.json")
    np.testing.assert_allclose(again["weights"], TRUE, atol=1e-6)


def broken(name, qd, J):
    """Give the arrays of a file that must be refused."""
    K = len(qd)
    cases = {
        "nan": {"qd": np.where(np.arange(K)[:, None] == 3, [[np.nan, 1, 1, 1, 1]], qd)},
        "infinite": {"qd": np.where(np.arange(K)[:, None] == 3, np.inf, qd)},
        "shape": {"jacobian": J[:, :, :4]},
        "short": {"jacobian": J[:-1]},
        "one": {"qd": qd[:1], "jacobian": J[:1]},
        "still": {"qd": 0 * qd},
        "deficient": {"jacobian": np.repeat(J[:, :1], 3, axis=1)},
        "inconsistent": {"xd": np.ones((K, 3)) * 7},
        "not redundant": {"qd": qd[:, :3], "jacobian": J[:, :, :3]},
        "text": {"qd": qd.astype(str)},
    }
    return {"qd": qd, "jacobian": J} | cases[name]


@pytest.mark.parametrize(
    "name",
    [
        "nan",
        "infinite",
        "shape",
        "short",
        "one",
        "still",
        "deficient",
        "inconsistent",
        "not redundant",
        "text",
    ],
)
def test_bad_files_are_refused_in_one_line_that_names_them(tmp_path, capsys, name):
    path = tmp_path / "bad.npz"
    np.savez(path, **broken(name, *motion(np.random.default_rng(1))))
    assert main(["weights", str(path)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert "bad.npz" in printed.err and "internal error" not in printed.err


def test_gaps_are_dropped_and_counted(tmp_path, capsys):
    qd, J = motion(np.random.default_rng(2))
    qd[7:10], J[7:10] = np.nan, np.nan
    path = tmp_path / "gap.npz"
    np.savez(path, qd=qd, jacobian=J)
    code = main(["weights", str(path), "--json"])
    printed = capsys.readouterr()
    assert code == 0 and json.loads(printed.out)["n_dropped"] == 3
    assert "3 of 200 samples" in printed.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["weights", "nowhere.npz"], "nowhere.npz"),
        (["weights", "examples/reach.csv"], "--arm"),
        (["weights", "examples/reach.csv", "--arm", "exoskeletn"], "exoskeleton"),
        (["weights", "examples/reach.csv", "--arm", "wrist"], "pronation"),
        (["weights", "examples/reach.csv", "--arm", "exoskeleton", "--null-ratio", "2"], "null"),
        (["weights", "examples/reach.csv", "--arm", "exoskeleton", "--cutoff", "90"], "cutoff"),
        (["split", "examples/reach.csv", "--arm", "exoskeleton", "--weights", "1,2"], "weights"),
        (["split", "examples/reach.csv", "--arm", "exoskeleton", "--weights", "a"], "--weights"),
    ],
)
def test_wrong_words_are_refused_in_one_line(words, said, capsys, monkeypatch):
    from tests.cli.golden import ROOT

    monkeypatch.chdir(ROOT)
    assert main(words) == 2
    printed = capsys.readouterr()
    assert printed.err.count("\n") == 1 and said in printed.err


def test_split_says_what_it_takes_for_repetitions(tmp_path, capsys):
    rng = np.random.default_rng(2)
    for trial in (1, 2):
        rows = [",".join(["time", "shoulder_elevation", "shoulder_rotation"])]
        rows[0] += ",shoulder_flexion,elbow_flexion"
        path = 0.5 + np.linspace(0.0, 0.5, 40)[:, None] * rng.uniform(0.5, 1.0, 4)
        rows += [f"{0.02 * k}," + ",".join(map(str, q)) for k, q in enumerate(path.tolist())]
        (tmp_path / f"{trial}.csv").write_text("\n".join(rows) + "\n")
    words = ["split", str(tmp_path), "--arm", "exoskeleton", "--weights", "equal"]
    assert main(words) == 0
    told = capsys.readouterr().out
    assert "2 repetitions" in told
    assert "the files name no condition or target" in told
