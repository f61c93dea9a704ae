"""The report of `selfmotion predict`: which law of posture holds on these people."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion.methods.predictors.catalogue import BASELINE, EFFORT, NOT_COMPUTED
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.prediction_figures import (
    errors_figure,
    natural_figure,
    predicted_figure,
    sensitivity_figure,
    shown_names,
)
from selfmotion.report.theme import words
from selfmotion.studies.prediction import LEAST_RADIUS, PredictionRun
from selfmotion.studies.prediction_summary import counted, of_variant
from selfmotion.studies.prediction_tables import PredictionTables

UNBROKEN = "\N{NO-BREAK SPACE}"
SUMMARY_COLUMNS = {
    "predictor": "predictor",
    "mean_deg": "error",
    "lower_deg": "from",
    "upper_deg": "to",
    "bias_deg": "bias",
    "gain_deg": "gain on constant",
    "gain_lower_deg": "gain from",
    "gain_upper_deg": "gain to",
    "better_people": "people better",
    "missing": "missing",
}


def write_prediction_report(path: str | Path, run: PredictionRun, tables: PredictionTables) -> Path:
    """Write the report; give its path."""
    sections = [
        errors_section(tables),
        angles_section(run, tables),
        people_section(tables),
        *([sensitivity_section(tables)] if len(tables.sensitivity) else []),
        files_section(run, tables),
    ]
    footer = Footer((tables.provenance,), ("Li2022",))
    return write_report(
        path,
        "Laws of natural posture against people",
        sections,
        summary=summary(tables),
        footer=footer,
    )


def summary(tables: PredictionTables) -> str:
    """Say which predictor came nearest, and how the paper's law did."""
    rows = tables.summary.set_index("predictor")
    best = str(tables.summary.loc[0, "predictor"])
    said = {name: _with_interval(rows.loc[name]) for name in (best, BASELINE, EFFORT)}
    return (
        f"Nearest to these people came {best!r}: {said[best]}. The constant per task, fitted on "
        f"the others, misses by {said[BASELINE]}; least muscle effort by {said[EFFORT]}."
    )


def errors_section(tables: PredictionTables) -> Section:
    """Show errors by predictor."""
    return Section(
        "Errors",
        words=(
            "Each person is predicted by what was fitted on all others. A person's absolute errors "
            "are averaged over kinds of moment, each alike; intervals (95 %) are over people. The "
            "gain is over the constant per task: a law that does not gain on it says nothing about "
            "these people beyond the task's name.",
        ),
        points=tuple(f"Not computed: {name}: {why}." for name, why in NOT_COMPUTED),
        pictures=(
            Picture(
                errors_figure(tables.summary, tables.persons),
                "Dots are people; large dots their mean, bars its 95 % interval; the dashed line "
                "is the constant per task.",
                "Mean absolute error of each predictor, by person",
            ),
        ),
        tables=(
            Table(
                tables.summary.loc[:, list(SUMMARY_COLUMNS)].rename(columns=SUMMARY_COLUMNS),
                "Degrees. Bias: mean signed error.",
            ),
            Table(
                tables.kinds.pivot(index="predictor", columns="kind", values="error_deg")
                .loc[list(tables.summary["predictor"])]
                .reset_index(),
                "Mean absolute error by kind of moment (deg).",
            ),
        ),
    )


def angles_section(run: PredictionRun, tables: PredictionTables) -> Section:
    """Show predicted over natural angles."""
    names = shown_names(tables.summary)
    return Section(
        "Predicted against natural",
        pictures=(
            Picture(
                predicted_figure(of_variant(run.predictions), names),
                "One point a moment; on the grey line the prediction is right.",
                "Predicted over natural swivel angle for " + ", ".join(names),
            ),
        ),
        tables=(
            Table(angles_by_person(tables.persons, names), "Mean angles by person and arm (deg)."),
        ),
    )


def angles_by_person(persons: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Give natural and predicted mean angles (whole deg), one row an arm and kind of moment."""
    arm = persons["subject"].astype(str) + UNBROKEN + persons["side"].astype(str)
    kind = persons["kind"].map(
        lambda k: words(k).replace(" ", UNBROKEN).replace("," + UNBROKEN, ", ")
    )
    shown = persons.assign(arm=arm, kind=kind).loc[persons["predictor"].isin(list(names))]
    said = shown.pivot(index=["arm", "kind"], columns="predictor", values="predicted_deg")
    natural = shown.groupby(["arm", "kind"])["natural_deg"].first()
    table = said.assign(natural=natural.reindex(said.index)).loc[:, ["natural", *names]]
    return table.map(_whole).reset_index()


def spread_in_words(spread: pd.DataFrame) -> pd.DataFrame:
    """Give one row a kind: mean, and the spreads with their intervals."""
    return pd.DataFrame(
        {
            "kind": words(str(row["kind"])),
            "mean": f"{row['mean_deg']:.0f}",
            **{
                f"{k} people": f"{row[f'{k}_deg']:.1f} ({row[f'{k}_lower_deg']:.1f} to "
                f"{row[f'{k}_upper_deg']:.1f})"
                for k in ("within", "between")
            },
            "people": row["people"],
            "moments": row["moments"],
        }
        for row in spread.to_dict("records")
    )


def errors_by_variant(sensitivity: pd.DataFrame) -> pd.DataFrame:
    """Give one row a variant: how far natural angles moved, and the errors (deg)."""
    variants = list(dict.fromkeys(sensitivity["variant"]))
    errors = sensitivity.pivot(index="variant", columns="predictor", values="mean_deg")
    errors = errors.loc[variants].dropna(axis=1)
    first = sensitivity.drop_duplicates("variant").set_index("variant").loc[variants]
    about = pd.DataFrame({"moved": first["moved_deg"].round(1), "inside": first["inside"]})
    return about.join(errors.round(1)).reset_index()


def people_section(tables: PredictionTables) -> Section:
    """Show the natural angles and how they vary."""
    ratio = tables.observations["effort_ratio"].dropna().astype(float)
    said = (
        f"Moments whose elbow is nearer than {1e3 * LEAST_RADIUS:.0f} mm to the line from shoulder "
        "to wrist have hardly a swivel angle and are left out.",
    )
    if len(ratio):
        said += (
            f"Natural postures need {ratio.median():.2f} times the least muscle effort for the "
            f"same hand pose (median; quartiles {ratio.quantile(0.25):.2f} to "
            f"{ratio.quantile(0.75):.2f}).",
        )
    return Section(
        "How people vary",
        words=said,
        pictures=(
            Picture(
                natural_figure(counted(tables.observations)),
                "Natural swivel angle of each repeat; the grey bar is what the limits allow.",
                "Natural swivel angles by person and kind of moment",
            ),
        ),
        tables=(
            Table(
                spread_in_words(tables.spread),
                "Swivel angle (deg): mean, standard deviation within people (repeats) and between "
                "their means, with 95 % intervals over people.",
            ),
        ),
    )


def sensitivity_section(tables: PredictionTables) -> Section:
    """Show what the shoulder centre and the limits change."""
    return Section(
        "What it depends on",
        words=(
            "The same recordings with the shoulder centre elsewhere (natural angle and hand pose "
            "both change) and with other joint limits.",
        ),
        pictures=(
            Picture(
                sensitivity_figure(tables.sensitivity),
                "Left: how far natural angles move against those as recorded. Right: errors.",
                "Shift of natural angles and errors, by shoulder centre and limits",
            ),
        ),
        tables=(
            Table(
                errors_by_variant(tables.sensitivity),
                "Mean absolute error of each predictor (deg); moved: mean size of the shift of "
                "natural angles (deg); inside: share of natural postures that the limits allow.",
            ),
        ),
    )


def files_section(run: PredictionRun, tables: PredictionTables) -> Section:
    """Show the fit to each person, and what could not be used."""
    return Section(
        "People and files",
        points=tuple(f"{what}: {why}" for what, why in run.failed),
        tables=(
            Table(
                tables.fits.drop(columns=["variant"]),
                "The arm with muscles at each person's size: lengths (m), fit to elbow and wrist "
                "(m), wrist offsets (rad), share of postures inside the limits.",
            ),
        ),
        warning=f"{len(run.failed)} items could not be used." if run.failed else "",
    )


def _whole(value: float) -> int | None:
    return round(value) if np.isfinite(value) else None


def _with_interval(row: "pd.Series") -> str:
    return f"{row['mean_deg']:.1f}° ({row['lower_deg']:.1f} to {row['upper_deg']:.1f})"
