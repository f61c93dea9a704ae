"""Pictures of convergence: the numerical examples of [Khoramshahi2022] and anyone's own fit."""

import matplotlib
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from selfmotion.report.theme import (
    BAND,
    BASELINE,
    INK,
    condition_line,
    condition_marker,
    joint_colour,
    joint_dash,
    legend_below,
    new_figure,
    themed,
    words,
)
from selfmotion.studies.results import Convergence, NoiseSweep, Sweep

# Perceptually even map for γ from 0 to 1; the ends are left out (too dark, too pale).
GAMMA_MAP = ("viridis", 0.25, 0.92)
GAMMA_TICKS = (0.05, 0.1, 0.2, 0.5, 1.0)
NOISE_NAMES = {
    "projected": "noise projected (eq. 15)",
    "not projected": "noise not projected (as in Fig 1)",
}
# Iterations that the panels of Fig 3 show; later ones look the same.
SHOWN = 200
METHOD_NAMES = {
    "ml": "maximum likelihood",
    "paper": "Algorithm 1 (paper)",
    "feedback": "ML with posture feedback",
}


@themed
def convergence_figure(run: Convergence) -> Figure:
    """Draw the weights from iteration to iteration, mean and spread over repeats (Fig 1)."""
    figure, axes = new_figure(size=(6.0, 3.6))
    ax = axes[0, 0]
    iterations = np.arange(run.weights.shape[1])
    mean, sd = run.weights.mean(axis=0), run.weights.std(axis=0)
    for i, true in enumerate(run.truth):
        colour = joint_colour(i)
        ax.fill_between(
            iterations,
            mean[:, i] - sd[:, i],
            mean[:, i] + sd[:, i],
            color=colour,
            alpha=BAND,
            linewidth=0,
        )
        ax.plot(iterations, mean[:, i], joint_dash(i), color=colour, label=f"$w_{i + 1}$")
        ax.axhline(true, color=colour, linewidth=0.8, linestyle=":")
    ax.plot([], [], color=BASELINE, linewidth=0.8, linestyle=":", label="true weight")
    repeats = len(run.weights)
    ax.set_title(f"{run.label}; mean ± SD of {repeats} repeats" if repeats > 1 else run.label)
    _iteration_axis(ax, len(iterations))
    ax.set_ylabel("weight (largest = 1)")
    ax.set_ylim(0.0, 1.08)
    legend_below(figure, ax, columns=6)
    return figure


@themed
def gamma_figure(sweep: Sweep) -> Figure:
    """Draw the weight error against iterations, one line a γ (Fig 2)."""
    figure, axes = new_figure(size=(6.4, 3.6))
    ax = axes[0, 0]
    for gamma, run in zip(sweep.gammas, sweep.runs, strict=True):
        error = run.error.mean(axis=0)
        ax.plot(np.arange(len(error)), error, color=_gamma_colour(gamma), label=f"γ = {gamma:g}")
    ax.set_yscale("log")
    ax.set_yticks(GAMMA_TICKS, labels=[f"{tick:g}" for tick in GAMMA_TICKS])
    ax.minorticks_off()
    ax.set_xlim(0, min(200, sweep.runs[0].weights.shape[1] - 1))
    ax.set_xlabel("iteration")
    ax.set_ylabel("‖weights − true weights‖")
    figure.legend(loc="outside right center")
    return figure


@themed
def two_joint_figure(sweep: Sweep) -> Figure:
    """Draw both weights against iterations, one panel a γ (Fig 3)."""
    n_columns = min(4, len(sweep.runs))
    n_rows = -(-len(sweep.runs) // n_columns)
    figure, axes = new_figure(
        n_rows, n_columns, size=(7.6, 1.95 * n_rows + 0.5), share_x=True, share_y=True
    )
    for ax in axes.flat[len(sweep.runs) :]:
        ax.set_visible(False)
    for ax, run in zip(axes.flat, sweep.runs, strict=False):
        history = run.weights[0]
        for i, true in enumerate(run.truth):
            colour = joint_colour(i)
            ax.axhline(true, color=colour, linewidth=0.8, linestyle=":")
            line = "-" if i == 0 else "--"
            ax.plot(history[:, i], line, color=colour, linewidth=1.1, label=f"$w_{i + 1}$")
        ax.set_title(run.label)
        ax.set_ylim(-0.04, 1.08)
        ax.set_xlim(0, min(SHOWN, len(history) - 1))
        ax.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    first = axes.flat[0]
    first.plot([], [], color=BASELINE, linewidth=0.8, linestyle=":", label="true weight")
    for ax in axes[:, 0]:
        ax.set_ylabel("weight")
    for column in range(n_columns):
        shown = [ax for ax in axes[:, column] if ax.get_visible()]
        shown[-1].set_xlabel("iteration")
        shown[-1].tick_params(labelbottom=True)
    legend_below(figure, first)
    return figure


@themed
def noise_figure(sweep: NoiseSweep) -> Figure:
    """Draw the error of each estimator against the null-space noise σ."""
    kinds = list(dict.fromkeys(sweep.table["noise"]))
    figure, axes = new_figure(1, len(kinds), size=(7.2, 3.5), share_y=True)
    for ax, kind in zip(axes[0], kinds, strict=True):
        part = sweep.table[sweep.table["noise"] == kind]
        for i, method in enumerate(dict.fromkeys(part["method"])):
            rows = part[part["method"] == method]
            ax.errorbar(
                rows["sigma"],
                rows["error"],
                rows["sd"],
                color=INK if i == 0 else BASELINE,
                linestyle=condition_line(i),
                marker=condition_marker(i),
                capsize=2,
                elinewidth=0.8,
                label=METHOD_NAMES.get(str(method), str(method)),
            )
        ax.set_title(NOISE_NAMES.get(str(kind), words(str(kind))))
        ax.set_xlabel("null-space noise σ (rad/s)")
    axes[0, 0].set_ylabel("‖weights − true weights‖")
    axes[0, 0].set_ylim(bottom=0.0)
    legend_below(figure, axes[0, 0])
    return figure


@themed
def fit_history_figure(
    history: Float[np.ndarray, "iterations joints"], joints: tuple[str, ...], *, method: str = ""
) -> Figure:
    """Draw the weights of one fit from iteration to iteration, on a logarithmic axis.

    Args:
        history: weights after each iteration, the start first; NaN is left out.
        joints: names (n).
        method: name of the estimator, for the title.
    """
    figure, axes = new_figure(size=(6.0, 3.4))
    ax = axes[0, 0]
    for i, joint in enumerate(joints):
        if np.isfinite(history[:, i]).any():
            ax.plot(
                history[:, i],
                joint_dash(i),
                color=joint_colour(i),
                marker="." if len(history) <= 30 else None,
                label=words(joint),
            )
    ax.set_yscale("log")
    _iteration_axis(ax, len(history))
    ax.set_ylabel("weight (largest = 1)")
    if method:
        ax.set_title(METHOD_NAMES.get(method, method))
    legend_below(figure, ax, columns=4)
    return figure


def _iteration_axis(ax: Axes, n_iterations: int) -> None:
    ax.set_xlabel("iteration")
    ax.set_xlim(0, max(1, n_iterations - 1))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))


def _gamma_colour(gamma: float) -> tuple[float, float, float, float]:
    name, low, high = GAMMA_MAP
    return matplotlib.colormaps[name](low + (high - low) * gamma)
