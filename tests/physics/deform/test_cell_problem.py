"""Effective stiffness of a core cell: exact limits, bounds and convergence."""

import pytest

from magicsim.deform.cell_problem import effective_stiffness

BODY, INFILL, SHARE = (0.369, 18.3), (0.017, 1000.0), 0.512


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_one_material_gives_itself_back(share: float) -> None:
    cell = effective_stiffness(body=BODY, infill=BODY, infill_share=share, subcells=5)
    assert cell.shear_modulus_mpa == pytest.approx(BODY[0], rel=1e-8)
    assert cell.bulk_modulus_mpa == pytest.approx(BODY[1], rel=1e-8)
    assert cell.anisotropy == pytest.approx(1, rel=1e-8)


def test_moduli_lie_between_reuss_and_hashin_shtrikman_bounds() -> None:
    cell = effective_stiffness(body=BODY, infill=INFILL, infill_share=SHARE, subcells=8)
    soft_shear = 1 / ((1 - SHARE) / BODY[0] + SHARE / INFILL[0])
    soft_bulk = 1 / ((1 - SHARE) / BODY[1] + SHARE / INFILL[1])
    stiff_bulk = (1 - SHARE) * BODY[1] + SHARE * INFILL[1]
    stiff_shear = (1 - SHARE) * BODY[0] + SHARE * INFILL[0]
    assert soft_bulk < cell.bulk_modulus_mpa < stiff_bulk
    for modulus in (cell.c44_mpa, cell.tetragonal_modulus_mpa, cell.shear_modulus_mpa):
        assert soft_shear < modulus < stiff_shear


def test_matches_hashin_shtrikman_upper_bound_within_reach() -> None:
    """A closed-cell foam of stiff walls lies below the upper bound of an isotropic mixture, and not far."""
    cell = effective_stiffness(body=(1.0, 3.0), infill=(0.5, 1.5), infill_share=0.3, subcells=8)
    bulk = 3.0 + 0.3 / (1 / (1.5 - 3.0) + 0.7 * 3 / (3 * 3.0 + 4 * 1.0))
    assert cell.bulk_modulus_mpa <= bulk * (1 + 1e-3)
    assert cell.bulk_modulus_mpa == pytest.approx(bulk, rel=0.02)


def test_walls_are_stiffer_along_than_in_shear() -> None:
    cell = effective_stiffness(body=BODY, infill=INFILL, infill_share=SHARE, subcells=8)
    assert 0.5 < cell.anisotropy < 0.8


def test_refinement_changes_little() -> None:
    coarse, fine = (effective_stiffness(body=BODY, infill=INFILL, infill_share=SHARE, subcells=n) for n in (6, 10))
    assert coarse.shear_modulus_mpa == pytest.approx(fine.shear_modulus_mpa, rel=0.01)
    assert coarse.bulk_modulus_mpa == pytest.approx(fine.bulk_modulus_mpa, rel=0.02)
