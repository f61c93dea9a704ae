"""The part of `selfmotion reproduce` on [Li2022]: its arm, its poses, and recorded people."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.batches import BatchChoices
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

    from selfmotion.muscles.geometry import MusculoskeletalArm
    from selfmotion.report.html import Section
    from selfmotion.studies.li2022 import Reproduction
    from selfmotion.studies.prediction_tables import PredictionTables

Say = Callable[[str], None]


@dataclass(frozen=True)
class People:
    """Whose recordings, how they are named and read, where they run, and the seed of intervals."""

    recordings: Path
    study: Path
    batch: BatchChoices
    seed: int


@dataclass(frozen=True, eq=False)
class Li2022Again:
    """The paper, computed again.

    Attributes:
        model: the arm with muscles.
        made: the synthetic part.
        table: each published number beside ours, people included.
        more: sections of the report on people.
        provenance: files and choices.
    """

    model: "MusculoskeletalArm"
    made: "Reproduction"
    table: "pd.DataFrame"
    more: "tuple[Section, ...]"
    provenance: Provenance


def li2022(people: People | None, *, searched: int, say: Say) -> Li2022Again:
    """Compute the paper again.

    Args:
        people: for Figs 8 and 9 and Table IV; None: without them.
        searched: poses on which the paper's own search runs too.
        say: is told what is being done.
    """
    from selfmotion.cli.models import load_muscles
    from selfmotion.studies.li2022 import Size, reproduce

    # People first, so that a broken study file is told at once.
    tables = None if people is None else _on_people(people, say)
    say("li2022: loading the arm with muscles")
    model = load_muscles("myoarm", None)
    say("li2022: poses of a vertical cup")
    made = reproduce(model, size=Size(published=searched))
    size = {"poses": len(made.postures), "searched_as_paper": searched}
    sized = replace(made.provenance, choices={**made.provenance.choices, **size})
    if people is None or tables is None:
        return Li2022Again(model, made, made.table, (), sized)
    from selfmotion.report.prediction_li2022 import people_sections
    from selfmotion.studies.li2022_people import li2022_on_people, with_people

    figures = li2022_on_people(tables)
    inputs = {**sized.inputs, **tables.provenance.inputs}
    return Li2022Again(
        model,
        made,
        with_people(made.table, figures),
        tuple(people_sections(figures)),
        replace(sized, inputs=inputs, seed=people.seed),
    )


def _on_people(people: People, say: Say) -> "PredictionTables":
    """Run the predictors on recorded people; warn of what could not be used."""
    from selfmotion.cli.predict import run_prediction
    from selfmotion.studies.prediction_tables import tables_of

    def on_start(arms: int) -> Callable[[object], None]:
        count = iter(range(1, arms + 1))
        say(f"li2022: recorded people, 0 of {arms} arms")
        return lambda outcome: say(f"li2022: recorded people, {next(count)} of {arms} arms")

    say("li2022: looking for recordings")
    run = run_prediction([people.recordings], people.study, batch=people.batch, on_start=on_start)
    for what, why in run.failed:
        warnings.warn(f"not used: {what}: {why}", stacklevel=2)
    return tables_of(run, seed=people.seed)
