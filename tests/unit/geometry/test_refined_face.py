"""A finer face on the same block."""

import manifold3d
import numpy as np
import pytest

from magicsim.geometry.design import FACET_MM, load_design
from magicsim.geometry.elastomer import build_elastomer, refined_face
from magicsim.geometry.mesh import SurfaceMesh, from_manifold


def block() -> tuple[SurfaceMesh, np.ndarray]:
    mesh = from_manifold(manifold3d.Manifold.cube((4.0, 3.0, 2.0)).refine_to_length(0.8))
    return mesh, mesh.vertices[:, 2] < 1e-9


@pytest.mark.parametrize("parts", [1, 2, 3, 5])
def test_solid_stays_closed_and_the_same(parts: int) -> None:
    mesh, is_face = block()
    found = refined_face(mesh, is_face, parts)
    assert found.is_watertight()
    assert found.volume_mm3() == pytest.approx(24.0, rel=1e-12)
    np.testing.assert_array_equal(found.vertices[: len(mesh.vertices)], mesh.vertices)
    on_face = (found.vertices[found.faces][:, :, 2] < 1e-9).all(1)
    assert on_face.sum() == parts**2 * is_face[mesh.faces].all(1).sum()
    beside = (found.vertices[:, 2] > 1e-9).sum()
    assert beside == (~is_face).sum()


def test_normals_keep_their_side() -> None:
    mesh, is_face = block()
    found = refined_face(mesh, is_face, 3)
    corners = found.vertices[found.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = corners.mean(1) - [2.0, 1.5, 1.0]
    assert (np.einsum("ti,ti->t", normal, outward) > 0).all()
    assert (np.linalg.norm(normal, axis=1) > 1e-6).all()


@pytest.mark.parametrize("name", ["mini-magictac", "mini-magictac-finger"])
def test_face_of_a_design_bends_over_tenths_of_a_millimetre(name: str) -> None:
    elastomer = build_elastomer(load_design(name))
    faces = elastomer.body.faces[elastomer.is_face[elastomer.body.faces].all(1)]
    flat = elastomer.design.flattened(elastomer.body.vertices)[faces][:, :, :2]
    sides = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=-1)
    assert sides.min(1).max() <= FACET_MM + 1e-9
    assert sides.max() < 2 * FACET_MM
    (ax, ay), (bx, by) = ((flat[:, corner] - flat[:, 0]).T for corner in (1, 2))
    area = np.abs(ax * by - ay * bx).sum() / 2
    assert area == pytest.approx(np.prod(elastomer.design.footprint_mm), rel=1e-9)


def test_coarse_facets_leave_cells_whole_and_the_block_as_it_is() -> None:
    design = load_design("mini-magictac")
    fine, coarse = build_elastomer(design), build_elastomer(design, facet_mm=1.0)
    assert (fine.triangles_per_cell, coarse.triangles_per_cell) == (48, 12)
    assert len(coarse.body.faces) < len(fine.body.faces) / 3
    assert coarse.body.volume_mm3() == pytest.approx(fine.body.volume_mm3(), rel=1e-9)
    assert coarse.infill is not None
    assert fine.infill is not None
    assert coarse.infill.volume_mm3() == pytest.approx(fine.infill.volume_mm3(), rel=1e-9)
