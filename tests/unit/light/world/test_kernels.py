"""Kernels that are compiled serve every printed unit: what a print's tolerances change is no literal of them."""

import pytest

from magicsim.light.backend import dr
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

SMALL = (
    "rig.camera.columns=24", "rig.camera.rows=32", "render.samples=1", "render.particles=1000",
    "render.anchor_samples=2", "render.anchor_particles=2000", "render.light_change=0", "design.lattice.cells_across=0",
)  # fmt: skip
TOUCH = FrameState(gap_mm=-0.5, x_mm=0, y_mm=0, twist_deg=0.0, flashlight=False, light_x_mm=0)


def kernels_of(*settings: str) -> set[str]:
    """Hashes of what an untouched and a touched image of a sensor run."""
    sensor = Sensor.for_scene(load_scene("pressed", [*SMALL, *settings], seed=1))
    dr.kernel_history_clear()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        sensor.radiance(UNTOUCHED, sensor.rest)
        sensor.radiance(TOUCH, sensor.deform(TOUCH, sensor.rest))
    return {each["hash"] for each in dr.kernel_history() if each["type"] == dr.KernelType.JIT}


def test_a_unit_with_other_indices_and_absorption_compiles_nothing():
    first = kernels_of()
    unit = (
        "design.materials.body.ior=1.487", "design.materials.infill.ior=1.462",
        "design.materials.infill.sigma_s_per_mm=0.31", "design.materials.body.absorption_per_mm=0.005",
    )  # fmt: skip
    assert len(first) > 10
    assert kernels_of(*unit) == first


@pytest.fixture(autouse=True)
def _forgets():
    yield
    dr.kernel_history_clear()
