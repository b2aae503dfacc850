"""Cost against work: the fit, failures, and one tiny size for real."""

import json

import pytest

from magicsim.bench import cost, run
from magicsim.bench.cost import fitted_power


def test_power_law_is_found_again():
    rows = [{"unknowns": unknowns, "seconds": 3e-6 * unknowns**1.4} for unknowns in (1e3, 1e4, 1e5)]
    fit = fitted_power(rows, "seconds")
    assert fit["exponent"] == pytest.approx(1.4)
    assert fit["factor"] == pytest.approx(3e-6)


def test_sizes_that_failed_are_left_out_of_the_fit():
    rows = [{"unknowns": 10, "seconds": 1.0}, {"unknowns": 1000, "seconds": None}]
    assert fitted_power(rows, "seconds") is None


def test_process_that_dies_is_a_row(monkeypatch, tmp_path):
    monkeypatch.setattr(cost.sys, "executable", "false")
    data = cost.run_cost(spacings_mm=[2.0])
    assert data["results"][0]["outcome"].startswith("ended with 1")
    file = tmp_path / "bench-cost.json"
    file.write_text(json.dumps(data))
    run.draw(file, tmp_path / "cost.png")


@pytest.mark.slow
def test_one_size_is_measured_in_its_own_process():
    row = cost.run_cost(spacings_mm=[2.0])["results"][0]
    assert row["outcome"] == "solved"
    assert row["unknowns"] == 3 * 13 * 17 * 3
    assert row["memory_mb"] > 50
