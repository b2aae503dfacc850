"""The room's two beams: what they send agrees with closed forms of an even room, and no line is in both."""

import numpy as np
import pytest

from magicsim.light.variant import SCALAR_VARIANT, activate_variant

if activate_variant() == SCALAR_VARIANT:
    pytest.skip("needs LLVM or CUDA", allow_module_level=True)

from magicsim.light.backend import dr, mi
from magicsim.light.world.room_light import room_beams, room_particles

COUNT = 200_000
RADIUS_MM, RADIANCE = 24.0, 0.7
SENSOR = mi.ScalarBoundingBox3f([-24, -24, 0], [24, 24, 33])
BLOCK = mi.ScalarBoundingBox3f([-12, -16, 0], [12, 16, 9])
BALL_MM, BALL_RADIUS_MM = np.array([2.0, -3.0, -9.0]), 4.0


@pytest.fixture(scope="module")
def even():
    return mi.load_dict({"type": "constant", "radiance": {"type": "rgb", "value": RADIANCE}})


@pytest.fixture(scope="module")
def uneven():
    rows, columns = np.mgrid[0:16, 0:32]
    picture = np.stack([1 + rows, 2 + np.cos(columns / 5), 0.3 + (columns > 20)], 2).astype(np.float32)
    return mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(picture)})


def ball_box():
    return mi.ScalarBoundingBox3f(BALL_MM - BALL_RADIUS_MM, BALL_MM + BALL_RADIUS_MM)


def numbers(seed):
    random = np.random.default_rng(seed)
    return [mi.Float(random.random(COUNT).astype(np.float32)) for _ in range(4)]


def sent(environment, beam, seed=1):
    ray, weight = room_particles(environment, beam, u=numbers(seed))
    return np.array(ray.o).T, np.array(ray.d).T, np.array(mi.Color3f(weight)).T


def landed(environment, beams):
    """Flux that arrives on the ball by each beam, for each channel, and its standard error."""
    flux = []
    for number, beam in enumerate(beams):
        origins, ways, weights = sent(environment, beam, seed=number)
        across = np.linalg.norm(np.cross(BALL_MM - origins, ways), axis=1)
        weights = weights * (across < BALL_RADIUS_MM)[:, None]
        flux.append((weights.mean(0), weights.std(0) / np.sqrt(COUNT)))
    return flux


def test_even_room_sends_pi_l_a_through_the_opening(even):
    (beam,) = room_beams(SENSOR, BLOCK, SENSOR, None, [])
    _, ways, weights = sent(even, beam)
    assert (ways[weights[:, 0] > 0, 2] > 0).all()
    assert weights[:, 0].mean() == pytest.approx(np.pi * RADIANCE * np.pi * RADIUS_MM**2, rel=0.01)


def test_particles_start_before_anything_and_cross_the_opening(even):
    far = mi.ScalarBoundingBox3f([-5, -5, -300], [5, 5, -290])
    beam = room_beams(SENSOR, BLOCK, SENSOR, far, [])[0]
    origins, ways, weights = sent(even, beam)
    assert np.linalg.norm(origins, axis=1).min() > 300
    origins, ways = (each[weights[:, 0] > 0] for each in (origins, ways))
    crossing = origins + ways * (-origins[:, 2:] / ways[:, 2:])
    assert np.linalg.norm(crossing[:, :2], axis=1).max() <= RADIUS_MM + 1e-2


def test_even_room_sends_a_free_block_as_much_as_its_sphere_takes(even):
    (beam,) = room_beams(BLOCK, BLOCK, None, None, [])
    radius = np.linalg.norm([12, 16, 4.5])
    assert sent(even, beam)[2][:, 0].mean() == pytest.approx(4 * np.pi**2 * RADIANCE * radius**2, rel=0.01)


@pytest.mark.parametrize("housing", [SENSOR, None])
def test_both_beams_together_light_a_ball_as_an_even_room_does(even, housing):
    flux = landed(even, room_beams(SENSOR, BLOCK, housing, ball_box(), []))
    assert housing is None or min(part[0] for part, _ in flux) > 0
    error = np.hypot(*(each[0] for _, each in flux))
    expected = np.pi * RADIANCE * 4 * np.pi * BALL_RADIUS_MM**2
    assert abs(sum(part[0] for part, _ in flux) - expected) < max(4 * error, 0.01 * expected)
    assert error < 0.03 * expected


def test_beams_split_the_light_of_an_uneven_room_wherever_the_opening_is(uneven):
    """What arrives on the ball is the same, whichever of its lines the first beam has."""
    whole = landed(uneven, room_beams(SENSOR, BLOCK, SENSOR, ball_box(), []))
    housing, block = (mi.ScalarBoundingBox3f([-size, -size, 0], [size, size, 33]) for size in (8, 4))
    narrow = landed(uneven, room_beams(housing, block, housing, ball_box(), []))
    error = np.sqrt(sum(each**2 for _, each in whole + narrow))
    difference = sum(part for part, _ in whole) - sum(part for part, _ in narrow)
    assert (np.abs(difference) < 4 * error).all()
    assert (error < 0.05 * sum(part for part, _ in whole)).all()


def test_no_line_around_an_object_is_sent_twice(even):
    first, second = room_beams(SENSOR, BLOCK, SENSOR, ball_box(), [])
    origins, ways, weights = sent(even, second)
    ray = mi.Ray3f(mi.Point3f(*origins.T.astype(np.float32)), mi.Vector3f(*ways.T.astype(np.float32)))
    assert not (np.array(first.has(ray)) & (weights[:, 0] > 0)).any()
    assert 0.1 < (weights[:, 0] == 0).mean() < 0.9


def test_an_object_on_its_way_does_not_move_the_first_beam():
    boxes = [mi.ScalarBoundingBox3f([-4, -4, z], [4, 4, z + 8]) for z in (-9.0, -12.0, -20.0)]
    beams = [room_beams(SENSOR, BLOCK, SENSOR, box, [])[0] for box in boxes]
    assert len({(beam.radius_mm, beam.away_mm, *dr.ravel(beam.centre)) for beam in beams}) == 1


def test_an_object_too_far_to_light_anything_gets_no_beam():
    assert len(room_beams(SENSOR, BLOCK, SENSOR, mi.ScalarBoundingBox3f([-4, -4, -99], [4, 4, -91]), [])) == 1
