"""Figs 8 and 9 and Table IV of [Li2022] on recorded people, as sections of a report."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from selfmotion.report.html import Picture, Section, Table
from selfmotion.report.prediction_figures import EFFORT_COLOUR
from selfmotion.report.theme import BASELINE, INK, TASK, new_figure, themed, words
from selfmotion.studies.li2022_people import COORDINATES, LAW_ON_PEOPLE, LiOnPeople

# Mean and standard deviation of the paper's error (deg).
PUBLISHED = LAW_ON_PEOPLE.values
# What stands above the columns of `LiOnPeople.table_iv`.
TABLE_HEADER = [
    "study",
    "assumption",
    "published (deg)",
    "predictor here",
    "mean ± SD (deg)",
    "over people (deg)",
    "note",
]
# Hands lower than this from the shoulder are far below it (m).
FAR_BELOW = -0.1


def people_sections(found: LiOnPeople) -> list[Section]:
    """Show the figures and the table on people."""
    return [
        Section(
            "On recorded people",
            words=(
                "The law is least muscle effort against gravity alone, on the arm scaled to each "
                "person, for the hand poses of their own movements. Published errors come from "
                "other people and tasks.",
            ),
            pictures=(
                Picture(
                    places_figure(found.places),
                    "As Fig 8: mean absolute error at the places of the hands, from the shoulder, "
                    "one point a person, arm and kind of moment. " + _by_height(found.places),
                    "Error of the swivel angle by place of the wrist, from above and the side",
                ),
                Picture(
                    trials_figure(found.trials, found.coordinates),
                    "As Fig 9: natural and replicated angle, the errors, and the errors of the "
                    "coordinates (mean and standard deviation). The paper's error is "
                    f"{PUBLISHED[0]:g} ± {PUBLISHED[1]:g}°, here it is "
                    f"{str(found.numbers.loc[0, 'ours']).replace(', ', ' ± ')}°. "
                    + _of_the_elbow(found.coordinates),
                    "Natural and replicated angles, histogram of errors, errors by coordinate",
                ),
            ),
            tables=(
                Table(
                    found.table_iv.set_axis(TABLE_HEADER, axis=1),
                    "Table IV beside ours (deg): mean ± standard deviation over moments, and mean "
                    "over people with its 95 % interval.",
                ),
            ),
        )
    ]


def _by_height(places: pd.DataFrame) -> str:
    """Say whether errors are larger far below the shoulder, as in the paper."""
    low = places["wrist_z_m"].to_numpy(dtype=float) < FAR_BELOW
    error = places["error_deg"].to_numpy(dtype=float)
    said = "In the paper (114 places, 5 people) hands far below the shoulder have larger errors"
    if not low.any() or low.all():
        return f"{said}."
    return (
        f"{said}; here the mean is {np.nanmean(error[low]):.0f}° more than {-100 * FAR_BELOW:.0f} "
        f"cm below it and {np.nanmean(error[~low]):.0f}° above that, but tasks differ as well."
    )


def _of_the_elbow(coordinates: pd.DataFrame) -> str:
    """Say whether elbow flexion, which the hand pose nearly fixes, errs least, as in the paper."""
    mean = coordinates["mean_deg"].to_numpy(dtype=float)
    if not np.isfinite(mean).all():
        return ""
    elbow = float(mean[COORDINATES.index("elbow_flexion")])
    return (
        "In the paper elbow flexion errs least, since the hand pose nearly fixes it; here "
        f"{'too' if elbow <= mean.min() else 'not'} ({elbow:.1f}°)."
    )


@themed
def places_figure(places: pd.DataFrame) -> Figure:
    """Draw the error at each place of the wrist, seen from above and from the right (Fig 8)."""
    figure, axes = new_figure(1, 2, size=(7.2, 3.4))
    x, y, z = (100.0 * places[f"wrist_{k}_m"].to_numpy(dtype=float) for k in "xyz")
    error = places["error_deg"].to_numpy(dtype=float)
    drawn = None
    for ax, (across, up), names in (
        (axes[0, 0], (x, y), ("to the side", "forward")),
        (axes[0, 1], (y, z), ("forward", "up")),
    ):
        drawn = ax.scatter(across, up, c=error, cmap="viridis", vmin=0.0, s=26, edgecolors="none")
        ax.plot(0.0, 0.0, "+", color=INK, markersize=9)
        ax.annotate("shoulder", (0.0, 0.0), (4, 4), textcoords="offset points", fontsize=8)
        ax.set_xlabel(f"{names[0]} (cm)")
        ax.set_ylabel(f"{names[1]} (cm)")
        ax.set_aspect("equal", adjustable="datalim")
    axes[0, 0].set_title("from above")
    axes[0, 1].set_title("from the side")
    if drawn is not None:
        figure.colorbar(drawn, ax=list(axes.flat), label="mean absolute error (deg)", shrink=0.9)
    return figure


@themed
def trials_figure(trials: pd.DataFrame, coordinates: pd.DataFrame) -> Figure:
    """Draw angles by moment, the histogram of errors and the coordinates' errors (Fig 9)."""
    figure, axes = new_figure(3, 1, size=(7.2, 7.6))
    above, middle, below = axes[:, 0]
    order = trials.sort_values(["kind", "subject", "trial"]).reset_index(drop=True)
    above.plot(order["natural_deg"], ".", color=INK, markersize=4, label="natural")
    above.plot(order["predicted_deg"], ".", color=EFFORT_COLOUR, markersize=4, label="least effort")
    for place in np.flatnonzero(order["kind"].to_numpy()[1:] != order["kind"].to_numpy()[:-1]):
        above.axvline(place + 0.5, color=BASELINE, linewidth=0.7)
    for kind, part in order.groupby("kind", sort=False):
        above.annotate(
            words(str(kind)).replace(", ", ",\n"),
            (float(np.mean(part.index.to_numpy())), 1.0),
            xycoords=("data", "axes fraction"),
            ha="center",
            va="top",
            fontsize=7.5,
        )
    above.margins(y=0.25)
    above.set_xlabel("moment")
    above.set_ylabel("swivel angle (deg)")
    above.set_title("A  natural and replicated")
    above.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    size = np.abs(order["error_deg"].to_numpy(dtype=float))
    size = size[np.isfinite(size)]
    middle.hist(
        size, bins=np.arange(0.0, max(size.max(initial=5.0), 5.0) + 5.0, 5.0), color=INK, alpha=0.75
    )
    middle.axvline(PUBLISHED[0], color=TASK, linestyle="--", label="published mean")
    if size.size:
        middle.axvline(float(size.mean()), color=EFFORT_COLOUR, label="mean here")
    middle.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    middle.set_xlabel("absolute error of the swivel angle (deg)")
    middle.set_ylabel("moments")
    middle.set_title("B  errors")
    names = [words(name) for name in coordinates["coordinate"]]
    mean = coordinates["mean_deg"].to_numpy(dtype=float)
    spread = coordinates["sd_deg"].fillna(0.0).to_numpy(dtype=float)
    below.bar(names, mean, color=EFFORT_COLOUR, width=0.6)
    below.errorbar(names, mean, yerr=spread, fmt="none", ecolor=INK, capsize=3, linewidth=1.0)
    below.set_ylim(bottom=0.0)
    below.set_ylabel("absolute error (deg)")
    below.set_title("C  by coordinate")
    below.tick_params(axis="x", labelrotation=20)
    return figure
