"""The comparison keeps what fails, needs no other solver, and its plot needs nothing but the JSON."""

import json
import sys
from functools import partial

import numpy as np
import pytest

from magicsim.bench import kinds as run
from magicsim.bench.deform.compare import compare
from magicsim.bench.deform.error_plot import plot_errors
from magicsim.bench.deform.lattice_method import graded, graded_quarter, solve_lattice
from magicsim.bench.deform.methods import VARIANTS, Variant, solve_optional
from magicsim.bench.deform.problem import Failure, Observation, sphere_on_block
from magicsim.bench.deform.reference import Reference, ReferenceDepth
from magicsim.bench.deform.rows import NOT_INSTALLED, SOLVED
from magicsim.bench.deform.surface import displacement_at
from magicsim.errors import ConfigError

SMALL = sphere_on_block("footprint_mm=[6.0, 6.0]", "core_mm=3.0").down_to(0.25, 0.5)


def flat_reference(problem=SMALL) -> Reference:
    points = problem.sample_points_mm
    return Reference(
        depths=tuple(
            ReferenceDepth(
                depth_mm=depth, force_n=1.0, force_error_n=0.01, contact_area_mm2=4.0, contact_area_error_mm2=0.1,
                surface_mm=np.tile([0.0, 0.0, 0.1], (len(points), 1)), surface_error_mm=0.001,
            )
            for depth in problem.depths_mm
        ),
        method="by hand", command="none",
    )  # fmt: skip


def fails_at_the_second_depth(problem, repeats):
    del repeats
    yield Observation(
        depth_mm=problem.depths_mm[0], force_n=1.1, contact_area_mm2=4.4, seconds=(0.1,), seconds_total=0.2,
        surface_mm=np.zeros_like(problem.sample_points_mm), unknowns=10, iterations=3,
    )  # fmt: skip
    yield Failure(depth_mm=problem.depths_mm[1], message="folded", seconds_total=0.7)


@pytest.fixture(scope="module")
def result():
    variants = [
        Variant(
            method="lattice", setting="1 mm", quick=True,
            solve=partial(solve_lattice, spacing_mm=1.0, tolerance_mm=0.01),
        ),
        Variant(method="fragile", setting="0.5 mm", solve=fails_at_the_second_depth, quick=True),
        Variant(
            method="absent", setting="1 mm", quick=True,
            solve=partial(solve_optional, module="no_such_package", solve="solve"),
        ),
        Variant(method="long", setting="0.1 mm", solve=fails_at_the_second_depth),
    ]  # fmt: skip
    return compare(quick=True, variants=variants, reference=flat_reference(), problem=SMALL)


def rows_of(result, method):
    return [row for row in result["results"] if row["method"] == method]


def test_a_quarter_by_symmetry_presses_as_the_whole_block_does():
    quarter, whole = (
        list(solve_lattice(SMALL, 1, spacing_mm=0.25, tolerance_mm=0.002, build=build))
        for build in (graded_quarter, graded)
    )
    for one, other in zip(quarter, whole, strict=True):
        assert one.force_n == pytest.approx(other.force_n, rel=0.005)
        assert one.contact_area_mm2 == pytest.approx(other.contact_area_mm2, rel=0.05)


def test_lattice_solves_every_depth(result):
    rows = rows_of(result, "lattice")
    assert [row["outcome"] for row in rows] == [SOLVED, SOLVED]
    assert rows[0]["force_n"] < rows[1]["force_n"]
    assert rows[1]["seconds_total"] > rows[1]["seconds"] > 0


def test_failed_depth_stays_in_the_results(result):
    assert [(row["outcome"], row["error"]) for row in rows_of(result, "fragile")] == [
        (SOLVED, pytest.approx(0.1)), ("folded", None),
    ]  # fmt: skip


def test_method_without_its_package_is_a_row_at_every_depth(result):
    assert [row["outcome"] for row in rows_of(result, "absent")] == [NOT_INSTALLED] * 2


def test_quick_leaves_out_what_is_not_quick(result):
    assert not rows_of(result, "long")


def test_plot_is_drawn_from_the_file_alone(result, tmp_path):
    file = tmp_path / "bench-deform.json"
    file.write_text(json.dumps(result))
    run.draw(file, tmp_path / "plot.svg")
    svg = (tmp_path / "plot.svg").read_text()
    assert 'id="lattice"' in svg
    assert 'id="failed fragile"' in svg
    assert "absent" not in svg


def test_plot_is_the_same_every_time(result, tmp_path):
    for name in ("a.png", "b.png"):
        plot_errors(result, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_lattice_variants_come_without_the_extra_or_its_libraries(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "felupe", None)
    (tmp_path / "ngsolve.py").write_text("raise ImportError('libgfortran.so.5: cannot open shared object file')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "ngsolve", raising=False)
    for name in ("felupe_method", "felupe_contact", "ngsolve_reference", "recompute"):
        monkeypatch.delitem(sys.modules, f"magicsim.bench.deform.{name}", raising=False)
    others = [one for one in VARIANTS if one.method.startswith(("felupe", "NGSolve"))]
    assert others
    for variant in others:
        outcomes = list(variant.solve(SMALL, 1))
        assert [outcome.message for outcome in outcomes] == [NOT_INSTALLED] * 2
    with pytest.raises(ConfigError, match=r"recompute needs NGSolve, .*: libgfortran.so.5: cannot open"):
        run.run_bench("deform", tmp_path / "out", recompute=True)


def test_every_variant_has_its_own_name():
    names = [(variant.method, variant.setting) for variant in VARIANTS]
    assert len(set(names)) == len(names)
    assert any(variant.quick for variant in VARIANTS)


@pytest.mark.parametrize("low", [-1.0, 0.0])
def test_displacement_of_the_face_is_exact_for_symmetric_cubics(low: float):
    """From nodes of the whole face, and of a quarter with its mirror images."""
    x, y = np.linspace(3 * low, 3, 9), np.linspace(4 * low, 4, 11)

    def field(x, y):
        return np.stack([x**3, x * x * y, 1 + y * y + 0 * x], -1)

    points = np.random.default_rng(0).uniform(0, 3, (20, 2))
    found = displacement_at(points, x, y, field(*np.meshgrid(x, y)))
    np.testing.assert_allclose(found, field(points[:, 0], points[:, 1]), atol=1e-10)


def test_sample_points_cover_one_quarter_of_the_face():
    problem = sphere_on_block()
    points = problem.sample_points_mm
    assert len(points) == 25 * 33
    np.testing.assert_allclose(points.max(0), [12, 16, 0])
    np.testing.assert_allclose(points[1] - points[0], [0.5, 0, 0])


def test_unknown_benchmark_is_an_error_that_lists_what_exists(tmp_path):
    with pytest.raises(ConfigError, match=f"available: {', '.join(sorted(run.BENCHMARKS))}"):
        run.run_bench("defrom", tmp_path)
