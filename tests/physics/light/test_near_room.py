"""A room that is near: what path tracing sees before a sphere, far away the infinite one, even where it is even."""

import numpy as np
import pytest
from PIL import Image

from magicsim.light.backend import VARIANT, mi
from magicsim.light.world.room_light import Beam, NearRoom, missed, room_particles
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
NEAR_MM = 60.0
SMALL = (
    "rig.strips=[]", "design.footprint_mm=[12,14]", "rig.camera.field_mm=10", "rig.camera.columns=24",
    "rig.camera.rows=28", "rig.camera.blur_px=0", "object.radius_mm=4",
)  # fmt: skip

QUICK = ("render.anchor_particles=100000", "render.particles=12000")
COARSE = "design.cell_mm=2.09"
"""Quick; linear fluence in so large cells is 1 % off `volpath` with any room."""


def picture(path):
    """A room with something of its own in each channel: a spot ahead, a ring around it, a side."""
    row, column = np.mgrid[:64, :128]
    up, turn = np.pi * (0.5 - (row + 0.5) / 64), 2 * np.pi * ((column + 0.5) / 128 - 0.5)
    off = np.degrees(np.arccos(np.cos(up) * np.cos(turn)))
    bright = np.stack([off < 25, (off > 25) & (off < 55), (np.sin(turn) > 0) & (off < 80)], -1)
    Image.fromarray((40 + 200 * bright).astype(np.uint8)).save(path)
    return f"rig.room='{path}'"


@pytest.fixture(scope="module")
def spots(tmp_path_factory):
    return picture(tmp_path_factory.mktemp("room") / "spots.png")


def near(distance_mm=NEAR_MM):
    return f"rig.room_distance_mm={distance_mm}"


def state(gap_mm):
    return FrameState(gap_mm=gap_mm, x_mm=1.0, y_mm=0.5, twist_deg=0.0, flashlight=False, light_x_mm=0.0)


def image(gap_mm, *overrides, seed=1, plain=False):
    anchor = f"render.anchor_seed={seed}"
    sensor = Sensor.for_scene(load_scene("near", [*SMALL, anchor, *overrides], seed=seed))
    view = sensor.view(state(gap_mm), sensor.rest)
    found = sensor.renderer.plain_radiance(view) if plain else sensor.renderer.radiance(view)
    return np.asarray(found, np.float64)


def world_of(*overrides):
    sensor = Sensor.for_scene(load_scene("near", [*SMALL, *overrides]))
    return sensor.renderer.light(sensor.view(state(None), sensor.rest))


def means(gap_mm, seeds, *overrides, plain=False):
    """Mean radiance of each channel and its relative standard error."""
    found = [image(gap_mm, *overrides, seed=seed, plain=plain).mean((0, 1)) for seed in seeds]
    return np.mean(found, 0), np.std(found, 0, ddof=1) / np.sqrt(len(found)) / np.mean(found, 0)


def test_a_clear_block_shows_what_path_tracing_shows(spots):
    """Without light in the block each pixel is what its rays meet; from infinitely far away it would be another."""
    clear = ("design.cell_mm=0", spots)
    path, ours, far = (
        image(None, *clear, *more, "render.samples=256", plain=True).reshape(4, 7, 4, 6, 3).mean((1, 3))
        for more in ((near(), "render.estimator=path"), (near(),), ())
    )
    off, parallax = (np.abs(each / path - 1).max() for each in (ours, far))
    assert off < 0.03
    assert parallax > 0.3
    np.testing.assert_allclose(ours.mean((0, 1)), path.mean((0, 1)), rtol=0.003)


@pytest.mark.parametrize(
    ("seeds", "samples", "distance_mm"),
    [
        pytest.param(3, 160, 60, marks=pytest.mark.slow),
        pytest.param(20, 512, 60, marks=pytest.mark.slow),
        pytest.param(20, 512, 150, marks=pytest.mark.slow),
    ],
)
def test_an_object_before_it_is_as_bright_as_by_path_tracing(spots, seeds, samples, distance_mm):
    settings, paths = (spots, near(distance_mm)), ("render.estimator=path", f"render.samples={samples}")
    path, path_error = means(2.0, range(200, 200 + seeds), *paths, *settings, plain=True)
    found, error = means(2.0, range(50, 50 + 2 * seeds), "render.anchor_particles=200000", *settings)
    noise = np.hypot(error, path_error)
    assert noise.max() < 0.015, "too noisy to tell anything"
    assert (np.abs(found / path - 1) < 0.003 + 3 * noise).all(), f"{found / path}, standard error {noise}"


def test_far_away_it_is_the_infinite_one(spots):
    images, flux = [], []
    for more in ((), (near(1e6),)):
        images.append(image(None, "design.cell_mm=0", spots, *more))
        world = world_of(spots, *more)
        sent = mi.PCG32(size=100_000)
        u = [sent.next_float32() for _ in range(4)]
        ray, weight = room_particles(world.inventory.environment, world.inventory.beams()[0], u=u)
        flux.append(np.concatenate([np.array(ray.d), np.array(weight)]).astype(np.float64))
    np.testing.assert_allclose(images[1], images[0], rtol=1e-3)
    off = np.abs(flux[1] - flux[0]).max(0) / np.abs(flux[0]).max()
    assert np.quantile(off, 0.98) < 1e-3  # the others start in a neighbouring cell, or beside an edge of the picture
    np.testing.assert_allclose(flux[1].mean(1), flux[0].mean(1), rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("gap_mm", [None, 2.0])
def test_an_even_room_is_as_bright_at_any_distance(gap_mm):
    even = ("rig=digit-rgb", *SMALL, "rig.ambient=[0.2,0.2,0.2]", COARSE, *QUICK)
    infinite, close = (image(gap_mm, *even, *more) for more in ((), (near(45.0),)))
    np.testing.assert_allclose(close, infinite, rtol=1e-4, atol=1e-4 * infinite.mean())


class Ahead:
    """Radiance that falls with the direction's height, for closed forms."""

    def eval(self, si, active=True):
        del active
        return mi.Color3f(mi.Float(1), -si.wi.x, si.wi.z)


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (20.0, -10.0, 15.0), (0.0, 5.0, -49.0)])
def test_a_ray_sees_where_it_leaves_the_sphere(place):
    random = np.random.default_rng(3)
    way = random.normal(size=(100, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    along = way @ place
    met = place + (-along + np.sqrt(along**2 - np.dot(place, place) + 50.0**2))[:, None] * way
    ray = mi.Ray3f(mi.Point3f(*place), mi.Vector3f(*way.T.astype(np.float32)))
    found = np.array(NearRoom(Ahead(), 50.0).eval(missed(ray)))
    np.testing.assert_allclose(found[1:], np.stack([met[:, 0], -met[:, 2]]) / 50, atol=2e-5)


@pytest.mark.parametrize("around", [False, True])
def test_particles_bring_what_arrives(spots, around):
    """Their flux is radiance over all lines of a beam: by other random numbers, drawn over places and directions."""
    world = world_of(spots, near())
    room, first = world.inventory.environment, world.inventory.beams()[0]
    beam = Beam(mi.ScalarPoint3f(5, 0, -20), 12.0, 90.0) if around else first
    sent = mi.PCG32(size=400_000)
    _, weight = room_particles(room, beam, u=[sent.next_float32() for _ in range(4)])
    random, count = np.random.default_rng(1), 1_000_000
    towards = random.normal(size=(count, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    turn, out = 2 * np.pi * random.random(count), beam.radius_mm * np.sqrt(random.random(count))
    sides = [np.array([1.0, 0, 0]), np.array([0, 1.0, 0])]
    share = np.maximum(-towards[:, 2], 0)
    if around:
        side = np.cross(towards, [0.3, 0.5, 0.8])
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        sides, share = [side, np.cross(towards, side)], np.ones(count)
    places = np.array(beam.centre).ravel() + (out * np.cos(turn))[:, None] * sides[0]
    places += (out * np.sin(turn))[:, None] * sides[1]
    ray = mi.Ray3f(*(kind(*each.T.astype(np.float32)) for kind, each in ((mi.Point3f, places), (mi.Vector3f, towards))))
    radiance = np.array(mi.Color3f(room.eval(missed(ray))), np.float64)
    expected = 4 * np.pi * np.pi * beam.radius_mm**2 * (share * radiance).mean(1)
    np.testing.assert_allclose(np.array(weight, np.float64).mean(1), expected, rtol=0.01)
