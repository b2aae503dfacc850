import numpy as np
import pytest

from magicsim.light.backend import VARIANT, mi
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import View
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = [
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28",
    "design.materials.body.sigma_s_per_mm=0.2",
]  # fmt: skip


def block_and_light(*overrides):
    sensor = Sensor.for_scene(load_scene("rest", [*SMALL, *overrides]))
    return sensor.elastomer, sensor.renderer.light(View())


def test_parts_of_the_body_add_up_to_walls_and_skin_between_the_strips():
    elastomer, light = block_and_light()
    volumes = light.body_part().held_mm3
    whole = elastomer.body.volume_mm3() - elastomer.infill.volume_mm3()
    assert volumes.sum() == pytest.approx(whole, rel=0.005)


def test_centres_lie_in_their_voxels():
    _, light = block_and_light()
    voxels, centres = light.voxels, light.body_part().centres_mm
    found = voxels.index(mi.Point3f(*centres.T.astype(np.float32)))
    np.testing.assert_array_equal(np.array(found), np.arange(voxels.count))


def test_inner_voxels_start_where_the_strips_shine_from():
    elastomer, light = block_and_light("design.cell_mm=0")
    voxels, half = light.voxels, np.array(elastomer.design.footprint_mm) / 2 - 0.2
    low = np.array(voxels.origin_mm[:2]) + voxels.size_mm[:2]
    np.testing.assert_allclose(low, -half)
    np.testing.assert_allclose(low + np.array(voxels.inner_counts[:2]) * voxels.size_mm[:2], half)
    assert len(voxels.inner) == np.prod(voxels.inner_counts)


def test_points_outside_count_to_the_nearest_voxel():
    voxels = block_and_light()[1].voxels
    far = voxels.index(mi.Point3f([-99.0, 99.0], [-99.0, 99.0], [-99.0, 99.0]))
    assert np.array(far).tolist() == [0, voxels.count - 1]
