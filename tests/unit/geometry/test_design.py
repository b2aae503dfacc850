import pytest

from magicsim.config.models import validate
from magicsim.errors import ConfigError
from magicsim.geometry.design import BodyMaterial, ElastomerDesign
from magicsim.geometry.flaws import MIN_WALL_MM

from .designs import design


def refused(**changes: object) -> str:
    data = design().model_dump() | changes
    with pytest.raises(ConfigError) as caught:
        validate(ElastomerDesign, data, source="my.toml")
    return str(caught.value)


@pytest.mark.parametrize("cell_mm", [0.0, 0.3, 3.0])
def test_cell_size_at_a_limit_is_allowed(cell_mm: float):
    assert design(cell_mm=cell_mm).has_grid == (cell_mm > 0)


@pytest.mark.parametrize("cell_mm", [-0.1, 0.1, 0.29, 3.01, float("nan"), float("inf")])
def test_cell_size_beyond_a_limit_is_refused(cell_mm: float):
    message = refused(cell_mm=cell_mm)
    assert message.startswith("my.toml: ")
    assert f"cell_mm = {cell_mm:g}" in message


@pytest.mark.parametrize("skin_mm", [0.1, 5.0])
def test_skin_at_a_limit_is_allowed(skin_mm: float):
    assert design(skin_mm=skin_mm).skin_mm == skin_mm


@pytest.mark.parametrize("skin_mm", [-0.5, 0.0, 0.09, 5.1, float("nan")])
def test_skin_beyond_a_limit_is_refused(skin_mm: float):
    assert f"skin_mm = {skin_mm}" in refused(skin_mm=skin_mm)


@pytest.mark.parametrize(("skin_mm", "core_mm", "height_mm"), [(0.1, 0.8, 1.0), (1.0, 23.0, 25.0)])
def test_height_is_core_plus_two_skins_up_to_its_limits(skin_mm: float, core_mm: float, height_mm: float):
    assert design(skin_mm=skin_mm, core_mm=core_mm).height_mm == pytest.approx(height_mm)


@pytest.mark.parametrize(("skin_mm", "core_mm"), [(0.1, 0.7), (1.0, 23.5), (5.0, 15.1)])
def test_height_beyond_a_limit_is_refused_with_the_limits(skin_mm: float, core_mm: float):
    message = refused(skin_mm=skin_mm, core_mm=core_mm)
    assert f"{2 * skin_mm + core_mm:g} mm" in message
    assert "1 to 25 mm" in message


def test_wall_that_could_close_when_deformed_is_refused():
    assert "wall_mm = 0.04" in refused(wall_mm=0.04)
    assert design(wall_mm=MIN_WALL_MM).wall_mm == MIN_WALL_MM


def test_wall_is_free_without_a_grid():
    assert design(cell_mm=0.0, wall_mm=0.0).wall_mm == 0


def test_cells_need_an_infill_material():
    body = design().materials.model_dump()["body"]
    assert "materials.infill is missing" in refused(materials={"body": body})
    assert design(cell_mm=0.0, materials={"body": body}).materials.infill is None


@pytest.mark.parametrize(
    "changes",
    [
        {"schema_version": 2},
        {"footprint_mm": (24.0,)},
        {"footprint_mm": (24.0, 1.0)},
        {"core_mm": 0},
        {"core_mm": True},
        {"skin_mm": "soft"},
    ],
)
def test_wrong_value_is_one_line_that_names_its_key(changes: dict[str, object]):
    message = refused(**changes)
    assert next(iter(changes)) in message
    assert "\n" not in message


def test_elastic_moduli_follow_from_modulus_and_poisson_ratio():
    body = BodyMaterial(ior=1.5, youngs_modulus_mpa=3.0, poisson_ratio=0.25)
    assert body.shear_modulus_mpa == pytest.approx(1.2)
    assert body.bulk_modulus_mpa == pytest.approx(2.0)


@pytest.mark.parametrize("poisson_ratio", [0.5, -1.0, 0.6])
def test_poisson_ratio_without_finite_stiffness_is_refused(poisson_ratio: float):
    materials = design().model_dump()["materials"]
    materials["body"]["poisson_ratio"] = poisson_ratio
    assert "poisson_ratio" in refused(materials=materials)
