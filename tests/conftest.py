"""No test reads or writes the user's cache, or takes from it what it is to compute; pages open in a real browser."""

import os
import shutil
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

os.environ["MAGICSIM_CACHE"] = "off"
# Where no bytecode may be written, every process that a test starts compiles the whole package again: seconds each.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SIZES = {"desktop": (1280, 900), "phone": (390, 844)}
HARMLESS = ("GPU stall due to ReadPixels", "THREE.Clock", "[Performance]")
"""Of software rendering, and of a library's own future; warnings, no errors."""
OWN = ("file:", "data:", "blob:", "http://127.0.0.1:", "ws://127.0.0.1:")


def pytest_terminal_summary(terminalreporter) -> None:
    """Writes the seconds of every file, then of every test over a second, longest first, into `MAGICSIM_DURATIONS`."""
    if "MAGICSIM_DURATIONS" not in os.environ:
        return
    files: Counter[str] = Counter()
    tests: Counter[str] = Counter()
    for report in (each for reports in terminalreporter.stats.values() for each in reports):
        if isinstance(report, pytest.TestReport):
            files[report.nodeid.partition("::")[0]] += report.duration
            tests[report.nodeid] += report.duration
    long = [(name, seconds) for name, seconds in tests.most_common() if seconds > 1]
    lines = [f"{seconds:8.2f}  {name}" for name, seconds in files.most_common() + long]
    path = Path(os.environ["MAGICSIM_DURATIONS"])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([f"{sum(files.values()):8.2f}  all", *lines]) + "\n", encoding="utf-8")


def pytest_collection_finish() -> None:
    """No episode renders a frame of each kind before its first: that compiles kernels, which timings alone need."""
    if (module := sys.modules.get("magicsim.simulation.sensor")) is not None:
        module.Sensor.warm_up = lambda *_: None


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    """Chromium. Who asks for it (`-m browser`) gets a failure and no skip where it is missing."""
    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError:
        pytest.fail("playwright is missing: pip install -e .[browser]")
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.fail(f"no browser on this machine, any of {', '.join(BROWSERS)} will do")
    with sync_playwright() as driver:
        running = driver.chromium.launch(
            executable_path=found, args=["--no-sandbox", "--enable-unsafe-swiftshader", "--use-gl=angle"]
        )
        yield running
        running.close()


@contextmanager
def watched(browser, size: tuple[int, int], *, is_touched: bool = False) -> Iterator[object]:
    """An empty page, which must end without an error or an outside request."""
    width, height = size
    opened = browser.new_page(viewport={"width": width, "height": height}, has_touch=is_touched)
    complaints: list[str] = []

    def heard(said) -> None:
        if said.type in {"error", "warning"} and not any(each in said.text for each in HARMLESS):
            complaints.append(said.text)

    opened.on("console", heard)
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda asked: None if asked.url.startswith(OWN) else complaints.append(asked.url))
    yield opened
    opened.close()
    assert complaints == []


@pytest.fixture(params=SIZES)
def page(request, browser) -> Iterator[object]:
    """A watched page at desktop and at phone width."""
    with watched(browser, SIZES[request.param], is_touched=request.param == "phone") as opened:
        yield opened


@pytest.fixture
def small_page(browser) -> Iterator[object]:
    """A watched page that is cheap to draw in 3D without a graphics card."""
    with watched(browser, (720, 480)) as opened:
        yield opened


@pytest.fixture
def tabbed():
    """What the Tab key reaches on a page, in order, each once, as (tag, what it is called)."""

    def walk(page, most: int = 200) -> list[tuple[str, str]]:
        reached: dict[int, tuple[str, str]] = {}
        for _ in range(most):
            page.keyboard.press("Tab")
            place, tag, name = page.evaluate(
                """() => { const e = document.activeElement;
                return [[...document.querySelectorAll('*')].indexOf(e), e.tagName.toLowerCase(),
                (e.getAttribute('aria-label') || e.innerText || e.id || e.name || '').trim().slice(0, 60)]; }"""
            )
            if place in reached:
                break
            if tag != "body":
                reached[place] = (tag, name)
        return list(reached.values())

    return walk
