"""Speed at equal error counts neither lucky zeros nor failures."""

import pytest

from magicsim.bench.deform.equal_error import equal_errors
from magicsim.bench.deform.rows import SOLVED, BenchRow


def row(method: str, setting: str, depth_mm: float, error: float | None, seconds: float | None) -> BenchRow:
    return BenchRow(
        method=method, setting=setting, depth_mm=depth_mm, error=error, error_signed=error,
        error_displacement_mm=None, error_displacement=None, error_area=None, force_n=None, contact_area_mm2=None,
        seconds=seconds, runs=1, seconds_total=1.0, unknowns=None, iterations=None,
        outcome=SOLVED if error is not None else "did not converge",
    )  # fmt: skip


LATTICE, FELUPE = "graded lattice, tolerance 0.002 mm", "felupe, graded whole block"
ROWS = [
    row(LATTICE, "coarse", 0.5, 0.030, 0.1), row(LATTICE, "coarse", 1.0, 0.0001, 0.2),
    row(LATTICE, "fine", 0.5, 0.004, 1.0), row(LATTICE, "fine", 1.0, 0.003, 2.0),
    row(FELUPE, "coarse", 0.5, 0.040, 0.5), row(FELUPE, "coarse", 1.0, 0.020, 1.0),
    row(FELUPE, "fine", 0.5, 0.005, 20.0), row(FELUPE, "fine", 1.0, 0.004, 40.0),
    row(FELUPE, "finest", 0.5, 0.001, 90.0), row(FELUPE, "finest", 1.0, None, None),
]  # fmt: skip


def test_the_fastest_lattice_that_is_as_accurate_is_compared() -> None:
    found = {(one.other, one.depth_mm): one for one in equal_errors(ROWS)}
    assert found[f"{FELUPE}, coarse", 0.5].ratio == pytest.approx(5)
    assert found[f"{FELUPE}, fine", 1.0].setting == f"{LATTICE}, fine"
    assert found[f"{FELUPE}, fine", 1.0].ratio == pytest.approx(20)


def test_an_error_that_vanishes_by_chance_is_none_of_its_accuracy() -> None:
    found = {(one.other, one.depth_mm): one for one in equal_errors(ROWS)}
    assert found[f"{FELUPE}, coarse", 1.0].other_error == pytest.approx(0.04)
    assert found[f"{FELUPE}, fine", 1.0].seconds == pytest.approx(2.0)


def test_where_no_lattice_is_as_accurate_there_is_no_ratio() -> None:
    found = {(one.other, one.depth_mm): one for one in equal_errors(ROWS)}
    assert found[f"{FELUPE}, finest", 0.5].ratio is None
    assert (f"{FELUPE}, finest", 1.0) not in found


def test_quarters_are_compared_with_quarters_and_whole_blocks_with_whole_ones() -> None:
    quarter = [
        row("graded lattice, quarter, tolerance 0.002 mm", "coarse", 0.5, 0.030, 0.02),
        row("felupe, graded quarter", "coarse", 0.5, 0.040, 0.1),
    ]
    found = {one.other: one for one in equal_errors([*ROWS, *quarter]) if one.depth_mm == 0.5}
    assert found["felupe, graded quarter, coarse"].ratio == pytest.approx(5)
    assert found[f"{FELUPE}, coarse"].setting == f"{LATTICE}, coarse"
