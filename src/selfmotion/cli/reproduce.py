"""`selfmotion reproduce`: each published number of a paper beside ours.

Studies that would take long run at the small sizes below; provenance says which.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.batches import BatchChoices
from selfmotion.cli.options import Json, Out, Quiet, Report, Seed, StudyFile
from selfmotion.cli.output import Contract, Document, Part, finish, save
from selfmotion.cli.progress import stages
from selfmotion.errors import FileFormatError, RangeError, unknown_name
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.report.html import Page
    from selfmotion.studies.khoramshahi2022 import Reproduction

# Data sets drawn for the numerical examples of khoramshahi2022, as in the paper.
REPEATS = 100
# Simulated people of tommasino2017 (the paper's six), and trials of each.
PEOPLE, TRIALS = 6, 10
# Samples round a circle of deboon.
CIRCLE_SAMPLES = 48
# Poses of li2022 that are searched as the paper does.
SEARCHED = 3


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


@dataclass(frozen=True)
class Asked:
    """What was typed; `repeats` and `people` are None where they were left out.

    `say` tells what is being done now.
    """

    data: Path | None
    repeats: int | None
    people: int | None
    seed: int
    recordings: Path | None = None
    study: Path | None = None
    batch: BatchChoices = field(default_factory=lambda: BatchChoices("reproduce"))
    say: Callable[[str], None] = lambda text: None


@dataclass(frozen=True, eq=False)
class Made:
    """One paper, computed again; `page` draws its report, which takes seconds."""

    paper: str
    numbers: list[NumberBeside]
    provenance: Provenance
    page: Callable[[], "Page"]


def reproduce(
    paper: Annotated[
        str,
        typer.Argument(
            metavar="PAPER", help="khoramshahi2022, tommasino2017, deboon, li2022 or all."
        ),
    ],
    data: Annotated[
        Path | None,
        typer.Option(
            "--data", metavar="FILE.mat", help="khoramshahi2022: run on a published data set."
        ),
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(
            "--repeats",
            min=1,
            help="khoramshahi2022: random data sets of the numerical examples; left out: 100.",
        ),
    ] = None,
    people: Annotated[
        int | None,
        typer.Option(
            "--people",
            min=2,
            help="khoramshahi2022, tommasino2017: generated people; left out: as many as the "
            "paper.",
        ),
    ] = None,
    recordings: Annotated[
        Path | None,
        typer.Option(
            "--recordings",
            metavar="DIR",
            help="li2022: also Figs 8 and 9 and Table IV on recorded people; needs --study.",
        ),
    ] = None,
    study_file: StudyFile = None,
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Annotated[
        int,
        typer.Option(
            "--jobs",
            metavar="N",
            help="li2022 --recordings: arms at once, one thread each; -1: every core.",
        ),
    ] = 1,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume", help="li2022 --recordings: keep the arms that an interrupted run completed."
        ),
    ] = False,
    seed: Seed = 2022,
    quiet: Quiet = False,
) -> int:
    """Compute a paper's numbers again and print them beside ours."""
    key = paper.lower()
    if key not in (*PAPERS, "all"):
        raise unknown_name("paper", paper, (*PAPERS, "all"))
    batch = BatchChoices("reproduce", out, jobs, None, resume, quiet)
    asked = Asked(data, repeats, people, seed, recordings, study_file, batch)
    refuse_or_warn_of_idle(key, asked)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)  # before minutes of work
    made = []
    with stages(quiet=quiet) as say:
        for name in PAPERS if key == "all" else (key,):
            say(f"computing {name} again")
            made.append(PAPERS[name](replace(asked, say=say)))
    document = ReproduceDocument(
        provenance=joint_provenance(made, seed),
        papers=[one.paper for one in made],
        numbers=[number for one in made for number in one.numbers],
    )
    written: list[Path] = []
    if out is not None:
        written.append(save(document, out, "reproduce"))
    written += write_pages(made, out, report)
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json)


def write_pages(made: Sequence[Made], out: Path | None, report: Path | None) -> list[Path]:
    """Write a page for each paper into a folder, and one that holds them all if they are several.

    Returns:
        The files; `report` takes the place of the page that holds everything.
    """
    if out is None and report is None:
        return []
    from selfmotion.report.html import write_page
    from selfmotion.report.reproductions_page import with_checklist

    several = len(made) > 1
    pages = [one.page() for one in made]
    alone = [with_checklist(page, one.paper) for page, one in zip(pages, made, strict=True)]
    written: list[Path] = []
    if out is not None and several:
        written += [
            write_page(out / f"{one.paper}.html", page)
            for one, page in zip(made, alone, strict=True)
        ]
    if out is not None and report is None:
        report = out / ("all.html" if several else f"{made[0].paper}.html")
    if report is not None:
        written.append(write_page(report, page_of_all(made, pages) if several else alone[0]))
    return written


def page_of_all(made: Sequence[Made], pages: Sequence["Page"]) -> "Page":
    """Put the reports on several papers into one page."""
    import pandas as pd

    from selfmotion.report.reproductions_page import reproductions_page

    numbers = [(n.paper, n.comparable, n.kind) for one in made for n in one.numbers]
    table = pd.DataFrame(numbers, columns=["paper", "comparable", "kind"])
    return reproductions_page(pages, table)


def refuse_or_warn_of_idle(key: str, asked: Asked) -> None:
    """Refuse what would be misread, and say which options have no effect.

    Raises:
        RangeError: --data or --recordings with another paper, or half of a pair.
    """
    import warnings

    if asked.data is not None and key != "khoramshahi2022":
        raise RangeError(f"--data {asked.data}: allowed with khoramshahi2022 only, not with {key}")
    if (asked.recordings is None) != (asked.study is None):
        raise RangeError("--recordings DIR and --study FILE.toml: allowed together only")
    if asked.recordings is not None and key not in ("li2022", "all"):
        raise RangeError(
            f"--recordings {asked.recordings}: allowed with li2022 or all, not with {key}"
        )
    if asked.repeats is not None and key not in ("khoramshahi2022", "all"):
        warnings.warn(f"--repeats: no effect on {key} (khoramshahi2022 only)", stacklevel=2)
    if asked.people is not None and key in ("deboon", "li2022"):
        warnings.warn(
            f"--people: no effect on {key} (khoramshahi2022 and tommasino2017 only)", stacklevel=2
        )


def joint_provenance(made: list[Made], seed: int) -> Provenance:
    """Give the provenance of one paper, or that of several with the choices of each."""
    if len(made) == 1:
        return made[0].provenance
    choices = {one.paper: dict(one.provenance.choices) for one in made}
    return Provenance("reproduce all", seed=seed, choices=choices)


def _khoramshahi2022(asked: Asked) -> Made:
    repeats = REPEATS if asked.repeats is None else asked.repeats
    found = khoramshahi2022(asked.data, repeats=repeats, people=asked.people, seed=asked.seed)

    def page() -> "Page":
        from selfmotion.report.khoramshahi2022_page import khoramshahi2022_page

        return khoramshahi2022_page(found)

    numbers = records("khoramshahi2022", found.table)
    return Made("khoramshahi2022", numbers, found.provenance, page)


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


def _tommasino2017(asked: Asked) -> Made:
    from selfmotion.studies.center_out import CenterOut
    from selfmotion.studies.tommasino2017_numbers import reproduce_tommasino2017

    n_people = PEOPLE if asked.people is None else asked.people
    protocol = CenterOut(n_trials=TRIALS)
    found = reproduce_tommasino2017(asked.seed, n_people=n_people, protocol=protocol)
    choices = {**found.provenance.choices, "n_trials": TRIALS}
    sized = replace(found.provenance, choices=choices)
    found = replace(found, provenance=sized)

    def page() -> "Page":
        from selfmotion.report.tommasino2017_page import tommasino2017_page

        return tommasino2017_page(found, shown(found.table))

    return Made("tommasino2017", records("tommasino2017", found.table), sized, page)


def _deboon(asked: Asked) -> Made:
    import numpy as np

    from selfmotion.studies.deboon import StudySize, deboon_study

    size = StudySize(n_samples=CIRCLE_SAMPLES)
    found = deboon_study(size=size, rng=np.random.default_rng(asked.seed))
    choices = {
        "n_points": size.options.n_points,
        "shifts": size.options.shifts,
        "heights": list(size.heights),
        "circle_samples": CIRCLE_SAMPLES,
    }
    provenance = Provenance("reproduce deboon", seed=asked.seed, choices=choices)
    table = with_kinds(found.numbers)

    def page() -> "Page":
        from selfmotion.report.deboon_page import deboon_page

        return deboon_page(found, shown(table), provenance)

    return Made("deboon", records("deboon", table), provenance, page)


def _li2022(asked: Asked) -> Made:
    from selfmotion.cli.reproduce_li2022 import People, li2022

    people = None
    if asked.recordings is not None and asked.study is not None:
        people = People(asked.recordings, asked.study, asked.batch, asked.seed)
    found = li2022(people, searched=SEARCHED, say=asked.say)

    def page() -> "Page":
        from selfmotion.report.li2022_page import li2022_page

        numbers = shown(found.table)
        return li2022_page(found.model, found.made, numbers, found.provenance, more=found.more)

    return Made("li2022", records("li2022", found.table), found.provenance, page)


PAPERS: dict[str, Callable[[Asked], Made]] = {
    "khoramshahi2022": _khoramshahi2022,
    "tommasino2017": _tommasino2017,
    "deboon": _deboon,
    "li2022": _li2022,
}


def with_kinds(numbers: "pd.DataFrame") -> "pd.DataFrame":
    """Give the table of deboon the columns of `published.beside`.

    Lengths and limits are those that the arm is built from, so that agreement proves little.
    """
    from selfmotion.studies.paper_figures import TAKEN

    known = numbers["published"].notna()
    table = numbers.assign(
        quantity=numbers["quantity"].str.replace("_", " "),
        published=[
            f"{v:.4g}" if k else "–" for v, k in zip(numbers["published"], known, strict=True)
        ],
        ours=[f"{value:.4g}" for value in numbers["ours"]],
        comparable=known,
        kind=[TAKEN if k else "published number not at hand" for k in known],
    )
    return table.reindex(columns=[*table.columns.drop("note"), "note"])


def shown(table: "pd.DataFrame") -> "pd.DataFrame":
    """Leave out the column that `kind` says in words."""
    return table.drop(columns=["comparable"])


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
