"""Pictures of planned and performed movements: [Tommasino2017] Figs 3 to 8.

What people did is drawn in full lines with bands of one standard deviation; what the model
predicts in dashed lines. The path of the hand has the colour of the task, joints have their own.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.methods.curvature import MeanTests
from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.report.theme import (
    BAND,
    BASELINE,
    INK,
    TASK,
    joint_colour,
    legend_below,
    new_figure,
    themed,
    words,
    zero_line,
)
from selfmotion.studies.center_out import DIRECTIONS, NAMES, RADIUS, target_places
from selfmotion.studies.tommasino2017 import MOVEMENTS, Comparison, Movements

# Inbound movements, beside the task colour of outbound ones: the same hue, lighter.
BACK = "#7FBEE0"
COLOURS = {"outbound": TASK, "inbound": BACK}
# Targets whose movements Fig 7 shows.
SHOWN_TARGETS = ("E", "W")
# Nearer than this to the straight line (m) a path is on no side of it.
ON_LINE = 1e-6


@themed
def planned_movements_figure(motion: PlannedMotion) -> Figure:
    """Draw paths, joint angles and speed of 16 planned movements (Fig 3)."""
    figure, axes = new_figure(1, 3, size=(9.6, 3.6))
    paths, joints, speed = axes[0]
    _targets(paths)
    for i in range(len(motion)):
        direction = DIRECTIONS[i // len(NAMES)]
        label = direction if i % len(NAMES) == 0 else None
        paths.plot(*motion.x[i].T, color=COLOURS[direction], label=label)
        speed.plot(motion.time, motion.speed[i], color=COLOURS[direction], linewidth=1.0)
    paths.set_title("Paths on the screen")
    paths.legend(loc="upper left", bbox_to_anchor=(-0.05, -0.12), ncols=2)
    for j, joint in enumerate(motion.joints):
        for i in range(len(NAMES)):
            angle = np.degrees(motion.q[i, :, j])
            label = words(joint) if i == 0 else None
            joints.plot(motion.time, angle, color=joint_colour(j), linewidth=1.0, label=label)
    joints.set_title("Joints, outbound")
    joints.set_xlabel("time (s)")
    joints.set_ylabel("angle (°)")
    joints.legend(loc="upper left", bbox_to_anchor=(-0.05, -0.18), ncols=3, columnspacing=1.0)
    speed.set_title("Speed")
    speed.set_xlabel("time (s)")
    speed.set_ylabel("speed (m/s at 1 m)")
    speed.set_ylim(bottom=0.0)
    return figure


@themed
def paths_figure(comparisons: list[Comparison], titles: list[str]) -> Figure:
    """Draw mean paths with their spread, and the predicted ones, one panel a person (Fig 5).

    Thick lines: A_net differs from zero. Stars at targets: hysteresis. Both after correction.
    """
    n_columns = min(3, len(comparisons))
    n_rows = -(-len(comparisons) // n_columns)
    figure, axes = new_figure(n_rows, n_columns, size=(3.2 * n_columns, 3.3 * n_rows + 0.3))
    for ax, found, title in zip(axes.flat, comparisons, titles, strict=False):
        _targets(ax)
        for i, (name, direction) in enumerate(MOVEMENTS):
            first = i % len(NAMES) == 0
            _mean_path(ax, found.data, (name, direction), bool(found.net_tests.differs[i]))
            model = found.model.x[found.model.of(name, direction)[0]]
            label = "model" if i == 0 else None
            ax.plot(*model.T, color=INK, linewidth=0.9, linestyle="--", label=label)
            if first:
                ax.plot([], [], color=COLOURS[direction], label=direction)
        for place, star in zip(target_places(), found.hysteresis_tests.differs, strict=True):
            if star:
                ax.annotate("*", 1.15 * place, ha="center", va="center", fontsize=14)
        ax.set_title(title)
    for ax in axes.flat[len(comparisons) :]:
        ax.set_visible(False)
    legend_below(figure, axes[0, 0])
    return figure


@themed
def net_areas_of_people_figure(comparisons: list[Comparison], titles: list[str]) -> Figure:
    """Draw measured A_net with its spread beside the predicted one, one row a person (Fig 6).

    Stars: the prediction differs from the mean after correction.
    """
    n_people = len(comparisons)
    figure, axes = new_figure(
        n_people, 2, size=(7.2, 1.25 * n_people + 1.2), share_x=True, share_y=True
    )
    at = np.arange(len(NAMES))
    for row, (found, title) in enumerate(zip(comparisons, titles, strict=True)):
        tests = found.model_tests
        for column, direction in enumerate(DIRECTIONS):
            ax = axes[row, column]
            part = slice(column * len(NAMES), (column + 1) * len(NAMES))
            zero_line(ax)
            mean, sd, model = tests.mean[part], tests.sd[part], tests.against[part]
            drawn = {"color": TASK, "ecolor": INK, "error_kw": {"linewidth": 0.9}}
            ax.bar(at - 0.2, mean, 0.38, yerr=sd, label="person (mean ± SD)", **drawn)
            ax.bar(at + 0.2, model, 0.38, color=BASELINE, label="model")
            _stars(ax, tests, part)
            ax.set_title(f"{title}, {direction}")
            ax.set_xticks(at, NAMES)
        axes[row, 0].set_ylabel("A_net")
    axes[0, 0].margins(y=0.2)
    legend_below(figure, axes[0, 0])
    return figure


@themed
def joint_trajectories_figure(
    comparisons: list[Comparison], titles: list[str], joints: tuple[str, ...]
) -> Figure:
    """Draw joint angles to and from the east and the west, one row a person (Fig 7)."""
    shown = [(name, direction) for name in SHOWN_TARGETS for direction in DIRECTIONS]
    n_people = len(comparisons)
    size = (9.6, 1.5 * n_people + 1.3)
    figure, axes = new_figure(n_people, len(shown), size=size, share_x=True, share_y=True)
    for row, (found, title) in enumerate(zip(comparisons, titles, strict=True)):
        for ax, movement in zip(axes[row], shown, strict=True):
            _joint_angles(ax, found, movement, joints)
        axes[row, 0].set_ylabel(f"{title}\nangle (°)")
    for ax, (name, direction) in zip(axes[0], shown, strict=True):
        ax.set_title(f"centre to {name}" if direction == "outbound" else f"{name} to centre")
    for ax in axes[-1]:
        ax.set_xlabel("movement (%)")
    axes[0, 0].plot([], [], color=INK, linestyle="--", label="model")
    legend_below(figure, axes[0, 0])
    return figure


@themed
def areas_figure(motion: PlannedMotion, name: str = "NE") -> Figure:
    """Draw the areas right and left of the way out to a target and back (Fig 4)."""
    figure, axes = new_figure(1, len(DIRECTIONS), size=(7.2, 3.0), share_y=True)
    for ax, direction in zip(axes[0], DIRECTIONS, strict=True):
        path = motion.x[DIRECTIONS.index(direction) * len(NAMES) + NAMES.index(name)]
        along = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
        s, left = (path - path[0]) @ along, (path - path[0]) @ [-along[1], along[0]]
        ax.axhline(0.0, color=BASELINE, linewidth=1.0, linestyle=":", label="straight line")
        ax.plot(100.0 * s, 100.0 * left, color=COLOURS[direction], label="path")
        for side, hatch, label in ((left < -ON_LINE, None, "A_R"), (left > ON_LINE, "//", "A_L")):
            ax.fill_between(
                100.0 * s,
                0.0,
                100.0 * left,
                where=side.tolist(),
                color=COLOURS[direction],
                alpha=BAND,
                hatch=hatch,
                linewidth=0,
                label=label if side.any() else None,
            )
        ax.set_title(f"centre to {name}" if direction == "outbound" else f"{name} to centre")
        ax.set_xlabel("along the line (cm)")
    axes[0, 0].set_ylabel("to the left of it (cm)")
    legend_below(figure, axes[0, 0])
    return figure


@themed
def speed_figure(found: Comparison) -> Figure:
    """Draw speed profiles by target, measured and predicted, from onset to offset (Fig 8)."""
    figure, axes = new_figure(2, 4, size=(9.6, 4.4), share_x=True, share_y=True)
    for ax, name in zip(axes.flat, NAMES, strict=True):
        for direction in DIRECTIONS:
            data = found.data.speed[found.data.of(name, direction)]
            u = np.linspace(0.0, 100.0, data.shape[1])
            mean, sd = data.mean(axis=0), data.std(axis=0)
            colour = COLOURS[direction]
            ax.fill_between(u, mean - sd, mean + sd, color=colour, alpha=BAND, linewidth=0)
            ax.plot(u, mean, color=colour, label=direction)
            model = found.model.speed[found.model.of(name, direction)[0]]
            ax.plot(u, model, color=colour, linestyle="--", label=f"{direction}, model")
        ax.set_title(name)
        ax.set_ylim(bottom=0.0)
    for ax in axes[1]:
        ax.set_xlabel("movement (%)")
    for ax in axes[:, 0]:
        ax.set_ylabel("speed (m/s at 1 m)")
    legend_below(figure, axes[0, 0])
    return figure


def _targets(ax: Axes) -> None:
    """Draw the nine targets with equal scales and without a frame."""
    places = np.concatenate([[[0.0, 0.0]], target_places()])
    ax.plot(*places.T, "o", color=BASELINE, markersize=5, zorder=0.5)
    for name, place in zip(NAMES, target_places(), strict=True):
        ax.annotate(name, 1.36 * place, ha="center", va="center", fontsize=8, color=INK)
    limit = 1.5 * RADIUS
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    ax.grid(visible=False)
    ax.set_axis_off()


def _mean_path(ax: Axes, data: Movements, movement: tuple[str, str], thick: bool) -> None:
    """Draw the mean path of one movement with a band of one standard deviation across it."""
    some = data.x[data.of(*movement)]
    if not len(some):
        return
    mean, colour = some.mean(axis=0), COLOURS[movement[1]]
    along = np.gradient(mean, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    sd = np.einsum("bsi,si->bs", some - mean, across).std(axis=0)[:, None]
    outline = np.concatenate([mean + sd * across, (mean - sd * across)[::-1]])
    ax.fill(*outline.T, color=colour, alpha=BAND, linewidth=0)
    ax.plot(*mean.T, color=colour, linewidth=2.8 if thick else 1.2)


def _joint_angles(
    ax: Axes, found: Comparison, movement: tuple[str, str], joints: tuple[str, ...]
) -> None:
    """Draw the joints' mean angles with a band of one standard deviation, and the model's."""
    data = found.data.q[found.data.of(*movement)]
    model = found.model.q[found.model.of(*movement)[0]]
    u = np.linspace(0.0, 100.0, data.shape[1])
    for j, joint in enumerate(joints):
        mean, sd = np.degrees(data[:, :, j].mean(axis=0)), np.degrees(data[:, :, j].std(axis=0))
        colour = joint_colour(j)
        ax.fill_between(u, mean - sd, mean + sd, color=colour, alpha=BAND, linewidth=0)
        ax.plot(u, mean, color=colour, label=words(joint))
        ax.plot(u, np.degrees(model[:, j]), color=colour, linestyle="--")


def _stars(ax: Axes, tests: MeanTests, part: slice) -> None:
    """Mark the movements in which the model differs."""
    top = np.nanmax(np.abs(tests.mean[part]) + np.nan_to_num(tests.sd[part]))
    for i, (differs, mean, sd) in enumerate(
        zip(tests.differs[part], tests.mean[part], tests.sd[part], strict=True)
    ):
        if differs:
            ax.annotate("*", (i - 0.2, max(mean + sd, 0.0) + 0.03 * top), ha="center", fontsize=13)
