"""The page on all papers: complete lists of figures, chapters, links that lead somewhere."""

import re
from dataclasses import replace

import pandas as pd
import pytest

from selfmotion.report.html import Page, Section, Table, render_report
from selfmotion.report.reproductions_page import (
    BY_FIGURE,
    CHECKLIST,
    reproductions_page,
    with_checklist,
)
from selfmotion.studies.paper_figures import FIGURES, MISSING, NO_RESULT, figures_of

# Figures and tables that each paper has, as it counts them.
COUNTS = {
    "khoramshahi2022": (9, ("1",)),
    "tommasino2017": (8, ("1", "2")),
    "deboon": (13, ("1", "2", "3")),
    "li2022": (9, ("I", "II", "III", "IV")),
}
ROMAN = r"[IVX]+|\d+"


def page_on(paper: str) -> Page:
    """A page with all the sections that the list of figures names."""
    headings = dict.fromkeys(one.section for one in FIGURES[paper] if one.section)
    sections = tuple(Section(heading, (f"All of {heading}.",)) for heading in headings)
    return Page(f"{paper.title()}, computed again", sections, f"On {paper}.")


def numbers_of(paper: str, word: str) -> list[str]:
    """Every number that stands behind "Fig", "Figs", "Table" or "Tables"."""
    found: list[str] = []
    for one in FIGURES[paper]:
        for listed in re.findall(rf"{word}s? ((?:{ROMAN})(?:, (?:{ROMAN}))*)", one.where):
            found += listed.split(", ")
    return found


@pytest.mark.parametrize("paper", FIGURES)
def test_every_figure_and_table_is_listed_once(paper: str) -> None:
    n_figures, tables = COUNTS[paper]
    assert sorted(numbers_of(paper, "Fig"), key=int) == [str(i + 1) for i in range(n_figures)]
    assert sorted(numbers_of(paper, "Table")) == sorted(tables)


@pytest.mark.parametrize("paper", FIGURES)
def test_what_is_shown_has_a_word_on_the_difference(paper: str) -> None:
    for one in FIGURES[paper]:
        assert one.difference or one.here == NO_RESULT, one.where
        assert one.here != MISSING or one.difference


def test_people_of_ones_own_fill_what_is_missing() -> None:
    alone = figures_of("li2022", frozenset())
    given = figures_of("li2022", frozenset({"On recorded people"}))
    assert sum(one.here == MISSING for one in alone) == 2
    assert not any(one.here == MISSING for one in given)
    changed = [a.where for a, b in zip(alone, given, strict=True) if a != b]
    assert changed == ["Fig 8", "Fig 9", "Table IV"]


def test_the_page_has_a_chapter_a_paper_and_links_from_each_list() -> None:
    pages = [page_on(paper) for paper in FIGURES]
    numbers = pd.DataFrame({"paper": list(FIGURES), "comparable": True, "kind": "same computation"})
    made = reproductions_page(pages, numbers)
    assert "4 published numbers of 4 papers" in made.summary
    assert list(dict.fromkeys(s.chapter for s in made.sections))[1:] == [
        page.title.removesuffix(", computed again") for page in pages
    ]
    text = render_report(made.title, made.sections)
    for paper, page in zip(FIGURES, pages, strict=True):
        name = page.title.removesuffix(", computed again")
        assert f'id="chapter-{paper}">{name} <a href="#contents">' in text
        assert f'id="{paper}-figures-and-tables-of-the-paper"' in text
        linked = sum(bool(one.section) for one in FIGURES[paper])
        headings = [s.heading for s in page.sections]
        # Each section stands in the contents, and every figure that is here leads to one.
        assert text.count(f'<a href="#{paper}-') == 1 + len(headings) + linked


def test_words_on_what_this_run_found_take_the_place_of_general_ones() -> None:
    found = pd.DataFrame({"in the paper": ["Fig. 6", "Figs 8, 9"], "difference": ["68 %", "13"]})
    page = page_on("deboon")
    by_figure = Section(BY_FIGURE, tables=(Table(found, "here"),))
    made = with_checklist(replace(page, sections=(*page.sections, by_figure)), "deboon")
    listed = made.sections[0].tables[0].frame
    said = dict(
        zip([one.text for one in listed["in the paper"]], listed["difference"], strict=True)
    )
    assert said["Fig 6"] == "68 %" and said["Figs 8, 9"] == "13" and len(said["Fig 5"] or "") > 5
    assert BY_FIGURE not in [section.heading for section in made.sections]


def test_a_page_on_one_paper_begins_with_its_list() -> None:
    made = with_checklist(page_on("deboon"), "deboon")
    assert made.sections[0].heading == CHECKLIST
    assert len(made.sections[0].tables[0].frame) == len(FIGURES["deboon"])
