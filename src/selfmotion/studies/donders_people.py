"""Postures and movements of recorded people: surfaces, laws, predictions, planned reaches.

[Tommasino2017], doi 10.3389/fnbot.2017.00065, read on people who move their whole arm: how thin the
Donders surfaces of shoulder, forearm and wrist are in each task; whether a law of least elastic
energy, fitted to some movements, predicts the postures of others; whether λ0-PMP plans the paths
that people take. Means and intervals are over people, each counted once.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.errors import SelfmotionError
from selfmotion.methods.donders import JointElasticity
from selfmotion.methods.elasticity.orientation_surface import OrientationSurface
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.methods.predictors.observation import angle_between
from selfmotion.provenance import Provenance
from selfmotion.studies.donders_paths import Reach, plan_reaches
from selfmotion.studies.donders_postures import ON_PATH, PersonPostures, postures_of
from selfmotion.studies.donders_predictions import (
    EFFORT,
    PRIOR,
    REPEAT,
    fit_law,
    fold_laws,
    prediction_table,
)
from selfmotion.studies.donders_surfaces import surface_of, surface_table
from selfmotion.studies.people import RecordedPerson, load_people
from selfmotion.studies.people_means import grouped
from selfmotion.studies.prediction_poses import fit_person, moments_of_person
from selfmotion.studies.study_file import StudyFile

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Shown:
    """What pictures need of one arm.

    Attributes:
        postures: of it.
        surface: of its upper arm, all tasks.
        reaches: recorded and planned paths.
    """

    postures: PersonPostures
    surface: OrientationSurface
    reaches: tuple[Reach, ...]


@dataclass(frozen=True, eq=False)
class DondersPeople:
    """What came of the people.

    Attributes:
        surfaces: one row an arm, segment and task (`surface_table`).
        laws: one row an arm and parameter: value, standard error, unit; `status` of the fit.
        predictions: one row a posture left out and predictor (`prediction_table`).
        reaches: one row a reach and model (`plan_reaches`).
        shown: arm by arm, for pictures.
        failed: (what, why) of files, people and poses that could not be used.
        provenance: study file and choices.
    """

    surfaces: "pd.DataFrame"
    laws: "pd.DataFrame"
    predictions: "pd.DataFrame"
    reaches: "pd.DataFrame"
    shown: tuple[Shown, ...]
    failed: tuple[tuple[str, str], ...]
    provenance: Provenance

    def to_frame(self) -> "pd.DataFrame":
        """Give the predictions."""
        return self.predictions


def donders_people(
    folders: Sequence[Path],
    study: StudyFile,
    *,
    effort: bool = True,
    jobs: int = 1,
    on_person: Callable[[], None] | None = None,
) -> DondersPeople:
    """Run the analysis on the people of a study.

    Args:
        folders: where their recordings are.
        study: how files are named; names static trials and the moment ``end_of_reach``.
        effort: whether to predict the moments by least muscle effort too (a second each).
        jobs: people calibrated at once.
        on_person: called after each arm.

    Raises:
        SelfmotionError: nobody could be used.
    """
    import pandas as pd

    failed: list[tuple[str, str]] = []
    parts: list[_Part] = []
    refused = None
    people = load_people(
        folders,
        study,
        jobs=jobs,
        on_refused=lambda subject, side, why: failed.append((f"{subject}, {side}", why)),
    )
    for person in people:
        failed += person.failed
        try:
            part, lost = analyse_person(person, effort=effort)
        except SelfmotionError as error:
            refused = error
            failed.append((f"{person.subject}, {person.side}", str(error)))
        else:
            parts.append(part)
            failed += lost
        if on_person is not None:
            on_person()
    if not parts:
        raise refused or SelfmotionError("no person could be used: " + "; ".join(failed[0]))
    tables = (
        pd.concat([getattr(p, name) for p in parts], ignore_index=True)
        for name in ("surfaces", "laws", "predictions", "reaches")
    )
    return DondersPeople(
        *tables,
        shown=tuple(p.shown for p in parts),
        failed=tuple(failed),
        provenance=Provenance("donders_people", choices={"prior": PRIOR, "effort": effort}),
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """The tables of one arm."""

    surfaces: "pd.DataFrame"
    laws: "pd.DataFrame"
    predictions: "pd.DataFrame"
    reaches: "pd.DataFrame"
    shown: Shown


def analyse_person(
    person: RecordedPerson, *, effort: bool = True
) -> tuple[_Part, list[tuple[str, str]]]:
    """Analyse one arm; give its tables, and what could not be used.

    Raises:
        SelfmotionError: the arm's movements are too few or too much alike.
    """
    import pandas as pd

    postures = postures_of(person)
    surface = surface_of(postures, "shoulder", postures.on_path)
    laws = fold_laws(postures)
    said = [prediction_table(postures, laws)]
    lost: list[tuple[str, str]] = []
    if effort:
        by_effort, lost = effort_table(person)
        said.append(by_effort)
    others = {name: fit for (kind, name), fit in laws.items() if kind == REPEAT}
    reaches, paths, unplanned = plan_reaches(person, postures, others)
    lost += unplanned
    return _Part(
        surface_table(postures),
        _law_table(postures, fit_law(postures, postures.on_path)),
        pd.concat(said, ignore_index=True),
        reaches,
        Shown(postures, surface, paths),
    ), lost


def effort_table(person: RecordedPerson) -> tuple["pd.DataFrame", list[tuple[str, str]]]:
    """Predict the swivel angle at a person's moments by least muscle effort ([Li2022] eq. 3.1).

    The myo-sim arm is scaled to the person; the hand pose is given, not only the wrist's place, and
    nothing is fitted to the swivel angle, so that what was left out makes no difference.
    """
    import pandas as pd

    moments, lost = moments_of_person(person)
    columns = ["subject", "side", "left_out", "task", "trial", "moment", "predictor"]
    columns += ["recorded", "predicted", "error_deg"]
    if not moments:
        return pd.DataFrame(columns=columns), lost
    knuckle = person.person.protocol.knuckle_radial
    fitted = fit_person(moments, knuckle_radial=knuckle)
    finder = PostureFinder.of(fitted.model)
    rows = []
    for moment, T_hand in zip(moments, fitted.hand_poses(), strict=True):
        if moment.moment == "start":
            continue
        found = finder.find(T_hand)
        if not found.minima:
            name = f"{person.subject}, {moment.task} {moment.trial}, {moment.moment}"
            lost.append((name, found.status.sentence))
        error = float(np.degrees(angle_between(found.swivel, moment.natural())))
        label = (person.subject, person.side, "nothing", moment.task, moment.trial, moment.moment)
        rows.append((*label, EFFORT, moment.natural(), found.swivel, error))
    return pd.DataFrame(rows, columns=columns), lost


def rms_by_person(predictions: "pd.DataFrame") -> "pd.DataFrame":
    """Give the root mean square error (deg) of each arm, by what was left out, place, predictor."""
    import pandas as pd

    place = np.where(predictions["moment"] == ON_PATH, "path", "moments")
    keys = ["left_out", "place", "predictor", "subject", "side"]
    found = grouped(predictions.assign(place=place), "error_deg", keys)
    rows = [
        (*key, float(np.sqrt(np.nanmean(values**2))), int(np.isnan(values).sum()))
        for key, values in found.items()
        if np.isfinite(values).any()
    ]
    return pd.DataFrame(rows, columns=[*keys, "rms_deg", "without"])


def _law_table(postures: PersonPostures, fit: JointElasticity) -> "pd.DataFrame":
    table = fit.to_frame()
    table.insert(0, "subject", postures.subject)
    table.insert(1, "side", postures.side)
    return table.assign(thickness_deg=fit.thickness_deg, status=fit.status.sentence)
