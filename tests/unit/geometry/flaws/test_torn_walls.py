"""Prints that lack walls: as many as asked for, fused cells that are closed, of the right volume, and of the seed."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.printed_cells import WHOLE

SMALL = ("footprint_mm=[12, 14]",)


def built(*settings: str):
    return build_elastomer(load_design("mini-magictac", [*SMALL, *settings]))


@pytest.fixture(scope="module")
def torn():
    return built("unevenness.torn_share=0.05", "unevenness.seed=3")


def walls(grid):
    counts = np.array(grid.counts)
    return int(sum((counts[axis] - 1) * counts.prod() // counts[axis] for axis in range(3)))


def mesh(elastomer, faces):
    """A mesh of the infill without its collapsed triangles."""
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    return SurfaceMesh(vertices=elastomer.infill.vertices, faces=faces[whole])


def test_no_wall_is_missing_by_default():
    assert built().fused is None


def test_as_many_walls_are_missing_as_asked_for_and_no_cell_lacks_two(torn):
    assert len(torn.fused.pairs) == round(0.05 * walls(torn.grid))
    assert len(np.unique(torn.fused.pairs)) == torn.fused.pairs.size
    steps = np.unique(torn.fused.pairs[:, 1] - torn.fused.pairs[:, 0])
    assert steps.tolist() == np.cumprod([1, *torn.grid.counts[:2]]).tolist()


def test_fused_cells_are_closed_and_hold_the_missing_walls(torn):
    fused = mesh(torn, torn.fused.without_membranes)
    assert fused.is_watertight()
    below, above = torn.fused.pairs.T
    axis = np.searchsorted(np.cumprod([1, *torn.grid.counts[:2]]), above - below)
    cell, pitch = torn.grid.cell_mm, torn.grid.pitch_mm
    added = sum((pitch[a] - cell[a]) * np.prod(np.delete(cell, a)) for a in axis)
    assert fused.volume_mm3() == pytest.approx(torn.grid.infill_volume_mm3 + added, rel=1e-9)


def test_every_cell_is_closed_by_its_membrane(torn):
    per_cell = torn.triangles_per_cell
    for cell in torn.fused.pairs.ravel():
        own = torn.fused.closed[cell * per_cell : (cell + 1) * per_cell]
        _, places = np.unique(own, return_inverse=True)
        vertices = torn.infill.vertices[np.unique(own)]
        assert SurfaceMesh(vertices=vertices, faces=places.reshape(-1, 3).astype(np.int32)).is_watertight()


def test_membranes_stand_in_the_missing_walls_and_tell_the_cell_behind(torn):
    per_cell = torn.triangles_per_cell
    membrane = np.flatnonzero(torn.fused.beyond != WHOLE)
    found = np.unique(np.stack([membrane // per_cell, torn.fused.beyond[membrane]], 1), axis=0)
    np.testing.assert_array_equal(found, torn.fused.pairs[np.argsort(torn.fused.pairs[:, 0])])
    assert len(membrane) == len(torn.fused.pairs) * per_cell / 6
    corners = torn.infill.vertices[torn.fused.faces[membrane]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    below, above = torn.fused.pairs.T
    axis = np.searchsorted(np.cumprod([1, *torn.grid.counts[:2]]), above - below)
    assert area == pytest.approx(sum(np.prod(np.delete(torn.grid.cell_mm, a)) for a in axis))


def test_vertices_of_a_torn_print_are_those_of_the_whole_one(torn):
    np.testing.assert_array_equal(torn.infill.vertices, built().infill.vertices)
    np.testing.assert_array_equal(torn.infill.faces, built().infill.faces)


def test_each_seed_lacks_other_walls(torn):
    same, other = (built("unevenness.torn_share=0.05", f"unevenness.seed={seed}").fused.pairs for seed in (3, 4))
    np.testing.assert_array_equal(same, torn.fused.pairs)
    assert same.shape == other.shape
    assert (same != other).any()


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("unevenness.torn_share=0.2", "must be a number of at least 0 and at most 0.1"),
        ("unevenness={torn_share=0.01,crossing_radius_mm=0.1}", "one of them must be 0"),
    ],
)
def test_prints_that_cannot_be_are_one_line(setting, message):
    with pytest.raises(ConfigError, match=message) as told:
        load_design("mini-magictac", [setting])
    assert "\n" not in str(told.value)
