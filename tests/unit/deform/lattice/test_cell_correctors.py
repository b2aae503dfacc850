"""Fluctuation of a cell: its symmetries, and points that follow lattice and cell."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from magicsim.deform.lattice.cell_problem import cell_fields
from magicsim.deform.lattice.follow import STRAINS, cell_correctors, fluctuation, rotation_and_strain
from magicsim.deform.lattice.structure import build_lattice
from magicsim.geometry.design import BodyMaterial, ElastomerDesign, InfillMaterial, LatticeOptions, Materials
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.flaws import Unevenness
from magicsim.geometry.grid import resolve_grid

FIELDS = cell_fields(body=(0.369, 18.3), infill=(0.017, 1000.0), infill_share=0.512, subcells=5)
POINTS = np.random.default_rng(0).uniform(0, 1, (200, 3))


def design(spacing_mm: float | None = None, *, soft_mpa: float = 0.017, bulk_mpa: float = 1000.0) -> ElastomerDesign:
    return ElastomerDesign(
        schema_version=1,
        footprint_mm=(4.7, 5.5),
        skin_mm=0.8,
        core_mm=3.1,
        cell_mm=0.8,
        wall_mm=0.2,
        materials=Materials(
            body=BodyMaterial(youngs_modulus_mpa=1.1, poisson_ratio=0.49, ior=1.49),
            infill=InfillMaterial(shear_modulus_mpa=soft_mpa, bulk_modulus_mpa=bulk_mpa, ior=1.46),
        ),
        lattice=LatticeOptions(spacing_mm=spacing_mm),
    )


def hung(spacing_mm: float | None = None, **moduli: float):
    block = design(spacing_mm, **moduli)
    elastomer, lattice = build_elastomer(block), build_lattice(block)
    assert elastomer.infill is not None
    correctors = cell_correctors(block, elastomer.grid, lattice, elastomer.infill.vertices)
    assert correctors is not None
    return lattice, correctors


def test_fluctuation_vanishes_at_the_crossings_and_in_the_middle() -> None:
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), -1).reshape(-1, 3)
    assert np.abs(fluctuation(FIELDS, np.vstack([corners, [[0.5] * 3]]).astype(float))).max() < 1e-14


@pytest.mark.parametrize("axis", range(3))
def test_fluctuation_is_periodic_and_continuous(axis: int) -> None:
    left, right = POINTS.copy(), POINTS.copy()
    left[:, axis], right[:, axis] = 0, 1
    np.testing.assert_allclose(fluctuation(FIELDS, left), fluctuation(FIELDS, right), atol=1e-13)
    left[:, axis], right[:, axis] = 0.5 - 1e-9, 0.5 + 1e-9
    np.testing.assert_allclose(fluctuation(FIELDS, left), fluctuation(FIELDS, right), atol=1e-7)


@pytest.mark.parametrize("order", [(1, 0, 2), (1, 2, 0), (2, 1, 0)])
def test_permuting_the_axes_permutes_the_fluctuation(order: tuple[int, ...]) -> None:
    turned = fluctuation(FIELDS, POINTS[:, order])  # point whose axis a is the old axis order[a]
    straight = fluctuation(FIELDS, POINTS)
    for case, (first, second) in enumerate(STRAINS):
        old = tuple(sorted((order[first], order[second])))
        np.testing.assert_allclose(turned[:, :, case], straight[:, order, STRAINS.index(old)], atol=1e-13)


def test_walls_strain_less_than_the_infill_in_shear() -> None:
    """Under 2 xz the walls across z move with the mean strain along their crossings; the infill shears more."""
    above, below = (fluctuation(FIELDS, np.array([[0.5, 0.5, z]]))[0, 0, 4] for z in (0.9, 0.1))
    assert above - below > 0.05


def test_one_material_does_not_fluctuate() -> None:
    fields = cell_fields(body=(0.4, 3.0), infill=(0.4, 3.0), infill_share=0.3, subcells=4)
    assert np.abs(fluctuation(fields, POINTS)).max() < 1e-12


@pytest.mark.parametrize("spacing_mm", [None, 0.5])
def test_mean_gradient_is_exact_for_affine_motion(spacing_mm: float | None) -> None:
    lattice, correctors = hung(spacing_mm)
    gradient = 0.2 * np.random.default_rng(1).normal(size=(3, 3))
    found = correctors.deformation_gradient(lattice.nodes_mm @ gradient.T + 0.3)
    np.testing.assert_allclose(found, np.broadcast_to(np.eye(3) + gradient, found.shape), atol=1e-12)


def test_rigid_motion_is_followed_exactly_and_strain_turns_with_it() -> None:
    lattice, correctors = hung()
    turn = Rotation.from_rotvec([0.4, -0.8, 0.3]).as_matrix()
    rigid = correctors.displaced(lattice.nodes_mm @ turn.T - lattice.nodes_mm + 0.5)
    np.testing.assert_allclose(rigid, correctors.points_mm @ turn.T + 0.5, atol=1e-12)
    stretch = np.array([[1.1, 0.1, 0.0], [0.1, 0.9, -0.2], [0.0, -0.2, 1.05]])
    straight, turned = (correctors.displaced(lattice.nodes_mm @ (f - np.eye(3)).T) for f in (stretch, turn @ stretch))
    np.testing.assert_allclose(turned, straight @ turn.T, atol=1e-12)


def test_rotation_and_logarithm_rebuild_the_gradient() -> None:
    gradient = np.eye(3) + 0.2 * np.random.default_rng(2).normal(size=(50, 3, 3))
    rotation, strain = rotation_and_strain(gradient)
    np.testing.assert_allclose(np.trace(strain, axis1=1, axis2=2), np.log(np.linalg.det(gradient)), atol=1e-12)
    values, vectors = np.linalg.eigh(strain)
    stretch = (vectors * np.exp(values)[:, None]) @ vectors.transpose(0, 2, 1)
    np.testing.assert_allclose(rotation @ stretch, gradient, atol=1e-12)


def test_equal_materials_leave_the_trilinear_map() -> None:
    body = design().materials.body
    lattice, correctors = hung(soft_mpa=body.shear_modulus_mpa, bulk_mpa=body.bulk_modulus_mpa)
    displacements = 0.1 * np.random.default_rng(3).normal(size=lattice.nodes_mm.shape)
    found = correctors.displaced(displacements)
    np.testing.assert_allclose(found, correctors.follow.displaced(displacements), atol=1e-10)


def test_interface_lies_on_the_interface_of_unequal_pitches() -> None:
    """Pitches differ from the cube; a corner of the printed infill must still read the corner of the cube."""
    block = design()
    grid = resolve_grid(block)
    assert grid is not None
    assert np.ptp(grid.pitch_mm) > 0.01
    _, correctors = hung()
    body, infill = block.materials.body, block.materials.infill
    assert infill is not None
    fields = cell_fields(
        body=(body.shear_modulus_mpa, body.bulk_modulus_mpa),
        infill=(infill.shear_modulus_mpa, infill.bulk_modulus_mpa),
        infill_share=float(np.prod(grid.cell_mm / grid.pitch_mm)),
    )
    local = correctors.points_mm[: len(correctors.fluctuation_mm)] - grid.centres_mm()[0]
    at_corner = np.isclose(np.abs(local), grid.cell_mm / 2).all(1)
    assert at_corner.sum() == 8
    corner = 0.5 + np.sign(local[at_corner]) * (0.5 - fields.half_wall)
    expected = fluctuation(fields, corner) * grid.pitch_mm[:, None]
    np.testing.assert_allclose(correctors.fluctuation_mm[at_corner].reshape(-1, 3, 6), expected, atol=1e-12)


def test_cells_of_a_shifted_print_bulge_as_those_of_the_drawing() -> None:
    """The cell at the corner, which stands for all of an even print, lies 0.08 mm beside its drawn place here."""
    _, drawn = hung()
    block = design().model_copy(
        update={"unevenness": Unevenness(pitch_scale=(1.05, 1.05, 1.0), pitch_drift=(0.0, 0.1, 0.0), skin_sd_mm=0.05)}
    )
    elastomer, lattice = build_elastomer(block), build_lattice(block)
    assert elastomer.infill is not None
    hanging = block, elastomer.grid, lattice, elastomer.infill.vertices
    by_first, shifted = cell_correctors(*hanging), cell_correctors(*hanging, elastomer.drawn_cell_mm)
    assert shifted is not None
    np.testing.assert_allclose(shifted.fluctuation_mm, drawn.fluctuation_mm, atol=1e-12)
    assert by_first is not None
    assert np.abs(by_first.fluctuation_mm - drawn.fluctuation_mm).max() > 0.3 * np.abs(drawn.fluctuation_mm).max()


def test_block_without_grid_has_no_correctors() -> None:
    block = design()
    assert cell_correctors(block, None, build_lattice(block), np.zeros((0, 3))) is None
