"""A ball much smaller than the lattice's spacing: the cells across its contact decide how stiff it looks."""

import pytest

from magicsim.config import load_preset
from magicsim.deform.press import press
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects import parse_object


def force_n(cells_across: int) -> float:
    design = load_preset(
        ElastomerDesign, "design", "uniform-block", ["footprint_mm=[8,8]", f"lattice.cells_across={cells_across}"]
    )
    return press(design, parse_object("sphere:radius_mm=0.5"), depth_mm=0.6).force_n[2]


def test_default_cells_are_enough_and_none_are_not() -> None:
    fine = force_n(8)
    assert force_n(4) == pytest.approx(fine, rel=0.05)
    assert force_n(0) > 1.2 * fine
