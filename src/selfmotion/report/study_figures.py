"""Pictures of a study: joint angles over the movement, and who does the work by person."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from selfmotion.errors import RangeError
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.motion.filters import normalise_time
from selfmotion.motion.recording import Study
from selfmotion.report.study_people_figures import label_bottom
from selfmotion.report.theme import (
    condition_line,
    joint_colour,
    joint_dash,
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
    label_bottom(axes, len(joints), "movement (%)")
    for ax in axes[:, 0]:
        ax.set_ylabel("angle (deg)")
    legend_below(figure, axes.flat[0])
    return figure


@themed
def contribution_radar(estimates: Mapping[tuple[str, str, str], WeightEstimate]) -> Figure:
    """Draw the contributions of each joint on spokes, one line a person, one panel a condition.

    Joints and panels in which nothing was identified are left out.

    Raises:
        RangeError: that is all of them.
    """
    found = {k: e for k, e in estimates.items() if np.isfinite(e.contribution).any()}
    if not found:
        raise RangeError("contributions: none was identified, nothing to draw")
    subjects = list(dict.fromkeys(key[0] for key in estimates))
    panels = list(dict.fromkeys(key[1:] for key in found))
    columns = min(len(panels), COLUMNS)
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(2.6 * columns, 0.9 + 2.5 * rows), layout="constrained")
    joints = next(iter(found.values())).joints
    known = np.isfinite(np.stack([e.contribution for e in found.values()])).any(axis=0)
    drawn = [joints[i] for i in np.flatnonzero(known)]
    angle = np.linspace(0.0, 2.0 * np.pi, len(drawn), endpoint=False)
    names = [words(joint).replace(" ", "\n", 1) for joint in drawn]
    axes = []
    for panel, (side, name) in enumerate(panels):
        ax = figure.add_subplot(rows, columns, panel + 1, projection="polar")
        for (subject, *of), estimate in found.items():
            if tuple(of) == (side, name):
                place, share = subjects.index(subject), estimate.contribution[known]
                ax.plot(
                    np.append(angle, angle[0]),
                    np.append(share, share[0]),
                    color=joint_colour(place),
                    linestyle=joint_dash(place),
                    linewidth=1.2,
                    marker="o",
                    markersize=2.5,
                )
        ax.set_title(f"{name or 'all movements'}, {side}" if side else name, fontsize=8.0)
        ax.set_xticks(angle, names, fontsize=5.5)
        ax.tick_params(axis="x", pad=5)
        ax.set_ylim(0.0, 1.0)
        ax.set_yticks([0.5, 1.0], ["0.5", "1"], fontsize=5.5)
        axes.append(ax)
    for place, subject in enumerate(subjects):  # one legend, whoever is in the first panel
        axes[0].plot(
            [], [], color=joint_colour(place), linestyle=joint_dash(place), label=subject or "all"
        )
    legend_below(figure, axes[0], columns=4)
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
