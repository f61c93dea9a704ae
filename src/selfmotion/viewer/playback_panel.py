"""Play a recording with its task and null-space velocity, and the planned movement beside it."""

import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.errors import SelfmotionError
from selfmotion.kinematics.arm import Arm
from selfmotion.motion.recording import Recording
from selfmotion.report.theme import INK, NULL, TASK
from selfmotion.viewer.open_recording import open_recording
from selfmotion.viewer.playback import PlannedBeside, Playback, make_playback, plan_beside
from selfmotion.viewer.scene import NULL_RGB, TASK_RGB, ground_to_ground

if TYPE_CHECKING:
    from selfmotion.viewer.studio import Studio

# Arrows: metres drawn for a metre a second.
ARROW = 0.25
FRAMES_A_SECOND = 30.0
PERSON_RGB, PLAN_RGB = (60, 60, 60), (204, 121, 167)


class PlaybackPanel:
    """Time, play, speed; figure, arrows and the planned movement.

    Attributes:
        source: file of the recording, or None.
        playback: the recording as it is drawn.
        planned: the planned movement beside it.
    """

    def __init__(self, studio: "Studio") -> None:
        """Add the controls to the tab that is open."""
        self._studio = studio
        self.source: str | None = None
        self.playback: Playback | None = None
        self.planned: PlannedBeside | None = None
        self._T = np.eye(4)
        self._stopped = threading.Event()
        gui = studio.server.gui
        self._words = gui.add_markdown("Open a recording of joint angles in the tab Files.")
        self._play = gui.add_checkbox("Play", False)
        self._time = gui.add_slider("Time (s)", 0.0, 1.0, 0.005, 0.0)
        self._speed = gui.add_slider("Speed", 0.1, 2.0, 0.1, 1.0)
        self._beside = gui.add_checkbox(
            "Planned beside it", True, hint="λ0-PMP, same start and end."
        )
        self._arm = gui.add_checkbox("Skeleton", True, hint="Show the arm with muscles as well.")
        self._arm.on_update(lambda _: studio.show_arm(self._arm.value))
        self._chart = gui.add_uplot(
            (np.zeros(1), np.full(1, np.nan), np.full(1, np.nan), np.full(1, np.nan)),
            (
                {"label": "time (s)"},
                {"label": "task", "stroke": TASK, "width": 2},
                {"label": "null space", "stroke": NULL, "width": 2},
                {"label": "now", "width": 0, "points": {"show": True, "size": 9, "fill": INK}},
            ),
            title="Joint speed: task and null space",
            scales={"x": {"time": False}},
            axes=({"label": "time (s)"}, {"label": "rad/s"}),
            height=220,
        )
        self._time.on_update(lambda _: self._draw())
        self._beside.on_update(lambda _: self._draw())
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def open(self, path: Path, name: str | None = None) -> None:
        """Open a recording and draw its first posture.

        Args:
            path: file of joint angles.
            name: what to call it, where the file has another name for a while.

        Raises:
            SelfmotionError: the file cannot be read, or no arm has its joints.
        """
        recording, arm = open_recording(path)
        self.show(recording, arm)
        self.source = name or str(path)

    def show(self, recording: Recording, arm: Arm) -> None:
        """Draw a recording's first posture, ready to play.

        Raises:
            SelfmotionError: it has gaps, or does not fit the arm.
        """
        playback, planned = make_playback(recording, arm), plan_beside(recording, arm)
        self.playback, self.planned = playback, planned
        self._T = ground_to_ground(arm, self._studio.model.arm)
        self._time.max = float(playback.time[-1])
        self._time.value = 0.0
        share = playback.parted.task_share
        self._words.content = (
            f"**{Path(recording.source).name}** ({arm.name}), {playback.time[-1]:.2f} s\n\n"
            f"task {share:.1%}, null space {1 - share:.1%} of squared joint speed (all weights "
            f"alike)\n\n"
            f"blue arrow: velocity of the hand; orange: of the elbow by the null space; purple "
            f"figure: λ0-PMP, {planned.status}"
        )
        self._draw()

    def time(self) -> float:
        """Give where in the recording we are (s)."""
        return float(self._time.value)

    def seek(self, instant: float) -> None:
        """Go to a time (s)."""
        self._time.value = min(max(instant, 0.0), float(self._time.max))
        self._draw()

    def play(self, playing: bool) -> None:
        """Start or hold."""
        self._play.value = playing

    def stop(self) -> None:
        """End the thread that plays."""
        self._stopped.set()
        self._thread.join(5.0)

    def _run(self) -> None:
        last = time.monotonic()
        while not self._stopped.wait(1.0 / FRAMES_A_SECOND):
            now = time.monotonic()
            passed, last = now - last, now
            if not self._play.value or self.playback is None:
                continue
            try:
                end = float(self.playback.time[-1])
                self._time.value = (self._time.value + passed * self._speed.value) % max(end, 1e-6)
                self._draw()
            except SelfmotionError as error:
                self._studio.complain(error)

    def _draw(self) -> None:
        p = self.playback
        if p is None:
            return
        k = int(np.searchsorted(p.time, self._time.value).clip(0, len(p.time) - 1))
        scene = self._studio.server.scene
        with self._studio.server.atomic():
            self._figure("/recording/person", self._ground(p.line[k]), PERSON_RGB)
            self._arrow("/recording/task", p.line[k, 3], p.hand_velocity[k], TASK_RGB)
            self._arrow("/recording/null", p.line[k, 1], p.elbow_null_velocity[k], NULL_RGB)
            if self.planned is not None and self._beside.value:
                s = int(np.searchsorted(self.planned.time, self._time.value))
                s = min(s, len(self.planned.time) - 1)
                self._figure("/recording/plan", self._ground(self.planned.line[s]), PLAN_RGB)
            else:
                scene.remove_by_name("/recording/plan")
        now = np.full(len(p.time), np.nan)
        now[k] = p.task_speed[k]
        top = 1.1 * float(max(p.task_speed.max(), p.null_speed.max()))
        self._chart.scales = {
            "x": {"time": False, "range": (0.0, float(p.time[-1]))},
            "y": {"range": (0.0, top)},
        }
        self._chart.data = (p.time, p.task_speed, p.null_speed, now)

    def _ground(self, points: np.ndarray) -> np.ndarray:
        return points @ self._T[:3, :3].T + self._T[:3, 3]

    def _figure(self, name: str, line: np.ndarray, colour: tuple[int, int, int]) -> None:
        pieces = np.stack([line[:-1], line[1:]], axis=1).astype(np.float32)
        self._studio.server.scene.add_line_segments(name, pieces, colour, thickness=0.02)

    def _arrow(
        self, name: str, at: np.ndarray, velocity: np.ndarray, colour: tuple[int, int, int]
    ) -> None:
        ends = np.stack([at, at + ARROW * velocity])
        self._studio.server.scene.add_arrows(
            name,
            self._ground(ends)[None].astype(np.float32),
            colour,
            shaft_radius=0.006,
            head_radius=0.016,
            head_length=0.03,
        )
