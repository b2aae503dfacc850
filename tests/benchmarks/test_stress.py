"""The stress grid drops nothing, and its verification does not take the solver's word."""

import json
import math
import signal
import time
from dataclasses import asdict, replace

import numpy as np
import pytest
from laboratory.stress import benchmark
from laboratory.stress import grid as stress
from laboratory.stress.benchmark import plot_stress
from laboratory.stress.cases import (
    CONTRASTS,
    DEPTH_SHARES,
    OBJECTS,
    POISSON_RATIOS,
    RELAXING,
    Stage,
    StressPath,
    block,
    every_path,
    grid_paths,
    layered,
    single_paths,
)
from laboratory.stress.grid import OutOfProcessorTimeError, processor_limit, verify, volume_ratios

from magicsim.deform.lattice.structure import box_lattice, build_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

BALL = "sphere:radius_mm=2"


def small_lattice():
    across = np.linspace(-3, 3, 7)
    return box_lattice((across, across, np.linspace(0, 3, 4)), shear_modulus_mpa=0.4, lame_mpa=4.0)


def path(**changes):
    """3 mm high, with the small lattice whatever the design says."""
    values = {
        "group": "single", "label": "small", "object_text": BALL, "design": block("skin_mm=0.5", "core_mm=2.0"),
        "change": lambda _: small_lattice(), "stages": (Stage(depth_share=0.1), Stage(depth_share=0.3)),
    }  # fmt: skip
    return StressPath(**(values | changes))


@pytest.fixture(scope="module")
def solved():
    lattice = small_lattice()
    indenter = place_object(parse_object(BALL), gap_mm=-0.5)
    return lattice, ContactSolver(lattice).solve(indenter), indenter


def test_grid_holds_every_combination():
    cases = {
        (one.label, one.contrast, one.poisson_ratio, stage.depth_share) for one in grid_paths() for stage in one.stages
    }
    assert len(cases) == len(OBJECTS) * len(CONTRASTS) * len(POISSON_RATIOS) * len(DEPTH_SHARES) == 384


def test_single_cases_have_names_of_their_own():
    labels = [one.label for one in single_paths()]
    assert len(set(labels)) == len(labels)


def test_every_single_case_can_be_built():
    heights = {one.label: one.lattice().height_mm for one in single_paths()}
    assert heights["height 1.5 mm"] == pytest.approx(1.5)
    assert heights["height 20 mm"] == pytest.approx(20)


def test_contrast_is_between_skin_and_core():
    lattice = layered(build_lattice(block()), contrast=100.0, poisson_ratio=0.25)
    assert lattice.is_core.sum() == 10 * 10 * 4
    skin, core = (lattice.shear_modulus_mpa[mask] for mask in (~lattice.is_core, lattice.is_core))
    np.testing.assert_allclose(skin / core[0], 100)
    np.testing.assert_allclose(lattice.lame_mpa, lattice.shear_modulus_mpa)


def test_valid_state_passes(solved):
    assert verify(*solved).faults(0.002) == ()


@pytest.mark.parametrize("fault", ["min J", "penetration", "force balance", "interior residual", "normal share"])
def test_each_fault_is_found_without_asking_the_solver(solved, fault):
    lattice, state, indenter = solved
    moved = state.displacements_mm.copy()
    centre = np.abs(lattice.nodes_mm - [0, 0, 1]).sum(1).argmin()
    if fault == "min J":
        moved[centre, 2] += 2.5
    elif fault == "penetration":
        indenter = place_object(parse_object(BALL), gap_mm=-0.51)
    elif fault == "interior residual":
        moved[centre, 0] += 0.01
    wrong = replace(state, displacements_mm=moved)
    if fault == "force balance":
        wrong = replace(state, force_n=1.01 * state.force_n)
    elif fault == "normal share":
        wrong = replace(state, contact_pressure_mpa=0 * state.contact_pressure_mpa)
    assert any(words.startswith(fault) for words in verify(lattice, wrong, indenter).faults(0.002))


def test_volume_ratios_of_distorted_cells_are_the_determinant_of_an_affine_map():
    lattice = small_lattice()
    rng = np.random.default_rng(0)
    rest = (lattice.nodes_mm + 0.1 * rng.normal(size=lattice.nodes_mm.shape))[lattice.cells]
    gradient = np.eye(3) + 0.3 * rng.normal(size=(3, 3))
    np.testing.assert_allclose(volume_ratios(rest, rest @ gradient.T), np.linalg.det(gradient), rtol=1e-10)


def test_declared_failure_is_recorded_and_the_path_goes_on(monkeypatch):
    solve = ContactSolver.solve

    def refuses_the_first(self, indenter, previous=None):
        if indenter.top_mm() < 0.5:
            msg = "no equilibrium"
            raise ConvergenceError(msg)
        return solve(self, indenter, previous)

    monkeypatch.setattr(ContactSolver, "solve", refuses_the_first)
    rows = list(stress.run_path(path()))
    assert [row.outcome for row in rows] == [stress.DECLARED, stress.VALID]
    assert rows[0].message == "no equilibrium"


def test_state_that_is_not_valid_is_called_silent(monkeypatch):
    solve = ContactSolver.solve

    def lies(self, indenter, previous=None):
        state = solve(self, indenter, previous)
        return replace(state, force_n=1.01 * state.force_n)

    monkeypatch.setattr(ContactSolver, "solve", lies)
    rows = list(stress.run_path(path()))
    assert [row.outcome for row in rows] == [stress.SILENT, stress.SILENT]
    assert benchmark.summarise(rows)["valid_share"] == 0


def test_a_relaxing_body_is_verified_with_what_it_remembers():
    """The forces of a body that relaxes are not those of its long-term lattice: these alone would be out of balance."""
    design = block("skin_mm=0.5", "core_mm=2.0", *RELAXING)
    change = {"change": lambda lattice: lattice, "friction": 1.0, "stage_s": 0.5, "design": design}
    stages = (Stage(depth_share=0.1), Stage(depth_share=0.1, shear_mm=0.2, twist_deg=10.0))
    rows = list(stress.run_path(path(object_text="sphere:radius_mm=4", stages=stages, **change)))
    assert [row.outcome for row in rows] == [stress.VALID] * 2
    soft = path(object_text="sphere:radius_mm=4", stages=stages, **(change | {"stage_s": math.inf}))
    assert rows[0].force_n > 1.2 * next(stress.run_path(soft)).force_n


def test_a_steep_cone_that_holds_itself_by_friction_is_valid_though_it_is_pulled():
    """On a body that relaxes slowly a cone of 60 degrees is drawn back by the friction of its flanks."""
    (way,) = (one for one in every_path() if one.label == "0.01 s a stage, friction 1, cone 30 deg")
    rows = list(stress.run_path(way))
    assert rows[-2].force_n < 0
    assert {row.outcome for row in rows} == {stress.VALID}


def test_crash_is_an_outcome_too(monkeypatch):
    def crashes(self, indenter, previous=None):
        raise ZeroDivisionError

    monkeypatch.setattr(ContactSolver, "solve", crashes)
    assert [row.outcome for row in stress.run_path(path())] == [stress.CRASHED] * 2


def test_unknown_object_is_not_available():
    rows = list(stress.run_path(path(object_text="teapot:radius_mm=2")))
    assert [row.outcome for row in rows] == [stress.NOT_AVAILABLE] * 2


def test_summary_counts_and_plot_comes_from_the_file_alone(tmp_path):
    data = benchmark.run_stress(paths=[path(), path(group="grid", contrast=1.0, poisson_ratio=0.25)])
    assert data["summary"]["cases"] == len(data["results"]) == 4
    assert data["summary"]["valid_share"] == 1
    plot_stress(json.loads(json.dumps(data)), tmp_path / "stress.png")
    assert (tmp_path / "stress.png").stat().st_size > 1000


def test_every_path_has_a_key_of_its_own():
    assert len({one.key for one in every_path()}) == len(every_path())


def test_finished_paths_are_read_and_the_rest_is_solved(tmp_path, monkeypatch):
    chosen = [one for one in every_path() if one.label == "height 1.5 mm"]
    done = [stress.unsolved(chosen[0], stage, stress.DECLARED, "from a run before") for stage in chosen[0].stages]
    file = tmp_path / f"{[one.key for one in every_path()].index(chosen[0].key):03d}.jsonl"
    file.write_text("".join(json.dumps(asdict(row)) + "\n" for row in done))
    assert benchmark.pooled_rows(chosen, tmp_path) == done


def test_path_that_takes_too_long_is_timed_out_in_every_stage(tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "LIMIT_S", 0.01)
    monkeypatch.setattr(benchmark, "STUCK", 10_000)
    chosen = [one for one in every_path() if one.label == "height 1.5 mm"]
    rows = benchmark.pooled_rows(chosen, tmp_path)
    assert [row.outcome for row in rows] == [stress.TIMED_OUT] * len(chosen[0].stages)
    assert {row.message for row in rows} == {"took longer than 0.01 s of processor time"}
    assert benchmark.summarise(rows)["valid_share"] == 0


def test_what_computes_is_ended_within_its_processor_time():
    begun = time.process_time()
    with pytest.raises(OutOfProcessorTimeError, match=r"0\.05 s of processor time"), processor_limit(0.05):
        _compute(5.0)
    assert 0.04 <= time.process_time() - begun < 5.0


def test_waiting_takes_no_processor_time():
    with processor_limit(0.2):
        time.sleep(0.4)


def test_the_limit_ends_with_its_block_and_the_former_handler_is_back():
    before = signal.getsignal(signal.SIGPROF)
    with processor_limit(0.05):
        pass
    assert signal.getsignal(signal.SIGPROF) is before
    _compute(0.1)


def _compute(seconds):
    until = time.process_time() + seconds
    while time.process_time() < until:
        pass
