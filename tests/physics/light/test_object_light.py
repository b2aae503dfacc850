"""Light on the object, gathered by rays from it, is what particles bring to it, with less noise."""

import numpy as np
import pytest

from magicsim.light.transport.light_field import total
from magicsim.light.world.shapes import wetted
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor

SMALL = ("design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "object.radius_mm=3")
PARTICLES = 100_000


def lit(scene, *, particles):
    """Irradiance by particles that land and by rays that gather, the areas of the triangles, and which are wet."""
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest) if state.gap_mm < 0 else sensor.rest
    view = sensor.view(state, deformation)
    light, mesh = sensor.renderer.light(view), sensor.renderer.object_mesh
    shares = dict.fromkeys(light.lights, particles)
    fields = [total(list(light.light_fields(shares, seed=seed).values())) for seed in (1, 2)]
    gathered = [light.with_lit_object(each, particles=20_000, seed=seed).irradiance for seed, each in enumerate(fields)]
    landed = (fields[0].irradiance + fields[1].irradiance) / 2
    a, b, c = mesh.vertices[mesh.faces].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    height = view.indenter.pose.to_sensor(mesh.vertices)[mesh.faces, 2].mean(1)
    return landed, gathered, area[:, None], height, wetted(light.scene, light.inventory.shapes())


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        pytest.param("near", (), marks=pytest.mark.slow),
        ("pressed", ()),
        pytest.param("near", ("rig.ambient=[0.3,0.2,0.1]",), marks=pytest.mark.slow),
        pytest.param("pressed", ("design.materials.body.sigma_s_per_mm=0.3",), marks=pytest.mark.slow),
    ],
)
def test_rays_bring_as_much_light_as_particles(small_scene, name, overrides):
    landed, (gathered, other), area, height, wet = lit(small_scene(name, *SMALL, *overrides), particles=PARTICLES)
    for part in (wet, ~wet & (height > -1.5)):
        if part.any():
            both = (gathered + other) / 2
            known, found = ((each * area)[part].sum(0) / area[part].sum() for each in (landed, both))
            np.testing.assert_allclose(found, known, rtol=0.03)
            noise = np.sqrt(((gathered - other)[part] ** 2 * area[part]).sum(0) / area[part].sum() / 2)
            assert (noise < 0.1 * known).all()


def test_a_dark_sensor_leaves_the_object_dark(small_scene):
    scene = small_scene("near", *SMALL, "rig.strips=[]")
    sensor = Sensor.for_scene(scene)
    light = sensor.renderer.light(sensor.view(timeline(scene)[0], sensor.rest))
    found = light.with_lit_object(light.darkness(), particles=1000, seed=1)
    assert not found.irradiance.any()
