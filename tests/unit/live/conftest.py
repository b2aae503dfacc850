"""A window whose sensor is small enough to be solved and rendered in a test."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import viser

from magicsim.live.server import open_server
from magicsim.live.session import find_subject
from magicsim.live.window import LiveWindow
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig

TINY = [
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
    "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10", "render.samples=1",
    "render.particles=1000", "render.anchor_samples=1", "render.anchor_particles=2000", "references=3",
    "object.radius_mm=4", "contact.friction=0",
]  # fmt: skip
SPACE = Workspace(x_mm=(-2, 2), y_mm=(-2, 2), twist_deg=(-30, 30), gap_mm=(-1, 10))
PORT = 8470


@pytest.fixture(scope="session")
def tiny_scene() -> SceneConfig:
    return find_subject("grip", TINY)


@pytest.fixture(scope="session")
def until() -> Callable[[Callable[[], bool]], None]:
    """Waits until something holds."""

    def wait(holds: Callable[[], bool], seconds: float = 120.0) -> None:
        end = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < end, "it never came about"
            time.sleep(0.02)

    return wait


@pytest.fixture(scope="module")
def servers() -> Iterator[list[viser.ViserServer]]:
    """Those that windows of a module have opened."""
    opened: list[viser.ViserServer] = []

    def open_and_keep(port: int, title: str) -> viser.ViserServer:
        opened.append(open_server(port, title))
        return opened[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("magicsim.live.window.open_server", open_and_keep)
        yield opened


@pytest.fixture(scope="module")
def window(tiny_scene: SceneConfig, until, servers, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveWindow]:
    folder: Path = tmp_path_factory.mktemp("recordings")
    with LiveWindow(tiny_scene, folder=folder, port=PORT, workspace=SPACE) as opened:
        until(lambda: opened.busy is None and opened.sight is not None)
        yield opened


@pytest.fixture
def viewers(window: LiveWindow, servers: list[viser.ViserServer]) -> Callable[[], list[viser.ClientHandle]]:
    """Tells which pages are connected with the window."""
    return lambda: list(servers[-1].get_clients().values())
