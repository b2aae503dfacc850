import numpy as np
import pytest

from magicsim.errors import RenderError
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import load_scene
from magicsim.simulation.meshes import check_skin, check_walls, thinnest_wall


@pytest.fixture(scope="module")
def block():
    design = load_scene("rest", ["design.footprint_mm=[6,7]", "design.core_mm=4", "design.wall_mm=0.2"]).design
    return build_elastomer(design)


def test_walls_at_rest_have_their_printed_thickness(block):
    assert thinnest_wall(block.infill.vertices, block.infill, block.grid)[0] == pytest.approx(0.2)


@pytest.mark.parametrize("axis", range(3))
def test_wall_squeezed_along_an_axis_is_as_much_thinner(block, axis):
    moved = block.infill.vertices.copy()
    moved[:, axis] *= 0.5
    assert thinnest_wall(moved, block.infill, block.grid)[0] == pytest.approx(0.1)


def test_sheared_wall_is_measured_along_its_normal(block):
    shear = np.eye(3)
    shear[0, 2] = 1.0  # walls across x lean by 45 degrees
    found = thinnest_wall(block.infill.vertices @ shear.T, block.infill, block.grid)[0]
    assert found == pytest.approx(0.2 / np.sqrt(2))


def test_wall_below_the_safe_gap_is_refused_with_its_place(block):
    cells = block.infill.vertices.reshape(block.grid.cell_count, -1, 3).copy()
    cells[0, cells[0, :, 0] == cells[0, :, 0].max(), 0] += 0.195  # one cell swells until 5 micrometres are left
    with pytest.raises(RenderError, match=r"wall near .* is squeezed to 5\.0 micrometres: must stay above 10"):
        check_walls(cells.reshape(-1, 3), block.infill, block.grid)


def test_overlapping_cells_are_refused(block):
    cells = block.infill.vertices.reshape(block.grid.cell_count, -1, 3).copy()
    cells[0, cells[0, :, 2] == cells[0, :, 2].max(), 2] += 0.3
    with pytest.raises(RenderError, match=r"squeezed to -100\.0 micrometres"):
        check_walls(cells.reshape(-1, 3), block.infill, block.grid)


@pytest.mark.parametrize(("depth_mm", "is_safe"), [(0.8, True), (0.95, False)])
def test_object_that_reaches_a_cell_through_the_skin_is_refused(block, depth_mm, is_safe):
    ball = place_object(parse_object("sphere:radius_mm=3"), gap_mm=-depth_mm, x_mm=0.5, y_mm=0.5)
    if is_safe:
        check_skin(block.infill.vertices, ball.distance, -0.008)
    else:
        with pytest.raises(RenderError, match="skin near"):
            check_skin(block.infill.vertices, ball.distance, -0.008)


@pytest.mark.parametrize("uneven", ["wave_sd_mm=0.03", "wall_sd_mm=0.02", "crossing_radius_mm=0.15"])
def test_walls_of_a_printed_block_are_told_apart(uneven):
    settings = ["design.footprint_mm=[6,7]", "design.core_mm=4", "design.wall_mm=0.2", f"design.unevenness.{uneven}"]
    printed = build_elastomer(load_scene("rest", settings).design)
    thickness, _ = thinnest_wall(printed.infill.vertices, printed.infill, printed.grid)
    assert 0.1 < thickness < 0.201
