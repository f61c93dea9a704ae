"""`selfmotion reproduce`: what it refuses, its records, and a report of each paper."""

import json
from pathlib import Path

import numpy as np
import pytest

from selfmotion.cli import reproduce
from selfmotion.methods.workspace import WorkspaceOptions
from selfmotion.provenance import Provenance
from tests.cli.running import Capture, answered, refused

PAPERS = ("khoramshahi2022", "tommasino2017", "deboon", "li2022")


def test_papers_are_the_four() -> None:
    assert tuple(reproduce.PAPERS) == PAPERS


def test_unknown_paper_is_refused_with_the_nearest(capsys: Capture) -> None:
    assert "did you mean 'deboon'" in refused(capsys, "reproduce", "deboom")


@pytest.mark.parametrize("paper", [*PAPERS[1:], "all"])
def test_data_are_refused_for_other_papers(paper: str, capsys: Capture) -> None:
    line = refused(capsys, "reproduce", paper, "--data", "people.mat")
    assert "--data people.mat" in line and "khoramshahi2022 only" in line


def test_one_report_for_all_is_refused(capsys: Capture) -> None:
    assert "--out DIR" in refused(capsys, "reproduce", "all", "--report", "r.html")


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduce, "TRIALS", 2)


@pytest.mark.usefixtures("small")
def test_tommasino2017_gives_numbers_and_a_report(tmp_path: Path, capsys: Capture) -> None:
    words = ("reproduce", "Tommasino2017", "--people", "2", "--out", tmp_path)
    document = answered(capsys, *words)
    assert document["papers"] == ["tommasino2017"]
    assert document["provenance"]["choices"]["n_trials"] == 2
    damping = document["numbers"][0]
    assert damping["published"] == damping["ours"] == "0.04, 0.12, 0.16"
    page = (tmp_path / "tommasino2017.html").read_text(encoding="utf-8")
    assert page.count("<svg") >= 5 and "Person 2" in page
    assert json.loads((tmp_path / "reproduce.json").read_text())["numbers"] == document["numbers"]


def test_numbers_of_deboon_say_that_they_are_taken_over(tmp_path: Path) -> None:
    from selfmotion.report.deboon_page import write_deboon_report
    from selfmotion.studies.deboon import StudySize, deboon_study

    options = WorkspaceOptions(n_points=256, shifts=3, slice_points=64)
    size = StudySize(options, n_samples=24, heights=(-0.2, 0.0))
    found = deboon_study(size=size, rng=np.random.default_rng(0))
    table = reproduce.with_kinds(found.numbers)
    records = reproduce.records("deboon", table)
    assert {r.comparable for r in records if "not at hand" in r.kind} == {False}
    assert all(r.published == r.ours for r in records if r.comparable)
    assert sum("not at hand" in r.kind for r in records) == 3
    path = write_deboon_report(tmp_path / "d.html", found, table, Provenance("test"))
    assert path.read_text(encoding="utf-8").count("<svg") >= 3


def test_all_is_each_paper_in_turn(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: Capture
):
    def quick(name: str):
        def make(asked: reproduce.Asked) -> reproduce.Made:
            def write(path: Path) -> Path:
                path.write_text(name)
                return path

            return reproduce.Made(name, [], Provenance(name, choices={"size": 1}), write)

        return make

    monkeypatch.setattr(reproduce, "PAPERS", {name: quick(name) for name in PAPERS})
    document = answered(capsys, "reproduce", "all", "--out", tmp_path)
    assert document["papers"] == list(PAPERS)
    assert document["provenance"]["choices"] == {name: {"size": 1} for name in PAPERS}
    assert {p.name for p in tmp_path.glob("*.html")} == {f"{name}.html" for name in PAPERS}
