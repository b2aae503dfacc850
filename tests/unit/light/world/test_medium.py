import numpy as np
import pytest

from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.world.medium import Medium, free_path, scattered, scattering_stretch

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
COUNT = 200_000


def uniform(seed):
    return mi.PCG32(size=COUNT, initstate=seed).next_float32()


@pytest.mark.parametrize("anisotropy", [-0.5, 0.0, 0.3, 0.8])
def test_mean_cosine_of_scattering_is_the_anisotropy(anisotropy):
    before = mi.Vector3f(dr.normalize(mi.Vector3f(1, 2, -2)))
    after = scattered(before, mi.Point2f(uniform(1), uniform(2)), anisotropy)
    assert dr.mean(dr.dot(before, after))[0] == pytest.approx(anisotropy, abs=0.006)
    np.testing.assert_allclose(np.array(dr.norm(after)), 1, atol=1e-5)


def test_free_paths_end_inside_the_segment_and_follow_the_truncated_exponential():
    sigma_t, length = 0.7, 2.0
    found = np.array(free_path(uniform(3), mi.Float(np.exp(-sigma_t * length)), sigma_t))
    assert 0 <= found.min() <= found.max() <= length * (1 + 1e-5)
    passed = np.exp(-sigma_t * length)
    assert found.mean() == pytest.approx(1 / sigma_t - length * passed / (1 - passed), rel=0.005)


@pytest.mark.parametrize(
    ("origin_z", "direction_z", "length", "start", "stretch"),
    [
        (1.0, 0.0, 3.0, 0.0, 3.0),  # level, below the plate
        (6.0, 0.0, 3.0, 0.0, 0.0),  # level, inside it
        (4.0, 1.0, 3.0, 0.0, 1.0),  # up into the plate
        (6.0, -1.0, 3.0, 1.0, 2.0),  # down out of it
        (6.0, -1.0, 0.5, 0.5, 0.0),  # down, not out of it
        (1.0, 1.0, 2.0, 0.0, 2.0),  # up, not into it
    ],
)
def test_stretch_that_scatters_lies_below_the_plate(origin_z, direction_z, length, start, stretch):
    side = float(np.sqrt(1 - direction_z**2))
    ray = mi.Ray3f(mi.Point3f(0, 0, origin_z), mi.Vector3f(side, 0, direction_z))
    found = scattering_stretch(ray, mi.Float(length), 5.0)
    assert [float(part[0]) for part in found] == pytest.approx([start, stretch], abs=1e-5)


def test_reduced_medium_keeps_absorption_and_transport_coefficient():
    medium = Medium(sigma_s=2.0, sigma_a=0.1, anisotropy=0.75)
    assert medium.reduced == Medium(sigma_s=0.5, sigma_a=0.1)
    assert medium.albedo == pytest.approx(2 / 2.1)
