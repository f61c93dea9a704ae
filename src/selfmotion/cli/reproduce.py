"""`selfmotion reproduce`: each published number of a paper beside ours."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.options import Json, Out, Quiet, Report, Seed
from selfmotion.cli.output import Contract, Document, Part, finish, save
from selfmotion.errors import FileFormatError, unknown_name

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.studies.khoramshahi2022 import Reproduction

PAPERS = ("khoramshahi2022",)


class NumberBeside(Part, frozen=True, kw_only=True):
    """A published number and ours; `kind` says what may be compared."""

    paper: str
    where: str
    quantity: str
    unit: str
    published: str
    ours: str
    comparable: bool
    kind: str
    note: str


class ReproduceDocument(Document, frozen=True, tag="selfmotion/reproduce/1", kw_only=True):
    """Published numbers beside ours."""

    papers: list[str]
    numbers: list[NumberBeside]


CONTRACT = Contract(
    ReproduceDocument, ("reproduce", "khoramshahi2022", "--repeats", "2", "--people", "2", "--json")
)


def reproduce(
    paper: Annotated[str, typer.Argument(metavar="PAPER", help=f"{', '.join(PAPERS)} or all.")],
    data: Annotated[
        Path | None,
        typer.Option("--data", metavar="FILE.mat", help="Run on a published data set."),
    ] = None,
    repeats: Annotated[
        int, typer.Option("--repeats", min=1, help="Random data sets of the numerical examples.")
    ] = 100,
    people: Annotated[
        int | None,
        typer.Option("--people", min=2, help="Generated people; left out: as many as the paper."),
    ] = None,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    seed: Seed = 2022,
    quiet: Quiet = False,
) -> int:
    """Compute a paper's numbers again and print them beside ours."""
    key = paper.lower()
    if key not in (*PAPERS, "all"):
        raise unknown_name("paper", paper, (*PAPERS, "all"))
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)  # before minutes of work
    found = khoramshahi2022(data, repeats=repeats, people=people, seed=seed)
    document = ReproduceDocument(
        provenance=found.provenance,
        papers=["khoramshahi2022"],
        numbers=records("khoramshahi2022", found.table),
    )
    written: list[Path] = []
    if out is not None:
        written.append(save(document, out, "reproduce"))
        report = report or out / "khoramshahi2022.html"
    if report is not None:
        from selfmotion.report.khoramshahi2022_page import write_khoramshahi2022_report

        written.append(write_khoramshahi2022_report(report, found))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json)


def khoramshahi2022(
    data: Path | None, *, repeats: int, people: int | None, seed: int
) -> "Reproduction":
    """Compute the paper again, on the recordings of a file if one is given."""
    from selfmotion.studies import khoramshahi2022 as study
    from selfmotion.studies.simulated_people import ReachingProtocol
    from selfmotion.studies.simulated_screen import ScreenProtocol

    published = None
    if data is not None:
        from selfmotion.motion.files.mat import read_mat

        published = read_mat(data)
        if published.layout not in study.LAYOUTS:
            raise FileFormatError(
                f"{data}: layout {published.layout!r}; allowed is a published data set of "
                f"{' or '.join(study.LAYOUTS)}"
            )
    size = study.Size(repeats=repeats, sweep_repeats=min(5, repeats))
    if people is not None:
        size = study.Size(
            repeats=repeats,
            sweep_repeats=min(5, repeats),
            reaching=ReachingProtocol(n_people=people),
            screen=ScreenProtocol(n_people=people),
        )
    return study.reproduce(seed=seed, size=size, data=published)


def records(paper: str, table: "pd.DataFrame") -> list[NumberBeside]:
    """Turn the table of numbers into records."""
    return [NumberBeside(paper=paper, **row) for row in table.to_dict("records")]


def as_text(document: ReproduceDocument) -> str:
    """Write the numbers as a person reads them."""
    lines = []
    for n in document.numbers:
        unit = f" {n.unit}" if n.unit else ""
        lines += [
            f"{n.where}: {n.quantity}",
            f"    published {n.published}{unit}; ours {n.ours or '-'}{unit}  [{n.kind}]",
        ]
        if n.note:
            lines.append(f"    {n.note}")
    return "\n".join(lines)
