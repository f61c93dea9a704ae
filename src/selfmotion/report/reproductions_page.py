"""The report of `selfmotion reproduce all`: the four papers, computed again, on one page."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import pandas as pd

from selfmotion.report.html import Footer, Page, Section, Table

TITLE = "Four papers, computed again"
END_OF_TITLE = ", computed again"


def reproductions_page(pages: Sequence[Page], numbers: pd.DataFrame) -> Page:
    """Put the reports on several papers into one.

    Args:
        pages: the report on each paper.
        numbers: every published number beside ours: `paper`, `comparable`, `kind`.
    """
    sections = [overview_section(numbers)]
    for page in pages:
        whose = page.title.removesuffix(END_OF_TITLE)
        first, *others = page.sections
        words = (page.summary, *first.words) if page.summary else first.words
        sections += [
            replace(section, heading=f"{whose}: {section.heading}")
            for section in (replace(first, words=words), *others)
        ]
    summary = (
        f"{len(numbers)} published numbers of {len(pages)} papers beside ours, with the papers' "
        f"figures drawn again; {sum(numbers['comparable'])} of the numbers can be compared."
    )
    return Page(TITLE, tuple(sections), summary, _joined([page.footer for page in pages]))


def overview_section(numbers: pd.DataFrame) -> Section:
    """Count the numbers of each paper by what may be compared."""
    counts = Counter(zip(numbers["paper"], numbers["kind"], strict=True))
    rows = [(paper, kind, count) for (paper, kind), count in counts.items()]
    table = pd.DataFrame(rows, columns=["paper", "kind", "numbers"])
    return Section(
        "What can be compared",
        words=(
            "Each paper's numbers stand in a table below, its figures after them. `kind` says "
            "whether a number can be compared with the published one, and why not where it "
            "cannot; `note` says what a difference comes from.",
        ),
        tables=(Table(table, "Published numbers by paper and kind."),),
    )


def _joined(footers: Sequence[Footer]) -> Footer:
    provenance = tuple(p for footer in footers for p in footer.provenance)
    return Footer(provenance, tuple(key for footer in footers for key in footer.papers))
