"""Sensors of one make share compiled kernels, whatever their numbers are, and so do frames of one sensor.

To compile a kernel takes longer than most frames.
"""

import gc
import weakref
from dataclasses import replace

import pytest

from magicsim.light.backend import VARIANT, dr
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, View
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = [
    "design.footprint_mm=[8,9]", "rig=digit-rgb", "rig.camera.field_mm=7", "rig.camera.columns=16",
    "rig.camera.rows=18", "render.anchor_samples=0", "render.particles=500", "render.samples=2",
]  # fmt: skip
OTHER = [
    "render.particles=700", "render.samples=3", "design.materials.infill.sigma_s_per_mm=0.9",
    "design.materials.body.ior=1.487", "design.materials.infill.ior=1.462",
]  # fmt: skip
LARGE = 500
"""Operations of a kernel from which on it is one of a pass."""


def kernels(*settings: str, seed: int) -> set[str]:
    gc.collect()  # a scene that another test left, and that goes in between, would move data that kernels point at
    renderer = Sensor.for_scene(load_scene("rest", [*SMALL, *settings], seed=seed)).renderer
    dr.kernel_history_clear()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        renderer.plain_radiance(View())
    return {each["hash"] for each in dr.kernel_history() if each.get("operation_count", 0) > LARGE}


def test_sensors_of_other_numbers_need_no_other_kernels():
    first = kernels(seed=1)
    assert len(first) >= 2  # of light and of the camera
    assert kernels(*OTHER, seed=2) == first


@pytest.mark.parametrize("gaps_mm", [(2.0, 1.5, 1.1), (-0.1, -0.15, -0.2)], ids=["near", "touched"])
def test_frames_of_other_gaps_need_no_other_kernels(gaps_mm: tuple[float, ...]):
    room = [
        "rig.ambient=[0.05,0.05,0.05]",
        "object.radius_mm=3",
        "render.anchor_samples=8",
        "render.anchor_particles=20000",
    ]
    sensor, found = Sensor.for_scene(load_scene("pressed", [*SMALL, *room], seed=1)), []
    for gap_mm in gaps_mm:
        state = replace(UNTOUCHED, gap_mm=gap_mm)
        deformation = sensor.deform(state, sensor.rest)
        gc.collect()
        dr.kernel_history_clear()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
            sensor.radiance(state, deformation)
        found.append({each["hash"] for each in dr.kernel_history() if "hash" in each})
    assert len(found[1]) >= 5
    assert found[2] <= found[0] | found[1]


def test_a_sensor_that_is_no_more_used_leaves_no_scene_behind():
    """Shapes that live on change the numbers of those that come, and with them all kernels."""
    sensor = Sensor.for_scene(load_scene("rest", SMALL, seed=5))
    sensor.renderer.plain_radiance(View())
    inventory = weakref.ref(sensor.renderer.light(View()).inventory)
    gc.disable()
    try:
        del sensor
        assert inventory() is None
    finally:
        gc.enable()
