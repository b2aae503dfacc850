import pytest

from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.live.sight import DESIGN_FIELDS, Wish, design_values
from magicsim.robot.workspace import Workspace


@pytest.fixture
def wish() -> Wish:
    design = load_preset(ElastomerDesign, "design", "mini-magictac")
    return Wish(design=design_values(design), exposure_grey=90.0)


def test_wish_begins_with_the_design_as_it_is(wish: Wish):
    assert dict(zip(DESIGN_FIELDS, wish.design, strict=True)) == {
        "skin_mm": 0.8, "core_mm": 5.0, "cell_mm": 0.8, "wall_mm": 0.1,
    }  # fmt: skip
    assert design_values(load_preset(ElastomerDesign, "design", "mini-magictac")) == wish.design


def test_object_stays_inside_of_the_workspace(wish: Wish):
    space = Workspace(x_mm=(-1, 1), gap_mm=(-1, 5))
    assert wish.pushed(space, gap_mm=-0.1).gap_mm == pytest.approx(wish.gap_mm - 0.1)
    assert wish.pushed(space, x_mm=7.0, gap_mm=-70.0) == wish.pushed(space, x_mm=1.0, gap_mm=-1 - wish.gap_mm)
