"""A known error gives the known row, and a failure stays a row."""

import numpy as np
import pytest

from magicsim.bench.deform.problem import Failure, Observation
from magicsim.bench.deform.reference import Reference, ReferenceDepth, load_reference, save_reference
from magicsim.bench.deform.rows import SOLVED, score
from magicsim.errors import PresetError

SURFACE = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [3.0, 4.0, 0.0], [0.0, 0.0, 0.0]])
REFERENCE = Reference(
    depths=(
        ReferenceDepth(
            depth_mm=1.0, force_n=5.0, force_error_n=0.01, contact_area_mm2=10.0, contact_area_error_mm2=0.1,
            surface_mm=SURFACE, surface_error_mm=0.001,
        ),
    ),
    method="by hand",
    command="none",
)  # fmt: skip


def observation(**changes: object) -> Observation:
    values = {
        "depth_mm": 1.0, "force_n": 4.5, "contact_area_mm2": 12.0, "surface_mm": np.add(SURFACE, (0.0, 0.6, 0.8)),
        "seconds": (3.0, 1.0, 2.0), "seconds_total": 9.0, "unknowns": 30, "iterations": 7,
    }  # fmt: skip
    return Observation(**(values | changes))


def test_known_differences_give_the_known_errors():
    row = score("method", "1 mm", observation(), REFERENCE)
    assert row.outcome == SOLVED
    assert row.error == pytest.approx(0.1)
    assert row.error_signed == pytest.approx(-0.1)
    assert row.error_area == pytest.approx(0.2)
    assert row.error_displacement_mm == pytest.approx(1.0)
    assert row.error_displacement == pytest.approx(1 / np.sqrt((1 + 1 + 25) / 4))


def test_time_is_the_median_and_says_of_how_many_runs():
    row = score("method", "1 mm", observation(), REFERENCE)
    assert (row.seconds, row.runs, row.seconds_total) == (2.0, 3, 9.0)


def test_failure_stays_a_row_with_its_message():
    failure = Failure(depth_mm=1.0, message="did not converge: J = -0.3", seconds_total=4.0)
    row = score("method", "1 mm", failure, REFERENCE)
    assert (row.outcome, row.seconds_total, row.error, row.seconds) == ("did not converge: J = -0.3", 4.0, None, None)


def test_depth_that_the_reference_lacks_is_named():
    with pytest.raises(PresetError, match=r"no depth of 2 mm; available: 1$"):
        score("method", "1 mm", observation(depth_mm=2.0), REFERENCE)


def test_reference_survives_its_file(tmp_path):
    save_reference(REFERENCE, tmp_path / "reference.json")
    found = load_reference(tmp_path / "reference.json")
    assert found.at(1.0).force_n == 5.0
    np.testing.assert_allclose(found.at(1.0).surface_mm, SURFACE)


def test_missing_reference_says_how_to_make_one(tmp_path):
    with pytest.raises(PresetError, match="--recompute"):
        load_reference(tmp_path / "none.json")
