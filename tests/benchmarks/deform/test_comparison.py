"""The comparison keeps what fails, needs no other solver, and its plot needs nothing but the JSON."""

import json
import sys
from functools import partial

import numpy as np
import pytest
from laboratory.deform.comparison import BenchRow, compare, equal_errors, score
from laboratory.deform.methods import VARIANTS, Variant, graded, graded_quarter, solve_lattice, solve_optional
from laboratory.deform.plot import plot_errors
from laboratory.deform.problem import (
    NOT_INSTALLED,
    SOLVED,
    Failure,
    Observation,
    displacement_at,
    sphere_on_block,
)
from laboratory.deform.reference import Reference, ReferenceDepth, load_reference, recompute_reference, save_reference

from magicsim.errors import ConfigError, PresetError

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


@pytest.mark.slow
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
    plot_errors(json.loads(json.dumps(result)), tmp_path / "plot.svg")
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
    for name in ("felupe_method", "ngsolve_reference"):
        monkeypatch.delitem(sys.modules, f"laboratory.deform.{name}", raising=False)
    others = [one for one in VARIANTS if one.method.startswith(("felupe", "NGSolve"))]
    assert others
    for variant in others:
        outcomes = list(variant.solve(SMALL, 1))
        assert [outcome.message for outcome in outcomes] == [NOT_INSTALLED] * 2
    with pytest.raises(ConfigError, match=r"recompute needs NGSolve, .*: libgfortran.so.5: cannot open"):
        recompute_reference(tmp_path / "reference.json")


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
