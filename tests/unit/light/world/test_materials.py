"""A film of metal inside a face: closed forms of parallel plates."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.world import materials  # noqa: F401 -- registers the material

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
IOR = 1.49
OUTSIDE, INSIDE = np.array([1.0, 0.7, 0.3]), np.array([-1.0, -0.9, -0.8])


def shares(reflectance, transmittance, cosine):
    """What of light along each cosine is reflected, and what passes, shape (2, cosines)."""
    film = mi.load_dict(
        {"type": "filmed_dielectric", "ior": IOR, "reflectance": reflectance, "transmittance": transmittance}
    )
    si = dr.zeros(mi.SurfaceInteraction3f, len(cosine))
    si.wi = mi.Vector3f(np.sqrt(1 - cosine**2).astype(np.float32), 0, cosine.astype(np.float32))
    context, found = mi.BSDFContext(mi.TransportMode.Importance), []
    for sample, side in ((0.0, 1), (1.0, -1)):
        bs, weight = film.sample(context, si, mi.Float(sample), mi.Point2f(0.5, 0.5), mi.Bool(True))
        went = np.array(bs.wo.z) * cosine * side > 0
        found.append(np.where(went, np.array(bs.pdf) * np.array(weight)[0], 0.0))
    return np.array(found)


def bare(cosine):
    return np.array(mi.fresnel(mi.Float(cosine.astype(np.float32)), mi.Float(IOR))[0])


@pytest.mark.parametrize("cosine", [OUTSIDE, INSIDE])
def test_film_without_losses_keeps_all_light(cosine):
    np.testing.assert_allclose(shares(0.6, 0.4, cosine).sum(0), 1, rtol=1e-5)


def test_as_much_passes_inwards_as_outwards():
    inside = -np.sqrt(1 - (1 - OUTSIDE**2) / IOR**2)
    np.testing.assert_allclose(shares(0.3, 0.45, OUTSIDE)[1], shares(0.3, 0.45, inside)[1], rtol=1e-4)


@pytest.mark.parametrize("cosine", [OUTSIDE, INSIDE])
def test_no_film_is_the_bare_face(cosine):
    np.testing.assert_allclose(shares(0.0, 1.0, cosine), [bare(cosine), 1 - bare(cosine)], rtol=1e-4, atol=1e-6)


def test_beyond_the_critical_angle_light_crosses_the_film_twice():
    reflected, passed = shares(0.3, 0.5, np.array([-0.3]))
    assert passed == 0
    np.testing.assert_allclose(reflected, 0.3 + 0.5**2 / (1 - 0.3), rtol=1e-5)


def test_face_and_film_reflect_to_and_fro():
    reflected, passed = shares(0.3, 0.45, INSIDE)
    series = 1 / (1 - 0.3 * bare(INSIDE))
    np.testing.assert_allclose(reflected, 0.3 + 0.45**2 * bare(INSIDE) * series, rtol=1e-4)
    np.testing.assert_allclose(passed, 0.45 * (1 - bare(INSIDE)) * series, rtol=1e-4)
