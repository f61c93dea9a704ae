"""`selfmotion cite`: how to cite the papers behind the results, and the library itself."""

import re
from typing import Annotated

import typer

from selfmotion._version import __version__
from selfmotion.cli.options import Json
from selfmotion.cli.output import Contract, Document, Part, finish
from selfmotion.errors import unknown_name
from selfmotion.papers import MODEL_TERMS, PAPERS, Paper
from selfmotion.provenance import Provenance

_VENUE = re.compile(
    r"(?P<journal>.*?)(?: (?P<volume>\d+)(?:\((?P<number>\d+)\))?)?(?:: (?P<pages>\w+))?"
)


class Reference(Part, frozen=True, kw_only=True):
    """One paper."""

    key: str
    authors: str
    year: int
    title: str
    venue: str
    doi: str | None
    used_for: str
    bibtex: str


class CiteDocument(Document, frozen=True, tag="selfmotion/cite/1", kw_only=True):
    """The papers asked for, the library, and the terms of the arm that it does not contain."""

    software: str
    model_terms: str
    papers: list[Reference]


CONTRACT = Contract(CiteDocument, ("cite", "Khoramshahi2022", "--json"))


def cite(
    keys: Annotated[
        list[str] | None,
        typer.Argument(metavar="KEY", help="Papers, as in Li2022; left out: all."),
    ] = None,
    bibtex: Annotated[bool, typer.Option("--bibtex", help="Print BibTeX entries.")] = False,
    json: Json = False,
) -> int:
    """Print how to cite the papers behind the results."""
    papers = select(keys or list(PAPERS))
    document = CiteDocument(
        provenance=Provenance("cite"),
        software=f"selfmotion {__version__}",
        model_terms=MODEL_TERMS,
        papers=[reference(paper) for paper in papers],
    )
    parts = [r.bibtex if bibtex else sentence(r) for r in document.papers]
    if not keys and not bibtex:
        parts.append(f"{document.software}. {MODEL_TERMS}")
    text = "\n\n".join(parts)
    return finish(document, text, json=json)


def select(keys: list[str]) -> list[Paper]:
    """Find papers by key, in any case, each once.

    Raises:
        UnknownNameError: no paper has that key.
    """
    by_key = {key.lower(): paper for key, paper in PAPERS.items()}
    for key in keys:
        if key.lower() not in by_key:
            raise unknown_name("paper", key, list(PAPERS))
    return [by_key[key] for key in dict.fromkeys(key.lower() for key in keys)]


def reference(paper: Paper) -> Reference:
    """Give a paper with its BibTeX entry."""
    return Reference(
        key=paper.key,
        authors=paper.authors,
        year=paper.year,
        title=paper.title,
        venue=paper.venue,
        doi=paper.doi,
        used_for=paper.used_for,
        bibtex=bibtex_entry(paper),
    )


def sentence(paper: Reference) -> str:
    """Give the reference as text, and what the library takes from it."""
    doi = f" https://doi.org/{paper.doi}" if paper.doi else ""
    cited = f"{paper.authors} ({paper.year}). {paper.title}. {paper.venue}.{doi}"
    return f"[{paper.key}] {cited}\n    used for: {paper.used_for}"


def bibtex_entry(paper: Paper) -> str:
    """Give an @article entry; the venue is taken apart into journal, volume, number and pages."""
    names = [_bibtex_name(name) for name in paper.authors.split(", ")]
    venue = _VENUE.fullmatch(paper.venue)
    fields = {
        "author": " and ".join(names),
        "year": str(paper.year),
        # The inner braces keep BibTeX styles from lower-casing names and abbreviations.
        "title": f"{{{paper.title}}}",
        **(venue.groupdict() if venue else {"journal": paper.venue}),
        "doi": paper.doi,
    }
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items() if value]
    return "\n".join([f"@article{{{paper.key},", *lines, "}"])


def _bibtex_name(name: str) -> str:
    """Turn ``Foley RCA`` into ``Foley, R. C. A.``: run together, BibTeX takes them for one name."""
    family, _, initials = name.rpartition(" ")
    return f"{family}, {' '.join(f'{letter}.' for letter in initials)}"
