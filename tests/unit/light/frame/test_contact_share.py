"""What of the light at a place comes from a contact, against solid angles in closed form."""

import manifold3d
import numpy as np
import pytest

from magicsim.geometry.mesh import from_manifold
from magicsim.light.frame.anchored_light import contact_share


def disk(radius_mm, edge_mm=0.2):
    """A flat disk at z = 0, looking up."""
    solid = manifold3d.Manifold.cylinder(1, radius_mm, radius_mm, 64).refine_to_length(edge_mm)
    mesh = from_manifold(solid.translate((0, 0, -1)))
    return mesh.vertices, mesh.faces[(np.abs(mesh.vertices[mesh.faces, 2]) < 1e-6).all(1)]


@pytest.mark.parametrize("height_mm", [1.0, 3.0, 10.0])
def test_above_a_disk_the_share_is_its_solid_angle(height_mm):
    radius = 2.0
    found = contact_share(np.array([[0, 0, height_mm]]), *disk(radius))
    expected = 1 - height_mm / np.hypot(height_mm, radius)
    assert found[0] == pytest.approx(expected, rel=0.05)


def test_far_away_it_falls_with_the_square_of_the_distance_and_the_cosine():
    near, far, aslant = contact_share(np.array([[0, 0, 20], [0, 0, 40], [20, 0, 20.0]]), *disk(1.0))
    assert far / near == pytest.approx(1 / 4, rel=0.01)
    assert aslant / near == pytest.approx(2**-1.5, rel=0.01)


def test_on_a_contact_it_is_everything_at_most():
    places = np.array([[0, 0, 0.05], [3, 1, 0.3], [0, 0, 1.0]])
    found = contact_share(places, *disk(12.0, 1.0))
    assert (found <= 1).all()
    assert found.min() > 0.7


def test_no_contact_no_share():
    np.testing.assert_array_equal(contact_share(np.ones((3, 3)), np.zeros((0, 3)), np.zeros((0, 3), np.int32)), 0)


def test_shares_do_not_depend_on_how_finely_a_contact_is_meshed():
    places = np.array([[0.5, 0.2, 1.0], [4, 1, 3.0]])
    coarse, fine = (contact_share(places, *disk(2.0, edge)) for edge in (0.5, 0.1))
    np.testing.assert_allclose(coarse, fine, rtol=0.05)
