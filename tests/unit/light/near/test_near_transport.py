"""Compressed transport gives what recorded paths and traced particles give, and what closed forms say."""

import gc

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, dr
from magicsim.light.near.lamp_light import LampLight
from magicsim.light.near.near_object import NearObject, radiance_of
from magicsim.light.near.near_transport import NearTransport, follow_ports
from magicsim.light.near.near_views import NearViews
from magicsim.light.transport.light_starts import FIXED_POINT, LightStarts
from magicsim.light.world.finish import Finish
from magicsim.light.world.names import ENVIRONMENT
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState, View
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = (
    "rig=digit-rgb", "design.footprint_mm=[10,12]",
    "rig.camera.field_mm=9", "rig.camera.columns=36", "rig.camera.rows=44",
    "render.anchor_samples=32", "render.anchor_particles=1600000", "render.particles=10000",
)  # fmt: skip
BALL = ("object.radius_mm=3", "object.color=[0.8,0.5,0.3]")
LARGER = ("rig.camera.columns=72", "rig.camera.rows=88")
"""More pixels: sums over all have less noise of single rays."""
BRIGHT = 0.05
"""Radiance of an even room."""


def at(gap_mm, **changed):
    state = {"gap_mm": gap_mm, "x_mm": 0.0, "y_mm": 0.0, "twist_deg": 0.0, "flashlight": False, "light_x_mm": 0.0}
    return FrameState(**(state | changed))


def sensor_of(*settings):
    return Sensor.for_scene(load_scene("pressed", [*SMALL, *settings], seed=1))


@pytest.fixture(scope="module")
def sensor():
    dark = "rig.passing={distance_mm=500,size_mm=[200,600],rise_mm=0,reflectance=[0.1,0.1,0.1]}"
    return sensor_of(f"rig.ambient=[{BRIGHT},{BRIGHT},{BRIGHT}]", dark, *BALL)


@pytest.fixture(scope="module")
def transport(sensor):
    world, rest = sensor.renderer.light(View()), sensor.renderer.anchor()
    return NearTransport.of(world, rest, follow_ports(world))


def look(transport, target, room, *, rays):
    scene, light = transport.world.scene, transport.rest.light
    behind = radiance_of(room, transport.lines)
    return target.look(scene, room, transport.ports, transport.lines, behind, light, rays=rays, seed=0)


def changes(sensor, state):
    """What an object changes of the image, truly and by compressed transport, in units of the mean image."""
    rest = sensor.radiance(UNTOUCHED, sensor.rest)
    found = NearViews(sensor.renderer).radiance(sensor.view(state, sensor.rest))
    return ((each - rest) / rest.mean() for each in (sensor.radiance(state, sensor.rest), found))


def test_light_of_an_even_room_through_the_ports_is_that_of_its_particles_through_the_face(sensor, transport):
    world, count = transport.world, 100_000
    beam = world.sent(ENVIRONMENT, count, seed=1)[0]
    starts = LightStarts.emitted([beam])
    place = starts.rays(-starts.rays.o.z / starts.rays.d.z)
    width, height = transport.ports.footprint_mm
    kept = dr.compress((dr.abs(place.x) < width / 2) & (dr.abs(place.y) < height / 2))
    tracks = world.light_pass(starts.some(kept))
    traced = tracks.cells[0].mean(1) / (FIXED_POINT * count) / world.inventory.volumes_mm3()[:, 0]
    brought = transport.brought[: len(traced)].sum(1) * BRIGHT
    assert brought.sum() / traced.sum() == pytest.approx(1, abs=0.02)
    assert np.corrcoef(brought, traced)[0, 1] > 0.95


def test_light_of_the_rest_that_leaves_is_what_falls_on_a_face_before_it(sensor, transport):
    target = NearObject.of(sensor.renderer.object_mesh, Finish(color=(0.0, 0.0, 0.0)))
    target.place(sensor.view(at(0.01), sensor.rest).indenter.pose)
    light = transport
    met = look(transport, target, None, rays=20_000)
    top, dark = target.placed.vertices[target.mesh.faces, 2].mean(1) > -0.05, np.zeros((len(target.mesh.faces), 3))
    middle = (light.room + light.strips).reshape(12, 10, -1, 3)[5:7, 4:6].mean((0, 1, 2))
    lit = met.irradiance(light.room + target.from_ports * light.strips, dark)
    assert lit[top].mean() == pytest.approx(np.pi * middle.mean(), rel=0.1)
    # What is turned away from the face meets the dark beside it.
    even = met.irradiance(np.ones_like(light.room), dark) - met.strips
    np.testing.assert_allclose(even[top], np.pi, rtol=0.05)


def test_an_object_as_bright_as_the_room_that_it_hides_changes_nothing(sensor, transport):
    target = NearObject.of(sensor.renderer.object_mesh, Finish(color=(0.5, 0.5, 0.5)))
    target.place(sensor.view(at(0.5), sensor.rest).indenter.pose)
    pixels = np.arange(transport.rest.image.shape[0] * transport.rest.image.shape[1], dtype=np.uint32)
    room = transport.world.inventory.environment
    light = transport
    met = look(transport, target, room, rays=1000)
    for share, expected in ((1.0, 0.0), (3.0, 2.0)):
        even = np.full((len(target.mesh.faces), 3), share * BRIGHT * np.pi / 0.5)
        seen = transport.seen.seen_outside(room, target, even, target.finish, pixels) / BRIGHT
        assert (seen.max() > 0.1) == (expected > 0)
        came = light.sums @ met.changes(even, np.zeros((len(met.behind), 3))) / BRIGHT
        assert came[: transport.brought.shape[1]].max() == pytest.approx(expected, abs=1e-4)
        hidden = transport.seen.seen_outside(room, target, 0 * even, target.finish, pixels) / BRIGHT
        np.testing.assert_allclose(seen, -expected * hidden, atol=1e-4)


@pytest.mark.parametrize(
    "state",
    [
        at(0.002), at(2.0, x_mm=1.5), at(None, flashlight=True), at(1.0, flashlight=True), at(12.0, flashlight=True),
        at(None, passing_mm=50.0), at(1.0, passing_mm=50.0), at(2.0, passing_mm=0.0, flashlight=True, light_x_mm=8.0),
    ],
)  # fmt: skip
def test_an_image_is_the_true_one(sensor, state):
    compare(sensor, state)


def test_some_pixels_see_what_they_see_in_the_whole_image(sensor, transport):
    target, paths = NearObject.of(sensor.renderer.object_mesh, Finish(color=(0.5, 0.5, 0.5))), transport.seen
    target.place(sensor.view(at(1.0), sensor.rest).indenter.pose)
    lit, pixels = np.full((len(target.mesh.faces), 3), 0.5), np.arange(36 * 44, dtype=np.uint32)

    def seen(pixels):
        return paths.seen_outside(None, target, lit, target.finish, pixels, room=None)

    whole = seen(pixels)
    assert 0.2 < (whole[:, 0] > 0).mean() < 1
    for some in (pixels[::-7], pixels[:1], pixels[:0]):
        np.testing.assert_array_equal(seen(some), whole[some])
    target.place(sensor.view(at(1e5), sensor.rest).indenter.pose)
    assert not seen(pixels[:1]).any()


def test_a_far_object_gets_as_much_from_recorded_particles_as_through_the_ports(sensor, transport):
    target = NearObject.of(sensor.renderer.object_mesh, Finish(color=(0.5, 0.5, 0.5)))
    target.place(sensor.view(at(12.0), sensor.rest).indenter.pose)
    met = look(transport, target, None, rays=300_000)
    own = np.zeros((len(target.mesh.faces), 3))
    areas = np.bincount(met.sent.triangle, met.sent.area_mm2, len(own))
    by_ports = (met.irradiance(transport.strips, own) - met.strips).T @ areas
    by_particles = met.strips.T @ areas / (1 - target.from_ports)
    assert 0 < target.from_ports < 0.2
    assert by_particles.sum() == pytest.approx(by_ports.sum(), rel=0.1)


def test_a_flashlight_that_wanders_leaves_nothing_behind(sensor):
    near, counts = NearViews(sensor.renderer), []
    for place in (-3.0, -1.0, 1.0, 3.0):
        near.radiance(sensor.view(at(None, flashlight=True, light_x_mm=place), sensor.rest))
        gc.collect()
        counts.append(sum(type(each) is LampLight for each in gc.get_objects()))
    assert counts[3] == counts[2] == counts[1] > 0


def test_a_flashlight_hides_what_passes_behind_it(sensor):
    lit, both = (
        NearViews(sensor.renderer).radiance(sensor.view(at(None, flashlight=True, passing_mm=place), sensor.rest))
        for place in (None, 0.0)
    )
    rest, passing = (
        sensor.radiance(at(None, passing_mm=place), sensor.rest) if place is not None else
        sensor.radiance(UNTOUCHED, sensor.rest) for place in (None, 0.0)
    )  # fmt: skip
    straight = (lit - rest).mean(-1) > 0.5 * (lit - rest).max()
    assert straight.sum() > 20
    assert np.abs(both - lit)[straight].mean() < 0.3 * np.abs(passing - rest)[straight].mean()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "state"),
    [
        ((*BALL, "object.specular=0.4", "rig.camera.columns=72", "rig.camera.rows=88"), at(0.3)),
        (
            (*BALL, "object.specular=0.4", "object.roughness=0.05", "rig.camera.columns=72", "rig.camera.rows=88"),
            at(1.0),
        ),
        (
            (
                "render.anchor_particles=400000",
                "render.particles=100000",
                "object={kind='box',size_mm=[6,4,3]}",
            ),
            at(0.2, twist_deg=30.0, tilt_x_deg=6.0),
        ),
    ],
)
def test_an_image_of_a_glossy_or_an_edged_object_is_the_true_one(settings, state):
    compare(sensor_of("rig.ambient=[0.02,0.02,0.02]", *settings), state)


def compare(sensor, state):
    true, found = changes(sensor, state)
    assert np.sqrt(np.mean(true**2)) > 0.02
    off = found - true
    assert np.sqrt(np.mean(off**2)) < 0.25 * np.sqrt(np.mean(true**2))
    # Sums over all pixels have no noise of single rays.
    np.testing.assert_allclose(found.mean((0, 1)), true.mean((0, 1)), atol=0.05 * np.abs(true.mean((0, 1))).max())


def test_what_touches_or_is_not_there_is_left_to_others(sensor):
    near = NearViews(sensor.renderer)
    assert near.radiance(sensor.view(UNTOUCHED, sensor.rest)) is None
    assert near.radiance(sensor.view(at(45.0, flashlight=True), sensor.rest)) is None
    assert near.radiance(sensor.view(at(-0.5), sensor.deform(at(-0.5), sensor.rest))) is None


def test_places_on_the_way_do_not_tell(sensor):
    first, second = (sensor.view(at(gap), sensor.rest) for gap in (0.4, 1.0))
    near = NearViews(sensor.renderer)
    alone = near.radiance(second)
    near.radiance(first)
    np.testing.assert_array_equal(near.radiance(second), alone)


def test_places_on_the_way_share_compiled_kernels(sensor):
    near = NearViews(sensor.renderer)

    def kernels(gap_mm):
        near.radiance(sensor.view(at(gap_mm), sensor.rest))
        gc.collect()  # a scene that another test left, and that goes in between, would move data that kernels point at
        dr.kernel_history_clear()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
            near.radiance(sensor.view(at(gap_mm + 0.05), sensor.rest))
        return {each["hash"] for each in dr.kernel_history() if "hash" in each}

    first = kernels(0.3)
    assert len(first) >= 5
    assert kernels(0.7) == first


@pytest.mark.parametrize("gap_mm", [None, 1.0])
@pytest.mark.parametrize("is_fast", [False, True])
def test_a_flashlight_as_bright_as_the_even_room_behind_it_changes_nothing(is_fast, gap_mm):
    """A disk that fills most of what the face looks at: as much light as it brings, it keeps away."""
    bright = "[2,2,2]"
    sensor = sensor_of(
        "rig.strips=[]", f"rig.ambient={bright}", f"rig.flashlight={{radiance={bright},radius_mm=16,distance_mm=10}}",
        *BALL, *LARGER, "render.anchor_particles=200000", "render.particles=100000",
    )  # fmt: skip

    def image(state):
        view = sensor.view(state, sensor.rest)
        return NearViews(sensor.renderer).radiance(view) if is_fast else sensor.renderer.radiance(view)

    without = image(at(gap_mm)) if gap_mm is not None else sensor.radiance(UNTOUCHED, sensor.rest)
    np.testing.assert_allclose(image(at(gap_mm, flashlight=True)).mean((0, 1)), without.mean((0, 1)), rtol=0.02)
