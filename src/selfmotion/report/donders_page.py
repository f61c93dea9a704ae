"""The report of `selfmotion donders DIR --study`: surfaces, predictions and plans of people."""

from pathlib import Path

import pandas as pd

from selfmotion.report.donders_figures import (
    plans_figure,
    prediction_figure,
    reaches_figure,
    surface_figure,
    thickness_figure,
)
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.svg import write_png
from selfmotion.studies.donders_people import DondersPeople, rms_by_person
from selfmotion.studies.donders_predictions import LAW, PRIOR
from selfmotion.studies.people_means import by_person, rows_of
from selfmotion.studies.reach_measures import MEASURES

DOTS = "Dots: people. Squares: mean over people with its 95 % interval."


def write_donders_report(path: str | Path, run: DondersPeople) -> Path:
    """Write the report; give its path."""
    sections = [surfaces_section(run), laws_section(run), predictions_section(run)]
    if len(run.reaches):
        sections.append(reaches_section(run))
    if run.failed:
        failed = pd.DataFrame(list(run.failed), columns=["what", "why"])
        sections.append(Section("What could not be used", tables=(Table(failed, ""),)))
    footer = Footer((run.provenance,), ("Tommasino2017",))
    title = "Donders' law and passive motion of recorded people"
    return write_report(path, title, sections, summary=summary(run), footer=footer)


def save_pictures(folder: Path, run: DondersPeople) -> list[Path]:
    """Write the report's pictures as PNG on white; give their paths."""
    figures = {
        "surface": surface_figure(run.shown[0]),
        "thickness": thickness_figure(run),
        "predictions": prediction_figure(run),
    }
    if len(run.reaches):
        figures |= {"reaches": reaches_figure(run), "plans": plans_figure(run)}
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, figure in figures.items():
        figure.set_facecolor("white")
        path = folder / f"donders_{name}.png"
        write_png(figure, str(path), dpi=110)
        written.append(path)
    return written


def summary(run: DondersPeople) -> str:
    """Say how many people, and how well their law predicts."""
    rms = by_person(rms_by_person(run.predictions), "rms_deg", ["left_out", "place", "predictor"])
    said = []
    for kind, words in (("repeat", "repeats"), ("task", "tasks")):
        rows = rows_of(rms, {"left_out": kind, "place": "path", "predictor": LAW})
        for one in rows.to_dict("records"):
            said.append(
                f"{one['mean']:.1f}° ({one['lower']:.1f} to {one['upper']:.1f}) in {words} left out"
            )
    arms = f"{len(run.shown)} arms"
    return f"{arms}. A law of least elastic energy predicts the swivel angle to " + ", ".join(said)


def surfaces_section(run: DondersPeople) -> Section:
    """Show the surfaces and their thickness."""
    table = by_person(run.surfaces, "held_out_deg", ["segment", "task"])
    return Section(
        "Donders surfaces",
        words=(
            "Torsion of a segment as a quadratic function of its two directions. A thin surface "
            "says that people do not use the freedom of torsion: where they point decides it.",
        ),
        pictures=(
            Picture(
                surface_figure(run.shown[0]),
                f"Upper arm of {run.shown[0].postures.subject} in the thorax, all tasks.",
                "Contours of the fitted torsion with the postures, and what remains",
            ),
            Picture(
                thickness_figure(run),
                "Grey: spread of the torsion itself. Blue: beside a surface that was fitted to "
                f"the other repeats. {DOTS}",
                "Thickness of the surfaces by task, for shoulder, forearm and wrist",
            ),
        ),
        tables=(Table(table, "Thickness with repeats held out (degrees): mean over people."),),
    )


def laws_section(run: DondersPeople) -> Section:
    """Show the laws fitted to all movements."""
    coupling = [" x " in name for name in run.laws["parameter"]]
    diagonal = run.laws.loc[[not one for one in coupling]]
    return Section(
        "Laws",
        words=(f"Prior: {PRIOR}. The trace of the stiffness is set to 4 N m/rad.",),
        warning=(
            "Without the prior these postures do not tell a law of four joints. The elbow's "
            "stiffness is the prior's: the elbow does not move in the self-motion."
        ),
        tables=(Table(diagonal, "One row a parameter; couplings are in laws.csv."),),
    )


def predictions_section(run: DondersPeople) -> Section:
    """Show the errors of all predictors."""
    rms = rms_by_person(run.predictions)
    keys = ["left_out", "place", "predictor"]
    return Section(
        "Postures predicted",
        words=(
            "All predictors see where the wrist is (least muscle effort: the pose of the hand). "
            "Fitted ones see no posture of the movements left out.",
        ),
        pictures=(
            Picture(
                prediction_figure(run),
                DOTS,
                "Error of the swivel angle by predictor, with repeats and with tasks left out",
            ),
        ),
        tables=(Table(by_person(rms, "rms_deg", keys), "Root mean square error (degrees)."),),
    )


def reaches_section(run: DondersPeople) -> Section:
    """Show planned reaches beside recorded ones."""
    table = run.reaches.assign(swivel_error_deg=run.reaches["swivel_error_deg"].abs())
    frames = [
        by_person(table, measure, ["task", "model"]).assign(measure=measure) for measure in MEASURES
    ]
    return Section(
        "Reaches planned",
        words=(
            "Paths of the wrist about the shoulder, from the recorded first posture to the "
            "recorded last place, in the recorded time. A straight line is what minimum jerk "
            "gives; its joints follow by the pseudo-inverse, or by the law.",
        ),
        pictures=(
            Picture(
                reaches_figure(run),
                "Seen from above, from the start of each reach.",
                "Recorded and planned paths of each person, one row a task",
            ),
            Picture(
                plans_figure(run),
                f"Left: how far paths lie apart. Right: swivel angle at the end. {DOTS}",
                "Distance of planned from recorded paths, and of end postures, by model",
            ),
        ),
        tables=(
            Table(pd.concat(frames, ignore_index=True), "Means over people; a_net over length²."),
        ),
    )
