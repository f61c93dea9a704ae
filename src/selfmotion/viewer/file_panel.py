"""Open a recording, save and restore what is set, export the scene."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.errors import SelfmotionError
from selfmotion.viewer.state import load_state, read_state, save_state

if TYPE_CHECKING:
    from selfmotion.viewer.studio import Studio


class FilePanel:
    """A path with its buttons; upload and download for a browser elsewhere."""

    def __init__(self, studio: "Studio") -> None:
        """Add the controls to the tab that is open."""
        self._studio = studio
        gui = studio.server.gui
        self._path = gui.add_text(
            "File", "", hint="Recording (.csv, .mot), or a saved state (.json)."
        )
        gui.add_button("Open").on_click(lambda _: self._try(self._open))
        upload = gui.add_upload_button("Upload a file")
        upload.on_upload(lambda _: self._try(lambda: self._uploaded(upload.value)))
        gui.add_button("Download state").on_click(lambda event: self._download_state(event.client))
        gui.add_button("Download scene").on_click(lambda event: self._download_scene(event.client))

    def _open(self) -> None:
        path = Path(self._path.value).expanduser()
        if path.suffix.lower() == ".json":
            self._studio.restore(load_state(path))
        else:
            self._studio.playback.open(path)
        self._studio.say(f"opened {path.name}")

    def _uploaded(self, file) -> None:
        if file.name.lower().endswith(".json"):
            self._studio.restore(read_state(file.content, file.name))
        else:
            with tempfile.TemporaryDirectory() as folder:
                aside = Path(folder, Path(file.name).name)
                aside.write_bytes(file.content)
                self._studio.playback.open(aside, name=file.name)
        self._studio.say(f"opened {file.name}")

    def _download_state(self, client) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = save_state(Path(folder, "studio.json"), self._studio.state())
            client.send_file_download("studio.json", path.read_bytes())

    def _download_scene(self, client) -> None:
        client.send_file_download("scene.html", self._studio.scene_html().encode())

    def _try(self, act) -> None:
        try:
            act()
        except (SelfmotionError, OSError) as error:
            self._studio.complain(error)
