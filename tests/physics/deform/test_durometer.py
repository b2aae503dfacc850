"""The virtual durometer: it ends where spring and sample agree, and orders samples by stiffness."""

import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.durometer import durometer, spring_force_n
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign


def sample(*overrides: str) -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", "uniform-block", ["footprint_mm=[10,10]", *overrides])


ROUGHLY = {"spacing_mm": 1.2, "step_mm": 0.25, "force_tolerance_n": 4e-3}
"""Where only the order of two readings is asked for: they are good to 0.05 units, and differ by more than one."""


@pytest.fixture(scope="module")
def soft() -> float:
    return durometer(sample("materials.body.youngs_modulus_mpa=1.0"), **ROUGHLY).shore_a


@pytest.mark.parametrize(
    ("name", "value"),
    [("step_mm", 0.0), ("step_mm", -0.1), ("spacing_mm", -1.0), ("spacing_mm", 0.0), ("hole_radius_mm", -1.0)],
)
def test_numbers_that_no_cone_can_be_pressed_with_are_refused(name: str, value: float) -> None:
    with pytest.raises(ConfigError, match=f"{name} = {value:g} is not allowed: must be a number of at least"):
        durometer(sample(), **{name: value})


def test_spring_is_that_of_the_standard() -> None:
    assert spring_force_n(2.5) == pytest.approx(0.55)
    assert spring_force_n(0.0) == pytest.approx(8.05)


def test_equilibrium_is_on_the_spring_and_valid() -> None:
    told = []
    found = durometer(sample(), spacing_mm=1.2, progress=lambda *step: told.append(step))
    spring = spring_force_n(found.depth_mm)
    assert told[-1] == (
        round(1000 * found.depth_mm), 2500, f"cone {found.force_n:.2f} N, spring {spring:.2f} N",
    )  # fmt: skip
    assert found.force_n == pytest.approx(spring, abs=1e-3)
    assert found.shore_a == pytest.approx(100 * (1 - found.depth_mm / 2.5))
    assert found.min_jacobian > 0
    assert found.max_penetration_mm <= 0.002
    assert found.force_balance < 1e-6
    assert found.walls == "none"  # of a block without a grid


def test_stiffer_is_harder(soft: float) -> None:
    assert durometer(sample("materials.body.youngs_modulus_mpa=2.0"), **ROUGHLY).shore_a > soft + 5


def test_thinner_is_harder(soft: float) -> None:
    thin = sample("materials.body.youngs_modulus_mpa=1.0", "core_mm=2.0")
    assert durometer(thin, **ROUGHLY).shore_a > soft + 2


def test_friction_of_the_tip_makes_the_reading_harder(soft: float) -> None:
    """It only holds the face; the reading in the middle is that with a coefficient of 1."""
    slipping, sticking = [
        durometer(sample("materials.body.youngs_modulus_mpa=1.0"), **ROUGHLY, friction=friction).shore_a
        for friction in (0.2, 2.0)
    ]
    assert slipping < soft < sticking


def test_foot_makes_the_reading_harder(soft: float) -> None:
    bare = durometer(sample("materials.body.youngs_modulus_mpa=1.0"), **ROUGHLY, hole_radius_mm=None)
    assert bare.shore_a < soft


@pytest.mark.slow
@pytest.mark.parametrize(("total_mm", "skin_mm", "shore_a"), [(10.0, 3.0, 33.25), (10.0, 0.5, 17.1)])
def test_moduli_of_the_default_design_meet_the_readings_that_they_were_fitted_to(
    total_mm: float, skin_mm: float, shore_a: float
) -> None:
    """Half a unit of difference is that between the centre of a cell and a crossing of walls."""
    printed = load_preset(
        ElastomerDesign, "design", "mini-magictac",
        [f"skin_mm={skin_mm}", f"core_mm={total_mm - 2 * skin_mm}"],
    )  # fmt: skip
    found = durometer(printed)
    assert found.walls == "resolved"
    assert found.shore_a == pytest.approx(shore_a, abs=0.6)


@pytest.mark.slow
def test_a_soft_block_is_read_on_its_own_lattice_without_folding() -> None:
    soft = sample("materials.body.youngs_modulus_mpa=0.3", "footprint_mm=[16,22]")
    found = durometer(soft)
    assert found.spacing_mm == pytest.approx(0.4)
    assert found.force_n == pytest.approx(spring_force_n(found.depth_mm), abs=1e-3)
    assert found.shore_a == pytest.approx(8.29, abs=0.1)  # with 0.3 mm between nodes
    assert found.min_jacobian > 0
