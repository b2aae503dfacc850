"""Walls are cells of their own below the spot, and nowhere else."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.lattice.spot import resolved_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import Zone
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import Place, resolve_grid, symmetric_place

SPOT = Zone(low_mm=(-0.3, -0.3), high_mm=(0.3, 0.3))
MARGIN_MM = 1.0


def design(name: str = "mini-magictac") -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", name, [])


def resolved(block: ElastomerDesign, spacing_mm: float = 0.4) -> Lattice:
    return resolved_lattice(block, SPOT, margin_mm=MARGIN_MM, spacing_mm=spacing_mm, growth=2.0)


def test_infill_fills_its_share_of_the_box() -> None:
    block = design()
    grid, infill = resolve_grid(block), block.materials.infill
    assert grid is not None
    assert infill is not None
    lattice = resolved(block)
    volume, pitch = lattice.sizes_mm.prod(1), grid.pitch_mm
    soft = lattice.shear_modulus_mpa == infill.shear_modulus_mpa
    walls = lattice.is_core & (lattice.shear_modulus_mpa == block.materials.body.shear_modulus_mpa)
    assert volume[soft].sum() / volume[soft | walls].sum() == pytest.approx(np.prod(grid.cell_mm / pitch), rel=1e-9)
    assert volume[soft | walls].sum() == pytest.approx(3 * 4 * 2 * np.prod(pitch))
    assert not lattice.wall_modulus_mpa[soft | walls].any()
    np.testing.assert_array_equal(lattice.lame_mpa[soft], infill.lame_mpa)


def test_the_block_keeps_its_size_and_its_stiffness_outside() -> None:
    block = design()
    lattice, usual = resolved(block), build_lattice(block)
    assert lattice.sizes_mm.prod(1).sum() == pytest.approx(usual.sizes_mm.prod(1).sum())
    centres = lattice.nodes_mm[lattice.cells].mean(1)
    far = lattice.is_core & (np.abs(centres[:, :2]).max(1) > 4)
    np.testing.assert_allclose(lattice.shear_modulus_mpa[far], usual.shear_modulus_mpa[usual.is_core][0])
    skin = centres[:, 2] < block.skin_mm
    np.testing.assert_allclose(lattice.shear_modulus_mpa[skin], block.materials.body.shear_modulus_mpa)


@pytest.mark.parametrize("name", ["mini-magictac", "uniform-block"])
def test_cells_below_the_spot_keep_to_the_spacing(name: str) -> None:
    lattice = resolved(design(name), spacing_mm=0.3)
    centres = lattice.nodes_mm[lattice.cells].mean(1)
    near = (np.abs(centres[:, :2]).max(1) < 0.3 + MARGIN_MM) & (centres[:, 2] < MARGIN_MM)
    assert lattice.sizes_mm[near].max() <= 0.3 * 1.05 + 1e-12
    assert lattice.sizes_mm.max() > 1


@pytest.mark.parametrize("place", ["cell", "wall"])
def test_a_quarter_is_what_lies_beyond_the_spot(place: Place) -> None:
    block = design()
    infill = block.materials.infill
    assert infill is not None
    x, y = symmetric_place(block, place)
    spot = Zone(low_mm=(x - 0.3, y - 0.3), high_mm=(x + 0.3, y + 0.3))
    quarter, whole = (
        resolved_lattice(block, spot, margin_mm=MARGIN_MM, spacing_mm=0.2, growth=2.0, mirrored=mirrored)
        for mirrored in (True, False)
    )
    assert quarter.planes_mm[0][0] == pytest.approx(x, abs=1e-9)
    assert quarter.planes_mm[1][0] == pytest.approx(y, abs=1e-9)
    assert quarter.planes_mm[0][-1] == whole.planes_mm[0][-1]
    soft, in_all = (
        each.sizes_mm.prod(1) @ (each.shear_modulus_mpa == infill.shear_modulus_mpa) for each in (quarter, whole)
    )
    assert soft == pytest.approx(in_all / 4)
