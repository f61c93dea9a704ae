import json

import pytest

from selfmotion.cli.app import main
from selfmotion.papers import PAPERS

Capture = pytest.CaptureFixture[str]


def test_every_paper_is_cited_with_its_key_and_doi(capsys: Capture) -> None:
    assert main(["cite"]) == 0
    out = capsys.readouterr().out
    for paper in PAPERS.values():
        assert f"[{paper.key}]" in out
        assert paper.doi is None or f"https://doi.org/{paper.doi}" in out


def test_terms_of_the_arm_with_muscles_are_told(capsys: Capture) -> None:
    assert main(["cite"]) == 0
    out = capsys.readouterr().out
    assert "myo-sim" in out and "Apache-2.0" in out
    assert "MoBL-ARMS" in out and "non-commercial" in out
    assert main(["cite", "--json", "Li2022"]) == 0
    assert "MoBL-ARMS" in json.loads(capsys.readouterr().out)["model_terms"]
    assert main(["cite", "--bibtex"]) == 0
    assert "non-commercial" not in capsys.readouterr().out


def test_bibtex_takes_names_and_venue_apart(capsys: Capture) -> None:
    assert main(["cite", "--bibtex", "khoramshahi2022"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "@article{Khoramshahi2022,"
    # Volume, number and article number as the journal prints them.
    assert "  journal = {PLoS ONE}," in lines
    assert "  volume = {17}," in lines
    assert "  number = {12}," in lines
    assert "  pages = {e0278228}," in lines
    names = "Khoramshahi, M. and Roby-Brami, A. and Parry, R. and Jarrassé, N."
    assert f"  author = {{{names}}}," in lines


def test_bibtex_keeps_initials_and_family_names_of_two_words(capsys: Capture) -> None:
    assert main(["cite", "--bibtex", "DeBoon"]) == 0
    out = capsys.readouterr().out
    assert "Foley, R. C. A." in out
    assert "La Delfa, N. J." in out
    assert "doi" not in out
    assert "volume" not in out


def test_json_gives_null_where_there_is_no_doi(capsys: Capture) -> None:
    assert main(["cite", "deboon", "DeBoon", "--json"]) == 0
    papers = json.loads(capsys.readouterr().out)["papers"]
    assert [(p["key"], p["doi"]) for p in papers] == [("DeBoon", None)]


def test_unknown_paper_is_refused(capsys: Capture) -> None:
    assert main(["cite", "Li2023"]) == 2
    assert "unknown paper 'Li2023'; did you mean 'Li2022'?" in capsys.readouterr().err
