"""A rough interface: smooth where its facets are flat, and no light lost or gathered anywhere in equilibrium."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.flaws.rough_surfaces import first_facet, walk_on

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
RAYS = 400_000
BINS = 8


def crossed(wi, alpha, eta, *, seed=7):
    """Directions in which rays leave, shape (rays, 3)."""
    numbers = mi.PCG32(size=RAYS, initstate=seed)
    alpha, eta = mi.Float(alpha), mi.Float(eta)
    facet = first_facet(wi, alpha, eta, numbers)
    reflects = numbers.next_float32() < facet.reflectance
    outside, way = wi.z > 0, dr.select(reflects, facet.reflected, facet.refracted)
    above = dr.select(reflects, outside, ~outside)
    everywhere = dr.full(mi.Bool, True, RAYS)
    return np.array(walk_on(way, above, facet.height, alpha, eta, numbers, everywhere), np.float64).T


def even_light(eta):
    """Rays of light that is in equilibrium on both sides: cosines, and as much as the square of the index."""
    numbers = mi.PCG32(size=RAYS, initstate=3)
    lit = mi.warp.square_to_cosine_hemisphere(mi.Point2f(numbers.next_float32(), numbers.next_float32()))
    below = numbers.next_float32() < eta**2 / (1 + eta**2)
    return mi.Vector3f(lit.x, lit.y, dr.select(below, -lit.z, lit.z)), np.array(below)


@pytest.mark.parametrize("alpha", [0.05, 0.3, 0.5])
@pytest.mark.parametrize("eta", [1.49, 1.46 / 1.49])
def test_light_in_equilibrium_stays_in_equilibrium(alpha, eta):
    arriving, below = even_light(eta)
    left = crossed(arriving, alpha, eta)
    assert np.abs(np.linalg.norm(left, axis=1) - 1).max() < 1e-5
    up = left[:, 2] > 0
    share, expected = up.mean(), 1 / (1 + eta**2)
    assert share == pytest.approx(expected, abs=4 * np.sqrt(expected * (1 - expected) / RAYS))
    for side in (up, ~up):
        counts = np.histogram(left[side, 2] ** 2, BINS, (0, 1))[0]  # even in the squared cosine
        due = side.sum() / BINS
        assert np.abs(counts - due).max() < 4.5 * np.sqrt(due)
    there, back = np.count_nonzero(~up & ~below), np.count_nonzero(up & below)
    assert abs(there - back) < 4.5 * np.sqrt(there + back)


@pytest.mark.parametrize("side", [1, -1])
def test_flat_facets_reflect_and_refract_as_a_smooth_interface(side):
    eta, angle = 1.49, np.deg2rad(30)
    wi = mi.Vector3f(float(np.sin(angle)), 0, float(side * np.cos(angle))) + dr.zeros(mi.Vector3f, RAYS)
    left = crossed(wi, 1e-4, eta)
    reflectance = float(mi.fresnel(mi.Float(float(side * np.cos(angle))), mi.Float(eta))[0][0])
    back = side * left[:, 2] > 0
    assert back.mean() == pytest.approx(reflectance, abs=4 * np.sqrt(reflectance / RAYS))
    sine = np.sin(angle) / eta if side > 0 else np.sin(angle) * eta
    assert -left[~back, 0].mean() == pytest.approx(sine, abs=2e-3)
    assert -left[back, 0].mean() == pytest.approx(np.sin(angle), abs=2e-3)


def test_half_of_the_facets_are_steeper_than_alpha():
    # Straight down, what a facet mirrors is turned by twice its slope; seen facets count by their level area.
    wi = mi.Vector3f(0, 0, 1) + dr.zeros(mi.Vector3f, RAYS)
    facet = first_facet(wi, mi.Float(0.1), mi.Float(1.49), mi.PCG32(size=RAYS))
    half = np.array(facet.reflected, np.float64).T + np.array([0, 0, 1])
    slopes = np.hypot(half[:, 0], half[:, 1]) / half[:, 2]
    assert np.median(slopes) == pytest.approx(0.1, rel=0.01)
