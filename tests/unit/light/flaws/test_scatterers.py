"""Bubbles and flakes: found where they are, and even light that meets them leaves as even light."""

import numpy as np
import pytest

from magicsim.geometry.printed_cells import PlacedInclusions
from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.flaws.scatterers import Scatterers, bump_ahead, turned

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
RAYS = 400_000
BINS = 8
RADIUS = 0.3
NORMAL = np.array([0.6, 0.0, 0.8])


def one(*, is_bubble, reflectance=1.0):
    """One bubble or flake in the only cell."""
    placed = PlacedInclusions(
        cell=np.array([0]), centres_mm=np.zeros((1, 3)), radii_mm=np.array([RADIUS]), normals=NORMAL[None],
        is_bubble=np.array([is_bubble]),
    )  # fmt: skip
    return Scatterers.of(placed, 1, 1.46, reflectance)


def met_in_even_light(scatterers):
    """Whether rays of even light within a sphere of 1 mm meet anything, and how they go on: places, ways, shares."""
    numbers = mi.PCG32(size=RAYS, initstate=5)
    place = mi.warp.square_to_uniform_sphere(mi.Point2f(numbers.next_float32(), numbers.next_float32()))
    inwards = mi.warp.square_to_cosine_hemisphere(mi.Point2f(numbers.next_float32(), numbers.next_float32()))
    way = mi.Frame3f(-place).to_world(inwards)
    ray, si = mi.Ray3f(mi.Point3f(place), way), dr.zeros(mi.SurfaceInteraction3f, RAYS)
    si.t = -2 * dr.dot(place, way)
    bump = bump_ahead(scatterers, ray, si, mi.UInt32(0), dr.full(mi.Bool, True, RAYS))
    on = turned(scatterers, ray, bump, numbers)
    found = np.array(bump.found)
    return found, *(np.array(each, np.float64).T[found] for each in (on.place, on.direction, on.share))


def is_even(values, low, high):
    counts, due = np.histogram(values, BINS, (low, high))[0], len(values) / BINS
    return np.abs(counts - due).max() < 4.5 * np.sqrt(due)


def test_a_bubble_hides_its_disk_and_keeps_light_even():
    found, places, ways, shares = met_in_even_light(one(is_bubble=True))
    assert found.mean() == pytest.approx(RADIUS**2, rel=0.02)
    assert (shares == 1).all()
    normals = places / np.linalg.norm(places, axis=1, keepdims=True)
    cosines = (normals * ways).sum(1)
    assert np.abs(np.linalg.norm(places, axis=1) - RADIUS).max() < 1e-5
    assert cosines.min() > 0
    assert is_even(cosines**2, 0, 1)
    assert is_even(normals[:, 2], -1, 1)


def test_a_bubble_bends_light_by_two_refractions():
    scatterers, sine = one(is_bubble=True), 0.5
    numbers = mi.PCG32(size=20_000)
    ray = mi.Ray3f(mi.Point3f(RADIUS * sine, 0, 1) + dr.zeros(mi.Vector3f, 20_000), mi.Vector3f(0, 0, -1))
    si = dr.zeros(mi.SurfaceInteraction3f, 20_000)
    si.t = mi.Float(2)
    bump = bump_ahead(scatterers, ray, si, mi.UInt32(0), dr.full(mi.Bool, True, 20_000))
    ways = np.array(turned(scatterers, ray, bump, numbers).direction, np.float64).T
    bent = 2 * (np.arcsin(1.46 * sine) - np.arcsin(sine))  # away from the axis, out of the thinner medium
    cosine = np.cos(bent)
    through = np.abs(ways @ [0, 0, -1] - cosine) < 1e-4
    once = 1 - float(mi.fresnel(mi.Float((1 - sine**2) ** 0.5), mi.Float(1 / 1.46))[0][0])
    assert through.mean() == pytest.approx(once**2, abs=0.015)
    assert (ways[through, 0] > 0).all()


def test_a_flake_shows_half_of_its_disk_and_sends_light_back_by_the_cosine():
    found, places, ways, shares = met_in_even_light(one(is_bubble=False, reflectance=0.25))
    assert found.mean() == pytest.approx(RADIUS**2 / 2, rel=0.02)
    np.testing.assert_allclose(shares, 0.25)
    assert np.abs(places @ NORMAL).max() < 1e-5
    assert is_even((ways @ NORMAL) ** 2, 0, 1)


def test_what_lies_behind_the_wall_is_not_met():
    scatterers = one(is_bubble=True)
    si = dr.zeros(mi.SurfaceInteraction3f, 1)
    si.t = mi.Float(0.5)
    bump = bump_ahead(scatterers, mi.Ray3f(mi.Point3f(0, 0, 1), mi.Vector3f(0, 0, -1)), si, mi.UInt32(0), mi.Bool(True))
    assert not bump.found[0]
    assert bump.length[0] == pytest.approx(0.5)
