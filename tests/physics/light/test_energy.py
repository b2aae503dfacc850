"""Energy balance of the light pass: what the lights emit is absorbed or escapes, at rest and deformed."""

import pytest

from magicsim.plan import can_touch
from magicsim.scenes.timeline import timeline
from magicsim.simulation import Sensor

SMALL = ("design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "object.radius_mm=3")


@pytest.mark.parametrize(
    ("state", "overrides"),
    [
        ("near", ()),
        ("pressed", ("object.specular=0.5",)),
        ("pressed", ("design.materials.body.sigma_s_per_mm=0.3", "design.materials.infill.sigma_s_per_mm=2")),
    ],
)
def test_emitted_light_is_absorbed_or_escapes(state, overrides, small_scene):
    from magicsim.scenes.integrator import lights
    from magicsim.scenes.light_pass import FIXED_POINT, deposit_tracks

    scene = small_scene(state, *SMALL, *overrides)
    sensor = Sensor(scene)
    frame = timeline(scene)[0]
    world = sensor.renderer.world(
        sensor.view(frame, sensor.deform(frame, sensor.rest) if can_touch(frame) else sensor.rest)
    )
    integrator = world.scene.integrator()
    for name in lights(world.scene):
        tracks = deposit_tracks(
            world.scene, integrator.emitter(world.scene, name), integrator.shapes(world.scene), integrator.media,
            integrator.voxels, first=0, particles=100_000, seed=5, inside=name in integrator.inside, is_room=False,
            max_depth=400, balance=True,
        )  # fmt: skip
        account = tracks.balance
        infill = integrator.media.infill.sigma_a * tracks.cells.reshape(-1, 3).sum(0) / FIXED_POINT
        body = integrator.media.body.sigma_a * tracks.body.reshape(-1, 3).sum(0) / FIXED_POINT
        spent = infill + body + account.clear_body + account.surfaces + account.escaped
        assert (spent >= 0).all()
        assert spent.sum() == pytest.approx(account.emitted.sum(), rel=0.005)
        assert abs(account.ended.sum()) < 0.005 * account.emitted.sum()
