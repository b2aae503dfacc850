"""A sensor small enough to solve in a test."""

import pytest

from magicsim.scenes.scene import SceneConfig, load_scene

BLOCK = [
    "design=uniform-block", "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.5",
    "design.lattice.cells_across=0", "rig.camera.columns=24", "rig.camera.rows=32",
]  # fmt: skip
"""A block without a grid: solved fast, and never rendered."""


@pytest.fixture(scope="session")
def block() -> SceneConfig:
    return load_scene("grip", BLOCK)
