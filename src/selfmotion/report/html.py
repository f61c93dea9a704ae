"""Write a report as one HTML file: pictures inline, nothing fetched, printable, light and dark.

A report is a list of sections of plain words, pictures and tables; everything is escaped. The
file is written whole or not at all.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from selfmotion.errors import RangeError, unknown_name
from selfmotion.papers import PAPERS, Paper
from selfmotion.provenance import Provenance
from selfmotion.report.interactive import Interactive, interactive_html
from selfmotion.report.svg import inline_svg
from selfmotion.writing import write_whole

# Digits shown in a table; the files beside the report hold all of them.
TABLE_DIGITS = 3


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with what stands below it and what a screen reader says.

    Attributes:
        figure: the drawing.
        caption: one or two sentences below it.
        alt: what it shows, in words, for people who do not see it.
    """

    figure: Figure
    caption: str
    alt: str


@dataclass(frozen=True)
class Link:
    """A cell of a table that leads to a section of the same page.

    Attributes:
        text: what is shown.
        heading: of the section, within the same chapter; where there is none, the text stands
            alone.
    """

    text: str
    heading: str


@dataclass(frozen=True, eq=False)
class Table:
    """A table with a caption.

    Attributes:
        frame: the rows; the index is not shown. Missing values are shown as a dash, a `Link` as a
            link.
        caption: what it holds, with units.
        digits: significant digits of its numbers.
    """

    frame: pd.DataFrame
    caption: str
    digits: int = TABLE_DIGITS


@dataclass(frozen=True, eq=False)
class Section:
    """One part of a report.

    Attributes:
        heading: its title.
        words: paragraphs of plain text.
        points: a list below the paragraphs.
        pictures: figures, in order.
        charts: interactive figures, after the pictures.
        tables: tables, after the figures.
        warning: something the reader must not miss; shown in a box.
        chapter: what it belongs to, where a page has chapters; sections of one chapter follow
            each other.
    """

    heading: str
    words: tuple[str, ...] = ()
    points: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    charts: tuple[Interactive, ...] = ()
    tables: tuple[Table, ...] = ()
    warning: str = ""
    chapter: str = ""


@dataclass(frozen=True, eq=False)
class Footer:
    """What stands at the end of a report.

    Attributes:
        provenance: how the results were made.
        papers: keys of the papers to cite, as in ``Khoramshahi2022``.
    """

    provenance: tuple[Provenance, ...] = ()
    papers: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Page:
    """A whole report, before it is written: what :func:`write_report` takes."""

    title: str
    sections: tuple[Section, ...]
    summary: str = ""
    footer: Footer = Footer()


def write_page(path: str | Path, page: Page) -> Path:
    """Write a page; give its path."""
    return write_report(path, page.title, page.sections, summary=page.summary, footer=page.footer)


def write_report(
    path: str | Path,
    title: str,
    sections: Sequence[Section],
    *,
    summary: str = "",
    footer: Footer | None = None,
) -> Path:
    """Write a report as one self-contained HTML file.

    Args:
        path: the file; it is replaced only once the new one is complete.
        title: title of the page.
        sections: its parts, in order.
        summary: what the reader should take home, in one or two sentences.
        footer: provenance and citations.

    Returns:
        The path.

    Raises:
        RangeError: there is no section.
        UnknownNameError: a paper's key does not exist.

    Example:
        >>> import tempfile
        >>> folder = tempfile.mkdtemp()
        >>> made = write_report(folder + "/r.html", "Weights", [Section("Result", ("All well.",))])
        >>> "All well." in made.read_text(encoding="utf-8")
        True
    """
    return write_whole(path, render_report(title, sections, summary=summary, footer=footer))


def render_report(
    title: str,
    sections: Sequence[Section],
    *,
    summary: str = "",
    footer: Footer | None = None,
) -> str:
    """Give the HTML text of a report; see :func:`write_report`."""
    if not sections:
        raise RangeError("report: 0 sections; at least one is needed")
    end = footer or Footer()
    environment = Environment(
        loader=PackageLoader("selfmotion.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    anchors = _anchors([f"{section.chapter} {section.heading}" for section in sections])
    places = {(s.chapter, s.heading): a for s, a in zip(sections, anchors, strict=True)}
    scripted = next((anchor for s, anchor in zip(sections, anchors, strict=True) if s.charts), None)
    parts = [_part(s, a, places, a == scripted) for s, a in zip(sections, anchors, strict=True)]
    return environment.get_template("report.html.j2").render(
        title=title,
        summary=summary,
        chapters=_chapters(parts),
        provenance=[_provenance_rows(p) for p in end.provenance],
        citations=[_citation(key) for key in end.papers],
    )


# Anchors of sections by chapter and heading.
Places = Mapping[tuple[str, str], str]


@dataclass(frozen=True)
class _Cell:
    text: str
    number: bool = False
    anchor: str = ""


@dataclass(frozen=True, eq=False)
class _Part:
    section: Section
    anchor: str
    svgs: list[Markup]
    charts: list[Markup]
    tables: list[tuple[str, list[str], list[list[_Cell]]]]


@dataclass(frozen=True, eq=False)
class _Chapter:
    title: str
    anchor: str
    parts: list[_Part]


def _chapters(parts: list[_Part]) -> list[_Chapter]:
    """Group the sections that follow each other by chapter; without chapters there is one."""
    groups = [(title, list(some)) for title, some in groupby(parts, lambda p: p.section.chapter)]
    anchors = _anchors([f"chapter {title}" for title, _ in groups])
    return [
        _Chapter(title, anchor, some) for (title, some), anchor in zip(groups, anchors, strict=True)
    ]


def _part(section: Section, anchor: str, places: Places, with_script: bool) -> _Part:
    svgs = [
        Markup(inline_svg(picture.figure, f"{anchor}-{i}", label=picture.alt))
        for i, picture in enumerate(section.pictures)
    ]
    charts = [
        Markup(interactive_html(chart, f"{anchor}-chart-{i}", with_script=with_script and i == 0))
        for i, chart in enumerate(section.charts)
    ]
    tables = [_cells(table, section.chapter, places) for table in section.tables]
    return _Part(section, anchor, svgs, charts, tables)


def _cells(table: Table, chapter: str, places: Places) -> tuple[str, list[str], list[list[_Cell]]]:
    """Give caption, header and rows."""
    header = [str(column).replace("_", " ") for column in table.frame.columns]
    rows = [
        [
            _Cell(value.text, anchor=places.get((chapter, value.heading), ""))
            if isinstance(value, Link)
            else _cell(value, table.digits)
            for value in row
        ]
        for row in table.frame.itertuples(index=False, name=None)
    ]
    return table.caption, header, rows


def _cell(value: object, digits: int) -> _Cell:
    if isinstance(value, bool) or type(value).__name__ == "bool":
        return _Cell("yes" if value else "no")
    if value is None or value is pd.NaT or (isinstance(value, float) and value != value):
        return _Cell("–")
    if isinstance(value, float):
        return _Cell(format_number(value, digits), number=True)
    if isinstance(value, int) or type(value).__name__.startswith("int"):
        return _Cell(str(value), number=True)
    return _Cell(str(value))


def format_number(value: float, digits: int = TABLE_DIGITS) -> str:
    """Write a number with significant digits, and powers of ten as people write them.

    Example:
        >>> format_number(0.0123456), format_number(1234.5), format_number(1.5e-9)
        ('0.0123', '1234', '1.50×10⁻⁹')
    """
    if value == 0.0:
        return "0"
    if 1e-4 <= abs(value) < 1e6:
        decimals = max(0, digits - 1 - _exponent(value))
        return f"{value:.{decimals}f}".replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa}×10{power}".replace("-", "−")


def _exponent(value: float) -> int:
    return int(f"{value:e}".split("e")[1])


def _anchors(headings: list[str]) -> list[str]:
    """Give each heading an id that is unique in the page."""
    taken: list[str] = []
    for heading in headings:
        base = re.sub(r"[^a-z0-9]+", "-", heading.lower()).strip("-") or "part"
        name, number = base, 2
        while name in taken:
            name, number = f"{base}-{number}", number + 1
        taken.append(name)
    return taken


def _provenance_rows(provenance: Provenance) -> list[tuple[str, str]]:
    rows = [("method", provenance.method), ("version", provenance.version)]
    rows += [(f"input {name}", digest) for name, digest in provenance.inputs.items()]
    if provenance.seed is not None:
        rows.append(("seed", str(provenance.seed)))
    return rows + [(name.replace("_", " "), str(v)) for name, v in provenance.choices.items()]


def _citation(key: str) -> tuple[Paper, str]:
    if key not in PAPERS:
        raise unknown_name("paper", key, tuple(PAPERS))
    paper = PAPERS[key]
    return paper, f"doi:{paper.doi}" if paper.doi else ""
