"""Pictures of maps over a workspace: slices, and a body of points that can be turned and cut."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from selfmotion.methods.reaching.map_result import UNITS, WorkspaceMaps
from selfmotion.report.theme import INK, new_figure, themed

if TYPE_CHECKING:
    import plotly.graph_objects as go

LABELS = {
    "margin": "room to the limits (share of half range)",
    "manipulability": "manipulability (m³)",
    "effort": "least muscle effort (sum of squared activations)",
}
# More is better for the first two; the effort's scale is turned round, so that dark is always bad.
SCALES = {"margin": "viridis", "manipulability": "viridis", "effort": "viridis_r"}
# Panels of a figure of slices.
PANELS, COLUMNS = 8, 4
NONE, LINES = "rgba(0,0,0,0)", "rgba(122,130,140,0.35)"
# Share of the values left out at the upper end of the effort's scale: a few are huge.
CUT = 95


@themed
def map_slices_figure(maps: WorkspaceMaps, name: str) -> Figure:
    """Draw a map in horizontal slices, seen from above."""
    volume, levels = maps.grid.volume(maps.values[name]), _levels(maps)
    n_rows = -(-len(levels) // COLUMNS)
    figure, axes = new_figure(
        n_rows, COLUMNS, size=(7.2, 2.1 * n_rows + 0.7), share_x=True, share_y=True
    )
    low, high = scale_ends(maps, name)
    x, y = (_edges(maps.grid.axis(i), maps.grid.spacing) for i in (0, 1))
    drawn = None
    for ax, level in zip(axes.ravel(), levels, strict=False):
        drawn = ax.pcolormesh(
            x, y, volume[:, :, level].T, cmap=SCALES[name], vmin=low, vmax=high, rasterized=True
        )
        ax.plot(0, 0, "+", color=INK, ms=6)
        ax.set_title(f"z = {1e3 * maps.grid.axis(2)[level]:+.0f} mm")
        ax.set_aspect("equal")
    for ax in axes.ravel()[len(levels) :]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("y (m)")
    for ax in axes[-1]:
        ax.set_xlabel("x (m)")
    if drawn is not None:
        figure.colorbar(drawn, ax=axes, shrink=0.8, pad=0.02, label=LABELS[name])
    return figure


def map_figure(maps: WorkspaceMaps) -> "go.Figure":
    """Draw the maps as points in space, one sheet of constant x after the other.

    A menu chooses the map, a slider takes sheets away, so that one sees inside.
    """
    import plotly.graph_objects as go

    names = list(maps.values)
    points = maps.grid.points
    sheets = [
        rows
        for x in maps.grid.axis(0)
        if len(rows := np.flatnonzero(maps.reached & np.isclose(points[:, 0], x)))
    ]
    first = names[0]
    figure = go.Figure()
    for rows in sheets:
        p = np.round(points[rows], 4).astype(np.float32)
        marker = {"size": 3.5, "coloraxis": "coloraxis", "color": _colours(maps, first, rows)}
        figure.add_trace(
            go.Scatter3d(
                x=p[:, 0], y=p[:, 1], z=p[:, 2], mode="markers", marker=marker, showlegend=False,
                hovertemplate="x %{x:.2f}, y %{y:.2f}, z %{z:.2f} m<br>%{marker.color:.3g}"
                "<extra></extra>",
            )
        )  # fmt: skip
    at = [float(points[rows[0], 0]) for rows in sheets]
    figure.update_layout(
        coloraxis=_axis(maps, first),
        scene={
            **{
                f"{a}axis": {"title": f"{a} (m)", "backgroundcolor": NONE, "gridcolor": LINES}
                for a in "xyz"
            },
            "aspectmode": "data",
            "camera": {"eye": {"x": -1.7, "y": 1.4, "z": 0.9}},
        },
        sliders=[_slider(at)],
        updatemenus=[_menu(maps, names, sheets)] if len(names) > 1 else [],
    )
    return figure


def scale_ends(maps: WorkspaceMaps, name: str) -> tuple[float, float]:
    """Give the values between which colours change."""
    known = maps.values[name][np.isfinite(maps.values[name])]
    if not len(known):
        return 0.0, 1.0
    top = np.percentile(known, CUT) if name == "effort" else known.max()
    return 0.0, float(max(top, 1e-12))


def _levels(maps: WorkspaceMaps) -> list[int]:
    """Choose horizontal layers that hold points, at most `PANELS`, evenly."""
    reached = maps.grid.volume(maps.reached)
    levels = np.flatnonzero(reached.any(axis=(0, 1)))
    chosen = np.unique(
        np.linspace(0, len(levels) - 1, min(PANELS, len(levels))).round().astype(int)
    )
    return levels[chosen].tolist()


def _edges(middles: np.ndarray, spacing: float) -> np.ndarray:
    return np.append(middles - 0.5 * spacing, middles[-1] + 0.5 * spacing)


def _colours(maps: WorkspaceMaps, name: str, rows: np.ndarray) -> list[float | None]:
    values = maps.values[name][rows]
    return [float(f"{v:.3g}") if np.isfinite(v) else None for v in values]


def _axis(maps: WorkspaceMaps, name: str) -> dict[str, object]:
    low, high = scale_ends(maps, name)
    title = {"text": f"{name}<br>({UNITS[name]})", "side": "top"}
    scale = "Viridis_r" if name == "effort" else "Viridis"
    return {
        "cmin": low,
        "cmax": high,
        "colorscale": scale,
        "colorbar": {"title": title, "len": 0.7},
    }


def _slider(at: list[float]) -> dict[str, object]:
    steps = [
        {
            "method": "restyle",
            "label": f"{1e3 * x:.0f}",
            "args": [{"visible": [other >= x for other in at]}],
        }
        for x in at
    ]
    prefix = {"prefix": "shown from x = ", "suffix": " mm"}
    return {"steps": steps, "currentvalue": prefix, "pad": {"t": 10, "b": 10}, "len": 0.9}


def _menu(maps: WorkspaceMaps, names: list[str], sheets: list[np.ndarray]) -> dict[str, object]:
    buttons = [
        {
            "method": "update",
            "label": name,
            "args": [
                {"marker.color": [_colours(maps, name, rows) for rows in sheets]},
                {"coloraxis": _axis(maps, name)},
            ],
        }
        for name in names
    ]
    return {"buttons": buttons, "x": 0.0, "xanchor": "left", "y": 1.08, "yanchor": "top"}
