"""Curved blocks: rest without stress, affine motions, the flat limit, symmetry, and Hertz's effective radius."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.durometer import durometer
from magicsim.deform.indentation.press import press, press_curve
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects import parse_object

BALL = parse_object("sphere:radius_mm=4")
SMALL = ("footprint_mm=[12,14]",)


def design(name, *overrides):
    return load_preset(ElastomerDesign, "design", name, [*SMALL, *overrides])


def dome(x=None, y=None, crown=1.0, rim=0.2):
    radii = [f"radius_{axis}_mm={radius}" for axis, radius in (("x", x), ("y", y)) if radius]
    return f'face={{kind="dome",{",".join(radii)},crown_mm={crown},rim_mm={rim}}}'


@pytest.mark.parametrize("name", ["uniform-block", "mini-magictac"])
def test_rest_is_free_of_stress_and_affine_motion_is_in_balance(name):
    lattice = build_lattice(design(name, dome(15, 20)))
    elasticity = Elasticity.of(lattice)
    state = elasticity.evaluate(lattice.nodes_mm)
    scale = lattice.shear_modulus_mpa.max()
    assert np.abs(state.gradient).max() < 1e-9 * scale
    np.testing.assert_allclose(state.jacobian, 1, atol=1e-12)
    if name == "uniform-block":
        motion = np.eye(3) + np.array([[0.1, 0.05, 0.02], [-0.03, -0.05, 0.04], [0.0, 0.02, 0.08]])
        gradient = elasticity.evaluate(lattice.nodes_mm @ motion.T).gradient
        low, high = lattice.planes_mm[2][[0, -1]]
        shape = tuple(len(planes) for planes in reversed(lattice.planes_mm))
        inner = np.zeros(shape, bool)
        inner[1:-1, 1:-1, 1:-1] = True
        assert high > low
        assert np.abs(gradient[inner.ravel()]).max() < 1e-9 * scale


@pytest.mark.parametrize("name", ["uniform-block", "mini-magictac"])
def test_very_flat_dome_is_the_flat_block(name):
    flat = press(design(name), BALL, depth_mm=0.5).force_n[2]
    curved = press(design(name, dome(10_000, 10_000)), BALL, depth_mm=0.5).force_n[2]
    assert curved == pytest.approx(flat, rel=1e-3)


def test_press_on_the_crown_of_a_symmetric_dome_has_no_side_force():
    force = press(design("mini-magictac", dome(15, 20)), BALL, depth_mm=0.5).force_n
    assert np.abs(force[:2]).max() < 1e-5 * force[2]


def test_dome_of_half_the_curvature_is_pressed_as_by_a_smaller_ball():
    """Bodies of radii 4 and 12 touch as a ball of 3 on a plane does (Hertz 1881), as long as the contact is small."""
    fine, press_mm = ("lattice.spacing_mm=0.5", "footprint_mm=[12,12]"), 0.12
    smaller = parse_object("sphere:radius_mm=3")
    on_plane = press(design("uniform-block", *fine), smaller, depth_mm=press_mm).force_n[2]
    on_dome = press(design("uniform-block", *fine, dome(12, 12, 1.6)), BALL, depth_mm=press_mm).force_n[2]
    assert on_dome == pytest.approx(on_plane, rel=0.05)


def test_a_curve_on_a_slope_is_that_of_presses_there_and_a_durometer_refuses_it(tmp_path):
    np.save(tmp_path / "slope.npy", np.tile(np.linspace(-1, 1, 41), (41, 1)))
    face = f"face={{kind='height_map',file='{tmp_path / 'slope.npy'}',footprint_mm=[12,14]}}"
    slope = design("uniform-block", face, "lattice.spacing_mm=1.5", "lattice.cells_across=0")
    alone, curve = press(slope, BALL, depth_mm=0.6), press_curve(slope, BALL, [0.3, 0.6])
    assert curve.depths_mm.tolist() == [0.3, 0.6]
    assert curve.points[-1].force_n[2] == pytest.approx(alone.force_n[2], rel=0.01)
    with pytest.raises(ConfigError, match=r"design\.face of kind 'height_map' is not allowed"):
        durometer(slope)


def test_depth_counts_from_the_face_wherever_the_object_is():
    curved = design(
        "uniform-block", dome(30, 30, crown=1.6, rim=0.4), "lattice.spacing_mm=1.5", "lattice.cells_across=0"
    )
    found = press(curved, BALL, depth_mm=0.5, shear_mm=(3.0, 0.0))
    assert [each.depth_mm for each in found.history] == pytest.approx([0.5, 0.5], abs=1e-3)
    small = parse_object("sphere:radius_mm=0.3")
    beside = place_object(small, gap_mm=-0.4, x_mm=5.0, design=curved)
    assert beside.top_mm() > 0.6
    assert beside.depth_mm(curved.face, curved.footprint_mm) == pytest.approx(0.4, abs=1e-6)
    solver = ContactSolver(build_lattice(curved), max_step_mm=0.1, max_iterations=1)
    with pytest.raises(ConvergenceError, match=r"mm deep, and 0\.4 mm were asked for"):
        solver.solve(beside)
