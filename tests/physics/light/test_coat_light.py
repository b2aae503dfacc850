"""Light of opaque coats is integrated: against closed forms, against paths, and over seeds."""

from types import SimpleNamespace

import numpy as np
import pytest

from magicsim.light.backend import dr, mi
from magicsim.light.transport.path_starts import CameraStarts
from magicsim.light.transport.streams import SEEDS_PER_RENDER
from magicsim.light.world.straight_light import Box, Lamps, Strips, rectangle_point
from magicsim.scenes.timeline import View
from magicsim.simulation.sensor import Sensor

COATED = (
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=6", "design.skin_mm=0.5", "design.core_mm=2",
    "design.cell_mm=0", 'design.coat={kind="opaque",color=[0.45,0.45,0.45],specular=0.2,roughness=0.4}',
)  # fmt: skip


def lambert(corners):
    """Irradiance of a level place at the origin by a polygon of radiance 1 (Lambert 1760)."""
    ways = corners / np.linalg.norm(corners, axis=1)[:, None]
    total = 0.0
    for a, b in zip(ways, np.roll(ways, -1, 0), strict=True):
        normal = np.cross(a, b)
        total += np.arccos(np.clip(a @ b, -1, 1)) * normal[2] / np.linalg.norm(normal)
    return abs(total) / 2


def clear_box(ior=1.41):
    body = SimpleNamespace(sigma_t=mi.Float(0), sigma_a=mi.Float(0))
    constants = SimpleNamespace(body=body, body_ior=mi.Float(ior), top_mm=mi.Float(2.5))
    return Box(height_mm=mi.Float(5.5), half_mm=(mi.Float(10), mi.Float(8)), constants=constants)


@pytest.mark.parametrize("place", [(-9.0, 0.0), (-5.0, 6.0), (0.0, 0.0), (9.0, 6.0)])
def test_points_of_a_strip_give_the_irradiance_of_the_closed_form(place):
    nodes = Strips.nodes(None)
    corner = np.array([-9.8 - place[0], -7.8 - place[1], 0.01])
    along, across = np.array([0, 15.6, 0]), np.array([0, 0, 2.4])
    point, angle = rectangle_point(
        *(mi.Vector3f(*each.tolist()) for each in (corner, along, across)),
        mi.Point2f(mi.Float(nodes[:, 0]), mi.Float(nodes[:, 1])),
    )
    found = np.array(angle * dr.normalize(point).z) @ nodes[:, 2]
    corners = corner + np.array([0 * along, along, along + across, across])
    assert found == pytest.approx(lambert(corners), rel=1e-3)


@pytest.mark.parametrize("way", [(0, 0, 1), (1, 0, 0), (0, -1, 1), (1, 1, 1)])
def test_a_way_by_mirrors_is_reflected_in_each_of_them_and_ends_at_the_lamp(way):
    box, place, target = clear_box(), np.array([1.0, 2.0, 0.3]), np.array([-8.0, 3.0, 1.5])
    turns = mi.Vector3f(*map(float, way))
    image = np.array(box.image(mi.Point3f(*place.tolist()), turns)).ravel()
    away = target - image
    distance = np.linalg.norm(away)
    share, legs = box.ways(
        mi.Point3f(*image.tolist()), mi.Vector3f(*(away / distance).tolist()), mi.Float(distance), turns
    )
    cosines = [abs(away[axis]) / distance for axis in range(3) if way[axis]]
    expected = np.prod([np.array(mi.fresnel(mi.Float(-cosine), mi.Float(1.41))[0])[0] for cosine in cosines])
    assert np.array(share)[0] == pytest.approx(expected, rel=1e-4)
    walked = [(np.array(ray.o).ravel(), np.array(ray.d).ravel(), float(np.array(length)[0])) for ray, length in legs]
    walked = [each for each in walked if each[2] > 0]
    assert len(walked) == sum(map(bool, way)) + 1
    np.testing.assert_allclose(walked[0][0], place, atol=1e-5)
    np.testing.assert_allclose(walked[-1][0] + walked[-1][1] * walked[-1][2], target, atol=1e-4)
    for origin, direction, length in walked:
        for at in (0.0, length):
            assert (np.abs(origin + at * direction)[:2] <= [10.001, 8.001]).all()
            assert (origin + at * direction)[2] <= 5.501


def test_lamp_behind_the_lens_face_gives_the_irradiance_of_all_directions_within_the_body():
    # A disk of 1 mm radius, 20 mm above the face: its light through the face, by directions on a fine grid.
    box, place = clear_box(), np.array([2.0, 1.0, 0.0])
    corners = np.array([[-1, -1, 25.5], [-1, 1, 25.5], [1, -1, 25.5]], float)
    lamps = Lamps(
        corners=[mi.Point3f(*each.tolist()) for each in corners], normals=mi.Vector3f(0, 0, -1), areas=mi.Float(2),
        exponents=mi.Float(1), radiance=mi.Color3f(1), count=1, turns=mi.Vector3f(0), straight=[0], rows=1,
    )  # fmt: skip
    seen = lamps.arriving(mi.UInt32(0), mi.Point3f(*place.tolist()), mi.Point2f(mi.Float(1 / 3), mi.Float(1 / 3)), box)
    found = float(np.array(seen.light.x * seen.direction.z)[0])
    # Straight from the law of refraction: rays that leave the place, and where they meet the lamp's plane.
    theta, phi = np.meshgrid(np.linspace(0, 0.2, 1201), np.linspace(-np.pi, np.pi, 2401), indexing="ij")
    outer = np.arcsin(1.41 * np.sin(theta))
    reach = 5.5 * np.tan(theta) + 20 * np.tan(outer)
    x, y = place[0] + reach * np.cos(phi), place[1] + reach * np.sin(phi)
    hit = (x > -1) & (y > -1) & (x + y < 0)
    passed = 1 - np.array(mi.fresnel(mi.Float(-np.cos(theta).ravel()), mi.Float(1.41))[0]).reshape(theta.shape)
    step = (theta[1, 0] - theta[0, 0]) * (phi[0, 1] - phi[0, 0])
    expected = (hit * 1.41**2 * passed * np.cos(theta) * np.sin(theta)).sum() * step
    assert found == pytest.approx(expected, rel=0.01)


def coated(small_scene):
    world = Sensor.for_scene(small_scene("rest", *COATED)).renderer.light(View())
    columns, rows = (int(size) for size in world.scene.sensors()[0].film().size())
    return world, np.arange(0, columns * rows, 7, dtype=np.uint32)


def integrated(world, pixels, seeds):
    dark = world.darkness()
    return [np.array(world.gather_pixels(dark, pixels, samples=4, seed=seed)).T for seed in range(seeds)]


def test_coat_differs_hardly_between_seeds(small_scene):
    found = integrated(*coated(small_scene), 2)
    assert np.sqrt(np.var(found, axis=0, ddof=1).mean()) < 0.01 * np.mean(found)


@pytest.mark.slow
def test_coat_has_the_light_of_paths(small_scene):
    world, pixels = coated(small_scene)
    ours, paths = integrated(world, pixels, 3), []
    for seed in range(8):
        starts = CameraStarts.of(world.scene.sensors()[0], samples=256, pixels=pixels, pattern=seed, part=range(256))
        paths.append(np.array(world.camera_pass(world.darkness(), starts, stream=SEEDS_PER_RENDER * seed) / 256).T)
    means = np.array([each.mean(0) for each in paths])
    noise = means.std(0, ddof=1) / np.sqrt(8)
    assert (np.abs(np.mean(ours, (0, 1)) - means.mean(0)) < 0.005 * means.mean(0) + 3 * noise).all()
