import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.shapes.mesh_solid import FAR_MM, MeshShape


def shape_of(mesh: trimesh.Trimesh) -> MeshShape:
    return MeshShape.of(SurfaceMesh(vertices=np.array(mesh.vertices, float), faces=np.array(mesh.faces, np.int32)))


@pytest.mark.parametrize("subdivisions", [2, 3, 4])
def test_icosphere_is_the_ball_within_its_sag(subdivisions: int):
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=2.0)
    shape = shape_of(ball)
    sag = 2.0 - np.linalg.norm(ball.triangles_center, axis=1).min()
    points = np.random.default_rng(0).uniform(-2.3, 2.3, (500, 3))
    radius = np.linalg.norm(points, axis=1)
    distance, normal = shape.distance(points)
    assert (distance - (radius - 2.0)).min() > -1e-9
    assert (distance - (radius - 2.0)).max() < sag + 1e-9
    near = np.abs(distance) > 0.3
    assert normal[near & (distance > 0)] == pytest.approx((points / radius[:, None])[near & (distance > 0)], abs=0.2)


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), flat=st.floats(0.05, 1.0))
def test_sign_is_right_beside_sharp_edges_and_corners(seed: int, flat: float):
    """Convex solids with acute corners: inside is where all face planes say so."""
    rng = np.random.default_rng(seed)
    hull = trimesh.convex.convex_hull(rng.standard_normal((5, 3)) * [1, 1, flat])
    shape = shape_of(hull)
    corners = np.repeat(hull.vertices, 20, axis=0)
    middles = np.repeat(hull.vertices[hull.edges_unique].mean(axis=1), 20, axis=0)
    points = np.concatenate([corners, middles])
    points = points + 0.05 * rng.standard_normal(points.shape)
    offset = points[:, None] - hull.triangles_center
    planes = np.einsum("pti,ti->pt", offset, hull.face_normals).max(axis=1)
    clear = np.abs(planes) > 1e-9
    distance, _ = shape.distance(points)
    assert np.array_equal(distance[clear] > 0, planes[clear] > 0)


def test_inside_a_convex_mesh_the_distance_is_that_to_the_nearest_face_plane():
    hull = trimesh.convex.convex_hull(np.random.default_rng(1).standard_normal((12, 3)))
    shape = shape_of(hull)
    points = np.random.default_rng(2).uniform(-0.5, 0.5, (200, 3))
    planes = np.einsum("pti,ti->pt", points[:, None] - hull.triangles_center, hull.face_normals)
    inside = planes.max(axis=1) < 0
    distance, normal = shape.distance(points)
    assert inside.sum() > 20
    assert distance[inside] == pytest.approx(planes.max(axis=1)[inside])
    assert normal[inside] == pytest.approx(hull.face_normals[planes.argmax(axis=1)][inside], abs=1e-6)


def test_normal_on_the_surface_is_the_pseudonormal():
    cube = shape_of(trimesh.creation.box((2.0, 2.0, 2.0)))
    points = np.array([[1.0, 0.3, 0.1], [1.0, 1.0, 0.2], [1.0, 1.0, 1.0]])
    distance, normal = cube.distance(points)
    assert distance == pytest.approx(np.zeros(3), abs=1e-12)
    assert normal[0] == pytest.approx([1, 0, 0])
    assert normal[1] == pytest.approx(np.array([1, 1, 0]) / np.sqrt(2))
    assert normal[2] == pytest.approx(np.ones(3) / np.sqrt(3))


@pytest.mark.parametrize("height_mm", [1e-12, 1e-9, 1e-6, -1e-6, 1e-3])
def test_above_a_face_the_normal_is_the_faces_without_rounding(height_mm: float):
    """A contact force turns with it: directions to a foot a nanometre away are noise."""
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=3.0)
    mesh.apply_translation([11.0, -7.0, 5.0])
    places = mesh.triangles_center + height_mm * mesh.face_normals
    _, normal = shape_of(mesh).distance(places)
    np.testing.assert_allclose(normal, mesh.face_normals, atol=1e-12)


def test_far_from_the_mesh_the_distance_is_a_lower_bound():
    ball = shape_of(trimesh.creation.icosphere(subdivisions=3, radius=1.0))
    points = np.random.default_rng(3).uniform(-5, 5, (500, 3))
    distance, normal = ball.distance(points)
    true = np.linalg.norm(points, axis=1) - 1
    assert (distance <= true + 0.02).all()
    beyond = np.linalg.norm(np.maximum(np.abs(points) - 1, 0), axis=1)
    assert (distance[beyond > FAR_MM] > FAR_MM).all()
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(500))


def test_concave_mesh_is_empty_in_its_hole():
    ring = shape_of(trimesh.creation.torus(2.0, 0.5))
    distance, _ = ring.distance(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.4, 0.0, 0.0]]))
    assert distance == pytest.approx([1.5, -0.5, 0.1], abs=0.02)


def test_mesh_is_refined_for_rendering_and_stays_on_the_surface():
    cube = shape_of(trimesh.creation.box((4.0, 4.0, 4.0)))
    mesh = cube.mesh()
    assert mesh.is_watertight()
    assert mesh.volume_mm3() == pytest.approx(64.0)
    assert np.abs(cube.distance(mesh.vertices)[0]).max() < 1e-12
    edges = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, axis=1)]
    assert np.linalg.norm(edges, axis=2).mean() < 0.6
