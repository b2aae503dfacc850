"""Rounded cells: closed, as large as round edges make them, and thicker walls where they cross."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.printed_cells import FACET_TOLERANCE, cell_mesh, cell_volume_mm3

EDGES = np.array([0.8, 0.9, 1.0])


@pytest.mark.parametrize("radius_mm", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("parts", [2, 3])
def test_a_cell_is_closed_and_has_the_volume_of_round_edges(radius_mm, parts):
    cell = cell_mesh(EDGES, parts, radius_mm)
    assert cell.is_watertight()
    assert cell.volume_mm3() == pytest.approx(cell_volume_mm3(EDGES, radius_mm), rel=FACET_TOLERANCE)
    np.testing.assert_allclose(np.ptp(cell.vertices, axis=0), EDGES, rtol=1e-6)


def test_edges_and_corners_stay_near_the_round():
    radius = 0.2
    places = np.abs(cell_mesh(EDGES, 2, radius).vertices)
    beyond = np.linalg.norm(np.maximum(places - (EDGES / 2 - radius), 0), axis=1)
    assert beyond.min() == pytest.approx(radius)
    assert beyond.max() < 1.16 * radius  # a sharp corner would be 1.73 away


def test_fillets_are_off_by_default_and_bounded():
    drawn = build_elastomer(load_design("mini-magictac", ["footprint_mm=[8,9]"]))
    assert drawn.infill.volume_mm3() == pytest.approx(drawn.grid.infill_volume_mm3)
    with pytest.raises(ConfigError, match=r"crossing_radius_mm = 0\.45 is not allowed.*must be at most 0\.4 cell_mm"):
        load_design("mini-magictac", ["unevenness.crossing_radius_mm=0.45"])
