"""Pictures of a study: joint angles over the movement, and who does the work by person."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.motion.filters import normalise_time
from selfmotion.motion.recording import Study
from selfmotion.report.theme import (
    condition_line,
    joint_colour,
    legend_below,
    new_figure,
    themed,
    words,
    zero_line,
)

N_POINTS = 101
COLUMNS = 3


@themed
def angle_bands_figure(study: Study) -> Figure:
    """Draw each joint's angle over 0 to 100 % of the movement: mean and spread over people.

    Each person's repeats are averaged first; the band is one standard deviation over people, or
    over movements where there is one person. Conditions differ by line style.
    """
    joints = study.joints
    rows = -(-len(joints) // COLUMNS)
    figure, axes = new_figure(rows, COLUMNS, size=(7.2, 1.0 + 1.7 * rows), share_x=True)
    percent = np.linspace(0.0, 100.0, N_POINTS)
    for c, (condition, part) in enumerate(study.group("condition").items()):
        curves = _curves(part)
        mean, spread = curves.mean(axis=0), curves.std(axis=0)
        for i in range(len(joints)):
            ax = axes.flat[i]
            label = str(condition[0] or "all movements") if i == 0 else None
            ax.plot(
                percent, mean[:, i], color=joint_colour(i), linestyle=condition_line(c), label=label
            )
            low, high = mean[:, i] - spread[:, i], mean[:, i] + spread[:, i]
            ax.fill_between(percent, low, high, color=joint_colour(i), alpha=0.15, linewidth=0)
    for i, ax in enumerate(axes.flat):
        ax.set_visible(i < len(joints))
        if i < len(joints):
            ax.set_title(words(joints[i]))
            zero_line(ax)
    figure.supxlabel("movement (%)")
    figure.supylabel("angle (deg)")
    legend_below(figure, axes.flat[0])
    return figure


@themed
def contribution_radar(estimates: Mapping[tuple[str, str, str], WeightEstimate]) -> Figure:
    """Draw the contributions of each joint on spokes, one line a person, one panel a condition.

    Joints that were not identified have no point; a person without any is left out.
    """
    conditions = list(dict.fromkeys((side, name) for _, side, name in estimates))
    columns = min(len(conditions), COLUMNS)
    rows = -(-len(conditions) // columns)
    figure = Figure(figsize=(2.6 * columns, 0.6 + 2.7 * rows), layout="constrained")
    joints = next(iter(estimates.values())).joints
    angle = np.linspace(0.0, 2.0 * np.pi, len(joints), endpoint=False)
    for panel, (side, name) in enumerate(conditions):
        ax = figure.add_subplot(rows, columns, panel + 1, projection="polar")
        people = [(k[0], e) for k, e in estimates.items() if k[1:] == (side, name)]
        for i, (person, estimate) in enumerate(people):
            if np.isfinite(estimate.contribution).any():
                ax.plot(
                    np.append(angle, angle[0]),
                    np.append(estimate.contribution, estimate.contribution[0]),
                    color=joint_colour(i),
                    marker="o",
                    markersize=2.5,
                    label=person,
                )
        ax.set_title(f"{name or 'all movements'} {side}".strip())
        ax.set_xticks(angle, [words(joint) for joint in joints], fontsize=5.5)
        ax.set_ylim(0.0, 1.0)
        ax.set_yticks([0.5, 1.0], ["", ""])
    return figure


def _curves(study: Study) -> np.ndarray:
    """Give mean curves (people, points, joints) in degrees; (movements, ...) for one person."""
    people = study.group("subject")
    groups = [list(part) for part in people.values()]
    if len(groups) == 1:
        groups = [[recording] for recording in groups[0]]
    return np.stack(
        [
            np.rad2deg(np.nanmean([normalise_time(r, N_POINTS).array("q") for r in group], axis=0))
            for group in groups
        ]
    )
