"""`selfmotion effort`: the muscle effort of postures."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from selfmotion.cli.batches import BatchChoices, fingerprint, hash_if_file, run_items
from selfmotion.cli.options import Jobs, Json, Out, Quiet, Report, Resume, Scheduler
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers, save
from selfmotion.cli.person_size import (
    Lengths,
    Mass,
    PersonChoices,
    Strength,
    load_person,
    segment_lengths_of,
)
from selfmotion.cli.posture import Convention, HandLoad, ModelName
from selfmotion.cli.tables import Name, Rows, read_rows
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.batch import Item, Outcome
    from selfmotion.muscles.geometry import MusculoskeletalArm
    from selfmotion.muscles.static_optimization import EffortOptions

# Postures in one item of a batch.
PART = 100


class PostureEffort(Part, frozen=True, kw_only=True):
    """The effort of one posture: null where the row holds no posture.

    `torque` is what the muscles must give, `missing` what no activation gives (N m, by
    coordinate); with some missing, effort is that of the answer with the least missing torque.
    """

    id: Name
    status: str
    failed: bool
    effort: Number
    activations: dict[str, Number]
    torque: dict[str, Number]
    missing: dict[str, Number]


class EffortDocument(Document, frozen=True, tag="selfmotion/effort/1", kw_only=True):
    """Muscle effort of postures."""

    model: str
    convention: str
    coordinates: list[str]
    muscles: list[str]
    postures: list[PostureEffort]


CONTRACT = Contract(EffortDocument, ("effort", "examples/postures.csv", "--json"))


@dataclass(frozen=True)
class EffortChoices:
    """What all postures of a run have in common."""

    model: str
    convention: str | None
    hand_load: float
    passive: bool
    exponent: float
    person: PersonChoices


def effort(
    postures: Annotated[
        Path,
        typer.Argument(
            metavar="POSTURES",
            help=".csv, columns named by coordinate (rad; NAME_deg: degrees); with "
            "NAME_velocity and NAME_acceleration: a movement.",
        ),
    ],
    model: ModelName = "myoarm",
    convention: Convention = None,
    hand_load: HandLoad = 0.0,
    passive: Annotated[
        bool, typer.Option("--passive", help="Let the passive force of stretched muscles count.")
    ] = False,
    exponent: Annotated[
        float,
        typer.Option(
            "--exponent", metavar="POWER", help="Effort is the sum of activations to this power."
        ),
    ] = 2.0,
    lengths: Lengths = None,
    mass: Mass = None,
    strength: Strength = "area",
    json: Json = False,
    out: Out = None,
    report: Report = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    quiet: Quiet = False,
) -> int:
    """Compute the muscle effort that holds postures, or makes a movement."""
    batch = BatchChoices("effort", out, jobs, scheduler, resume, quiet)
    person = PersonChoices(segment_lengths_of(lengths), mass, strength)
    choices = EffortChoices(model, convention, hand_load, passive, exponent, person)
    loaded, options = model_of(choices)
    names = loaded.arm.joints
    rates = [[f"{name}_{rate}" for name in names] for rate in ("velocity", "acceleration")]
    rows = read_rows(postures, names, rates, strict=True)
    outcomes = run_items(efforts_of, effort_items(rows, names, choices), batch)
    document = EffortDocument(
        provenance=provenance_of(loaded, options, postures),
        model=loaded.arm.name,
        convention=loaded.convention,
        coordinates=list(names),
        muscles=list(loaded.muscles.names),
        postures=records(rows, outcomes, names, loaded.muscles.names),
    )
    written = [] if out is None else [save(document, out, "effort"), save_table(document, out)]
    if report is not None:
        written.append(save_report(document, report, loaded, rows.array(list(names))))
    text = "\n".join([as_text(document), *(f"wrote {path}" for path in written)])
    return finish(document, text, json=json, failed=sum(p.failed for p in document.postures))


@functools.lru_cache(maxsize=2)
def model_of(choices: EffortChoices) -> "tuple[MusculoskeletalArm, EffortOptions]":
    """Load the model, and give its convention's options with those of the command line."""
    from dataclasses import replace

    from selfmotion.muscles.static_optimization import EffortOptions

    model = load_person(choices.model, choices.convention, choices.person)
    options = EffortOptions.of(model.convention)
    loads = (*options.loads, "passive") if choices.passive else options.loads
    return model, replace(
        options, hand_load=choices.hand_load, loads=loads, exponent=choices.exponent
    )


def effort_items(rows: Rows, names: tuple[str, ...], choices: EffortChoices) -> "list[Item]":
    """Make batch items of the rows that hold a posture, some rows each."""
    from selfmotion.batch import Item

    good = [i for i, problem in enumerate(rows.problems) if not problem]
    groups = [("q", list(names))]
    groups += [(rate, [f"{n}_{rate}" for n in names]) for rate in ("velocity", "acceleration")]
    arrays = {key: rows.array(group) for key, group in groups if rows.has(group)}
    items = []
    for first in range(0, len(good), PART):
        part = good[first : first + PART]
        values = {key: array[part].tolist() for key, array in arrays.items()}
        mark = fingerprint(choices, hash_if_file(choices.model), values)
        items.append(Item(f"rows {part[0]} to {part[-1]}", (choices, part, values), mark))
    return items


def efforts_of(payload: tuple[EffortChoices, list[int], dict[str, Any]]) -> dict[str, Any]:
    """Compute some postures; gives their place in the file and their numbers."""
    from selfmotion.muscles.static_optimization import muscle_effort

    choices, part, values = payload
    model, options = model_of(choices)
    found = muscle_effort(
        model,
        values["q"],
        velocity=values.get("velocity"),
        acceleration=values.get("acceleration"),
        options=options,
    )
    return {
        "place": part,
        "status": [status.sentence for status in found.status],
        "failed": [not status.ok for status in found.status],
        "effort": numbers(found.effort),
        "activations": numbers(found.activations),
        "torque": numbers(found.torque),
        "missing": numbers(found.missing),
    }


def records(
    rows: Rows,
    outcomes: "list[Outcome]",
    coordinates: tuple[str, ...],
    muscles: tuple[str, ...],
) -> list[PostureEffort]:
    """Give a record for every row, in the file's order."""
    found: dict[int, dict[str, Any]] = {}
    for outcome in outcomes:
        result = outcome.result or {"place": []}
        for k, i in enumerate(result["place"]):
            found[i] = {key: values[k] for key, values in result.items() if key != "place"}
    reason = next((o.status.sentence for o in outcomes if o.result is None), "not computed")
    out = []
    for i, (name, problem) in enumerate(zip(rows.ids, rows.problems, strict=True)):
        got = found.get(i, {"status": problem or reason, "failed": True, "effort": None})
        n, m = len(coordinates), len(muscles)
        out.append(
            PostureEffort(
                id=name,
                status=got["status"],
                failed=got["failed"],
                effort=got["effort"],
                activations=dict(zip(muscles, got.get("activations", [None] * m), strict=True)),
                torque=dict(zip(coordinates, got.get("torque", [None] * n), strict=True)),
                missing=dict(zip(coordinates, got.get("missing", [None] * n), strict=True)),
            )
        )
    return out


def provenance_of(
    model: "MusculoskeletalArm", options: "EffortOptions", postures: Path
) -> Provenance:
    """Say where the results come from."""
    from dataclasses import asdict

    from selfmotion.provenance import hash_file

    choices = {"model": model.arm.name, "source": model.arm.source, "convention": model.convention}
    return Provenance(
        "muscle_effort",
        inputs={"postures": hash_file(postures)},
        choices=choices | {**asdict(options), "loads": list(options.loads)},
    )


def save_table(document: EffortDocument, folder: Path) -> Path:
    """Write effort.csv: one row a posture, then activations by muscle."""
    import pandas as pd

    table = pd.DataFrame(
        {"id": p.id, "status": p.status, "effort": p.effort, **p.activations}
        for p in document.postures
    )
    return write_whole(folder / "effort.csv", table.to_csv(index=False))


def save_report(
    document: EffortDocument, path: Path, model: "MusculoskeletalArm", q: "np.ndarray"
) -> Path:
    """Write the report; q are the postures of the file, a row each (rad)."""
    import numpy as np
    import pandas as pd

    from selfmotion.report.effort_page import HeldPosture, write_effort_report

    held = [
        HeldPosture(str(p.id), q[i], p.effort, np.array(list(p.activations.values())), p.status)
        for i, p in enumerate(document.postures)
        if p.effort is not None
    ]
    table = pd.DataFrame(
        {"id": p.id, "effort": p.effort, "hardest": hardest_of(p), "status": p.status}
        for p in document.postures
    )
    return write_effort_report(path, model, held, table, document.provenance)


def hardest_of(posture: PostureEffort, most: int = 4) -> str:
    """Name the muscles that work hardest, with their activations."""
    known = {name: a for name, a in posture.activations.items() if a is not None}
    names = sorted(known, key=lambda name: -known[name])[:most]
    return ", ".join(f"{name} {known[name]:.2f}" for name in names)


def as_text(document: EffortDocument) -> str:
    """Write effort, and the muscles that work hardest, as a person reads them."""
    lines = [f"model {document.model}, convention {document.convention}"]
    for p in document.postures:
        if p.effort is None:
            lines.append(f"posture {p.id}: {p.status}")
            continue
        lines.append(f"posture {p.id}: effort {p.effort:.4g} ({p.status}); {hardest_of(p)}")
    return "\n".join(lines)
