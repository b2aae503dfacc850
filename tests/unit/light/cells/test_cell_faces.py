"""Places that count as clear of a cell's dents lie behind all planes of the faces beside them."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import build_elastomer
from magicsim.light.backend import VARIANT
from magicsim.light.cells.cell_faces import FRAME, NEVER, NONE, cell_faces
from magicsim.light.cells.cell_topology import FACES, CellTopology, canonical_triangles

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")


@pytest.fixture(scope="module", params=[1.0, 0.4])
def elastomer(request: pytest.FixtureRequest):
    settings = ["footprint_mm=[4.6,5.6]", "core_mm=3", "wall_mm=0.2", f"lattice.spacing_mm={request.param}"]
    return build_elastomer(load_preset(ElastomerDesign, "design", "mini-magictac", settings))


def rough(elastomer, size_mm):
    """Vertices moved at random, the worst for the slopes of dents."""
    vertices = elastomer.infill.vertices
    return vertices + np.random.default_rng(1).uniform(-size_mm, size_mm, vertices.shape)


def margins(faces):
    return np.array(faces.frames).reshape(-1, FRAME)[:, 12:15]


def planes(vertices, topology):
    """A point and the outward normal of every triangle of every face, each of shape (cells, 6, triangles, 3)."""
    corners = vertices.reshape(np.prod(topology.counts), -1, 3)[:, topology.corners]
    a, b, c = (corners[:, :, index] for index in canonical_triangles(topology.parts).T)
    return a, np.cross(b - a, c - a)


@pytest.mark.parametrize("size_mm", [0.001, 0.005, 0.02])
def test_clear_places_are_behind_all_planes_beside_them(elastomer, size_mm):
    topology, vertices = CellTopology.of(elastomer), rough(elastomer, size_mm)
    faces = cell_faces(vertices, topology)
    frames, (points, normals) = np.array(faces.frames, np.float64).reshape(-1, FRAME), planes(vertices, topology)
    inward, centres, checked = frames[:, :9].reshape(-1, 3, 3), frames[:, 9:12], 0
    for out, signs in ((axis, signs) for axis in range(3) for signs in np.ndindex(2, 2, 2)):
        clear = 1 - margins(faces) - 1e-5
        clear[:, out] = 1
        possible = (clear > 0).all(1)
        ends = centres + np.einsum("cij,cj->ci", np.linalg.inv(inward), clear * (2 * np.array(signs) - 1))
        beside = [face for face in range(FACES) if face // 2 != out]
        height = np.einsum("cfti,cfti->cft", normals[:, beside], ends[:, None, None] - points[:, beside])
        assert (height[possible] < 0).all()
        checked += possible.sum()
    assert checked > 0 or size_mm > 0.01


def test_a_face_may_not_be_known_across_a_wall_where_its_neighbour_is_in_front_of_itself(elastomer):
    topology = CellTopology.of(elastomer)
    vertices = rough(elastomer, 0.015)
    (points, normals), faces = planes(vertices, topology), cell_faces(vertices, topology)
    corners = vertices.reshape(np.prod(topology.counts), -1, 3)[:, topology.corners]
    known = np.array(faces.neighbours).reshape(-1, FACES)
    cell, face = np.argwhere(known != NONE).T
    assert len(cell) > 0
    assert (known[known[cell, face], face ^ 1] == cell).all()
    other = corners[known[cell, face], face ^ 1]
    height = np.einsum("nti,ntvi->ntv", normals[cell, face], other[:, None] - points[cell, face][:, :, None])
    assert height.min() > 0


def test_cells_at_rest_are_convex_and_crushed_ones_nowhere_clear():
    elastomer = build_elastomer(load_preset(ElastomerDesign, "design", "mini-magictac", ["footprint_mm=[4.6,5.6]"]))
    at_rest = margins(cell_faces(elastomer.infill.vertices, CellTopology.of(elastomer)))
    assert np.isneginf(at_rest).all()
    crushed = margins(cell_faces(rough(elastomer, 0.2), CellTopology.of(elastomer)))
    assert (crushed == NEVER).any()
