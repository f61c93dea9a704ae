"""The report of `selfmotion effort`: the muscles that hold each posture, and how hard."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from jaxtyping import Float
from matplotlib.figure import Figure

from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.provenance import Provenance
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.posture_figures import ACTIVATION, muscles_figure
from selfmotion.report.theme import INK, NULL, new_figure, themed

# Postures drawn one by one; the table holds all of them. Muscles shown of each.
MOST_DRAWN, MOST_MUSCLES = 6, 12
# From so many postures on effort is drawn over them.
LEAST_FOR_CURVE = 4


@dataclass(frozen=True, eq=False)
class HeldPosture:
    """One posture and what holds it.

    Attributes:
        name: as the file names it.
        q: (7,) posture (rad).
        effort: sum of the activations to their power.
        activations: (M,) by muscle.
        status: whether they hold it.
    """

    name: str
    q: Float[np.ndarray, " coords"]
    effort: float
    activations: Float[np.ndarray, " muscles"]
    status: str


def write_effort_report(
    path: str | Path,
    model: MusculoskeletalArm,
    postures: Sequence[HeldPosture],
    table: pd.DataFrame,
    provenance: Provenance,
) -> Path:
    """Write the report on the effort of postures; give its path.

    Args:
        path: the HTML file.
        model: the arm with muscles.
        postures: those with an effort; the first are drawn.
        table: one row a posture of the file, with its status.
        provenance: where the numbers come from.
    """
    shown = postures[:MOST_DRAWN]
    words = (
        f"The muscles of {model.arm.name}, convention {model.convention}, that hold each posture "
        "with the least effort.",
    )
    if len(shown) < len(postures):
        words += (f"The first {len(shown)} of {len(postures)} are drawn one by one.",)
    curve = ()
    if len(postures) >= LEAST_FOR_CURVE:
        curve = (
            Picture(
                curve_figure(postures),
                "Muscle effort over the postures, in the order of the file.",
                "Muscle effort by posture",
            ),
        )
    captioned = Table(
        table, "Effort (sum of powers of activations, no unit), and the hardest working muscles."
    )
    sections = [Section("Postures", words=words, pictures=curve, tables=(captioned,))]
    sections += [posture_section(model, posture) for posture in shown]
    summary = f"Effort of {len(postures)} of {len(table)} postures."
    footer = Footer((provenance,), ("Li2022",))
    return write_report(path, "Muscle effort", sections, summary=summary, footer=footer)


def posture_section(model: MusculoskeletalArm, posture: HeldPosture) -> Section:
    """Draw one posture: the arm, and the muscles that work hardest."""
    return Section(
        f"Posture {posture.name}",
        words=(f"Effort {posture.effort:.4g}; {posture.status}.",),
        pictures=(
            Picture(
                muscles_figure(model, posture.q, posture.activations),
                "The arm in this posture; muscles are coloured by activation.",
                f"The arm with its muscles in posture {posture.name}",
            ),
            Picture(
                hardest_figure(model.muscles.names, posture.activations),
                "Activation of the muscles that work hardest (1: all they can).",
                f"Activations of the hardest working muscles in posture {posture.name}",
            ),
        ),
    )


@themed
def hardest_figure(names: Sequence[str], activations: Float[np.ndarray, " muscles"]) -> Figure:
    """Draw the activations of the muscles that work hardest, the greatest above."""
    order = np.argsort(-activations)[:MOST_MUSCLES]
    values = activations[order]
    figure, axes = new_figure(size=(5.2, 0.7 + 0.22 * len(order)))
    ax = axes[0, 0]
    colours = ACTIVATION(values / max(float(values.max(initial=0.0)), 0.05))
    ax.barh(range(len(order)), values, color=colours, height=0.65, edgecolor=INK, linewidth=0.4)
    ax.set_yticks(range(len(order)), [names[i] for i in order])
    ax.set_ylim(len(order) - 0.4, -0.6)
    ax.set_xlim(left=0.0)
    ax.grid(visible=False, axis="y")
    ax.grid(visible=True, axis="x")
    ax.set_xlabel("activation (no unit)")
    return figure


@themed
def curve_figure(postures: Sequence[HeldPosture]) -> Figure:
    """Draw effort over the postures in their order."""
    figure, axes = new_figure(size=(6.4, 3.0))
    ax = axes[0, 0]
    marker = "o" if len(postures) <= 40 else ""
    places = range(1, len(postures) + 1)
    ax.plot(places, [p.effort for p in postures], color=NULL, marker=marker)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("posture (in order)")
    ax.set_ylabel("muscle effort (no unit)")
    return figure
