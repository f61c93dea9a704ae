"""The studio as a person uses it: a headless Chromium loads, drags, changes a limit, plays.

Needs Chromium on the path and the package playwright, which drives it; skipped otherwise.
"""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

REACH = Path(__file__).parents[2] / "examples" / "reach.csv"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SIZE = {"width": 900, "height": 600}
# A software renderer on a busy machine draws a frame or two a second.
PATIENCE = 90.0


@pytest.fixture(scope="module")
def page(studio) -> Iterator:
    api = pytest.importorskip("playwright.sync_api", reason="needs: pip install playwright")
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        pytest.skip(f"needs a browser on the path: {', '.join(BROWSERS)}")
    software = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with api.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=browser, args=software)
        shown = chromium.new_page(viewport=SIZE)
        shown.set_default_timeout(1e3 * PATIENCE)
        shown.errors = []
        shown.on("console", lambda m: m.type == "error" and shown.errors.append(m.text))
        shown.on("pageerror", lambda e: shown.errors.append(str(e)))
        shown.goto(studio.url)
        shown.get_by_role("tab", name="Posture").wait_for()
        shown.locator("canvas").first.wait_for()
        yield shown
        assert shown.errors == []
        chromium.close()


def eventually(holds: Callable[[], bool]) -> bool:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.1)
    return False


def pixel(studio, point: np.ndarray) -> tuple[float, float]:
    """Give where a point in space (m) is on the page."""
    camera = studio.server.initial_camera
    eye, at, up = (np.array(v) for v in (camera.position, camera.look_at, camera.up))
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
    top = np.cross(right, forward)
    x, y, depth = np.array([right, top, forward]) @ (point - eye)
    scale = 0.5 * SIZE["height"] / np.tan(0.5 * camera.fov) / depth
    return 0.5 * SIZE["width"] + scale * x, 0.5 * SIZE["height"] - scale * y


def picture(page, path: Path) -> np.ndarray:
    from matplotlib.image import imread

    page.screenshot(path=path, timeout=1e3 * PATIENCE)
    return imread(path)[..., :3]


def test_it_loads_and_the_arm_is_to_be_seen(studio, page, tmp_path):
    def drawn() -> bool:
        image = picture(page, tmp_path / "loaded.png")
        return bool((image[:, : SIZE["width"] // 2] < 0.7).all(axis=2).mean() > 0.01)

    assert eventually(drawn)
    assert page.get_by_text("Muscle effort E over swivel angle").is_visible()


def test_dragging_the_hand_moves_the_arm(studio, page, tmp_path):
    before = studio.posture.hand_pose()
    drawn = picture(page, tmp_path / "before.png")
    # The tip of an arrow of the target, pulled away from its origin: the one that lies most
    # across the view.
    origin = before[:3, 3]
    starts = [pixel(studio, origin + 0.13 * before[:3, i]) for i in range(3)]
    centre = pixel(studio, origin)
    i = int(np.argmax([np.hypot(x - centre[0], y - centre[1]) for x, y in starts]))
    x, y = starts[i]
    stop = pixel(studio, origin + 0.19 * before[:3, i])
    page.mouse.move(x, y)
    time.sleep(1.0)
    page.mouse.down()
    for share in np.linspace(0.0, 1.0, 8):
        page.mouse.move(x + share * (stop[0] - x), y + share * (stop[1] - y))
        time.sleep(0.2)
    page.mouse.up()
    assert eventually(lambda: np.abs(studio.posture.hand_pose() - before).max() > 0.01)
    assert studio.settle()
    moved = studio.posture.hand_pose()[:3, 3] - origin
    assert abs(moved @ before[:3, i]) > 0.9 * np.linalg.norm(moved)  # along the arrow
    assert (picture(page, tmp_path / "after.png") != drawn).mean() > 0.001


def test_changing_a_limit_shows_what_is_lost(studio, page):
    page.get_by_role("tab", name="Reach").click()
    page.get_by_label("Workspace").click()
    assert eventually(lambda: studio.reach.shown is not None)
    page.get_by_label("Splinted elbow").click()
    assert eventually(lambda: studio.reach.shown.regions["lost"].volume > 0.05)
    page.get_by_text("Lost (orange)").wait_for()


def test_a_recording_plays(studio, page, tmp_path):
    studio.playback.open(REACH)
    page.get_by_role("tab", name="Play").click()
    page.get_by_text("Joint speed: task and null space").wait_for()
    page.get_by_label("Play", exact=True).click()
    first = studio.playback.time()
    assert eventually(lambda: studio.playback.time() != first)
    page.get_by_label("Play", exact=True).click()
    picture(page, tmp_path / "played.png")
