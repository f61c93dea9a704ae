"""`selfmotion reproduce`: what it refuses, its records, and a report of each paper."""

import json
from pathlib import Path

import numpy as np
import pytest

from selfmotion.cli import reproduce
from selfmotion.methods.workspace import WorkspaceOptions
from selfmotion.provenance import Provenance
from selfmotion.report.html import Page, Section
from selfmotion.studies.paper_figures import FIGURES
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
    assert page.count("<svg") >= 6 and "Person 2" in page
    assert all(one.section in page for one in FIGURES["tommasino2017"])
    assert json.loads((tmp_path / "reproduce.json").read_text())["numbers"] == document["numbers"]


def test_numbers_of_deboon_say_that_they_are_taken_over(tmp_path: Path) -> None:
    from selfmotion.report.deboon_page import deboon_page
    from selfmotion.report.html import write_page
    from selfmotion.studies.deboon import StudySize, deboon_study

    options = WorkspaceOptions(n_points=256, shifts=3, slice_points=64)
    size = StudySize(options, n_samples=24, heights=(-0.2, 0.0))
    found = deboon_study(size=size, rng=np.random.default_rng(0))
    table = reproduce.with_kinds(found.numbers)
    records = reproduce.records("deboon", table)
    assert {r.comparable for r in records if "not at hand" in r.kind} == {False}
    assert all(r.published == r.ours for r in records if r.comparable)
    assert sum("not at hand" in r.kind for r in records) == 3
    path = write_page(tmp_path / "d.html", deboon_page(found, table, Provenance("test")))
    text = path.read_text(encoding="utf-8")
    assert text.count("<svg") >= 3
    assert all(one.section in text for one in FIGURES["deboon"])


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every paper a page with one number, at once."""

    def maker(name: str):
        def make(asked: reproduce.Asked) -> reproduce.Made:
            number = reproduce.NumberBeside(
                paper=name,
                where="Table 1",
                quantity="a length",
                unit="m",
                published="1",
                ours="1",
                comparable=True,
                kind="taken over",
                note="",
            )
            sections = (
                Section("Published numbers beside ours", (f"All of {name}.",)),
                Section("Scenario 1: a circle", points=(f"A figure of {name}.",)),
            )
            page = Page(f"{name.title()} et al., computed again", sections, f"On {name}.")
            return reproduce.Made(
                name, [number], Provenance(name, choices={"size": 1}), lambda: page
            )

        return make

    monkeypatch.setattr(reproduce, "PAPERS", {name: maker(name) for name in PAPERS})


@pytest.mark.usefixtures("quick")
def test_all_is_each_paper_in_turn_and_one_page_of_everything(
    tmp_path: Path, capsys: Capture
) -> None:
    document = answered(capsys, "reproduce", "all", "--out", tmp_path)
    assert document["papers"] == list(PAPERS)
    assert document["provenance"]["choices"] == {name: {"size": 1} for name in PAPERS}
    pages = {f"{name}.html" for name in (*PAPERS, "all")}
    assert {p.name for p in tmp_path.glob("*.html")} == pages
    whole = (tmp_path / "all.html").read_text(encoding="utf-8")
    assert "4 published numbers of 4 papers" in whole
    for name in PAPERS:
        assert f"On {name}." in whole and f"A figure of {name}." in whole
        assert f'id="{name}-et-al-published-numbers-beside-ours"' in whole
        assert f'id="{name}-et-al-scenario-1-a-circle"' in whole


@pytest.mark.usefixtures("quick")
def test_one_report_of_all_holds_every_paper(tmp_path: Path, capsys: Capture) -> None:
    answered(capsys, "reproduce", "all", "--report", tmp_path / "r.html")
    whole = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert all(f"A figure of {name}." in whole for name in PAPERS)
    assert [p.name for p in tmp_path.iterdir()] == ["r.html"]
