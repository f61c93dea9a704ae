"""Pictures of a person's workspace: ranges against norms, regions, and cuts with the body.

What is kept is blue, what is lost orange; joints have their colours, and a triangle points up for
an upper limit, down for a lower one.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.spatial import KDTree

from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.methods.reaching.boundary import BODY
from selfmotion.methods.reaching.regions import RegionReach
from selfmotion.methods.reaching.sections import FORWARD, RIGHT, UP, PlaneCut
from selfmotion.report.theme import (
    BASELINE,
    INK,
    NULL,
    TASK,
    joint_colour,
    new_figure,
    themed,
    words,
)
from selfmotion.report.workspace_words import bound_title, joint_title

KEPT, LOST = TASK, NULL
LABELS = {RIGHT: "to the right (cm)", FORWARD: "forward (cm)", UP: "up (cm)"}
# Cells of a picture of a cut, and of the body's outline in it (m).
CELL, OUTLINE_CELL = 0.01, 0.01
# Beyond the last point of a cut (m).
AROUND = 0.05
COLUMNS = 3
# Room beside the longest bar (degrees).
MARGIN = 8.0


@themed
def cuts_figure(cuts: Sequence[PlaneCut], body: BodyShapes, *, cut_out: bool) -> Figure:
    """Draw what is reached and lost in vertical cuts, with the body.

    Args:
        cuts: of `body_cuts`.
        body: whose outline is drawn.
        cut_out: whether the inside of the body was left out; else it is an outline only.
    """
    figure, axes = new_figure(1, len(cuts), size=(7.2, 3.9))
    for ax, cut in zip(axes[0], cuts, strict=True):
        _filled(ax, cut)
        _body(ax, cut, body, cut_out)
        _frame(ax, cut)
    _legend(figure, cuts[0], [])
    return figure


@themed
def bounded_slices_figure(
    slices: Sequence[PlaneCut], body: BodyShapes, arm: Arm, *, cut_out: bool
) -> Figure:
    """Draw horizontal slices with the body, and in joint colours the limits that bound them."""
    n_columns = min(COLUMNS, len(slices))
    n_rows = -(-len(slices) // n_columns)
    order = _limits_used(slices)
    width = max(2.4 * n_columns, 4.2 + 0.9 * n_columns)
    low, high = _window(slices)
    tall = (high - low)[1] / (high - low)[0] * (width - 0.7) / n_columns
    height = n_rows * (tall + 0.35) + 0.8 + 0.18 * -(-(len(order) + 3) // 2)
    figure, axes = new_figure(n_rows, n_columns, size=(width, height), share_x=True, share_y=True)
    flat = axes.ravel()
    for ax, cut in zip(flat, slices, strict=False):
        _filled(ax, cut, faint=True)
        _body(ax, cut, body, cut_out)
        _limits(ax, cut)
        _frame(ax, cut)
    for ax in flat[len(slices) :]:
        ax.set_visible(False)
    flat[0].set(xlim=1e2 * np.array([low[0], high[0]]), ylim=1e2 * np.array([low[1], high[1]]))
    for i, ax in enumerate(flat[: len(slices)]):
        ax.label_outer()
        if i + n_columns >= len(slices):
            ax.tick_params(labelbottom=True)
            ax.set_xlabel(LABELS[RIGHT])
    _legend(figure, slices[0], [_limit_handle(arm, *key) for key in order])
    return figure


@themed
def regions_figure(regions: Sequence[RegionReach]) -> Figure:
    """Draw for each named region what of the free arm's share is kept and lost."""
    shown = [r for r in regions if r.sets["free"].volume > 0]
    figure, axes = new_figure(size=(7.2, 0.36 * len(shown) + 1.1))
    ax = axes[0, 0]
    for i, reach in enumerate(reversed(shown)):
        free = reach.sets["free"].volume
        kept = 100.0 * reach.sets.get("limited", reach.sets["free"]).volume / free
        ax.barh(i, kept, color=KEPT, height=0.62)
        ax.barh(i, 100.0 - kept, left=kept, color=LOST, height=0.62)
        inside = kept > 12
        ax.text(
            kept - 1.5 if inside else kept + 1.5,
            i,
            f"{kept:.0f} %",
            ha="right" if inside else "left",
            va="center",
            color="white" if inside else "black",
            fontsize=8.5,
        )
    ax.set_yticks(range(len(shown)), [_short(r.region.title) for r in reversed(shown)])
    ax.tick_params(axis="y", length=0)
    ax.set_xlim(0, 100)
    ax.set_xlabel("share of what the free arm reaches there (%)")
    ax.grid(False)
    figure.legend(
        handles=[Patch(color=KEPT, label="kept"), Patch(color=LOST, label="lost")],
        loc="outside lower center",
        ncols=2,
    )
    return figure


@themed
def ranges_figure(
    free: Arm, limited: Arm | None, norms: Mapping[str, tuple[float, float]]
) -> Figure:
    """Draw the range of each joint, free and limited, over that of healthy adults (degrees)."""
    joints = free.joints
    figure, axes = new_figure(size=(7.2, 0.36 * len(joints) + 1.1))
    ax = axes[0, 0]
    for i, joint in enumerate(reversed(joints)):
        j = free.chain.index(joint)
        if joint in norms:
            low, high = norms[joint]
            ax.barh(i, high - low, left=low, color=BASELINE, alpha=0.3, height=0.74)
        low, high = np.degrees([free.lower[j], free.upper[j]])
        if limited is None:
            ax.barh(i, high - low, left=low, color=KEPT, height=0.34)
            continue
        ax.barh(i, high - low, left=low, color=LOST, height=0.34)
        low, high = np.degrees([limited.lower[j], limited.upper[j]])
        ax.barh(i, max(high - low, 0.8), left=low, color=KEPT, height=0.34)
    ax.axvline(0.0, color=INK, lw=0.7)
    low, high = ax.get_xlim()
    ax.set_xlim(low - MARGIN, high + MARGIN)
    ax.set_yticks(range(len(joints)), [joint_title(free, j) for j in reversed(joints)])
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel("angle (degrees)")
    ax.grid(True, axis="x")
    ax.grid(False, axis="y")
    handles = [Patch(color=KEPT, label="range")]
    if limited is not None:
        handles = [Patch(color=KEPT, label="kept"), Patch(color=LOST, label="lost")]
    if norms:
        handles.append(Patch(color=BASELINE, alpha=0.3, label="95 % of healthy adults"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _plane(cut: PlaneCut) -> tuple[int, int]:
    """Give the axes that lie in a cut: across and up the page."""
    a, b = (axis for axis in (RIGHT, FORWARD, UP) if axis != cut.across)
    return a, b


def _filled(ax: Axes, cut: PlaneCut, *, faint: bool = False) -> None:
    """Fill what is kept and lost: each cell as the nearest point was decided."""
    a, b = _plane(cut)
    free = cut.regions["free"]
    local = free.points @ cut.axes
    x, y = _cells(local[:, a]), _cells(local[:, b])
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    nearest = KDTree(local[:, [a, b]]).query(grid.reshape(-1, 2))[1]
    image = np.zeros((grid.shape[0] * grid.shape[1], 4))
    kept = cut.regions.get("limited", free).inside[nearest]
    image[kept] = to_rgba(KEPT, 0.35 if faint else 0.75)
    if "lost" in cut.regions:
        image[cut.regions["lost"].inside[nearest]] = to_rgba(LOST, 0.45 if faint else 0.8)
    half = 0.5 * CELL
    ends = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    ax.imshow(
        image.reshape(*grid.shape[:2], 4),
        origin="lower",
        extent=tuple(1e2 * e for e in ends),  # pyright: ignore[reportArgumentType]
        interpolation="nearest",
        zorder=1,
    )


def _cells(values: Float[np.ndarray, " points"]) -> Float[np.ndarray, " cells"]:
    return np.arange(values.min(), values.max() + CELL, CELL)


def _body(ax: Axes, cut: PlaneCut, body: BodyShapes, cut_out: bool) -> None:
    """Draw the body where a slice meets it; from the side and the front, its outline."""
    a, b = _plane(cut)
    low, high = ax.get_xlim(), ax.get_ylim()
    x = np.arange(1e-2 * low[0] - 0.2, 1e-2 * low[1] + 0.2, OUTLINE_CELL)
    y = np.arange(1e-2 * high[0] - 0.2, 1e-2 * high[1] + 0.2, OUTLINE_CELL)
    X, Y = np.meshgrid(x, y)
    depth = [cut.at]
    if cut.across != UP:  # a silhouette: the nearest of several planes through the trunk
        depth = np.linspace(-0.24, 0.24, 9).tolist()
    distance = np.full(X.size, np.inf)
    for at in depth:
        local = np.empty((X.size, 3))
        local[:, a], local[:, b], local[:, cut.across] = X.ravel(), Y.ravel(), at
        distance = np.minimum(distance, body.distance(local @ cut.axes.T))
    field = distance.reshape(X.shape)
    if field.min() >= 0:
        return
    if cut_out and cut.across == UP:
        ax.contourf(1e2 * X, 1e2 * Y, field, levels=[-9, 0], colors=[BASELINE], alpha=0.6, zorder=2)
    ax.contour(1e2 * X, 1e2 * Y, field, levels=[0], colors=[INK], linewidths=0.9, zorder=3)


def _limits_used(cuts: Sequence[PlaneCut]) -> list[tuple[int, int]]:
    """Give the limits that bound in any of the cuts, the most frequent first."""
    used: dict[tuple[int, int], int] = {}
    for cut in cuts:
        if cut.boundary is None or not len(cut.boundary.points):
            continue
        for joint, side in cut.boundary.limit_names():
            count = int(cut.boundary.chosen(joint, side).sum())
            if joint != BODY:
                used[joint, side] = used.get((joint, side), 0) + count
    return sorted(used, key=lambda key: -used[key])


def _limits(ax: Axes, cut: PlaneCut) -> None:
    """Draw the points of the boundary in the colours of the joints that bound there."""
    if cut.boundary is None or not len(cut.boundary.points):
        return
    a, b = _plane(cut)
    local = 1e2 * (cut.boundary.points @ cut.axes)
    for joint, side in cut.boundary.limit_names():
        if joint == BODY:
            continue
        at = cut.boundary.chosen(joint, side)
        ax.plot(
            local[at, a],
            local[at, b],
            linestyle="",
            marker=_marker(side),
            ms=3.2,
            color=_colour(joint),
            zorder=4,
        )


def _limit_handle(arm: Arm, joint: int, side: int) -> Line2D:
    label = bound_title(arm, joint, side)
    mark, colour = _marker(side), _colour(joint)
    return Line2D([], [], label=words(label), ms=4.5, marker=mark, color=colour, linestyle="")


def _marker(side: int) -> str:
    return {1: "^", -1: "v", 0: "o"}[side]


def _colour(joint: int) -> str:
    return BASELINE if joint < 0 else joint_colour(joint)


def _frame(ax: Axes, cut: PlaneCut) -> None:
    """Set title, labels and the window: all that is reached, and a little around it."""
    a, b = _plane(cut)
    low, high = _window([cut])
    ax.set_xlim(1e2 * low[0], 1e2 * high[0])
    ax.set_ylim(1e2 * low[1], 1e2 * high[1])
    ax.set_title(cut.title[0].upper() + cut.title[1:])
    ax.set_xlabel(LABELS[a])
    ax.set_ylabel(LABELS[b])
    ax.set_aspect("equal")
    ax.grid(True, axis="both")


def _window(cuts: Sequence[PlaneCut]) -> tuple[np.ndarray, np.ndarray]:
    """Give lower and upper corner (m) of what is reached in any of some cuts, and around it."""
    corners = []
    for cut in cuts:
        free = cut.regions["free"]
        local = (free.points[free.inside] if free.inside.any() else free.points) @ cut.axes
        local = local[:, list(_plane(cut))]
        corners.append([local.min(axis=0) - AROUND, local.max(axis=0) + AROUND])
    low, high = np.array(corners).transpose(1, 0, 2)
    return low.min(axis=0), high.max(axis=0)


def _legend(figure: Figure, cut: PlaneCut, more: list[Line2D]) -> None:
    handles: list[Patch | Line2D] = [Patch(color=KEPT, alpha=0.6, label="reached")]
    if "lost" in cut.regions:
        handles = [
            Patch(color=KEPT, alpha=0.6, label="kept"),
            Patch(color=LOST, alpha=0.6, label="lost"),
        ]
    handles.append(Line2D([], [], color=INK, lw=0.9, label="body"))
    columns = 3 if not more else 2
    figure.legend(handles=[*handles, *more], loc="outside lower center", ncols=columns)


def _short(title: str) -> str:
    """Give the title up to its first comma, if there are two."""
    return title.split(", ")[0] if len(title) > 32 else title
