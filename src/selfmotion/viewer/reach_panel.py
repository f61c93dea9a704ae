"""Set joint ranges and a splint, and see what the hand still reaches and what it has lost."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.errors import SelfmotionError
from selfmotion.methods.workspace import Region, Workspace, WorkspaceOptions, workspace
from selfmotion.viewer.latest import Latest
from selfmotion.viewer.ranges import Splint
from selfmotion.viewer.scene import KEPT_RGB, LOST_RGB, cloud

if TYPE_CHECKING:
    from selfmotion.viewer.studio import Studio

# Points enough for a cloud and a volume to about 1 %, in a moment.
FINENESS = WorkspaceOptions(n_points=4096, shifts=4, slice_points=16)
# Half the thickness of the layer at the hand's height (m).
HALF_LAYER = 0.02


class ReachPanel:
    """Limit sliders, the splint, the workspace cloud.

    Attributes:
        worker: computes workspaces, the latest request only.
        shown: the workspace computed last.
    """

    def __init__(self, studio: "Studio") -> None:
        """Add the controls to the tab that is open."""
        self._studio = studio
        self.shown: Workspace | None = None
        self.worker: Latest[None] = Latest(self._compute, studio.complain)
        gui = studio.server.gui
        self._cloud = gui.add_checkbox("Workspace", False, hint="Show what the hand can reach.")
        self._slab = gui.add_checkbox("Only at the hand's height", False, hint="A layer of 4 cm.")
        self._splint = gui.add_checkbox("Splinted elbow", False, hint=_splint_words())
        self._words = gui.add_markdown("")
        self._sliders = {}
        with gui.add_folder("Joint ranges (°)"):
            for joint in studio.model.arm.joints:
                low, high = studio.ranges.own_deg(joint)
                slider = gui.add_multi_slider(
                    joint.replace("_", " "), np.floor(low), np.ceil(high), 1.0, (low, high)
                )
                slider.on_update(partial(self._changed, joint))
                self._sliders[joint] = slider
        self._cloud.on_update(lambda _: self.ask())
        self._slab.on_update(lambda _: self._draw())
        self._splint.on_update(lambda _: self._splinted())

    def restore(self, limits_deg: dict[str, tuple[float, float]], *, splint: bool) -> None:
        """Set ranges (degrees) and the splint.

        Raises:
            SelfmotionError: a joint does not exist or a range leaves nothing.
        """
        for joint, (low, high) in limits_deg.items():
            self._studio.ranges.set(joint, low, high)
            self._sliders[joint].value = (low, high)
        self._splint.value = splint
        self._studio.ranges.splint = Splint() if splint else None
        self._studio.change_ranges()

    def ask(self) -> None:
        """Have the workspace computed where it is shown."""
        if self._cloud.value:
            self.worker.ask(None)
        else:
            for name in ("kept", "lost"):
                self._studio.server.scene.remove_by_name(f"/workspace/{name}")
            self._words.content = ""

    def show(self) -> None:
        """Show the cloud."""
        self._cloud.value = True
        self.ask()

    def _changed(self, joint: str, _event: object) -> None:
        low, high = self._sliders[joint].value
        self._try(lambda: self._studio.ranges.set(joint, float(low), float(high)))

    def _splinted(self) -> None:
        def put() -> None:
            self._studio.ranges.splint = Splint() if self._splint.value else None

        self._try(put)

    def _try(self, change) -> None:
        try:
            change()
            self._studio.change_ranges()
        except SelfmotionError as error:
            self._studio.complain(error)

    def _compute(self, _request: None) -> None:
        limited = self._studio.ranges.limited()
        found = workspace(self._studio.model.arm, limited=limited, options=FINENESS)
        self.shown = found
        self._draw()

    def _draw(self) -> None:
        found = self.shown
        if found is None or not self._cloud.value:
            return
        kept, lost = found.regions["limited"], found.regions["lost"]
        slab = None
        if self._slab.value:
            at, up = self._studio.posture.hand_pose()[:3, 3], self._studio.model.arm.up
            slab = (at, up, HALF_LAYER)
        for name, region, colour in (("kept", kept, KEPT_RGB), ("lost", lost, LOST_RGB)):
            self._studio.server.scene.add_point_cloud(
                f"/workspace/{name}",
                cloud(region, slab=slab).astype(np.float32),
                colour,
                point_size=0.004,
                point_shape="circle",
            )
        self._words.content = (
            f"Kept (blue): {_litres(kept)}\n\nLost (orange): {_litres(lost)}\n\n"
            f"Free: {_litres(found.regions['free'])}"
        )


def _litres(region: Region) -> str:
    return f"{1e3 * region.volume:.0f} ± {1e3 * region.standard_error:.0f} litres"


def _splint_words() -> str:
    low, high = Splint().range_deg
    return f"Holds the elbow between {low:g} and {high:g} degrees."
