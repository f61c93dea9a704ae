"""The report of `selfmotion curvature`: paths, areas, tests by direction, hysteresis."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from selfmotion.methods.curvature import VACUOUS
from selfmotion.provenance import Provenance
from selfmotion.report.curvature_figures import (
    MOST_PANELS,
    curved_paths_figure,
    hysteresis_figure,
    net_areas_figure,
)
from selfmotion.report.html import Footer, Picture, Section, Table, write_report

TITLE = "Curvature of paths"
COLUMNS = ["subject", "side", "condition", "target", "n", "mean", "sd", "t", "p", "p_corrected"]


def write_curvature_report(
    path: str | Path,
    paths: Sequence[Sequence[Sequence[float]]],
    tables: tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame],
    provenance: Provenance,
    *,
    unread: Sequence[str] = (),
) -> Path:
    """Write the report on curved paths; give its path.

    Args:
        path: the HTML file.
        paths: of each movement, (samples, 2 or 3) m; empty where it could not be measured.
        tables: one row a movement, one a loop out and back, one a test.
        provenance: how they were made.
        unread: files that could not be read, each with the reason.
    """
    movements, loops, tests = tables
    sections = [_movements(paths, movements, unread)]
    measured = movements.loc[movements["a_net"].notna()]
    if len(measured):
        sections.append(_directions(movements, tests))
    if len(loops):
        sections.append(_loops(loops, tests))
    sections.append(_all(movements))
    veering = sum(t["differs"] and t["measure"] == "a_net" for t in tests.to_dict("records"))
    summary = (
        f"{len(measured)} of {len(movements)} movements were measured; directions that veer to "
        f"one side, after correction: {veering}."
    )
    footer = Footer((provenance,), ("Tommasino2017",))
    return write_report(path, TITLE, sections, summary=summary, footer=footer)


def _movements(
    paths: Sequence[Sequence[Sequence[float]]], movements: pd.DataFrame, unread: Sequence[str]
) -> Section:
    bad = [f"{r['name']}: {r['status']}" for r in movements.to_dict("records") if r["failed"]]
    pictures: tuple[Picture, ...] = ()
    if any(map(len, paths)):
        pictures = (
            Picture(
                curved_paths_figure(paths, movements),
                "Paths from onset to offset (20 % of peak speed), each with its straight line."
                f" At most {MOST_PANELS} panels.",
                "Paths of the hand with their straight lines",
            ),
        )
    return Section(
        "Paths",
        words=(
            "A_right and A_left are the areas between a path and its straight line, right and "
            "left of it, over the squared length of that line. A_net is right minus left: above "
            "0 the path veers to the right. Movements that stand apart (duration or length more "
            "than two interquartile ranges from the person's median) are not tested.",
        ),
        pictures=pictures,
        warning=" ".join(f"{sentence}." for sentence in (*unread, *bad)),
    )


def _directions(movements: pd.DataFrame, tests: pd.DataFrame) -> Section:
    net = tests.loc[tests["measure"] == "a_net", [*COLUMNS, "differs"]]
    total = tests.loc[tests["measure"] == "a_sum", COLUMNS]
    return Section(
        "Does a direction veer to one side?",
        words=(
            "Student's t of the mean A_net of a direction (condition and target) against 0, "
            "corrected after Holm for the directions of a person.",
        ),
        pictures=(
            Picture(
                net_areas_figure(movements, tests),
                "A_net of each movement by direction, and its mean.",
                "Net area of each movement by direction, with means",
            ),
        ),
        tables=(
            Table(net, "A_net by direction."),
            Table(total, f"A_sum by direction. {VACUOUS}."),
        ),
    )


def _loops(loops: pd.DataFrame, tests: pd.DataFrame) -> Section:
    columns = [name for name in COLUMNS if name != "condition"]
    found = tests.loc[tests["measure"] == "hysteresis", [*columns, "differs"]]
    return Section(
        "Hysteresis",
        words=(
            "A_net of a movement out plus A_net of the movement back: the area between the two "
            "ways, 0 where the hand comes back as it went. Student's t against 0, corrected "
            "after Holm for the targets of a person.",
        ),
        pictures=(
            Picture(
                hysteresis_figure(loops, tests),
                "Hysteresis of each pair of movements by target, and its mean.",
                "Hysteresis of each pair of movements out and back by target, with means",
            ),
        ),
        tables=(Table(found, "Hysteresis by target."),),
    )


def _all(movements: pd.DataFrame) -> Section:
    """List the movements by their labels, or by their files where they have none."""
    labels = ["subject", "side", "condition", "target", "trial"]
    known = [name for name in labels if any(movements[name].notna().tolist())]
    names = known if movements.loc[:, known].drop_duplicates().shape[0] == len(movements) else []
    columns = [*(names or ["name"]), "duration", "length", "a_right", "a_left", "a_sum", "a_net"]
    return Section(
        "All movements",
        tables=(
            Table(
                movements.loc[~movements["failed"], [*columns, "stands_apart"]],
                "Duration in s (samples where there are no times), length in m, areas over "
                "squared length.",
            ),
        ),
    )
