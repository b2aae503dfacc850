"""Rays that go on from a surface are off it: on the right side, and by so little that no scattering is missed."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.world.medium import leave
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = [
    "rig=digit-rgb",
    "design.footprint_mm=[8,9]",
    "rig.camera.field_mm=7",
    "rig.camera.columns=24",
    "rig.camera.rows=28",
]
RAYS = 200_000


@pytest.fixture(scope="module")
def hits():
    """A pressed sensor, and where rays from everywhere in it meet its surfaces."""
    scene = load_scene("pressed", SMALL)
    sensor, frame = Sensor.for_scene(scene), timeline(scene)[0]
    loaded = sensor.renderer.world(sensor.view(frame, sensor.deform(frame, sensor.rest))).scene
    random = mi.PCG32(size=RAYS)
    x, y, z, u, v = (random.next_float32() for _ in range(5))
    inside = mi.Point3f(8 * x - 4, 9 * y - 4.5, 6.6 * z)
    si = loaded.ray_intersect(mi.Ray3f(inside, mi.warp.square_to_uniform_sphere(mi.Point2f(u, v))))
    return loaded, si, random


@pytest.mark.parametrize("side", [1, -1])
def test_no_ray_meets_the_triangle_that_it_leaves(hits, side):
    loaded, si, random = hits
    local = side * mi.warp.square_to_cosine_hemisphere(mi.Point2f(random.next_float32(), random.next_float32()))
    then = loaded.ray_intersect(leave(si, si.to_world(local)), si.is_valid())
    again = then.is_valid() & (then.shape == si.shape) & (then.prim_index == si.prim_index)
    assert dr.count(si.is_valid())[0] > 0.9 * RAYS
    assert dr.count(again)[0] == 0
    # The same from the surface itself would not do.
    still = loaded.ray_intersect(mi.Ray3f(si.p, si.to_world(local)), si.is_valid())
    same = still.is_valid() & (still.shape == si.shape) & (still.prim_index == si.prim_index)
    assert dr.count(same)[0] > 0.1 * RAYS


@pytest.mark.parametrize("side", [1, -1])
def test_rays_start_on_their_own_side_less_than_a_micrometre_off(hits, side):
    _, si, _ = hits
    way = side * si.n
    off = np.array(dr.dot(leave(si, way).o - si.p, way))[np.array(si.is_valid())]
    assert (off > 0).all()
    assert (off < 3e-4).all()
