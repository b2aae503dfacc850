import manifold3d
import numpy as np
import pytest

from magicsim.geometry.mesh import SurfaceMesh, from_manifold


def cube() -> SurfaceMesh:
    return from_manifold(manifold3d.Manifold.cube((2.0, 3.0, 4.0)).translate((5.0, -1.0, 2.0)))


def test_volume_is_positive_for_outward_triangles_wherever_the_mesh_lies():
    mesh = cube()
    assert mesh.volume_mm3() == pytest.approx(24.0)
    assert SurfaceMesh(vertices=mesh.vertices, faces=mesh.faces[:, ::-1]).volume_mm3() == pytest.approx(-24.0)


def test_closed_mesh_is_watertight_and_one_with_a_hole_is_not():
    mesh = cube()
    assert mesh.is_watertight()
    assert not SurfaceMesh(vertices=mesh.vertices, faces=mesh.faces[1:]).is_watertight()


def test_mesh_with_one_flipped_triangle_is_not_watertight():
    mesh = cube()
    faces = mesh.faces.copy()
    faces[0] = faces[0, ::-1]
    assert not SurfaceMesh(vertices=mesh.vertices, faces=faces).is_watertight()


def test_mesh_with_a_triangle_twice_is_not_watertight():
    mesh = cube()
    assert not SurfaceMesh(vertices=mesh.vertices, faces=np.concatenate([mesh.faces] * 2)).is_watertight()
