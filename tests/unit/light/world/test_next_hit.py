"""Hits found from the cell that a ray is in are those of Embree's search, however the cells are deformed."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.world.medium import leave
from magicsim.light.world.next_hit import IN_CELL, IN_WALL, next_hit, whereabouts
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import View
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = ["design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28"]
RAYS = 40_000


def at_rest(vertices):
    return vertices


def pressed_and_sheared(vertices):
    x, y, z = vertices.T
    near = np.exp(-(x**2 + y**2) / 8)
    return np.stack([x + 0.3 * near * z, y, z + 0.15 * near * (6.6 - z)], 1)


def dented(vertices):
    """Every cell's faces bulge in and out by up to 10 um."""
    return vertices + 0.01 * np.stack([np.sin(9 * vertices[:, (k + 1) % 3] + k) for k in range(3)], 1)


def grid_and_scene(deformation, *overrides):
    sensor = Sensor.for_scene(load_scene("rest", [*SMALL, *overrides]))
    infill = deformation(sensor.elastomer.infill.vertices)
    light = sensor.renderer.light(View(infill=infill))
    return light.inventory.shapes(), light.scene


def continued(si, infill, faces, random):
    """Rays that go on from hits on walls, two thirds straight on and one third reflected, and where they start."""
    on_wall = si.is_valid() & (si.shape == infill)
    turned = random.next_float32() < 1 / 3
    outside = (mi.Frame3f.cos_theta(si.wi) > 0) == turned
    local = mi.warp.square_to_cosine_hemisphere(mi.Point2f(random.next_float32(), random.next_float32()))
    local.z = dr.select(outside, local.z, -local.z)
    way = si.to_world(dr.select(turned, local, -si.wi))
    return leave(si, way), whereabouts(si, on_wall, mi.Bool(False), outside, faces), on_wall


@pytest.mark.parametrize(
    ("deformation", "setting"),
    [
        pytest.param(at_rest, "design.lattice.spacing_mm=1", marks=pytest.mark.slow),
        (pressed_and_sheared, "design.lattice.spacing_mm=1"),
        (dented, "design.lattice.spacing_mm=1"),
        pytest.param(pressed_and_sheared, "design.lattice.spacing_mm=0.4", marks=pytest.mark.slow),
        (pressed_and_sheared, "design.unevenness.torn_share=0.1"),
    ],
)
def test_hits_are_those_of_a_search_through_all_triangles(deformation, setting):
    shapes, scene = grid_and_scene(deformation, setting)
    random = mi.PCG32(size=RAYS)
    x, y, z = (random.next_float32() for _ in range(3))
    way = mi.warp.square_to_uniform_sphere(mi.Point2f(random.next_float32(), random.next_float32()))
    ray, (body, infill, _) = mi.Ray3f(mi.Point3f(6 * x - 3, 7 * y - 3.5, 0.9 + 4.8 * z), way), shapes.pointers()
    si = scene.ray_intersect(ray)
    for _ in range(3):
        ray, at, on_wall = continued(si, infill, shapes.faces, random)
        dr.eval(ray, at, on_wall, random)  # once, and not anew for every array below
        wanted = scene.ray_intersect(ray, on_wall)
        si = next_hit(scene, ray, body, infill, shapes.faces, at, on_wall)
        dr.eval(si, wanted)
        known = np.array(on_wall)
        different = known & (np.array(si.prim_index) != np.array(wanted.prim_index))
        # Rays through an edge may count to either of its triangles.
        assert different.sum() <= 1e-4 * known.sum()
        same = known & ~different & np.array(wanted.is_valid())
        # A tenth of a micrometre: rays that graze a wall magnify the last bits.
        np.testing.assert_allclose(np.array(si.t)[same], np.array(wanted.t)[same], atol=1e-4)
        for name in ("p", "n", "wi"):
            # The frames turn differently about the normal, so of the direction only its height is the same.
            got, sought = (np.array(getattr(hit, name))[-1 if name == "wi" else slice(None)] for hit in (si, wanted))
            np.testing.assert_allclose(got[..., same], sought[..., same], atol=3e-4)
        assert (np.array(si.shape == infill) == np.array(wanted.shape == infill))[known & ~different].all()


@pytest.mark.parametrize(("deformation", "least"), [(at_rest, 0.999), (pressed_and_sheared, 0.5), (dented, 0.7)])
def test_most_hits_in_cells_need_no_search(deformation, least):
    shapes, scene = grid_and_scene(deformation)
    random = mi.PCG32(size=RAYS)
    x, y, z = (random.next_float32() for _ in range(3))
    way = mi.warp.square_to_uniform_sphere(mi.Point2f(random.next_float32(), random.next_float32()))
    body, infill, _ = shapes.pointers()
    si = scene.ray_intersect(mi.Ray3f(mi.Point3f(6 * x - 3, 7 * y - 3.5, 0.9 + 4.8 * z), way))
    ray, at, on_wall = continued(si, infill, shapes.faces, random)
    nothing = mi.load_dict({"type": "scene"})
    found = np.array(next_hit(nothing, ray, body, infill, shapes.faces, at, on_wall).is_valid())
    inside, beside = (np.array(on_wall & (at.kind == kind)) for kind in (IN_CELL, IN_WALL))
    assert found[inside].mean() >= least
    assert found[beside].mean() > 0.3


def test_the_state_of_the_grid_follows_its_mesh():
    sensor = Sensor.for_scene(load_scene("rest", SMALL))
    rest = sensor.elastomer.infill.vertices
    lowest = []
    for infill in (None, pressed_and_sheared(rest), dented(rest), None):
        inventory = sensor.renderer.light(View(infill=infill)).inventory
        patches = np.array(inventory.shapes().faces.patches).reshape(-1, 28)[:, :27]
        lowest.append(patches.reshape(-1, 3).min(0))
        wanted = rest if infill is None else infill
        np.testing.assert_allclose(lowest[-1], wanted.min(0), atol=1e-5)
    assert np.ptp(lowest, axis=0).max() > 0.005


def test_the_housing_around_a_lit_room_is_no_stranger_in_the_grid():
    shapes, _ = grid_and_scene(at_rest, "rig.ambient=[0.5,1,0.7]")
    assert shapes.faces is not None


def test_a_strip_under_a_thin_skin_is_not_overlooked():
    shapes, _ = grid_and_scene(at_rest, "design.skin_mm=0.1")
    assert shapes.faces is None
