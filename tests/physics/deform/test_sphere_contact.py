"""A sphere on a bonded block: symmetry, balance, references, limits."""

import numpy as np
import pytest
from laboratory.deform.reference import load_reference

from magicsim.config.models import load_preset
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import press
from magicsim.deform.lattice.structure import box_lattice, build_lattice
from magicsim.deform.quality import NewtonOptions
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.design import FAR_FIELD_BOUND, ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.objects.plain import SphereObject

SYMMETRY = 1e-6
"""Departure from symmetry that residuals of 1e-8 of the contact force leave [mm, N, N mm]."""
BALL = SphereObject(kind="sphere", radius_mm=4.0)
REFERENCE_N = {depth.depth_mm: depth.force_n for depth in load_reference().depths}
"""Finite elements on `uniform-block` under a sphere of 4 mm (`python benchmarks/deform.py --recompute`)."""


def uniform_block(*overrides: str) -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", "uniform-block", overrides)


def small_solver(*, poisson_ratio: float = 0.49, half: int = 4) -> ContactSolver:
    across = np.linspace(-half, half, 2 * half + 1)
    lattice = box_lattice(
        (across, across, np.linspace(0, 4, 5)),
        shear_modulus_mpa=1 / 3,
        lame_mpa=2 / 3 * poisson_ratio / (1 - 2 * poisson_ratio),
    )
    return ContactSolver(lattice)


@pytest.fixture(scope="module")
def pressed() -> Deformation:
    return small_solver().solve(place_object(BALL, gap_mm=-0.8))


def test_force_is_the_reaction_and_points_into_the_sensor(pressed: Deformation) -> None:
    assert pressed.force_n[2] > 0
    assert pressed.force_balance < 1e-6
    assert pressed.max_penetration_mm <= 0.002
    assert pressed.min_jacobian > 0


def test_symmetric_press_gives_symmetric_answer(pressed: Deformation) -> None:
    side = 9
    grid = pressed.displacements_mm.reshape(5, side, side, 3)
    np.testing.assert_allclose(grid, grid[:, :, ::-1] * [-1, 1, 1], atol=SYMMETRY)
    np.testing.assert_allclose(grid, grid[:, ::-1] * [1, -1, 1], atol=SYMMETRY)
    np.testing.assert_allclose(grid, grid.transpose(0, 2, 1, 3)[..., [1, 0, 2]], atol=SYMMETRY)
    np.testing.assert_allclose(pressed.force_n[:2], 0, atol=SYMMETRY)
    np.testing.assert_allclose(pressed.torque_nmm, 0, atol=SYMMETRY)


def test_torque_follows_the_place_of_the_force() -> None:
    state = small_solver(half=6).solve(place_object(BALL, gap_mm=-0.5, x_mm=2.0))
    x_mm = -state.torque_nmm[1] / state.force_n[2]
    assert x_mm == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.4999, 0.499999])
def test_converges_up_to_incompressibility(poisson_ratio: float) -> None:
    state = small_solver(poisson_ratio=poisson_ratio).solve(place_object(BALL, gap_mm=-0.5))
    assert state.converged
    assert state.iterations < 40


def test_object_that_cannot_touch_leaves_the_rest_state() -> None:
    solver = small_solver()
    state = solver.solve(place_object(BALL, gap_mm=0.2))
    assert state.is_rest
    assert state.iterations == 0
    assert np.array_equal(state.displacements_mm, np.zeros_like(solver.lattice.nodes_mm))


def test_warm_start_ends_where_a_cold_start_does(pressed: Deformation) -> None:
    solver = small_solver()
    halfway = solver.solve(place_object(BALL, gap_mm=-0.4))
    state = solver.solve(place_object(BALL, gap_mm=-0.8), halfway)
    assert state.force_n[2] == pytest.approx(pressed.force_n[2], rel=5e-3)


def test_release_returns_to_rest(pressed: Deformation) -> None:
    assert small_solver().solve(place_object(BALL, gap_mm=1.0), pressed).is_rest


def test_press_beyond_reach_raises_with_figures() -> None:
    solver = ContactSolver(small_solver(half=2).lattice, options=NewtonOptions(max_iterations=3))
    with pytest.raises(ConvergenceError, match=r"iterations.*residual.*min J.*penetration.*force balance") as caught:
        solver.solve(place_object(BALL, gap_mm=-3.4))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("field", "settings"),
    [
        ("depth_mm", {"depth_mm": -0.1}),
        ("depth_mm", {"depth_mm": float("nan")}),
        ("depth_mm", {"depth_mm": 6.0}),
        ("shear_mm along y", {"depth_mm": 1.0, "shear_mm": (0.0, float("inf"))}),
        ("tolerance_mm", {"depth_mm": 1.0, "tolerance_mm": 0.0}),
    ],
)
def test_press_names_the_number_that_is_not_allowed(field: str, settings: dict) -> None:
    with pytest.raises(ConfigError, match=f"^{field} = .* is not allowed: must be"):
        press(uniform_block(), BALL, **settings)


@pytest.mark.parametrize("depth_mm", [0.5, 1.0])
def test_force_is_near_finite_elements_at_default_spacing(depth_mm: float) -> None:
    result = press(uniform_block(), BALL, depth_mm=depth_mm)
    assert result.force_n[2] == pytest.approx(REFERENCE_N[depth_mm], rel=0.05)
    assert result.max_penetration_mm <= 0.002


@pytest.mark.parametrize(("depth_mm", "error"), [(0.5, 0.02), pytest.param(2.5, 0.04, marks=pytest.mark.slow)])
def test_force_is_near_finite_elements_at_fine_spacing(depth_mm: float, error: float) -> None:
    result = press(uniform_block("lattice.spacing_mm=0.5"), BALL, depth_mm=depth_mm)
    assert result.force_n[2] == pytest.approx(REFERENCE_N[depth_mm], rel=error)


@pytest.mark.slow
@pytest.mark.parametrize("growth", [1.0, 1.6])
def test_force_converges_to_finite_elements(growth: float) -> None:
    design = uniform_block("lattice.spacing_mm=0.5", f"lattice.growth={growth}")
    force = press(design, BALL, depth_mm=1.0).force_n[2]
    assert force == pytest.approx(REFERENCE_N[1.0], rel=0.02)


@pytest.mark.parametrize("depth_mm", [0.5, 1.0])
def test_reference_agrees_with_the_bonded_layer_formula(depth_mm: float) -> None:
    """Long, Hall, Wu and Hui, Biophysical Journal 2011: incompressible bonded layer under a sphere."""
    radius, height, modulus = 4.0, 6.0, 0.9933 / (1 - 0.49**2)
    omega = (radius * depth_mm / height**2) ** 1.5
    alpha = 10.05 - 0.63 * np.sqrt(height / radius) * (3.1 + (height / radius) ** 2)
    beta = 4.8 - 4.23 * (height / radius) ** 2
    factor = (1 + 1.15 * omega ** (1 / 3) + alpha * omega + beta * omega**2) / (1 + 2.3 * omega)
    force = 4 / 3 * modulus * np.sqrt(radius) * depth_mm**1.5 * factor
    assert REFERENCE_N[depth_mm] == pytest.approx(force, rel=0.02)


@pytest.mark.parametrize("text", ["box:size_mm=4x4x8", "punch:radius_mm=2", "cylinder:radius_mm=3,length_mm=8"])
def test_every_kind_of_object_presses_the_default_design(text: str) -> None:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ["footprint_mm=[10,10]"])
    result = press(design, parse_object(text), depth_mm=0.4)
    assert result.force_n[2] > 0


def test_core_cells_are_softer_than_the_skin() -> None:
    lattice = build_lattice(load_preset(ElastomerDesign, "design", "mini-magictac"))
    assert lattice.is_core.sum() == 25 * 34 * 6
    assert lattice.shear_modulus_mpa[lattice.is_core].max() < lattice.shear_modulus_mpa[~lattice.is_core].min() / 2


@pytest.mark.parametrize("name", ["mini-magictac", "uniform-block"])
def test_coarse_far_field_changes_the_force_by_less_than_its_bound(name: str) -> None:
    forces = []
    for growth in (1.0, ElastomerDesign.model_fields["lattice"].default.growth):
        design = load_preset(ElastomerDesign, "design", name, ["footprint_mm=[16,16]", f"lattice.growth={growth}"])
        forces.append(press(design, BALL, depth_mm=0.5, tolerance_mm=5e-4).force_n[2])
    assert forces[1] == pytest.approx(forces[0], rel=FAR_FIELD_BOUND)
    assert forces[1] != forces[0]


def test_unloading_ends_where_loading_does() -> None:
    """Multipliers that outlive a deeper press would pull the face across a gap."""
    solver = ContactSolver(small_solver().lattice, tolerance_mm=2e-4)
    deep = solver.solve(place_object(BALL, gap_mm=-0.8))
    back, direct = (solver.solve(place_object(BALL, gap_mm=-0.2), start) for start in (deep, None))
    assert back.force_n[2] == pytest.approx(direct.force_n[2], rel=0.01)
    assert back.contact_gap_mm[back.contact_pressure_mpa > 0].max() <= 2e-4
