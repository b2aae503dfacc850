import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from magicsim.geometry.objects.textured import DotPlate, Plate, RidgePlate, nearest_place, places_on

PLATE = Plate(size_mm=4.0, thickness_mm=1.0, edge_radius_mm=0.1)
DOTS = DotPlate(radius_mm=0.3, spacing_mm=0.9, plate=PLATE)
RIDGES = RidgePlate(width_mm=0.4, spacing_mm=1.0, height_mm=0.5, edge_radius_mm=0.1, plate=PLATE)


@settings(deadline=None, max_examples=50)
@given(count=st.integers(1, 7), spacing=st.floats(0.1, 3), seed=st.integers(0, 99))
def test_nearest_place_is_the_nearest_of_all(count: int, spacing: float, seed: int):
    coordinates = np.random.default_rng(seed).uniform(-8, 8, (50, 2))
    places = (np.arange(count) - (count - 1) / 2) * spacing
    assert places.mean() == pytest.approx(0, abs=1e-12)
    nearest = np.abs(coordinates[..., None] - places).min(axis=-1)
    assert np.abs(coordinates - nearest_place(coordinates, count, spacing)) == pytest.approx(nearest)


def test_as_many_bumps_as_fit_on_the_flat_part():
    assert DOTS.count == 4  # centres within 3.8 - 0.6 = 3.2 mm
    assert RIDGES.count == 4
    assert [places_on(length, 1.0) for length in (-0.1, 0.0, 0.99, 1.0, 2.5)] == [0, 1, 1, 2, 3]
    assert places_on(0.3, 0.1) == 4


def test_outside_the_distance_is_the_least_to_plate_and_all_dots():
    rng = np.random.default_rng(2)
    points = rng.uniform(-3, 3, (2000, 3))
    top = DOTS.face_mm
    centres = [(x, y, top) for x in (-1.35, -0.45, 0.45, 1.35) for y in (-1.35, -0.45, 0.45, 1.35)]
    balls = np.min([np.linalg.norm(points - centre, axis=1) - 0.3 for centre in centres], axis=0)
    plate, _ = PLATE.distance(points - [0, 0, top])
    brute = np.minimum(plate, balls)
    outside = brute > 0
    assert DOTS.distance(points)[0][outside] == pytest.approx(brute[outside], abs=1e-12)
    assert (DOTS.distance(points)[0][~outside] <= 1e-12).all()


def test_point_below_a_dot_leaves_by_its_outline_and_not_by_the_hidden_face():
    below = np.array([[0.45, 0.45, DOTS.face_mm - 0.1]])
    distance, normal = DOTS.distance(below)
    assert distance[0] == pytest.approx(-np.hypot(0.3, 0.1))
    assert normal[0, 2] == pytest.approx(0.1 / np.hypot(0.3, 0.1))


def test_point_below_a_ridge_leaves_by_its_outline_and_not_by_the_hidden_face():
    below = np.array([[0.55, 0.2, RIDGES.face_mm - 0.1]])
    distance, normal = RIDGES.distance(below)
    assert distance[0] == pytest.approx(-np.hypot(0.15, 0.1))
    assert normal[0] == pytest.approx(np.array([0.15, 0, 0.1]) / np.hypot(0.15, 0.1))


def test_bumps_stand_on_the_plate_and_the_whole_is_centred():
    up = np.array([0.0, 0.0, 1.0])
    for solid, bump in ((DOTS, 0.3), (RIDGES, 0.5)):
        assert solid.support_mm(up) == pytest.approx((1.0 + bump) / 2)
        assert solid.support_mm(-up) == pytest.approx((1.0 + bump) / 2)
    over_groove = np.array([[0.0, 0.0, 2.0]])
    assert DOTS.distance(over_groove)[0][0] == pytest.approx(np.linalg.norm([0.45, 0.45, 2.0 - DOTS.face_mm]) - 0.3)
    assert RIDGES.distance(np.array([[0.5, 0.0, 2.0]]))[0][0] == pytest.approx(2.0 - 0.75)


def test_meshes_have_the_volume_of_plate_and_bumps():
    plate = PLATE.box.mesh().volume_mm3()
    dots = DOTS.mesh().volume_mm3() - plate
    sag = 2 * 0.3 * (1 - np.cos(np.pi / 32))  # the facets lie between the ball and one that is smaller by this
    assert 16 * 2 / 3 * np.pi * (0.3 - sag) ** 3 < dots < 16 * 2 / 3 * np.pi * 0.3**3
    sharp = RidgePlate(width_mm=0.4, spacing_mm=1.0, height_mm=0.5, edge_radius_mm=1e-3, plate=PLATE)
    assert sharp.mesh().volume_mm3() - plate == pytest.approx(4 * 0.4 * 3.8 * 0.5, rel=2e-3)


def test_mesh_of_a_dense_array_stays_moderate_and_closed():
    dense = DotPlate(radius_mm=0.05, spacing_mm=0.12, plate=PLATE)
    mesh = dense.mesh()
    assert dense.count == 31
    assert mesh.is_watertight()
    assert 31**2 * 12 < len(mesh.faces) <= 100_000


def test_bumps_thicker_than_the_plate_do_not_reach_through_it():
    thin = DotPlate(radius_mm=0.8, spacing_mm=2.0, plate=Plate(size_mm=4.0, thickness_mm=0.3, edge_radius_mm=0.05))
    low = -(0.3 + 0.8) / 2
    mesh = thin.mesh()
    assert mesh.vertices[:, 2].min() == pytest.approx(low)
    distance, normal = thin.distance(np.array([[0.0, 0.0, low - 0.2]]))
    assert distance[0] == pytest.approx(0.2)
    assert normal[0] == pytest.approx([0, 0, -1])
