"""The live window in Chromium: dragged, slid, typed, recorded, reconnected, by two at once."""

import http.server
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from magicsim.judge.verdicts import TABLE
from magicsim.live.window import LiveWindow
from magicsim.notebook.screen import EDGE_PX

pytestmark = pytest.mark.browser
SLOW_MS = 60_000


def visit(page, window: LiveWindow):
    page.set_default_timeout(SLOW_MS)
    page.goto(window.address)
    page.wait_for_selector("table.verdicts", state="attached")
    return page


@pytest.fixture
def opened(page, window: LiveWindow):
    return visit(page, window)


@pytest.fixture
def small(small_page, window: LiveWindow):
    return visit(small_page, window)


@pytest.fixture
def settled(window: LiveWindow, until) -> Callable[[Callable[[], bool]], None]:
    """Waits until the window rests and something holds of its last sight."""
    return lambda holds: until(lambda: window.busy is None and holds())


def shown(page, place: str, text: str) -> None:
    """Waits until a place of the page says a text: it comes by the socket after the window has settled, drawn anew."""
    page.locator(place).filter(has_text=text).wait_for(state="attached")


def pixel_of(camera, page, point_mm: tuple[float, float, float]) -> tuple[float, float]:
    """Where a point of the 3D view stands on the page, from the camera that the page has told [px]."""
    w, x, y, z = camera.wxyz
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    seen = rotation.T @ (np.array(point_mm) - camera.position)
    box = page.locator("canvas").first.bounding_box()
    scale = box["height"] / 2 / np.tan(camera.fov / 2)
    return (
        box["x"] + box["width"] / 2 + scale * seen[0] / seen[2],
        box["y"] + box["height"] / 2 + scale * seen[1] / seen[2],
    )


def test_page_shows_frame_verdicts_force_and_rate(opened):
    assert opened.locator("img.camera").evaluate("each => each.complete && each.naturalWidth") == 48 + EDGE_PX
    assert "24 x 32" in opened.locator("img.camera").get_attribute("alt")
    text = opened.locator("table.verdicts").inner_text()
    assert all(word in text for word in ("calibrated", "published", "E [bit]", "proximity", "contact"))
    assert "frames / s" in opened.locator("table.forces").inner_text()
    assert opened.locator("canvas").count() >= 1
    assert opened.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_refused_pose_says_why_and_the_object_stays(small, window: LiveWindow, settled):
    before = window.sight.wish
    window.ask(replace(before, x_mm=50.0))
    small.wait_for_selector(".refusal", state="attached")
    assert small.locator(".refusal").inner_text().startswith("x_mm = 50 is not allowed: must be -2 to 2")
    settled(lambda: window.wish == before)
    small.keyboard.press("Shift+KeyL")
    settled(lambda: window.sight.refusal is None and window.sight.wish.gap_mm == pytest.approx(before.gap_mm + 0.1))
    small.keyboard.press("Shift+KeyP")
    settled(lambda: window.sight.wish == before)


def test_keys_move_and_press_the_object(small, window: LiveWindow, settled):
    start = window.sight.wish
    for key in ("Shift+ArrowRight", "Shift+ArrowUp", "Shift+KeyP", "Shift+KeyJ"):
        small.keyboard.press(key)
    settled(lambda: window.sight.wish == start.pushed(window.workspace, x_mm=0.1, y_mm=0.1, gap_mm=-0.1, twist_deg=5.0))
    shown(small, "table.forces", f"{window.sight.wish.gap_mm:.2f} mm")
    for key in ("Shift+ArrowLeft", "Shift+ArrowDown", "Shift+KeyL", "Shift+KeyK"):
        small.keyboard.press(key)
    settled(lambda: window.sight.wish == start)


def test_slider_is_moved_by_keyboard_alone(opened, window: LiveWindow, settled, tabbed):
    before = window.sight.wish.gap_mm
    slider = opened.get_by_role("slider").first
    slider.focus()
    opened.keyboard.press("ArrowLeft")
    settled(lambda: window.sight.wish.gap_mm < before)
    slider.focus()
    opened.keyboard.press("ArrowRight")
    settled(lambda: window.sight.wish.gap_mm == pytest.approx(before))
    reached = tabbed(opened)
    assert any(name == "Record" for _, name in reached)


def test_recording_is_written_by_one_button(small, window: LiveWindow, settled):
    small.get_by_role("button", name="Record").click()
    shown(small, ".recorded", "Recording: 1 frames")
    small.keyboard.press("Shift+KeyP")
    shown(small, ".recorded", "Recording: 2 frames")
    small.get_by_role("button", name="Stop and save").click()
    shown(small, ".recorded", "2 frames in")
    pressed, newest = window.sight.wish.gap_mm, max(window.folder.iterdir(), key=lambda each: each.name)
    assert {each.name for each in newest.iterdir()} >= {TABLE, "report.html", "config.toml", "frames"}
    small.keyboard.press("Shift+KeyL")
    settled(lambda: window.sight.wish.gap_mm == pytest.approx(pressed + 0.1))
    assert small.locator(".recorded").inner_text().startswith("2 frames in")


def test_page_comes_back_after_the_connection_is_lost(small, window: LiveWindow, servers, viewers, settled, until):
    servers[-1]._websock_server.disconnect_all_clients()  # viser has no public way
    until(lambda: len(viewers()) == 0)
    until(lambda: len(viewers()) == 1)
    small.wait_for_selector("table.verdicts", state="attached")
    before = window.sight.wish
    small.keyboard.press("Shift+ArrowRight")
    settled(lambda: window.sight.wish != before)
    small.keyboard.press("Shift+ArrowLeft")
    settled(lambda: window.sight.wish == before)


def test_two_windows_show_one_sensor(small, browser, window: LiveWindow, settled):
    second = browser.new_page(viewport={"width": 720, "height": 480})
    second.goto(window.address)
    second.wait_for_selector("table.forces", timeout=SLOW_MS)
    before = window.sight.wish
    small.keyboard.press("Shift+KeyP")
    settled(lambda: window.sight.wish != before)
    for each in (small, second):
        shown(each, "table.forces", f"{window.sight.wish.gap_mm:.2f} mm")
    second.keyboard.press("Shift+KeyL")
    settled(lambda: window.sight.wish == before)
    second.close()


def test_object_is_dragged_with_the_mouse(small, window: LiveWindow, viewers, settled, until):
    page = small
    until(lambda: any(each.camera.position is not None for each in viewers()))
    page.wait_for_timeout(1500)  # the view is drawn
    before = window.sight.wish
    height = -before.gap_mm
    camera = viewers()[0].camera
    begin = pixel_of(camera, page, (before.x_mm, before.y_mm, height + 3.0))
    end = pixel_of(camera, page, (before.x_mm, before.y_mm, height + 5.0))
    page.mouse.move(*begin)
    page.mouse.down()
    for share in (0.25, 0.5, 0.75, 1.0):
        page.mouse.move(*(a + share * (b - a) for a, b in zip(begin, end, strict=True)))
        page.wait_for_timeout(120)
    page.mouse.up()
    settled(lambda: window.sight.wish.gap_mm < before.gap_mm - 0.5)
    assert window.sight.wish.x_mm == pytest.approx(before.x_mm, abs=0.05)


def test_page_of_another_origin_gets_nothing(browser, window: LiveWindow, tmp_path: Path):
    (tmp_path / "index.html").write_text("<p>elsewhere</p>", encoding="utf-8")
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=str(tmp_path))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{other.server_port}/")
        answer = page.evaluate(
            """address => new Promise(done => { const socket = new WebSocket(address, ['viser-v1.1.1']);
            socket.onopen = () => done('open'); socket.onerror = () => done('refused'); })""",
            window.address.replace("http", "ws"),
        )
        assert answer == "refused"
        page.close()
        other.shutdown()
