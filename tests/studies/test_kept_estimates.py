"""Estimates that are kept come back as they were; what is damaged does not count."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import selfmotion.studies.study_run as study_run
from selfmotion.batch import Runner
from selfmotion.methods.identification import identify_weights
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.motion.recording import Recording
from selfmotion.studies.kept_estimates import ARRAYS, KeptEstimates
from selfmotion.studies.study_file import load_study_file
from selfmotion.studies.study_run import StudyPlan, run_study

EXAMPLE = Path(__file__).parents[2] / "examples" / "study"


def estimate() -> WeightEstimate:
    rng = np.random.default_rng(1)
    jacobian = rng.normal(size=(50, 2, 4))
    return identify_weights(
        Recording(np.arange(50.0), qd=rng.normal(size=(50, 4)), jacobian=jacobian)
    )


def same(a: WeightEstimate, b: WeightEstimate) -> None:
    for f in dataclasses.fields(a):
        one, two = getattr(a, f.name), getattr(b, f.name)
        if f.name in ARRAYS:
            np.testing.assert_array_equal(one, two)
            assert one.shape == two.shape
        elif f.name == "provenance":  # JSON knows no tuples
            assert json.dumps(one.to_dict()) == json.dumps(two.to_dict())
        elif f.name == "unidentifiable":
            assert dict(one) == dict(two)
        else:
            assert one == two, f.name


def test_what_is_kept_comes_back_with_every_digit(tmp_path: Path):
    path, found = tmp_path / "e.jsonl", estimate()
    KeptEstimates.open(path, resume=False).keep("a", found)
    again = KeptEstimates.open(path, resume=True)
    back = again.recall("a")
    assert back is not None and again.recall("b") is None
    same(found, back)
    assert KeptEstimates.open(path, resume=False).recall("a") is None
    assert path.read_text() == ""


def test_a_damaged_line_does_not_count(tmp_path: Path):
    path = tmp_path / "e.jsonl"
    KeptEstimates.open(path, resume=False).keep("a", estimate())
    whole = path.read_text()
    for spoilt in (whole[:-20], whole.replace('"weights"', '"wights"'), "[1]\nnull\n{}"):
        path.write_text(spoilt)
        again = KeptEstimates.open(path, resume=True)
        assert again.recall("a") is None
        again.keep("b", estimate())
        assert KeptEstimates.open(path, resume=True).recall("b") is not None


def test_a_resumed_study_identifies_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    study = load_study_file(EXAMPLE / "study.toml")
    plan = StudyPlan((EXAMPLE,), study, "exoskeleton", out=tmp_path)
    first = run_study(plan)
    lines = (tmp_path / "estimates.jsonl").read_text().splitlines()
    (tmp_path / "estimates.jsonl").write_text("\n".join(lines[:-1]))  # one was not finished
    calls = []
    real = study_run.identify_weights_from_arrays

    def counted(*args, **options):
        calls.append(1)
        return real(*args, **options)

    monkeypatch.setattr(study_run, "identify_weights_from_arrays", counted)
    again = run_study(plan, Runner(resume=True))
    assert len(calls) == 1 and len(lines) > 3
    for key, wanted in first.estimates.items():
        same(again.estimates[key], wanted)
