import manifold3d
import numpy as np
import pytest

from magicsim.errors import GeometryError
from magicsim.geometry.design import FACET_MM, load_design
from magicsim.geometry.elastomer import FACE_EDGE_MM, Elastomer, build_elastomer, refined_face
from magicsim.geometry.mesh import SurfaceMesh, from_manifold

from .designs import EXTREMES, design


@pytest.fixture(params=EXTREMES.values(), ids=EXTREMES.keys(), scope="module")
def elastomer(request: pytest.FixtureRequest) -> Elastomer:
    return build_elastomer(design(**request.param))


def closed_form_mm3(elastomer: Elastomer) -> float:
    """n_x n_y n_z cell_x cell_y cell_z, from the design alone."""
    block = elastomer.design
    volume = 1.0
    for size in (*block.footprint_mm, block.height_mm):
        core = size - 2 * block.skin_mm
        count = max(1, round(core / (block.cell_mm + block.wall_mm)))
        volume *= count * (core / count - block.wall_mm)
    return volume


def longest_edge_mm(mesh: SurfaceMesh) -> float:
    corners = mesh.vertices[mesh.faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())


def test_both_meshes_are_closed_and_outward_with_the_volume_of_the_closed_form(elastomer: Elastomer):
    block = elastomer.design
    assert elastomer.body.is_watertight()
    assert elastomer.body.volume_mm3() == pytest.approx(np.prod([*block.footprint_mm, block.height_mm]), rel=1e-9)
    assert elastomer.infill is not None
    assert elastomer.infill.is_watertight()
    assert elastomer.infill.volume_mm3() == pytest.approx(closed_form_mm3(elastomer), rel=1e-9)


def test_each_block_of_infill_triangles_is_one_cell_in_its_place(elastomer: Elastomer):
    grid, infill = elastomer.grid, elastomer.infill
    assert grid is not None
    assert infill is not None
    corners = infill.vertices[infill.faces].reshape(grid.cell_count, -1, 3)
    assert corners.shape[1] == 3 * elastomer.triangles_per_cell
    assert corners.min(1) == pytest.approx(grid.centres_mm() - grid.cell_mm / 2, abs=1e-9)
    assert corners.max(1) == pytest.approx(grid.centres_mm() + grid.cell_mm / 2, abs=1e-9)


def test_walls_between_cells_and_around_them_have_the_thickness_asked_for(elastomer: Elastomer):
    grid, block = elastomer.grid, elastomer.design
    assert grid is not None
    assert elastomer.infill is not None
    assert grid.pitch_mm - grid.cell_mm == pytest.approx([block.wall_mm] * 3)
    cover = block.skin_mm + block.wall_mm / 2
    low, high = elastomer.infill.vertices.min(0), elastomer.infill.vertices.max(0)
    assert low - elastomer.body.vertices.min(0) == pytest.approx([cover] * 3)
    assert elastomer.body.vertices.max(0) - high == pytest.approx([cover] * 3)


def test_body_is_fine_enough_to_bend(elastomer: Elastomer):
    assert longest_edge_mm(elastomer.body) <= 2 * FACE_EDGE_MM


def test_block_lies_on_the_contact_face_centred_about_the_axis():
    body = build_elastomer(design()).body
    assert body.vertices.min(0) == pytest.approx([-3, -4, 0])
    assert body.vertices.max(0) == pytest.approx([3, 4, 4.6])


def test_block_without_a_grid_is_only_a_body():
    plain = build_elastomer(design(cell_mm=0.0))
    assert plain.infill is None
    assert plain.grid is None
    assert plain.triangles_per_cell == 0
    assert plain.body.volume_mm3() == pytest.approx(6 * 8 * 4.6)


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({}, 2),
        ({"lattice": {"spacing_mm": 1.0}}, 2),
        ({"lattice": {"spacing_mm": 0.55}}, 2),
        ({"lattice": {"spacing_mm": 0.3}}, 4),
        # Neither a thick nor a thin skin counts: only what the lattice does along a pitch.
        ({"footprint_mm": (14.0, 14.0), "skin_mm": 5.0, "core_mm": 4.0, "lattice": {"spacing_mm": 1.0}}, 2),
        ({"footprint_mm": (2.2, 2.2), "skin_mm": 0.1, "core_mm": 2.0, "lattice": {"spacing_mm": 0.5}}, 2),
    ],
)
def test_infill_is_split_as_often_as_the_lattice_splits_a_pitch_and_at_least_in_two(
    changes: dict[str, object], parts: int
):
    assert build_elastomer(design(**changes)).triangles_per_cell == 12 * parts**2


def test_design_whose_cells_do_not_fit_is_refused():
    with pytest.raises(GeometryError, match="no cell fits"):
        build_elastomer(design(core_mm=0.5))


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
