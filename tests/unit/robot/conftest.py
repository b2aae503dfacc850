"""Sensors small enough to solve and render in a test, built once and reset before each."""

from collections.abc import Iterator

import pytest

from magicsim.robot.live import LiveSensor, live_sensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene

TINY = [
    "rig.room='dark'", "rig.camera.exposure_grey=90",
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
    "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10", "render.samples=2",
    "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=2000", "references=2",
    "object.radius_mm=4",
]  # fmt: skip
BLOCK = [
    "design=uniform-block", "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.5",
    "design.lattice.cells_across=0", "rig.camera.columns=24", "rig.camera.rows=32", "object.radius_mm=4",
]  # fmt: skip
"""A block without a grid, whose contact is solved fast; it scatters nothing, so it gives no image."""
RANGE = Workspace(x_mm=(-2, 2), y_mm=(-4, 2), twist_deg=(0, 0), gap_mm=(-1.5, 30))


@pytest.fixture(scope="session")
def tiny_scene() -> SceneConfig:
    return load_scene("pressed", TINY)


@pytest.fixture(scope="session")
def shared_live(tiny_scene: SceneConfig) -> Iterator[LiveSensor]:
    with LiveSensor(tiny_scene, workspace=RANGE) as live:
        yield live


@pytest.fixture
def live(shared_live: LiveSensor) -> LiveSensor:
    """A frictionless sensor that renders, 24 x 32 pixels, untouched."""
    shared_live.set_image_size(columns=24, rows=32)
    shared_live.set_frame_rate(15)
    shared_live.reset()
    return shared_live


@pytest.fixture(scope="session")
def shared_rubbing() -> Iterator[LiveSensor]:
    with live_sensor("grip", BLOCK, workspace=RANGE) as live:
        yield live


@pytest.fixture
def rubbing(shared_rubbing: LiveSensor) -> LiveSensor:
    """A sensor with friction 0.8 that is solved and not rendered, untouched."""
    shared_rubbing.reset()
    return shared_rubbing
