"""Sensors of one make share compiled kernels, whatever their numbers are: to compile takes longer than most frames."""

import gc

import pytest

from magicsim.light.backend import VARIANT, dr
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import View
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
