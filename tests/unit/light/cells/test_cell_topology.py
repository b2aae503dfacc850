"""Every face of a cell is the same square of triangles, and neighbours face each other."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import build_elastomer
from magicsim.light.cells.cell_topology import FACES, CellTopology, canonical_triangles


@pytest.fixture(scope="module", params=[1.0, 0.4])
def elastomer(request: pytest.FixtureRequest):
    settings = ["footprint_mm=[4.6,5.6]", "core_mm=3", f"lattice.spacing_mm={request.param}"]
    return build_elastomer(load_preset(ElastomerDesign, "design", "mini-magictac", settings))


def test_canonical_triangles_are_triangles_of_the_mesh(elastomer) -> None:
    topology = CellTopology.of(elastomer)
    faces = elastomer.infill.faces[: elastomer.triangles_per_cell]
    local = canonical_triangles(topology.parts)
    for face in range(FACES):
        for number, triangle in enumerate(local):
            found = faces[topology.triangles[face, number]].tolist()
            wanted = topology.corners[face, triangle].tolist()
            assert found in [wanted, wanted[1:] + wanted[:1], wanted[2:] + wanted[:2]]


def test_every_triangle_belongs_to_one_face(elastomer) -> None:
    topology = CellTopology.of(elastomer)
    assert sorted(topology.triangles.ravel()) == list(range(elastomer.triangles_per_cell))
    assert np.bincount(topology.face_of).tolist() == [elastomer.triangles_per_cell // FACES] * FACES


def test_faces_lie_on_the_side_that_their_number_says(elastomer) -> None:
    topology = CellTopology.of(elastomer)
    vertices = elastomer.infill.vertices[: topology.corners.max() + 1]
    for face in range(FACES):
        axis, side = divmod(face, 2)
        wanted = vertices[:, axis].max() if side else vertices[:, axis].min()
        assert vertices[topology.corners[face], axis] == pytest.approx(wanted)


def test_neighbours_are_mutual_and_one_pitch_away(elastomer) -> None:
    topology, grid = CellTopology.of(elastomer), elastomer.grid
    neighbours, centres = topology.neighbours(), grid.centres_mm()
    for face in range(FACES):
        axis, side = divmod(face, 2)
        inside = neighbours[:, face] >= 0
        assert np.count_nonzero(~inside) == grid.cell_count // grid.counts[axis]
        step = centres[neighbours[inside, face]] - centres[inside]
        assert step == pytest.approx(np.broadcast_to(np.eye(3)[axis] * grid.pitch_mm * (2 * side - 1), step.shape))
        assert (neighbours[neighbours[inside, face], face ^ 1] == np.flatnonzero(inside)).all()


def test_a_block_without_a_grid_has_no_topology() -> None:
    assert CellTopology.of(build_elastomer(load_preset(ElastomerDesign, "design", "uniform-block", []))) is None
