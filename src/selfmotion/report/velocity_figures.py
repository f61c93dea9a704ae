"""Pictures of joint velocities over a movement: conditions, task space, null space."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from selfmotion.methods.velocity_split import VelocityBands
from selfmotion.report.theme import (
    BAND,
    BASELINE,
    NULL,
    TASK,
    condition_line,
    joint_colour,
    joint_dash,
    legend_below,
    new_figure,
    themed,
    words,
    zero_line,
)
from selfmotion.studies.results import NullSpeeds, SplitBands

UNIT = "(rad/s)"
# Panels show at least this much either side of zero (rad/s): smaller is rounding, not motion.
LEAST_RANGE = 0.02
PROGRESS = "movement (%)"


@dataclass(frozen=True)
class _Look:
    colour: str
    line: str
    label: str | None


@themed
def velocity_figure(
    bands: Mapping[tuple[str, ...], VelocityBands], conditions: Sequence[str]
) -> Figure:
    """Draw joint velocities, targets in columns and conditions in rows (Fig 5).

    Args:
        bands: by target and condition.
        conditions: in the order of the rows.
    """
    targets = list(dict.fromkeys(target for target, _ in bands))
    size = (2.3 * len(targets) + 1.0, 1.9 * len(conditions) + 0.7)
    figure, axes = new_figure(len(conditions), len(targets), size=size, share_x=True, share_y=True)
    for r, condition in enumerate(conditions):
        for c, target in enumerate(targets):
            ax = axes[r, c]
            one = bands.get((target, condition))
            for j, joint in enumerate(one.joints if one is not None else ()):
                assert one is not None
                _band(ax, one, "total", j, _Look(joint_colour(j), joint_dash(j), words(joint)))
            zero_line(ax)
            ax.set_title(f"{words(condition)}: {words(target)}")
        axes[r, 0].set_ylabel(f"joint velocity {UNIT}")
    _progress(axes[-1])
    legend_below(figure, axes[0, 0], columns=4)
    return figure


@themed
def null_velocity_figure(speeds: NullSpeeds, conditions: Sequence[str]) -> Figure:
    """Draw all velocity, and its null-space part with own weights and with W = I (Fig 7).

    Joints in rows; conditions differ by line style.
    """
    joints = next(iter(speeds.panels.values())).joints
    columns = (
        ("identified", "total", "joint velocity"),
        ("identified", "null", "null space, identified W"),
        ("identity", "null", "null space, W = I"),
    )
    figure, axes = new_figure(len(joints), 3, size=(7.4, 1.35 * len(joints) + 0.8), share_x=True)
    for j, joint in enumerate(joints):
        for k, (kind, part, title) in enumerate(columns):
            ax = axes[j, k]
            colour = (joint_colour(j), NULL, BASELINE)[k]
            for c, condition in enumerate(conditions):
                look = _Look(colour, condition_line(c), None)
                _band(ax, speeds.panels[condition, kind], part, j, look)
            zero_line(ax)
            if j == 0:
                ax.set_title(title)
        axes[j, 1].sharey(axes[j, 2])
        _widen(axes[j, 2])
        axes[j, 0].set_ylabel(f"{words(joint).replace(' ', chr(10), 1)}\n{UNIT}")
    figure.align_ylabels(axes[:, 0])
    _progress(axes[-1])
    for c, condition in enumerate(conditions):
        axes[0, 0].plot([], [], condition_line(c), color=BASELINE, label=words(condition))
    legend_below(figure, axes[0, 0])
    return figure


@themed
def split_figure(bands: SplitBands) -> Figure:
    """Draw task and null-space velocity of each joint, with weights in colour, W = I grey.

    Args:
        bands: from `velocity_profiles.split_bands`.
    """
    identity, identified = bands.identity, bands.identified
    n = len(identity.joints)
    figure, axes = new_figure(n, 2, size=(6.8, 1.4 * n + 0.9), share_x=True, share_y="row")
    for j, joint in enumerate(identity.joints):
        for k, (part, colour) in enumerate((("task", TASK), ("null", NULL))):
            ax = axes[j, k]
            zero_line(ax)
            _band(ax, identity, part, j, _Look(BASELINE, "--", "W = I"))
            if identified is not None:
                label = f"{part.replace('null', 'null-space')} velocity, these weights"
                _band(ax, identified, part, j, _Look(colour, "-", label))
        axes[j, 0].set_ylabel(f"{words(joint).replace(' ', chr(10), 1)}\n{UNIT}")
        _widen(axes[j, 0])
    figure.align_ylabels(axes[:, 0])
    axes[0, 0].set_title("task")
    axes[0, 1].set_title("null space")
    _progress(axes[-1])
    handles = {}
    for ax in (axes[0, 0], axes[0, 1]):
        found = ax.get_legend_handles_labels()
        handles |= {text: handle for handle, text in zip(*found, strict=True)}
    figure.legend(
        list(handles.values()), list(handles), loc="outside lower center", ncols=len(handles)
    )
    return figure


@themed
def null_share_figure(speeds: NullSpeeds, conditions: Sequence[str]) -> Figure:
    """Draw each person's null-space speed with identified weights and with W = I."""
    figure, axes = new_figure(
        1, len(conditions), size=(2.5 * len(conditions) + 0.6, 3.2), share_y=True
    )
    table = speeds.table
    for ax, condition in zip(axes[0], conditions, strict=True):
        part = table[table["condition"] == condition]
        wide = part.pivot(index="subject", columns="weights", values="rms")
        for _, row in wide.iterrows():
            ax.plot([0, 1], [row["identified"], row["identity"]], color=BASELINE, lw=0.7, alpha=0.7)
        ax.plot([0] * len(wide), wide["identified"], "o", color=NULL, label="identified W")
        ax.plot([1] * len(wide), wide["identity"], "o", color=BASELINE, label="W = I")
        ax.set_xticks([0, 1], labels=["identified W", "W = I"])
        ax.set_xlim(-0.4, 1.4)
        ax.set_title(words(condition))
    axes[0, 0].set_ylabel("null-space speed, rms (rad/s)")
    axes[0, 0].set_ylim(bottom=0.0)
    return figure


def _band(ax: Axes, bands: VelocityBands, part: str, joint: int, look: _Look) -> None:
    percent, mean = 100.0 * bands.phase, bands.mean[part][:, joint]
    sd = np.nan_to_num(bands.spread[part][:, joint])  # one trial has no spread
    ax.fill_between(percent, mean - sd, mean + sd, color=look.colour, alpha=BAND, linewidth=0)
    ax.plot(percent, mean, look.line, color=look.colour, label=look.label)


def _widen(ax: Axes) -> None:
    """Keep a panel without motion from showing rounding errors, magnified."""
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -LEAST_RANGE), max(high, LEAST_RANGE))


def _progress(axes: Iterable[Axes]) -> None:
    for ax in axes:
        ax.set_xlim(0, 100)
        ax.set_xticks([0, 25, 50, 75, 100])
        ax.set_xlabel(PROGRESS)
