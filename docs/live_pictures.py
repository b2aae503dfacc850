"""Makes the pictures of the live window, in Chromium: a ball pressed and sheared, at desktop and phone width.

    python docs/live_pictures.py [--scene grip] [--set dotted.key=value ...] [--out docs]

Needs the extra `browser` and Chromium or Chrome on the machine.
"""

import argparse
import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from magicsim.live import LiveWindow, find_subject
from magicsim.live.sight import Wish

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
DESKTOP, PHONE = (1360, 860), (390, 844)
LONGEST_S = 900.0


def settle(window: LiveWindow, wish: Wish) -> None:
    """Asks for a wish and waits until it is shown with its frame."""
    window.ask(wish)
    end = time.monotonic() + LONGEST_S
    while window.busy is not None or window.sight is None or window.sight.wish != wish:
        if time.monotonic() > end:
            raise SystemExit("live_pictures: the window did not come to rest")
        time.sleep(0.1)


def opened(browser: object, window: LiveWindow, size: tuple[int, int]) -> Page:
    """The window's page, drawn."""
    page: Page = browser.new_page(viewport={"width": size[0], "height": size[1]})  # type: ignore[attr-defined]
    page.set_default_timeout(240_000)
    page.goto(window.address)
    page.wait_for_selector("table.forces", state="attached")
    page.add_style_tag(content=".mantine-Notification-root { display: none }")  # that no graphics card draws
    page.wait_for_timeout(3000)
    return page


def main() -> None:
    """Takes two pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="grip")
    parser.add_argument("--set", dest="settings", action="append", default=[])
    parser.add_argument("--out", type=Path, default=Path("docs"))
    options = parser.parse_args()
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        raise SystemExit(f"live_pictures: no browser on this machine, any of {', '.join(BROWSERS)} will do")
    scene = find_subject(options.scene, options.settings)
    folder = Path(tempfile.mkdtemp())
    with LiveWindow(scene, folder=folder) as window, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found, args=["--no-sandbox", "--enable-unsafe-swiftshader"])
        start = window.wish
        for gap_mm, x_mm in ((2.0, 0.0), (-0.4, 0.0), (-0.9, 0.0), (-0.9, 0.5)):
            settle(window, replace(start, gap_mm=gap_mm, x_mm=x_mm))
        for name, size in (("pressed", DESKTOP), ("phone", PHONE)):
            page = opened(browser, window, size)
            page.screenshot(path=options.out / f"live-{name}.png")
            page.close()
        browser.close()


if __name__ == "__main__":
    main()
