"""White furnace: in a world of equal radiance nothing loses or gains light, at rest and deformed.

Without absorption and with radiance 1 all around, the fluence in a medium of index n is 4 pi n^2 everywhere, and a
camera sees 1 less the part that it would see mirrored in the lens face, which the dark housing keeps away.
"""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.plan import can_touch
from magicsim.scenes.finish import Finish
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import timeline
from magicsim.simulation import Sensor

CLEAR = (
    "design.materials.body.absorption_per_mm=0",
    "design.materials.infill.absorption_per_mm=0",
    "design.footprint_mm=[8, 9]",
    "rig.camera.field_mm=7.5",
    "rig.strips=[]",
)


def furnace(scene: SceneConfig, monkeypatch):
    """The deformed, object-free world of a scene in an environment of radiance 1."""
    from magicsim.scenes import world as world_module

    build = world_module._scene

    def surrounded(*arguments):
        environment = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
        return {**build(*arguments), "environment": environment}

    monkeypatch.setattr(world_module, "_scene", surrounded)
    sensor = Sensor(scene)
    state = timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest) if can_touch(state) else sensor.rest
    view = sensor.view(state, deformation)
    content = world_module.WorldContent(object_mesh=None, object_finish=Finish(), flashlight=False)
    world = world_module.World(sensor.elastomer, scene.rig, content, sensor.renderer._integrator())
    if view.body is not None:
        world.update(body=view.body, infill=view.infill)
    return world.scene


@pytest.mark.parametrize("name", ["rest", "pressed"])
def test_light_pass_fills_every_cell_with_the_furnace_fluence(name, small_scene, monkeypatch):
    scene = small_scene(name, *CLEAR)
    loaded = furnace(scene, monkeypatch)
    field = loaded.integrator().light(loaded, "environment", particles=400_000, seed=3)
    expected = 4 * np.pi * scene.design.materials.infill.ior**2
    ratio = field.fluence / expected
    assert ratio.mean() == pytest.approx(1, abs=0.005)
    assert np.abs(ratio - 1).max() < 0.12  # single cells, Monte Carlo noise of about 0.03 included


@pytest.mark.parametrize("name", ["rest", "pressed"])
def test_camera_pass_leaks_no_light(name, small_scene, monkeypatch):
    scene = small_scene(name, *CLEAR)
    loaded = furnace(scene, monkeypatch)
    integrator = loaded.integrator()
    field = integrator.light(loaded, "environment", particles=64, seed=1)
    even = replace(field, fluence=np.full_like(field.fluence, 4 * np.pi * scene.design.materials.infill.ior**2))
    image = np.array(integrator.gather(loaded, even, samples=64, seed=1))
    body = scene.design.materials.body.ior
    mirrored = ((body - 1) / (body + 1)) ** 2
    assert image.mean() == pytest.approx(1 - mirrored, abs=0.005)
    assert np.isfinite(image).all()
