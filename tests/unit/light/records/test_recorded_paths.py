"""Recorded camera paths and things in a scene of their own give what one scene and one estimator give."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.light.backend import VARIANT
from magicsim.light.transport.light_field import LightField
from magicsim.light.transport.lit_world import CAMERA_DEPTH
from magicsim.light.transport.path_record import STEPS
from magicsim.light.transport.streams import MIRRORED, SEEDS_PER_RENDER
from magicsim.light.world.loaded_scene import Outsides
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import View
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = [
    "rig=digit-rgb",
    "design.footprint_mm=[8,9]",
    "rig.camera.field_mm=7",
    "rig.camera.columns=24",
    "rig.camera.rows=28",
]
SAMPLES, SEED = 5, 3


def small(name, *overrides):
    overrides = [*overrides, "object.radius_mm=3"] if name == "near" else list(overrides)
    sensor = Sensor.for_scene(load_scene(name, [*SMALL, *overrides]))
    return sensor.renderer, sensor.view(sensor.states[0], sensor.rest)


def outside_of(renderer, view):
    """What stands before the block, in a scene of its own."""
    return Outsides(renderer.rig, renderer.object_mesh, renderer.object_finish, renderer.load_world).of(
        view.indenter and view.indenter.pose.to_sensor(renderer.object_mesh.vertices), view.flashlight_x_mm
    )


def smooth_field(rest, outside):
    """Some light that varies gently enough to stay positive within every cell."""
    dark, places = rest.darkness(outside), rest.inventory.centres_mm()
    waves = np.stack([2 + np.sin(places @ [0.2, 0.1 * k, 0.3]) for k in range(3)], 1)
    lit = np.linspace(0.5, 1.5, dark.irradiance.size).reshape(dark.irradiance.shape)
    return LightField(fluence=waves, body=dark.body + 0.3 * rest.held_mm3(), irradiance=lit)


def recorded_light(rest, particles):
    """What leaves the untouched block of so many particles of each light."""
    from magicsim.light.records.untouched_passes import untouched

    shares = dict.fromkeys(rest.lights, particles)
    return untouched(
        rest, shares, seed=SEED, samples=1, most=1, recorded=particles, with_room=False, regions=None
    ).light


def gathered(light, field):
    return np.array(light.gather(field, samples=SAMPLES, seed=SEED), np.float64)


@pytest.mark.parametrize("name", ["near", "flashlight"])
@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("rig.ambient=[0.1,0.2,0.3]",),
        ("design.materials.body.sigma_s_per_mm=0.2",),
        ("design.materials.infill.sigma_s_per_mm=2", "design.materials.infill.anisotropy=0.8"),
        (
            "design.roughness.skin=0.1",
            "design.inclusions.bubbles_per_mm3=1",
            "design.inclusions.flakes_per_mm3=1",
            "design.unevenness.torn_share=0.05",
        ),
    ],
    ids=["clear", "in a lit room", "body that scatters", "infill that scatters forward", "print with flaws"],
)
def test_recorded_paths_give_the_gathered_image(name, overrides):
    from magicsim.light.records.untouched_passes import recorded_paths

    renderer, view = small(name, *overrides)
    seen, outside, rest = renderer.light(view), outside_of(renderer, view), renderer.light(View())
    field = smooth_field(rest, outside)
    wanted = gathered(seen, field) - gathered(rest, rest.darkness())
    paths = recorded_paths(rest, seed=SEED, samples=SAMPLES)
    pixels = np.arange(24 * 28, dtype=np.uint32)
    glow = paths.glow(rest.elements(field), pixels)
    beyond = paths.seen_outside(rest.inventory.environment, outside, field.irradiance, renderer.object_finish, pixels)
    assert np.median(glow) > 0.005
    assert np.abs(beyond).mean() > 0.01
    # Only where rounding sends a path another way do the two differ.
    difference = np.abs((glow + beyond).reshape(28, 24, 3) - wanted).max(2) / wanted.mean()
    assert np.median(difference) < 1e-5
    assert np.mean(difference > 1e-3) < 0.02


def test_what_a_glossy_thing_mirrors_is_that_in_one_scene():
    from magicsim.light.records.untouched_passes import recorded_paths

    many, few, seeds = 16, 8, 16
    renderer, view = small("near", "object.specular=0.6", "object.roughness=0.3", "object.color=[0,0,0]")
    seen, outside, rest = renderer.light(view), outside_of(renderer, view), renderer.light(View())
    field, pixels = smooth_field(rest, outside), np.arange(24 * 28, dtype=np.uint32)
    wanted, found = [], []
    for seed in range(seeds):
        with_it, without = (np.array(each.gather(field, samples=many, seed=seed), np.float64) for each in (seen, rest))
        wanted.append(blocks(with_it - without))
        paths = recorded_paths(rest, seed=seed, samples=many)
        mirrored = paths.mirrored(
            outside, renderer.object_finish, pixels, lambda starts, seed=seed: rest.camera_pass(
                field, starts, stream=SEEDS_PER_RENDER * seed + MIRRORED, outside=outside
            ), samples=few, seed=seed,
        )  # fmt: skip
        found.append(blocks(mirrored))
    assert np.mean(wanted) > 0.01
    assert np.mean(found) == pytest.approx(np.mean(wanted), rel=0.05)
    difference = np.array(found) - wanted
    in_errors = difference.mean(0) / np.maximum(difference.std(0, ddof=1) / np.sqrt(seeds), 1e-4)
    assert np.sqrt(np.mean(in_errors**2)) < 1.5


def blocks(image):
    return image.reshape(4, 7, 4, 6, 3).mean((1, 3))


def test_every_interaction_of_a_path_has_a_number_of_its_own():
    assert CAMERA_DEPTH < STEPS


def test_mirrored_paths_are_none_without_a_mirror():
    from magicsim.light.records.untouched_passes import recorded_paths

    renderer, view = small("near", "object.specular=0.0")
    paths = recorded_paths(renderer.light(View()), seed=SEED, samples=1)
    pixels = np.arange(5, dtype=np.uint32)
    found = paths.mirrored(
        outside_of(renderer, view),
        renderer.object_finish,
        pixels,
        lambda _: pytest.fail("nothing to follow"),
        samples=1,
        seed=SEED,
    )
    assert not found.any()


def test_light_on_a_thing_in_its_own_scene_is_that_in_one_scene():
    renderer, view = small("near")
    shares = {"strip0": 3000, "strip2": 3000}
    wanted = renderer.light(view).light_fields(shares, seed=SEED)
    found = renderer.light(View()).light_fields(shares, seed=SEED, outside=outside_of(renderer, view))
    for name in shares:
        for kind in ("fluence", "irradiance"):
            one, other = getattr(found[name], kind), getattr(wanted[name], kind)
            assert one.sum() == pytest.approx(other.sum(), rel=1e-3)
            assert np.abs(one - other).mean() < 0.01 * other.mean()


def test_recorded_light_that_meets_a_thing_is_what_the_thing_adds():
    from magicsim.light.records.untouched_passes import follow_light

    renderer, view = small("near")
    rest, outside, particles = renderer.light(View()), outside_of(renderer, view), 200_000
    names = rest.lights
    shares = dict.fromkeys(names, particles)
    wanted = renderer.light(view).light_fields(shares, seed=SEED)
    alone = rest.light_fields(shares, seed=SEED)
    found = follow_light(rest, outside, recorded_light(rest, particles), seed=SEED + 1)
    added = sum(wanted[name].fluence - alone[name].fluence for name in names)
    landed = sum(wanted[name].irradiance for name in names)
    assert added.mean() > 0
    assert found.fluence.mean() == pytest.approx(added.mean(), rel=0.08)
    assert found.irradiance.mean() == pytest.approx(landed.mean(), rel=0.03)
    layers = [each.reshape(-1, len(added) // rest.counts[2], 3).mean(1) for each in (found.fluence, added)]
    assert layers[0] == pytest.approx(layers[1], rel=0.15)


def test_light_that_misses_a_thing_leaves_all_as_it_is():
    from magicsim.light.records.untouched_passes import follow_light

    sensor = Sensor.for_scene(load_scene("near", [*SMALL, "object.radius_mm=3"]))
    view = sensor.view(replace(sensor.states[0], gap_mm=1e5), sensor.rest)
    rest = sensor.renderer.light(View())
    light = recorded_light(rest, 1000)
    added = follow_light(rest, outside_of(sensor.renderer, view), light, seed=SEED)
    assert not added.fluence.any()
    assert not added.irradiance.any()


def test_room_that_was_too_small_is_enlarged(monkeypatch):
    from magicsim.light.records import recorded_paths as module
    from magicsim.light.records.untouched_passes import recorded_paths

    rest = small("near")[0].light(View())
    enough = recorded_paths(rest, seed=SEED, samples=SAMPLES)
    monkeypatch.setattr(module, "FEW_SEGMENTS", 1)
    short = recorded_paths(rest, seed=SEED, samples=SAMPLES)
    np.testing.assert_array_equal(short.response.toarray(), enough.response.toarray())
    np.testing.assert_array_equal(np.array(short.rays), np.array(enough.rays))


def test_paths_do_not_depend_on_how_many_are_traced_at_once(monkeypatch):
    from magicsim.light.records import recorded_paths as module
    from magicsim.light.records.untouched_passes import recorded_paths

    rest = small("near")[0].light(View())
    together = recorded_paths(rest, seed=SEED, samples=SAMPLES)
    monkeypatch.setattr(module, "AT_ONCE", 2 * 24 * 28)
    parts = recorded_paths(rest, seed=SEED, samples=SAMPLES)
    np.testing.assert_allclose(parts.response.toarray(), together.response.toarray(), rtol=1e-4, atol=1e-9)
    np.testing.assert_array_equal(np.array(parts.rays), np.array(together.rays))


def test_image_of_more_paths_than_are_recorded_is_that_of_all_of_them():
    from magicsim.light.records.untouched_passes import untouched

    rest = small("rest")[0].light(View())
    shares = dict.fromkeys(rest.lights, 4000)
    some, every = (
        untouched(rest, shares, seed=SEED, samples=8, most=most, recorded=10, with_room=False, regions=None)
        for most in (2, 8)
    )
    assert (some.paths.samples, every.paths.samples) == (2, 8)
    np.testing.assert_allclose(some.image.mean((0, 1)), every.image.mean((0, 1)), rtol=0.02)
    assert np.corrcoef(some.image.ravel(), every.image.ravel())[0, 1] > 0.99
