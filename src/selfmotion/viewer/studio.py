"""The studio: a server that shows the arm in a browser and answers to the mouse (viser).

What is drawn comes from `scene`, `bones` and `playback`; here it is handed to viser, and what a
person does is handed to the methods. Everything is served from this machine, and to it alone
unless another host is asked for.
"""

import contextlib
import io
import threading
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from selfmotion.errors import MissingExtraError, SelfmotionError
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.viewer.bones import skeleton_of
from selfmotion.viewer.file_panel import FilePanel
from selfmotion.viewer.playback_panel import PlaybackPanel
from selfmotion.viewer.posture_panel import PosturePanel
from selfmotion.viewer.ranges import Ranges
from selfmotion.viewer.reach_panel import ReachPanel
from selfmotion.viewer.scene import landmark_line, linear_light, muscle_lines
from selfmotion.viewer.state import StudioState
from selfmotion.writing import whole_file

BONE = (214, 203, 178)
# Of the camera (rad).
FIELD_OF_VIEW = 0.7
# Muscle paths differ in their number of points from posture to posture; so many pieces are kept.
PIECES = 1500


def require_viewer() -> None:
    """See that viser is there: to be asked before an arm is loaded for seconds.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import viser  # noqa: F401
    except ImportError:
        raise MissingExtraError(
            'the studio needs the extra viewer: pip install "selfmotion[viewer]"'
        ) from None


@dataclass(frozen=True)
class Address:
    """Where the studio listens.

    Attributes:
        host: loopback, unless others are to see it.
        port: the first that is tried; a taken one is passed over.
    """

    host: str = "127.0.0.1"
    port: int = 8080


class Studio:
    """An arm in the browser, with its panels.

    Attributes:
        server: viser's.
        model: the arm with muscles, with the ranges of its model.
        ranges: the ranges that a person has set.
        finder: finds natural postures inside these ranges.
        busy: held while the model's work space is in use, which is one for all threads.
    """

    def __init__(self, model: MusculoskeletalArm, address: Address | None = None) -> None:
        """Start the server and draw the arm.

        Raises:
            MissingExtraError: viser is not installed.
        """
        require_viewer()
        import viser

        where = address or Address()
        with _quietly():
            self.server = viser.ViserServer(where.host, where.port, label="selfmotion")
        self.model = model
        self.model_name = model.arm.name
        self.ranges = Ranges(model.arm)
        self.finder = PostureFinder.of(model)
        self.busy = threading.RLock()
        self.server.gui.configure_theme(show_logo=False, show_share_button=False)
        self.server.scene.set_up_direction(tuple(model.arm.up.tolist()))
        self._skeleton = skeleton_of(model)
        self._draw_arm()
        self._aim_camera()
        self.message = self.server.gui.add_markdown("")
        tabs = self.server.gui.add_tab_group()
        with tabs.add_tab("Posture"):
            self.posture = PosturePanel(self)
        with tabs.add_tab("Reach"):
            self.reach = ReachPanel(self)
        with tabs.add_tab("Play"):
            self.playback = PlaybackPanel(self)
        with tabs.add_tab("Files"):
            self.files = FilePanel(self)
        self.posture.ask()

    @property
    def url(self) -> str:
        """Where a browser finds the studio."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def say(self, text: str) -> None:
        """Show a sentence above the panels."""
        self.message.content = text

    def complain(self, error: Exception) -> None:
        """Show what went wrong; a defect of ours says that it is one."""
        told = isinstance(error, SelfmotionError)
        self.say(f"**{error}**" if told else f"**internal error: {type(error).__name__}: {error}**")

    def show_posture(
        self, q: Float[np.ndarray, " coords"], activations: Float[np.ndarray, " muscles"]
    ) -> None:
        """Draw the arm in a posture (rad), muscles coloured by activation."""
        with self.busy:
            lines = muscle_lines(self.model, q, activations)
            places = self._skeleton.place(q) if self._skeleton else None
            line = landmark_line(self.model.arm, q[None])[0]
        with self.server.atomic():
            if places is not None:
                for handle, position, quaternion in zip(self._bones, *places, strict=True):
                    handle.position, handle.wxyz = position, quaternion
            self._muscles.points = _padded(lines.points, PIECES)
            self._muscles.colors = _padded(linear_light(lines.colours), PIECES)
            self._line.points = np.stack([line[:-1], line[1:]], axis=1).astype(np.float32)

    def change_ranges(self) -> None:
        """Let ranges that have been changed hold for posture and workspace.

        Raises:
            RangeError: a range leaves nothing.
        """
        limited = self.ranges.limited()
        self.finder = PostureFinder.of(replace(self.model, arm=limited))
        self.posture.ask()
        self.reach.ask()

    def show_arm(self, visible: bool) -> None:
        """Show or hide bones, muscles and the hand's target."""
        for handle in (*self._bones, self._muscles):
            handle.visible = visible
        self._line.visible = visible and not self._bones
        self.posture.show_target(visible)

    def state(self) -> StudioState:
        """Give what is set, to be saved."""
        return StudioState(
            model=self.model_name,
            hand=tuple(tuple(row) for row in self.posture.hand_pose().tolist()),
            limits_deg=dict(self.ranges.limits_deg),
            splint=self.ranges.splint is not None,
            swivel_deg=self.posture.swivel_deg(),
            recording=self.playback.source,
            time=self.playback.time(),
        )

    def restore(self, state: StudioState) -> None:
        """Set what a state says.

        Raises:
            SelfmotionError: the state does not fit the model, or its recording cannot be read.
        """
        self.reach.restore(state.limits_deg, splint=state.splint)
        if state.hand is not None:
            self.posture.restore(np.array(state.hand), state.swivel_deg)
        if state.recording is not None:
            self.playback.open(Path(state.recording))
            self.playback.seek(state.time)

    def scene_html(self) -> str:
        """Give the scene as one HTML page that needs no server and no network."""
        return self.server.get_scene_serializer().as_html()

    def export(self, path: Path) -> Path:
        """Write the scene as one HTML page, whole or not at all."""
        with whole_file(path) as aside:
            aside.write_text(self.scene_html(), encoding="utf-8")
        return path

    def settle(self, timeout: float = 120.0) -> bool:
        """Wait until nothing is being computed (s); tell whether that came."""
        return self.posture.worker.wait(timeout) and self.reach.worker.wait(timeout)

    def close(self) -> None:
        """End all threads and the server."""
        self.playback.stop()
        self.posture.worker.stop()
        self.reach.worker.stop()
        with _quietly():
            self.server.stop()

    def _draw_arm(self) -> None:
        scene = self.server.scene
        self._bones = [
            scene.add_mesh_simple(
                f"/arm/bones/{i:02d}_{bone.name}",
                bone.vertices.astype(np.float32),
                bone.faces.astype(np.uint32),
                color=BONE,
            )
            for i, bone in enumerate(self._skeleton.bones if self._skeleton else ())
        ]
        nothing = np.zeros((PIECES, 2, 3), dtype=np.float32)
        self._muscles = scene.add_line_segments(
            "/arm/muscles", nothing, nothing.astype(np.uint8), thickness=0.006
        )
        self._line = scene.add_line_segments(
            "/arm/line", nothing[:3], (90, 90, 90), thickness=0.012, visible=not self._bones
        )

    def _aim_camera(self) -> None:
        arm = self.model.arm
        right = np.cross(arm.forward, arm.up)
        look_at = landmark_line(arm, _rest(arm)[None])[0, 0] + 0.15 * arm.forward - 0.05 * arm.up
        camera = self.server.initial_camera
        camera.fov = FIELD_OF_VIEW
        camera.look_at = tuple(look_at.tolist())
        position = look_at + 1.0 * arm.forward + 1.3 * right + 0.35 * arm.up
        camera.position = tuple(position.tolist())
        camera.up = tuple(arm.up.tolist())


def _quietly() -> contextlib.AbstractContextManager[object]:
    """Keep viser's own banner off standard output, which is for one JSON document."""
    return contextlib.redirect_stdout(io.StringIO())


def _rest(arm: Arm) -> Float[np.ndarray, " coords"]:
    return np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)


def _padded(values: np.ndarray, length: int) -> np.ndarray:
    """Bring to a fixed length: what is missing has no extent, what is too much is left out."""
    kind = np.float32 if values.dtype.kind == "f" else values.dtype
    out = np.zeros((length, *values.shape[1:]), dtype=kind)
    n = min(length, len(values))
    out[:n] = values[:n]
    if values.dtype.kind == "f" and n:
        out[n:] = values[n - 1, 1]
    return out
