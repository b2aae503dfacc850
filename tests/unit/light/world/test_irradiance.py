"""Smoothing of light that falls on an object: flux stays, light does not leak around an edge."""

import manifold3d
import numpy as np
import pytest

from magicsim.geometry.mesh import from_manifold
from magicsim.light.world.irradiance import (
    DOUBLINGS,
    FACING,
    REACH,
    SMOOTHING_MM,
    WIDE_FROM_MM,
    WIDENING_MM,
    irradiance_kernel,
    widened,
)


def areas_mm2(mesh):
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(cross, axis=1) / 2


def nothing(mesh):
    return np.zeros(len(mesh.faces), bool)


@pytest.fixture(scope="module")
def box():
    return from_manifold(manifold3d.Manifold.cube((6, 6, 6), True).refine_to_length(0.5))


def test_even_light_stays_even(box):
    found = irradiance_kernel(box).irradiance(2.5 * areas_mm2(box)[:, None], nothing(box))
    np.testing.assert_allclose(found, 2.5, rtol=1e-9)


def test_a_spot_spreads_as_a_gaussian_and_keeps_its_flux():
    plate = from_manifold(manifold3d.Manifold.cube((12, 12, 1), True).refine_to_length(0.2))
    centres, area = plate.vertices[plate.faces].mean(1), areas_mm2(plate)
    on_top = centres[:, 2] > 0.499
    middle = np.flatnonzero(on_top)[np.linalg.norm(centres[on_top, :2], axis=1).argmin()]
    deposits = np.zeros((len(area), 1))
    deposits[middle] = 1.0
    found = irradiance_kernel(plate).irradiance(deposits, nothing(plate))[:, 0]
    flux = found * area
    assert flux.sum() == pytest.approx(1, rel=0.02)
    spread = np.sqrt((flux * (centres[:, 0] - centres[middle, 0]) ** 2).sum() / flux.sum())
    # A Gaussian cut off at two standard deviations is 0.83 as wide.
    assert spread == pytest.approx(0.83 * SMOOTHING_MM, rel=0.05)


@pytest.mark.parametrize("width_mm", [SMOOTHING_MM, 8 * SMOOTHING_MM])
def test_every_patch_within_reach_that_faces_alike_counts_by_its_distance(box, width_mm):
    ((patches, weights),) = irradiance_kernel(box, width_mm).parts
    centres = box.vertices[box.faces].mean(1)
    cross = np.cross(*(box.vertices[box.faces[:, corner]] - box.vertices[box.faces[:, 0]] for corner in (1, 2)))
    area = np.linalg.norm(cross, axis=1)
    places = (patches @ (centres * area[:, None])) / (patches @ area)[:, None]
    facing = cross @ (patches @ cross).T > FACING * np.outer(area, np.linalg.norm(patches @ cross, axis=1))
    away = np.linalg.norm(centres[:, None] - places, axis=2)
    expected = np.where(facing & (away <= REACH * width_mm), np.exp(-(away**2) / (2 * width_mm**2)), 0)
    np.testing.assert_allclose(weights.toarray(), expected, atol=1e-8)


def test_light_does_not_leak_around_an_edge(box):
    centres = box.vertices[box.faces].mean(1)
    below = centres[:, 2] < -2.999
    found = irradiance_kernel(box).irradiance(np.where(below, areas_mm2(box), 0.0)[:, None], nothing(box))[:, 0]
    np.testing.assert_allclose(found[below], 1, rtol=1e-6)
    assert np.abs(found[~below]).max() < 1e-6


def test_light_does_not_leak_across_the_rim_of_a_contact(box):
    centres = box.vertices[box.faces].mean(1)
    wetted = (centres[:, 2] > 2.999) & (np.linalg.norm(centres[:, :2], axis=1) < 1.5)
    deposits = np.where(wetted, 3.0, 1.0) * areas_mm2(box)
    found = irradiance_kernel(box).irradiance(deposits[:, None], wetted)[:, 0]
    np.testing.assert_allclose(found, np.where(wetted, 3.0, 1.0), rtol=1e-9)


def test_a_kernel_twice_as_wide_spreads_twice_as_far():
    plate = from_manifold(manifold3d.Manifold.cube((20, 20, 1), True).refine_to_length(0.4))
    centres, area = plate.vertices[plate.faces].mean(1), areas_mm2(plate)
    on_top = centres[:, 2] > 0.499
    middle = np.flatnonzero(on_top)[np.linalg.norm(centres[on_top, :2], axis=1).argmin()]
    deposits = np.zeros((len(area), 1))
    deposits[middle] = 1.0
    flux = irradiance_kernel(plate, 2 * SMOOTHING_MM).irradiance(deposits, nothing(plate))[:, 0] * area
    spread = np.sqrt((flux * (centres[:, 0] - centres[middle, 0]) ** 2).sum() / flux.sum())
    assert spread == pytest.approx(2 * 0.83 * SMOOTHING_MM, rel=0.05)


def test_surfaces_further_off_are_smoothed_more():
    """Between two kernels the irradiance is a mean of what both give; far away the widest serves."""
    asked = []

    def gathered(level):
        asked.append(level)
        return np.full((4, 1), float(level))

    found = widened(gathered, np.array([-1.0, WIDE_FROM_MM, WIDE_FROM_MM + WIDENING_MM * (2**1.5 - 1), 1e6]))
    np.testing.assert_allclose(found[:, 0], [0, 0, 1.5, DOUBLINGS], atol=1e-12)
    assert set(asked) == {0, 1, 2, DOUBLINGS}
