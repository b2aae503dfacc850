"""Forces on taxels, stretch and stress of the skin, shear of the infill, against closed forms and conservation."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.cell_problem import cell_fields
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.follow import rotation_and_strain
from magicsim.deform.lattice.relaxation import Relaxation, branch_moduli
from magicsim.deform.lattice.structure import Lattice, box_lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import InfillCells, SkinCells, localisation, shear_of
from magicsim.deform.taxels import TaxelForces, TaxelGrid, TaxelMap
from magicsim.geometry.design import load_design
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.pose import Pose

from .deep_block import DeepBlock, ball, pressed
from .layer_theory import layer_contact, sphere

SHEAR_MPA, LAME_MPA = 0.4, 3.0
SOMEWHERE = Pose(position_mm=np.zeros(3), rotation=np.eye(3))
UNIFORM = load_design("uniform-block", ["footprint_mm=[10,10]"])


def displaced(lattice: Lattice, places_mm: np.ndarray) -> Deformation:
    """A lattice at given places; nothing is known of contact."""
    return replace(Deformation.rest(lattice), displacements_mm=places_mm - lattice.nodes_mm, pose=SOMEWHERE)


def cube() -> Lattice:
    planes = (np.linspace(-1, 1, 4), np.linspace(-1, 1, 4), np.linspace(0, 2, 4))
    return box_lattice(planes, shear_modulus_mpa=SHEAR_MPA, lame_mpa=LAME_MPA)


def skin_of(lattice: Lattice, **options: object) -> SkinCells:
    """All of a lattice, as of a block without a grid."""
    return SkinCells.of(UNIFORM, lattice, **options)


def encircled(forces: TaxelForces, grid: TaxelGrid, radius_mm: float) -> float:
    """Share of the normal force on the taxels whose middles are within a radius."""
    inside = np.linalg.norm(grid.centres_mm, axis=-1) < radius_mm
    return float(forces.force_n[inside, 2].sum() / forces.force_n[..., 2].sum())


def on_taxels(solver: ContactSolver, indenter: Indenter, *, side_mm: float, block: DeepBlock) -> tuple:
    grid = TaxelGrid.over(solver.lattice, rows=201, columns=201)
    near = np.linspace(-side_mm, side_mm, 202)
    grid = replace(grid, edges_x_mm=near, edges_y_mm=near[::-1])
    shares = TaxelMap.of(solver.lattice, grid, point_spacing_mm=block.half_width_mm)
    return shares.forces(solver.solve(indenter)), grid


@pytest.mark.parametrize("shape", [(1, 1), (7, 5), (64, 48)])
def test_taxels_add_up_to_force_and_torque_of_a_sheared_press(shape: tuple[int, int]):
    thing = parse_object("sphere:radius_mm=3")
    poses = [place_object(thing, gap_mm=-0.6, x_mm=x, y_mm=-2.0) for x in (1.5, 1.8)]
    design = load_design("mini-magictac", ["footprint_mm=[12,12]"])
    lattice, spacing = build_lattice(design, zone=contact_zone(poses, design)), point_spacing_mm(thing.shape())
    solver, state = ContactSolver(lattice, friction=0.6, point_spacing_mm=spacing), None
    for pose in poses:
        state = solver.solve(pose, state)
    assert state is not None
    grid = TaxelGrid.over(lattice, rows=shape[0], columns=shape[1])
    found = TaxelMap.of(lattice, grid, point_spacing_mm=spacing).forces(state)
    np.testing.assert_allclose(found.force_n.sum((0, 1)), state.force_n, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.torque_nmm.sum((0, 1)), state.torque_nmm, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.area_mm2, 144 / np.prod(shape), rtol=1e-9)
    assert state.force_n[0] > 0.05  # dragged along +x
    if shape == (64, 48):  # row 0 is at +y: the press at y = -2 is in the lower half, at x > 0 in the right one
        normal = found.force_n[..., 2]
        centre = np.average(grid.centres_mm.reshape(-1, 2), axis=0, weights=normal.ravel())
        assert centre == pytest.approx([1.5, -2.0], abs=0.1)  # where it first touched: the face sticks
        assert normal[33:, 25:].sum() == pytest.approx(state.force_n[2])
        arms = np.cross(np.dstack([grid.centres_mm, np.zeros(shape)]), found.force_n).sum((0, 1))
        assert arms[:2] == pytest.approx(state.torque_nmm[:2], rel=0.2)


def test_ball_presses_as_hertz_says():
    """Of the force of a pressure p0 sqrt(1 - r^2 / a^2) the part 1 - (1 - r^2 / a^2)^1.5 is within r."""
    block = DeepBlock(height_mm=20.0, half_width_mm=20.0, poisson=0.3)
    depth = layer_contact(sphere(50.0), 1.0, height_mm=20.0, modulus_mpa=2 / 0.7, poisson=0.3).depth_mm
    solver = block.solver((12, 8), tolerance_mm=depth / 1000)
    forces, grid = on_taxels(solver, ball(50.0, depth), side_mm=1.5, block=block)
    for radius in (0.4, 0.6, 0.8):
        assert encircled(forces, grid, radius) == pytest.approx(1 - (1 - radius**2) ** 1.5, abs=0.05)
    assert encircled(forces, grid, 1.2) == pytest.approx(1, abs=0.01)
    along = forces.force_n.sum((0, 1))
    assert abs(along[:2]).max() < 1e-3 * along[2]


def test_flat_punch_presses_at_its_rim():
    """Of the force of a rigid flat punch the part 1 - sqrt(1 - r^2 / a^2) is within r, of an even pressure r^2 / a^2.

    Pressures of neighbouring points alternate below a flat face, which leaves some percent in a circle.
    """
    block = DeepBlock(height_mm=20.0, half_width_mm=20.0, poisson=0.3)
    tool = parse_object("punch:radius_mm=1,edge_radius_mm=0.02").shape()
    solver = block.solver((18, 9), tolerance_mm=1e-5)
    forces, grid = on_taxels(solver, pressed(tool, 0.01), side_mm=1.5, block=block)
    for radius in (0.4, 0.5, 0.6, 0.7, 0.8):
        assert encircled(forces, grid, radius) == pytest.approx(1 - np.sqrt(1 - radius**2), abs=0.06)


def test_uniform_compression_is_a_uniaxial_state():
    """Free sides: the lateral stretch follows from zero stress, and von Mises is force over deformed area."""
    lattice, axial = cube(), 0.7
    low, high = 1.0, 1.5
    for _ in range(60):
        side = (low + high) / 2
        jacobian = side**2 * axial
        stress = SHEAR_MPA * (side**2 - 1) / jacobian + LAME_MPA * (jacobian - 1)
        low, high = (side, high) if stress < 0 else (low, side)
    places = lattice.nodes_mm * [side, side, axial]
    skin = skin_of(lattice).fields(displaced(lattice, places))
    np.testing.assert_allclose(skin.stretch, side, rtol=1e-9)
    forces = Elasticity.of(lattice).evaluate(places).gradient
    top = lattice.nodes_mm[:, 2] == 0
    np.testing.assert_allclose(skin.von_mises_mpa, forces[top, 2].sum() / (2 * side) ** 2, rtol=1e-9)
    np.testing.assert_allclose(forces[~top & (lattice.nodes_mm[:, 2] < 2)], 0, atol=1e-9)


def test_tension_stretches_the_skin_by_the_strain():
    lattice = cube()
    skin = skin_of(lattice).fields(displaced(lattice, lattice.nodes_mm * [1.25, 1, 1]))
    np.testing.assert_allclose(skin.stretch, 1.25, rtol=1e-12)


def test_rigid_motion_neither_stretches_nor_stresses():
    lattice, turn = cube(), Pose.from_degrees(np.array([1.0, 2.0, 3.0]), yaw=40.0, pitch=20.0)
    skin = skin_of(lattice).fields(displaced(lattice, turn.to_sensor(lattice.nodes_mm)))
    np.testing.assert_allclose(skin.stretch, 1, rtol=1e-12)
    np.testing.assert_allclose(skin.von_mises_mpa, 0, atol=1e-12)


def test_bent_skin_stretches_by_its_distance_from_the_neutral_surface():
    """Bent to a cylinder about its middle surface, a skin is stretched by 1 + t / R at the distance t from it."""
    radius, thickness = 6.0, 0.8
    planes = (np.linspace(-2, 2, 41), np.linspace(-0.5, 0.5, 3), np.linspace(0, thickness, 9))
    lattice = box_lattice(planes, shear_modulus_mpa=SHEAR_MPA, lame_mpa=LAME_MPA)
    x, y, z = lattice.nodes_mm.T
    from_centre, angle = radius + thickness / 2 - z, x / radius
    places = np.stack([from_centre * np.sin(angle), y, radius - from_centre * np.cos(angle)], 1)
    outermost = thickness / 2 - thickness / 8 * (0.5 - 0.5 / np.sqrt(3))  # the Gauss points nearest to the face
    skin = skin_of(lattice).fields(displaced(lattice, places))
    np.testing.assert_allclose(skin.stretch, 1 + outermost / radius, rtol=2e-4)


def test_body_that_relaxes_is_stiffer_at_once():
    lattice = build_lattice(UNIFORM)
    terms = [(0.1, 2.0), (10.0, 1.0)]
    branches = branch_moduli(UNIFORM, lattice, terms)
    state = displaced(lattice, lattice.nodes_mm * [1.1, 1, 0.95])
    late = skin_of(lattice).fields(state).von_mises_mpa
    memory = Relaxation.of(Elasticity.of(lattice), branches).rest()
    soon = skin_of(lattice, branches=branches).fields(replace(state, relaxation=memory)).von_mises_mpa
    modulus = UNIFORM.materials.body.youngs_modulus_mpa
    np.testing.assert_allclose(soon, late * (modulus + 3.0) / modulus, rtol=1e-9)


def test_simple_shear_is_its_own_amount():
    for amount in (0.0, 0.05, 0.8):
        gradient = np.eye(3)[None].copy()
        gradient[0, 0, 2] = amount
        assert shear_of(rotation_and_strain(gradient)[1])[0] == pytest.approx(amount, abs=1e-9)


@pytest.mark.parametrize("share", [0.3, 0.729])
def test_strain_of_the_infill_gives_the_stiffness_of_the_cell(share: float):
    """Hill: C = C_wall + share (C_infill - C_wall) A, for each of the three moduli of a cubic cell."""
    body, infill = (0.4, 8.0), (0.02, 40.0)
    fields = cell_fields(body=body, infill=infill, infill_share=share)
    found, cell = localisation(fields), fields.stiffness
    jump, bulk_jump = share * (infill[0] - body[0]), share * (infill[1] - body[1])
    assert body[0] + jump * found.shear == pytest.approx(cell.c44_mpa, rel=1e-9)
    assert body[0] + jump * (found.along - found.across) == pytest.approx(cell.tetragonal_modulus_mpa, rel=1e-9)
    assert body[1] + bulk_jump * (found.along + 2 * found.across) == pytest.approx(cell.bulk_modulus_mpa, rel=1e-9)


def test_infill_of_a_sheared_block_is_sheared_more_than_the_block():
    design = load_design("mini-magictac", ["footprint_mm=[8,8]"])
    lattice, amount = build_lattice(design), 0.02
    infill = InfillCells.of(design, lattice)
    assert infill is not None
    places = lattice.nodes_mm.copy()
    places[:, 0] += amount * places[:, 2]
    shear = infill.shear(displaced(lattice, places))
    assert shear.shape == (6, infill.grid.counts[1], infill.grid.counts[0])
    np.testing.assert_allclose(shear, infill.localisation.shear * amount, rtol=1e-3)
    assert infill.localisation.shear > 1.1


def test_infill_of_the_walls_material_is_sheared_as_the_block():
    body = load_design("mini-magictac").materials.body
    same = f"materials.infill.shear_modulus_mpa={body.shear_modulus_mpa}"
    bulk = f"materials.infill.bulk_modulus_mpa={body.bulk_modulus_mpa}"
    design = load_design("mini-magictac", ["footprint_mm=[8,8]", same, bulk])
    lattice = build_lattice(design)
    infill = InfillCells.of(design, lattice)
    assert infill is not None
    places = lattice.nodes_mm.copy()
    places[:, 1] += 0.6 * places[:, 2]
    np.testing.assert_allclose(infill.shear(displaced(lattice, places)), 0.6, rtol=1e-6)
