"""The report of `selfmotion ik`: what was reached, and how the joints lie in their ranges."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.ik_figures import error_figure, limits_figure, trajectories_figure
from selfmotion.report.theme import words

# Rows of a table that a reader still looks through; a joint this near (degrees) is at its limit.
MOST_ROWS, AT_LIMIT = 40, 0.01


@dataclass(frozen=True, eq=False)
class IkResults:
    """Postures for targets, as a report shows them.

    Attributes:
        arm: its name.
        joints: their names.
        limits: (2, n) lower and upper (rad), NaN where there is none.
        rows: what was held.
        ids: names of the targets.
        q: (K, n) postures (rad), NaN where there is none.
        errors: (K, 2) mm and degrees, NaN where there is none.
        status: "solved", or a sentence.
        time: (K,) s for a path, else None.
        path_status: a sentence about the path, or nothing.
        provenance: how the results were made.
    """

    arm: str
    joints: tuple[str, ...]
    limits: Float[np.ndarray, "2 coords"]
    rows: tuple[str, ...]
    ids: tuple[int | str, ...]
    q: Float[np.ndarray, "samples coords"]
    errors: Float[np.ndarray, "samples 2"]
    status: tuple[str, ...]
    time: Float[np.ndarray, " samples"] | None
    path_status: str
    provenance: Provenance

    @property
    def solved(self) -> np.ndarray:
        """(K,) which targets were reached."""
        return np.array([text == "solved" for text in self.status], dtype=bool)


def write_ik_report(path: str | Path, results: IkResults) -> Path:
    """Write the report on postures for targets, or along a path; give its path."""
    sections = [reach_section(results), joints_section(results)]
    title = "Postures for hand targets" if results.time is None else "A path of the hand, followed"
    footer = Footer((results.provenance,), ("DeBoon",))
    return write_report(path, title, sections, summary=summary(results), footer=footer)


def summary(results: IkResults) -> str:
    """Say what the reader should take home."""
    n, solved = len(results.status), int(results.solved.sum())
    text = f"{solved} of {n} targets are reached with all joints inside their limits."
    if results.path_status:
        text += f" The path: {results.path_status}."
    busiest = sorted(at_limits(results).items(), key=lambda item: -item[1])[:3]
    if busiest:
        named = ", ".join(f"{words(joint)} ({count})" for joint, count in busiest)
        text += f" Joints most often at a limit: {named}."
    return text


def at_limits(results: IkResults) -> dict[str, int]:
    """Count for each joint the postures in which it is at a limit."""
    near = np.radians(AT_LIMIT)
    gap = np.minimum(np.abs(results.q - results.limits[0]), np.abs(results.q - results.limits[1]))
    counts = (gap <= near).sum(axis=0)  # NaN compares as False
    return {joint: int(c) for joint, c in zip(results.joints, counts, strict=True) if c}


def reach_section(results: IkResults) -> Section:
    """Show what is missing to each target."""
    found = np.isfinite(results.errors).all(axis=1)
    pictures: tuple[Picture, ...] = ()
    if found.any():
        time = None if results.time is None else results.time[found]
        figure = error_figure(results.errors[found, 0], results.solved[found], time)
        caption = "Distance of the hand to its target; below 0.001 mm it is drawn there."
        pictures = (Picture(figure, caption, "Distance to each target on a logarithmic scale"),)
    missed = ~results.solved
    tables: tuple[Table, ...] = ()
    if missed.any():
        frame = pd.DataFrame(
            {
                "target": [str(name) for name in results.ids],
                "short_mm": results.errors[:, 0],
                "short_degrees": results.errors[:, 1],
                "status": results.status,
            }
        ).loc[missed]
        more = len(frame) - MOST_ROWS
        caption = "Targets not reached, and how near the hand comes"
        caption += f" (the first {MOST_ROWS}; {more} more are in ik.csv)." if more > 0 else "."
        tables = (Table(frame.head(MOST_ROWS), caption),)
    return Section(
        "Reach",
        words=(f"Arm {results.arm}; held at each target: {', '.join(results.rows)}.",),
        pictures=pictures,
        tables=tables,
        warning=_warning(int(missed.sum())),
    )


def _warning(missed: int) -> str:
    if not missed:
        return ""
    return "1 target is not reached." if missed == 1 else f"{missed} targets are not reached."


def joints_section(results: IkResults) -> Section:
    """Show the joints against their limits."""
    found = np.isfinite(results.q).all(axis=1)
    q, limits = np.degrees(results.q[found]), np.degrees(results.limits)
    counts = at_limits(results)
    points = tuple(
        f"{words(j)}: at a limit in {c} of {len(q)} postures." for j, c in counts.items()
    )
    if not found.any():
        return Section("Joints", words=("No posture was computed.",))
    if results.time is None:
        figure = limits_figure(q, limits, results.joints)
        caption = "Each tick is the posture of one target."
        alt = "Range of each joint, with the angle in each posture"
    else:
        figure = trajectories_figure(results.time[found], q, limits, results.joints)
        caption = "Joint angles along the path; dashed: a limit, where one is near."
        alt = "Joint angles over time with limits"
    frame = pd.DataFrame(
        {
            "joint": [words(joint) for joint in results.joints],
            "lower limit": limits[0],
            "least": q.min(axis=0),
            "greatest": q.max(axis=0),
            "upper limit": limits[1],
        }
    )
    return Section(
        "Joints",
        points=points,
        pictures=(Picture(figure, caption, alt),),
        tables=(Table(frame, "Ranges allowed and used (degrees)."),),
    )
