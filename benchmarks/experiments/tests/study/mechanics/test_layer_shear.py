import numpy as np
import pytest

from magicsim.deform.lattice.spot import resolved_lattice
from magicsim.deform.lattice.zone import Zone
from magicsim.geometry.design import load_design
from magicsim.geometry.grid import resolve_grid, symmetric_place
from magicsim_experiments.study.mechanics.limit_press import layer_shear


def test_shear_of_each_layer_of_the_cube_below_a_place():
    design = load_design("mini-magictac", ["footprint_mm=[8,8]"])
    place = symmetric_place(design, "cell")
    spot = Zone(low_mm=place, high_mm=place).grown(0.5)
    lattice = resolved_lattice(design, spot, margin_mm=0.5, spacing_mm=0.45, growth=2.0)
    moved = np.zeros_like(lattice.nodes_mm)
    moved[:, 0] = 0.1 * lattice.nodes_mm[:, 2] ** 2
    found = layer_shear(lattice, moved, place)
    grid = resolve_grid(design)
    assert grid is not None
    top = grid.origin_mm[2] + (grid.pitch_mm[2] - grid.cell_mm[2]) / 2
    layers = len(found)
    depths = top + grid.cell_mm[2] * (np.arange(layers) + 0.5) / layers
    np.testing.assert_allclose(found, 0.2 * depths, rtol=1e-6)


def test_block_without_infill_has_none():
    design = load_design("uniform-block", ["footprint_mm=[8,8]"])
    spot = Zone(low_mm=(0.0, 0.0), high_mm=(0.0, 0.0)).grown(0.5)
    lattice = resolved_lattice(design, spot, margin_mm=0.5, spacing_mm=1.0, growth=2.0)
    assert len(layer_shear(lattice, np.zeros_like(lattice.nodes_mm), (0.0, 0.0))) == pytest.approx(0)
