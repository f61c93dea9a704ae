"""Drag the hand and see the natural posture, muscle effort over swivel angle, and activations."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from selfmotion.report.theme import TASK
from selfmotion.viewer.latest import Latest
from selfmotion.viewer.live_posture import LivePosture, effort_series, live_posture, start_pose

if TYPE_CHECKING:
    from selfmotion.viewer.studio import Studio

# Series of the chart: that many feasible intervals are drawn, and the posture shown.
INTERVALS = 4
# Muscles that are named with their activation.
NAMED = 6


class PosturePanel:
    """Hand target, swivel angle, the chart of effort.

    Attributes:
        worker: finds postures, the latest request only.
        shown: what was found last.
    """

    def __init__(self, studio: "Studio") -> None:
        """Add the controls to the tab that is open."""
        self._studio = studio
        self.shown: LivePosture | None = None
        self.worker: Latest[None] = Latest(self._find, studio.complain)
        gui, scene = studio.server.gui, studio.server.scene
        pose = start_pose(studio.model.arm)
        self._target = scene.add_transform_controls(
            "/hand", scale=0.16, position=pose[:3, 3], wxyz=_wxyz(pose), depth_test=False
        )
        self._target.on_update(lambda _: self.ask())
        self._least = gui.add_checkbox("Least effort", True, hint="Off: choose the swivel angle.")
        self._swivel = gui.add_slider("Swivel angle (°)", -180.0, 180.0, 0.5, 0.0)
        self._least.on_update(lambda _: self.ask())
        self._swivel.on_update(lambda event: self._slid(event.client is not None))
        blank = np.zeros(1)
        self._chart = gui.add_uplot(
            (blank, *([np.full(1, np.nan)] * (INTERVALS + 1))),
            (
                {"label": "swivel (°)"},
                *({"label": "effort E", "stroke": TASK, "width": 2} for _ in range(INTERVALS)),
                {
                    "label": "shown",
                    "stroke": "#D55E00",
                    "width": 0,
                    "points": {"show": True, "size": 11, "fill": "#D55E00"},
                },
            ),
            title="Muscle effort E over swivel angle",
            scales={"x": {"time": False}},
            axes=({"label": "swivel angle (°)"}, {"label": "effort E"}),
            legend={"show": False},
            height=230,
        )
        self._words = gui.add_markdown("")

    def hand_pose(self) -> Float[np.ndarray, "4 4"]:
        """Give the pose of the hand target in the ground (m)."""
        T = np.eye(4)
        T[:3, :3] = Rotation.from_quat(self._target.wxyz, scalar_first=True).as_matrix()
        T[:3, 3] = self._target.position
        return T

    def show_target(self, visible: bool) -> None:
        """Show or hide the target."""
        self._target.visible = visible

    def swivel_deg(self) -> float | None:
        """Give the swivel angle that was chosen (degrees), or None for that of least effort."""
        return None if self._least.value else float(self._swivel.value)

    def restore(self, T_hand: Float[np.ndarray, "4 4"], swivel_deg: float | None) -> None:
        """Set hand pose (m) and swivel angle (degrees)."""
        self._target.position, self._target.wxyz = T_hand[:3, 3], _wxyz(T_hand)
        if swivel_deg is not None:
            self._swivel.value = swivel_deg
        self._least.value = swivel_deg is None
        self.ask()

    def ask(self) -> None:
        """Have the posture found for what is set now."""
        self.worker.ask(None)

    def _slid(self, by_hand: bool) -> None:
        if by_hand:  # the slider also follows the posture of least effort
            self._least.value = False
            self.ask()

    def _find(self, _request: None) -> None:
        # What is set is read now: several threads ask, and the last to ask may have read first.
        chosen = self.swivel_deg()
        swivel = None if chosen is None else float(np.radians(chosen))
        with self._studio.busy:
            live = live_posture(self._studio.finder, self.hand_pose(), swivel=swivel)
        self.shown = live
        if not np.isfinite(live.q).all():
            self._studio.say(f"**{live.status}** The arm stays where it was.")
            return
        self._studio.show_posture(live.q, live.activations)
        self._studio.say("")
        if swivel is None:
            self._swivel.value = round(float(np.degrees(live.swivel)) * 2) / 2
        self._draw_chart(live)
        self._words.content = _words(live)

    def _draw_chart(self, live: LivePosture) -> None:
        grid, series = effort_series(live.curves, INTERVALS)
        here = np.full(len(grid), np.nan)
        here[int(np.argmin(np.abs(grid - np.degrees(live.swivel))))] = live.effort
        top = float(np.nanmax(np.concatenate([*series, here])))
        self._chart.scales = {
            "x": {"time": False, "range": (float(grid[0]) - 5.0, float(grid[-1]) + 5.0)},
            "y": {"range": (0.0, 1.1 * top)},  # NaN in a series would leave it without a range
        }
        self._chart.data = (grid, *series, here)


def _wxyz(T: np.ndarray) -> np.ndarray:
    return Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)


def _words(live: LivePosture) -> str:
    """Say what is shown: status, effort, joint angles, the most active muscles."""
    found = live.found
    most = np.argsort(-np.nan_to_num(live.activations))[:NAMED]
    muscles = ", ".join(f"{found.muscles[m]} {live.activations[m]:.2f}" for m in most)
    joints = "\n".join(
        f"| {name.replace('_', ' ')} | {np.degrees(angle):.0f} |"
        for name, angle in zip(found.coordinates, live.q, strict=True)
    )
    ranges = ", ".join(
        f"{np.degrees(a):.0f} to {np.degrees(b):.0f}" for a, b in found.feasible_swivel
    )
    return (
        f"E = {live.effort:.4f}: {live.status}\n\n"
        f"Feasible swivel angles: {ranges}°\n\n"
        f"Most active: {muscles}\n\n"
        f"| joint | angle (°) |\n| --- | --- |\n{joints}"
    )
