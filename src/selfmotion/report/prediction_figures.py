"""Pictures of laws of posture against people: predicted over natural angles, errors, spread."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from selfmotion.methods.predictors.catalogue import (
    BASELINE,
    CRITERIA,
    EFFORT,
    EFFORT_PASSIVE,
    FITTED,
)
from selfmotion.report.theme import (
    BASELINE as GREY,
)
from selfmotion.report.theme import (
    INK,
    JOINT_COLOURS,
    condition_marker,
    joint_colour,
    legend_below,
    new_figure,
    themed,
    words,
)

# Groups of predictors and their colours; grey is the baseline's, here as everywhere.
EFFORT_COLOUR, CRITERION_COLOUR, FITTED_COLOUR = (JOINT_COLOURS[i] for i in (2, 0, 1))
COLUMNS = 3
# More than there are colours, so that no two predictors look alike.
VARIANT_MARKERS = ("o", "s", "^", "D", "v", "P", "X")


def colour_of(predictor: str) -> str:
    """Give the colour of a predictor's group."""
    if predictor == BASELINE:
        return GREY
    if predictor in {p.name for p in FITTED}:
        return FITTED_COLOUR
    return EFFORT_COLOUR if predictor.startswith(EFFORT) else CRITERION_COLOUR


@themed
def predicted_figure(predictions: pd.DataFrame, names: Sequence[str]) -> Figure:
    """Draw predicted over natural swivel angle, one panel a predictor, one point a moment."""
    columns = min(len(names), COLUMNS)
    rows = -(-len(names) // columns)
    figure, axes = new_figure(
        rows, columns, size=(7.2, 1.1 + 2.45 * rows), share_x=True, share_y=True
    )
    kinds = list(dict.fromkeys(predictions["kind"]))
    both = np.rad2deg(
        predictions.loc[predictions["predictor"].isin(list(names))][
            ["natural", "predicted"]
        ].to_numpy(dtype=float)
    )
    low, high = np.nanmin(both) - 8.0, np.nanmax(both) + 8.0
    for ax, name in zip(axes.flat, names, strict=False):
        ax.plot([low, high], [low, high], color=GREY, linewidth=0.9, zorder=0.5)
        part = predictions.loc[predictions["predictor"] == name]
        for i, kind in enumerate(kinds):
            here = part.loc[part["kind"] == kind]
            ax.plot(
                np.rad2deg(here["natural"].to_numpy(dtype=float)),
                np.rad2deg(here["predicted"].to_numpy(dtype=float)),
                linestyle="none",
                marker=condition_marker(i),
                color=joint_colour(i),
                markersize=3.5,
                alpha=0.7,
                label=words(kind),
            )
        ax.set_title(_broken(name), fontsize=8.5)
        ax.set_xlim(low, high)
        ax.set_ylim(low, high)
        ax.set_aspect("equal", adjustable="box")
    for ax in axes.flat[len(names) :]:
        ax.set_visible(False)
    for ax in axes[-1]:
        ax.set_xlabel("natural angle (deg)")
    for ax in axes[:, 0]:
        ax.set_ylabel("predicted angle (deg)")
    legend_below(figure, axes.flat[0], columns=2)
    return figure


@themed
def errors_figure(summary: pd.DataFrame, persons: pd.DataFrame) -> Figure:
    """Draw each predictor's error: people as dots, their mean with its 95 % interval."""
    figure, axes = new_figure(size=(7.2, 0.9 + 0.29 * len(summary)))
    ax = axes[0, 0]
    over = persons.groupby(["predictor", "subject"])["error_deg"].mean()
    means = pd.DataFrame({"error_deg": over}).reset_index()
    for i, row in enumerate(summary.to_dict("records")):
        name, colour = str(row["predictor"]), colour_of(str(row["predictor"]))
        own = means.loc[means["predictor"] == name, "error_deg"].to_numpy(dtype=float)
        ax.plot(own, np.full(len(own), i + 0.27), ".", color=colour, alpha=0.6, markersize=4)
        ax.plot([row["lower_deg"], row["upper_deg"]], [i, i], color=colour, linewidth=2.4)
        ax.plot(row["mean_deg"], i, "o", color=colour, markersize=6)
    base = float(summary.set_index("predictor").loc[BASELINE, "mean_deg"])  # pyright: ignore[reportArgumentType]
    ax.axvline(base, color=GREY, linewidth=0.9, linestyle="--", zorder=0.5)
    ax.set_yticks(range(len(summary)), list(summary["predictor"]))
    ax.set_ylim(len(summary) - 0.5, -0.5)
    ax.set_xlim(left=0.0)
    ax.grid(visible=False, axis="y")
    ax.grid(visible=True, axis="x")
    ax.set_xlabel("mean absolute error of the swivel angle (deg)")
    groups = {
        "fitted on other people": FITTED_COLOUR,
        "criterion": CRITERION_COLOUR,
        "muscle effort": EFFORT_COLOUR,
        "baseline": GREY,
    }
    handles = [
        Line2D([], [], color=c, marker="o", linewidth=2.4, label=k) for k, c in groups.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


@themed
def natural_figure(observations: pd.DataFrame) -> Figure:
    """Draw natural swivel angles by person, with the feasible range, one panel a kind."""
    kinds = list(dict.fromkeys(observations["kind"]))
    columns = min(len(kinds), 2)
    rows = -(-len(kinds) // columns)
    figure, axes = new_figure(
        rows, columns, size=(7.2, 0.7 + 2.3 * rows), share_x=True, share_y=True
    )
    who = observations["subject"].astype(str) + " " + observations["side"].str[0].str.upper()
    everyone = sorted(set(who))
    for i, (ax, kind) in enumerate(zip(axes.flat, kinds, strict=False)):
        for k, person in enumerate(everyone):
            part = observations.loc[(who == person) & (observations["kind"] == kind)]
            _person(ax, k, part, joint_colour(i))
        ax.set_title(words(kind))
    for ax in axes.flat[len(kinds) :]:
        ax.set_visible(False)
    for ax in axes[-1]:
        ax.set_xticks(range(len(everyone)), everyone, rotation=90)
    figure.supylabel("swivel angle (deg)")
    handles = [
        Line2D([], [], color=INK, marker="o", linestyle="none", markersize=3.5, label="natural"),
        Line2D([], [], color=GREY, linewidth=5, alpha=0.35, label="feasible (median)"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


@themed
def sensitivity_figure(sensitivity: pd.DataFrame) -> Figure:
    """Draw how natural angles move and errors change with the shoulder centre and the limits.

    Predictors are drawn that all variants have.
    """
    variants = list(dict.fromkeys(sensitivity["variant"]))
    seen = sensitivity.groupby("predictor")["variant"].nunique()
    everywhere = seen.index[seen.to_numpy(dtype=int) == len(variants)]
    by_error = sensitivity.sort_values("mean_deg")["predictor"]
    names = [n for n in dict.fromkeys(by_error) if n in everywhere]
    figure, axes = new_figure(1, 2, size=(7.2, 1.3 + 0.27 * len(variants)), share_y=True)
    left, right = axes[0]
    rows = sensitivity.drop_duplicates("variant").set_index("variant").loc[variants]
    places = list(range(len(variants)))
    left.barh(places, rows["moved_deg"].to_numpy(dtype=float), color=GREY, height=0.5)
    left.plot(rows["shift_deg"].to_numpy(dtype=float), places, "o", color=INK)
    left.set_xlabel("shift of natural angles (deg)\nbar: mean size; dot: mean")
    left.axvline(0.0, color=GREY, linewidth=0.7)
    for i, name in enumerate(names):
        part = sensitivity.loc[sensitivity["predictor"] == name].set_index("variant")
        values = part["mean_deg"].reindex(variants).to_numpy(dtype=float)
        right.plot(
            values,
            range(len(variants)),
            linestyle="none",
            marker=VARIANT_MARKERS[i % len(VARIANT_MARKERS)],
            color=GREY if name == BASELINE else joint_colour(i),
            label=name,
        )
    right.set_xlim(left=0.0)
    right.set_xlabel("mean absolute error (deg)")
    left.set_yticks(range(len(variants)), variants)
    left.set_ylim(len(variants) - 0.5, -0.5)
    for ax in (left, right):
        ax.grid(visible=True, axis="both")
    legend_below(figure, right, columns=3)
    return figure


def shown_names(summary: pd.DataFrame) -> list[str]:
    """Choose predictors worth a panel: the best, the baseline, the law, and the best criterion."""
    order = list(summary["predictor"])
    criteria = [n for n in order if n in {p.name for p in CRITERIA} and not n.startswith(EFFORT)]
    wanted = (order[0], BASELINE, "regression on hand pose", criteria[0], EFFORT, EFFORT_PASSIVE)
    return [n for n in dict.fromkeys(wanted) if n in order]


def _person(ax: Axes, place: int, part: pd.DataFrame, colour: str) -> None:
    if not len(part):
        return
    low, high = (
        float(np.rad2deg(np.nanmedian(part[k].to_numpy(dtype=float))))
        for k in ("feasible_low", "feasible_high")
    )
    ax.plot([place, place], [low, high], color=GREY, linewidth=5, alpha=0.35)
    angles = np.rad2deg(part["natural"].to_numpy(dtype=float))
    ax.plot(np.full(len(angles), place), angles, "o", color=colour, markersize=3.5, alpha=0.8)


def _broken(name: str) -> str:
    """Break a long name into two lines."""
    if len(name) < 24:
        return name
    head, _, tail = name.partition(", ")
    return f"{head},\n{tail}" if tail else name
