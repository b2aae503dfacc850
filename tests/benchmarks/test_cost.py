"""Cost against work: the fit, failures, and one tiny size for real."""

import json
import sys

import pytest
from laboratory.cost import fitted_power, plot_cost, run_cost


def test_power_law_is_found_again():
    rows = [{"unknowns": unknowns, "seconds": 3e-6 * unknowns**1.4} for unknowns in (1e3, 1e4, 1e5)]
    fit = fitted_power(rows, "seconds")
    assert fit["exponent"] == pytest.approx(1.4)
    assert fit["factor"] == pytest.approx(3e-6)


def test_power_law_above_an_offset_is_found_again():
    sizes = (5e3, 2e4, 1e5, 4e5)
    rows = [{"unknowns": unknowns, "memory_mb": 250 + 2e-4 * unknowns**1.3} for unknowns in sizes]
    fit = fitted_power(rows, "memory_mb", offset=True)
    assert fit["offset"] == pytest.approx(250, rel=1e-3)
    assert fit["exponent"] == pytest.approx(1.3, rel=1e-3)
    assert fitted_power(rows[:2], "memory_mb", offset=True) is None


def test_sizes_that_failed_are_left_out_of_the_fit():
    rows = [{"unknowns": 10, "seconds": 1.0}, {"unknowns": 1000, "seconds": None}]
    assert fitted_power(rows, "seconds") is None


def test_process_that_dies_is_a_row(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", "false")
    data = run_cost(spacings_mm=[2.0])
    assert data["results"][0]["outcome"].startswith("ended with 1")
    plot_cost(json.loads(json.dumps(data)), tmp_path / "cost.png")


def test_one_size_is_measured_in_its_own_process():
    row = run_cost(spacings_mm=[2.0])["results"][0]
    assert row["outcome"] == "solved"
    assert row["unknowns"] == 3 * 13 * 17 * 3
    assert row["memory_mb"] > 50
