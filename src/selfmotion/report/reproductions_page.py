"""The report of `selfmotion reproduce all`: the four papers, computed again, on one page.

A chapter a paper; each begins with the paper's figures and tables and where they stand here.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from selfmotion.report.html import Footer, Link, Page, Section, Table
from selfmotion.studies.paper_figures import MISSING, NO_RESULT, TAKEN, figures_of

TITLE = "Four papers, computed again"
END_OF_TITLE = ", computed again"
CHECKLIST = "Figures and tables of the paper"
# Section of a report that words the differences by what this run found; the list takes them over.
BY_FIGURE = "Figure by figure"


def reproductions_page(pages: Sequence[Page], numbers: pd.DataFrame) -> Page:
    """Put the reports on several papers into one.

    Args:
        pages: the report on each paper.
        numbers: every published number beside ours: `paper`, `comparable`, `kind`; the papers in
            the order of the pages.
    """
    papers = list(dict.fromkeys(numbers["paper"]))
    whose = [page.title.removesuffix(END_OF_TITLE) for page in pages]
    sections = [overview_section(pages, numbers, dict(zip(papers, whose, strict=True)))]
    for page, paper, chapter in zip(pages, papers, whose, strict=True):
        first, *others = with_checklist(page, paper).sections
        words = (page.summary, *first.words) if page.summary else first.words
        sections += [
            replace(one, chapter=chapter) for one in (replace(first, words=words), *others)
        ]
    summary = (
        f"{len(numbers)} published numbers of {len(pages)} papers beside ours, with the papers' "
        f"figures drawn again; {int(_told(numbers).sum())} of the numbers can be compared."
    )
    return Page(TITLE, tuple(sections), summary, _joined([page.footer for page in pages]))


def with_checklist(page: Page, paper: str) -> Page:
    """Let a report begin with the paper's figures and tables, each with a link to its place.

    Args:
        page: the report on one paper.
        paper: its key, as in `reproduce`.
    """
    headings = frozenset(section.heading for section in page.sections)
    found = {
        str(row["in the paper"]).replace(".", ""): row["difference"]
        for section in page.sections
        if section.heading == BY_FIGURE
        for row in section.tables[0].frame.to_dict("records")
    }
    rows = [
        {
            "in the paper": Link(one.where, one.section),
            "shows": one.shows,
            "here": one.here,
            "difference": found.get(one.where, one.difference) or None,
        }
        for one in figures_of(paper, headings)
    ]
    section = Section(
        CHECKLIST,
        tables=(Table(pd.DataFrame(rows), "In the paper's order; links lead to our counterpart."),),
    )
    others = (other for other in page.sections if other.heading != BY_FIGURE)
    return replace(page, sections=(section, *others))


def overview_section(
    pages: Sequence[Page], numbers: pd.DataFrame, names: dict[str, str]
) -> Section:
    """Count the figures and the numbers of each paper by what may be compared.

    Args:
        pages: the report on each paper.
        numbers: as for `reproductions_page`.
        names: of the papers in words, by key.
    """
    rows = []
    for page, (paper, name) in zip(pages, names.items(), strict=True):
        headings = frozenset(section.heading for section in page.sections)
        figures = figures_of(paper, headings)
        some = numbers.loc[numbers["paper"] == paper]
        rows.append(
            {
                "paper": name,
                "figures and tables": len(figures),
                "shown here": sum(one.here not in (MISSING, NO_RESULT) for one in figures),
                "photographs, diagrams": sum(one.here == NO_RESULT for one in figures),
                "not at hand": sum(one.here == MISSING for one in figures),
                "numbers": len(some),
                "that can be compared": int(_told(some).sum()),
            }
        )
    counts = Counter(numbers["kind"])
    kinds = pd.DataFrame(counts.items(), columns=["kind", "numbers"])
    return Section(
        "What can be compared",
        words=(
            "A chapter a paper: first a list of all its figures and tables with links to ours, "
            "then its numbers beside ours, then the figures. “Kind” says whether a number can be "
            "compared with the published one, and why not where it cannot; “note” says what a "
            "difference comes from.",
            "The recordings behind the papers are not at hand. Where people are generated, "
            "agreement is built in and proves nothing about the paper; it shows that the "
            "computation is the paper's.",
        ),
        tables=(
            Table(pd.DataFrame(rows), "What each paper shows, and what of it stands here."),
            Table(kinds, "Published numbers by kind of comparison."),
        ),
    )


def _told(numbers: pd.DataFrame) -> np.ndarray:
    """Tell which numbers ought to agree and are not what the computation begins with."""
    return numbers["comparable"].to_numpy(dtype=bool) & (numbers["kind"].to_numpy() != TAKEN)


def _joined(footers: Sequence[Footer]) -> Footer:
    provenance = tuple(p for footer in footers for p in footer.provenance)
    return Footer(provenance, tuple(key for footer in footers for key in footer.papers))
