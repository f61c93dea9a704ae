"""The report parses, escapes what it is given, and refers to nothing outside."""

import re
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from selfmotion.provenance import Provenance
from selfmotion.report.html import (
    Footer,
    Link,
    Picture,
    Section,
    Table,
    format_number,
    render_report,
    write_report,
)
from selfmotion.report.theme import new_figure, themed

VOID = {"meta", "br", "hr", "img", "link", "input", "path", "use"}


class Checked(HTMLParser):
    """Collects what an HTML page holds, and whether its tags close."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.references, self.text = [], [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            if name in ("src", "href", "srcset", "data", "action"):
                self.references.append(value)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


@themed
def line():
    figure, axes = new_figure()
    axes[0, 0].plot([0, 1], [0, 1], label="a")
    axes[0, 0].set_xlabel("time (s)")
    return figure


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    table = pd.DataFrame({"joint": ["<script>alert(1)</script>", "b"], "weight": [0.5, np.nan]})
    sections = [
        Section("Weights & more", ("First <b>words</b>.",), pictures=(Picture(line(), "c", "a"),)),
        Section("Weights & more", points=("a point",), tables=(Table(table, "caption"),)),
        Section("Third", warning="mind this", pictures=(Picture(line(), "c", 'say "hi"'),)),
    ]
    footer = Footer((Provenance("identify_weights", seed=7),), ("Khoramshahi2022",))
    path = tmp_path_factory.mktemp("report") / "deep" / "report.html"
    write_report(path, "A <title>", sections, summary="In short.", footer=footer)
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def parsed(page):
    checked = Checked()
    checked.feed(page)
    return checked


def test_all_tags_close(parsed):
    assert parsed.open == []


def test_ids_are_unique_and_references_stay_inside(parsed):
    assert len(set(parsed.ids)) == len(parsed.ids)
    assert all(reference.startswith("#") for reference in parsed.references)
    assert all(reference[1:] in parsed.ids for reference in parsed.references)


def test_nothing_is_fetched(page):
    assert not re.search(r"https?:|@import|<script|<link|<iframe|data:", page)
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]+)\)", page))


def test_what_is_given_is_escaped(page):
    assert "&lt;b&gt;words&lt;/b&gt;" in page
    assert "&lt;script&gt;" in page
    assert 'aria-label="say &quot;hi&quot;"' in page


def test_pictures_follow_the_colours_of_the_page(page):
    assert "currentColor" in page and "var(--grid)" in page
    assert "prefers-color-scheme: dark" in page and "@media print" in page


def test_footer_cites_and_says_where_it_comes_from(parsed):
    text = "".join(parsed.text)
    assert "10.1371/journal.pone.0278228" in text
    assert "identify_weights" in text and "7" in text


def test_missing_numbers_are_a_dash(parsed):
    assert "–" in parsed.text


def test_links_lead_to_sections_of_their_chapter():
    places = pd.DataFrame({"where": [Link("Fig 1", "Numbers"), Link("Fig 2", "nowhere")]})
    sections = [
        Section("Numbers", chapter=name, tables=(Table(places, "all figures"),))
        for name in ("One paper", "Another & more")
    ]
    checked = Checked()
    text = render_report("t", sections + [Section("End", ("well",))])
    checked.feed(text)
    assert checked.open == [] and len(set(checked.ids)) == len(checked.ids)
    inside = [r for r in checked.references if "numbers" in r]
    assert inside.count("#one-paper-numbers") == 2  # contents and table
    assert inside.count("#another-more-numbers") == 2
    assert all(r[1:] in checked.ids for r in checked.references)
    assert "<td>Fig 2</td>" in text and "Another &amp; more" in text


def test_same_report_same_bytes(tmp_path):
    made = [
        write_report(tmp_path / name, "t", [Section("s", pictures=(Picture(line(), "c", "a"),))])
        for name in ("a.html", "b.html")
    ]
    assert made[0].read_bytes() == made[1].read_bytes()


def test_a_failed_report_leaves_the_old_file(tmp_path):
    path = tmp_path / "r.html"
    path.write_text("old")
    with pytest.raises(ValueError, match="unknown paper"):
        write_report(path, "t", [Section("s")], footer=Footer(papers=("Nobody1999",)))
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_a_report_needs_a_section(tmp_path):
    with pytest.raises(ValueError, match="0 sections"):
        write_report(tmp_path / "r.html", "t", [])


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (-0.25, "−0.250"), (123456.0, "123456"), (2e-6, "2.00×10⁻⁶"), (3e7, "3.00×10⁷")],
)
def test_numbers(value, text):
    assert format_number(value) == text
