"""`selfmotion predict`: a planted study from its journal to document, files and report."""

from pathlib import Path

import pytest

from selfmotion.methods.predictors.catalogue import BASELINE, CRITERIA, FITTED
from tests.cli.running import Capture, answered, refused
from tests.studies.prediction_cases import planted


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    planted(tmp_path)
    return tmp_path


def words(folder: Path) -> tuple[object, ...]:
    return (
        "predict",
        folder,
        "--study",
        folder / "study.toml",
        "--out",
        folder / "out",
        "--resume",
    )


def test_an_interrupted_run_goes_on_and_writes_everything(folder: Path, capsys: Capture):
    report = folder / "report.html"
    document = answered(capsys, *words(folder), "--report", report)
    assert document["schema"] == "selfmotion/predict/1"
    assert (document["people"], document["moments"], document["moments_left_out"]) == (4, 16, 8)
    assert {s["predictor"] for s in document["summary"]} == {p.name for p in (*CRITERIA, *FITTED)}
    assert document["baseline"] == BASELINE
    assert len(document["observations"]) == 24
    assert document["observations"][0]["predicted"] == {}  # left out
    for table in ("predictors", "errors_by_kind", "errors_by_person", "spread", "observations"):
        assert (folder / "out" / f"{table}.csv").is_file()
    text = report.read_text(encoding="utf-8")
    assert text.count("<svg") == 3
    for caption in (
        "Predicted against natural",
        "Mean absolute error by kind",
        "Mean angles by person",
        "mid\N{NO-BREAK SPACE}drink",
        "standard deviation within people",
        "The arm with muscles at each",
    ):
        assert caption in text


def test_a_broken_person_is_reported_and_the_rest_goes_on(folder: Path, capsys: Capture):
    (folder / "Q1_reach_1.csv").write_text("broken")
    (folder / "Q1_static.csv").write_text("Trajectories\n100\nbroken")
    document = answered(capsys, *words(folder), code=1)
    assert document["people"] == 4
    assert [bad["item"] for bad in document["failed"]] == ["Q1 right"]
    assert "Q1_static.csv" in document["failed"][0]["status"]


def test_refusals(folder: Path, capsys: Capture):
    assert "--study" in refused(capsys, "predict", folder)
    assert "cannot be opened" in refused(capsys, "predict", folder, "--study", folder / "no.toml")
    assert "no such folder" in refused(
        capsys, "predict", folder / "nowhere", "--study", folder / "study.toml"
    )
    assert "--out" in refused(
        capsys, "predict", folder, "--study", folder / "study.toml", "--resume"
    )


def test_people_for_a_reproduction_need_a_study_and_the_right_paper(folder: Path, capsys: Capture):
    assert "--study" in refused(capsys, "reproduce", "li2022", "--recordings", folder)
    said = ("--recordings", folder, "--study", folder / "study.toml")
    assert "li2022" in refused(capsys, "reproduce", "deboon", *said)
