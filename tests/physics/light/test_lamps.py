"""Single LEDs: what a lobe sends out is what it shows, and its power is the closed form's."""

import numpy as np
import pytest

from magicsim.light.backend import dr, mi
from magicsim.light.variant import activate_variant
from magicsim.light.world.lamp_shapes import lamp_entries, led_name
from magicsim.scenes.rig import load_rig

RAYS = 1 << 18
PLACE_MM, AXIS, RADIUS_MM = (0.0, 10.0, 20.0), np.array([0.0, -0.6, -0.8]), 1.0


def lamp(lobe: float):
    activate_variant()
    led = (
        f"leds=[{{place_mm={list(PLACE_MM)},direction={AXIS.tolist()},radiance=[3.0,2.0,1.0],lobe={lobe},"
        f"radius_mm={RADIUS_MM}}}]"
    )
    return mi.load_dict({"type": "scene", led_name(0): lamp_entries(load_rig("digit-rgb", [led]), 8.0)[led_name(0)]})


def sent(scene):
    """Origins, directions and weights of rays of the only light, shape (rays, 3) each."""
    draw = mi.load_dict({"type": "independent"})
    draw.seed(1, RAYS)
    ray, weight = scene.emitters()[0].sample_ray(
        mi.Float(0), draw.next_1d(), draw.next_2d(), draw.next_2d(), mi.Bool(True)
    )
    return tuple(np.array(each).T for each in (ray.o, ray.d, weight))


@pytest.mark.parametrize("lobe", [1.0, 2.0, 6.0])
def test_power_and_directions_are_those_of_the_lobe(lobe: float):
    origins, directions, weights = sent(lamp(lobe))
    area = weights[0, 0] * (lobe + 1) / (2 * np.pi * 3.0)
    assert area == pytest.approx(np.pi * RADIUS_MM**2, rel=0.02)  # a disk of straight edges
    assert weights == pytest.approx(np.broadcast_to(weights[0], weights.shape), rel=1e-5)
    assert weights[0] / weights[0, 2] == pytest.approx([3, 2, 1], rel=1e-5)
    cosine = directions @ AXIS
    assert cosine.min() > 0
    # density (n + 1) / (2 pi) cos^n: mean (n + 1) / (n + 2), of the square (n + 1) / (n + 3)
    assert cosine.mean() == pytest.approx((lobe + 1) / (lobe + 2), abs=2e-3)
    assert np.square(cosine).mean() == pytest.approx((lobe + 1) / (lobe + 3), abs=2e-3)
    assert np.linalg.norm(origins - PLACE_MM, axis=1).max() < 1.01 * RADIUS_MM  # corners of a polygon of that area


@pytest.mark.parametrize("lobe", [1.0, 4.0])
def test_rays_that_arrive_carry_the_radiance_that_is_seen(lobe: float):
    """Flux through a small square below: by rays of the light, and by directions towards it from the square."""
    scene, half, below_mm = lamp(lobe), 2.0, 5.0
    origins, directions, weights = sent(scene)
    distance = (below_mm - origins[:, 2]) / directions[:, 2]
    met = origins + distance[:, None] * directions
    inside = (distance > 0) & (np.abs(met[:, 0]) < half) & (np.abs(met[:, 1]) < half)
    arrived = (weights[:, 0] * inside).mean()
    draw = mi.load_dict({"type": "independent"})
    draw.seed(2, RAYS)
    at = dr.zeros(mi.SurfaceInteraction3f, RAYS)
    sample = draw.next_2d()
    at.p = mi.Point3f(half * (2 * sample.x - 1), half * (2 * sample.y - 1), below_mm)
    at.n = mi.Normal3f(0, 0, 1)
    ds, value = scene.emitters()[0].sample_direction(at, draw.next_2d(), mi.Bool(True))
    seen = float(np.mean(np.array(value[0] * dr.abs(ds.d.z)))) * (2 * half) ** 2
    assert seen == pytest.approx(arrived, rel=0.03)
