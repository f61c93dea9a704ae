"""Pictures of IK weights: people as points, contributions, and what the data can tell."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import stdtrit  # scipy.stats takes a second to import

from selfmotion.errors import ShapeError
from selfmotion.report.theme import (
    BASELINE,
    INK,
    condition_marker,
    joint_colour,
    legend_below,
    new_figure,
    themed,
    words,
)

# Half-width of the place of one joint in which its conditions stand, axis units.
SPREAD = 0.32
# Share of the height kept free below the points.
FOOT = 0.16
# Text of a joint whose weight the data cannot tell.
NOT_IDENTIFIED = "not\nidentified"
NEEDED = ("subject", "condition", "joint", "weight", "identified")


@themed
def weights_figure(
    table: pd.DataFrame, *, truth: Mapping[str, tuple[float, ...]] | None = None
) -> Figure:
    """Draw weights with people as points, and mean with 95 % interval (Figs 6 and 9).

    Joints stand side by side, conditions beside each other within a joint. The axis is
    logarithmic, since only ratios of weights mean anything; the mean is geometric, its interval
    that of the mean log-weight over people (with one person: from the standard error). A joint
    that is not identified gets words in place of points.

    Args:
        table: columns subject, condition, joint, weight, identified, and stderr_log where known.
        truth: condition to weights in joint order, drawn as a short bar.
    """
    _check(table)
    joints = list(dict.fromkeys(table["joint"]))
    conditions = list(dict.fromkeys(table["condition"]))
    figure, axes = new_figure(size=(_width(len(joints), len(conditions)), 3.8))
    ax = axes[0, 0]
    for j, joint in enumerate(joints):
        if j:
            ax.axvline(j - 0.5, color=BASELINE, linewidth=0.5, alpha=0.5)
        rows = table.loc[table["joint"] == joint]
        if not bool(np.any(rows["identified"])):
            ax.text(
                j,
                0.5,
                NOT_IDENTIFIED,
                transform=ax.get_xaxis_transform(),
                ha="center",
                va="center",
                color=BASELINE,
                style="italic",
            )
            continue
        for c, condition in enumerate(conditions):
            part = rows.loc[rows["condition"] == condition]
            place = j + _offset(c, len(conditions))
            _draw_people(ax, place, part, joint_colour(j), condition_marker(c))
            if truth is not None and condition in truth:
                ax.hlines(truth[condition][j], place - 0.09, place + 0.09, color=INK, linewidth=1)
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    ax.set_ylim(low * (low / high) ** FOOT, high)  # room for words below the points
    ax.set_xticks(range(len(joints)), labels=[words(str(j)).replace(" ", "\n", 1) for j in joints])
    ax.set_xlim(-0.5, len(joints) - 0.5)
    ax.set_ylabel("IK weight (largest = 1)")
    _condition_legend(figure, ax, conditions, with_truth=truth is not None)
    return figure


def _width(n_joints: int, n_conditions: int) -> float:
    """Give a width (inches) in which points and words do not touch."""
    return min(10.0, max(4.6, 1.0 + n_joints * (0.7 + 0.4 * n_conditions)))


def _draw_people(ax: Axes, place: float, part: pd.DataFrame, colour: str, marker: str) -> None:
    known = part.loc[np.asarray(part["identified"], dtype=bool)]
    missing = len(part) - len(known)
    if missing and len(part):
        ax.text(
            place,
            0.01,
            "not\nidentified" if missing == len(part) else f"{missing}/{len(part)} not\nidentified",
            transform=ax.get_xaxis_transform(),
            ha="center",
            va="bottom",
            color=BASELINE,
            fontsize=6.5,
        )
    if known.empty:
        return
    values = np.asarray(known["weight"], dtype=float)
    # A fixed pattern instead of random jitter: the picture is the same each time.
    sideways = 0.075 * (np.arange(len(values)) * 0.618 % 1.0 - 0.5)
    if len(values) > 1:
        ax.plot(
            place - 0.05 + sideways, values, marker, color=colour, alpha=0.45, ms=3.5, mew=0, ls=""
        )
    centre, low, high = _centre(known)
    ax.errorbar(
        [place + 0.06],
        [centre],
        [[centre - low], [high - centre]],
        color=INK,
        marker=marker,
        markerfacecolor=colour,
        markeredgecolor=INK,
        markeredgewidth=0.8,
        ms=6,
        capsize=2.5,
        elinewidth=1.1,
    )


def _centre(rows: pd.DataFrame) -> tuple[float, float, float]:
    """Give the geometric mean and its 95 % interval."""
    logs = np.log(np.asarray(rows["weight"], dtype=float))
    if len(logs) > 1:
        half = stdtrit(len(logs) - 1, 0.975) * logs.std(ddof=1) / np.sqrt(len(logs))
    else:
        error = float(np.asarray(rows["stderr_log"])[0]) if "stderr_log" in rows else np.nan
        half = 1.96 * error if np.isfinite(error) else 0.0
    centre = logs.mean()
    return float(np.exp(centre)), float(np.exp(centre - half)), float(np.exp(centre + half))


@themed
def contribution_figure(table: pd.DataFrame) -> Figure:
    """Draw contribution coefficients, mean over people, as one stacked bar a condition.

    Args:
        table: columns subject, condition, joint, contribution (within scale groups or as in
            eq. 26; they add up to one over the joints drawn).
    """
    joints = list(dict.fromkeys(table["joint"]))
    conditions = list(dict.fromkeys(table["condition"]))
    figure, axes = new_figure(size=(6.4, 1.3 + 0.5 * len(conditions)))
    ax = axes[0, 0]
    for row, condition in enumerate(conditions):
        start = 0.0
        for j, joint in enumerate(joints):
            here = (table["condition"] == condition) & (table["joint"] == joint)
            share = float(table.loc[here, "contribution"].mean())
            if not np.isfinite(share):
                continue
            label = words(str(joint)) if row == 0 else None
            ax.barh(row, share, left=start, height=0.62, color=joint_colour(j), label=label)
            if share >= 0.07:
                ax.text(
                    start + share / 2,
                    row,
                    f"{share:.2f}",
                    ha="center",
                    va="center",
                    color=_ink_on(joint_colour(j)),
                )
            start += share
    ax.set_yticks(range(len(conditions)), labels=[words(str(c)) for c in conditions])
    ax.invert_yaxis()
    ax.set_xlim(0.0, 1.0)
    ax.grid(False)
    ax.set_xlabel("contribution β (shares that add up to 1)")
    legend_below(figure, ax, columns=4)
    return figure


@themed
def ratio_error_figure(
    errors: Float[np.ndarray, "joints joints"], joints: tuple[str, ...], *, limit: float = 1.0
) -> Figure:
    """Draw the standard error of every log-ratio: which pairs of joints the data can compare.

    Args:
        errors: standard errors (n, n); infinite where nothing can be said.
        joints: names (n).
        limit: largest error at which a ratio counts as identified.
    """
    n = len(joints)
    if errors.shape != (n, n):
        raise ShapeError(f"errors have shape {errors.shape}; expected ({n}, {n})")
    figure, axes = new_figure(size=(2.6 + 0.55 * n, 1.7 + 0.42 * n))
    ax = axes[0, 0]
    for i in range(n):
        for j in range(i):
            known = bool(errors[i, j] <= limit)
            ax.add_patch(_cell(j, i, known))
            ax.text(
                j,
                i,
                f"{errors[i, j]:.2g}" if np.isfinite(errors[i, j]) else "–",
                ha="center",
                va="center",
                color=_ink_on(_KNOWN) if known else INK,
                fontsize=8,
            )
    names = [words(joint) for joint in joints]
    ax.set_xlim(-0.5, n - 1.5)
    ax.set_ylim(n - 0.5, 0.5)
    ax.set_xticks(range(n - 1), labels=names[:-1], rotation=35, ha="right")
    ax.set_yticks(range(1, n), labels=names[1:])
    ax.grid(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    ax.tick_params(length=0)
    figure.suptitle(
        f"standard error of log-ratio\n(filled: ≤ {limit:g}, identified)",
        fontsize=9,
        x=0.02,
        ha="left",
    )
    return figure


_KNOWN = "#56B4E9"


def _cell(x: float, y: float, known: bool):  # noqa: ANN202
    from matplotlib.patches import Rectangle

    return Rectangle(
        (x - 0.47, y - 0.47),
        0.94,
        0.94,
        facecolor=_KNOWN if known else "none",
        edgecolor=BASELINE,
        linewidth=0.6,
        hatch=None if known else "////",
        alpha=None if known else 0.5,
    )


def _offset(index: int, count: int) -> float:
    return 0.0 if count == 1 else SPREAD * (2.0 * index / (count - 1) - 1.0)


def _ink_on(colour: str) -> str:
    """Give black or white, whichever reads better on a colour."""
    red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return "#000000" if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.32 else "#FFFFFF"


def _condition_legend(figure: Figure, ax: Axes, conditions: list, *, with_truth: bool) -> None:
    for c, condition in enumerate(conditions):
        if len(conditions) > 1:
            ax.plot(
                [], [], condition_marker(c), color=BASELINE, mec=INK, label=words(str(condition))
            )
    if with_truth:
        ax.plot([], [], "-", color=INK, linewidth=1, label="true (centre of the people)")
    legend_below(figure, ax)


def _check(table: pd.DataFrame) -> None:
    missing = [name for name in NEEDED if name not in table]
    if missing:
        raise ShapeError(f"table of weights: column(s) {', '.join(missing)} are missing")
