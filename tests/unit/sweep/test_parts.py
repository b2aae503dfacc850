"""What a film serves: nothing is solved that no measure asks for."""

from types import SimpleNamespace

import numpy as np
import pytest

from magicsim.errors import ConfigError, ConvergenceError
from magicsim.sweep import detection, parts, texture
from magicsim.sweep.designs import list_designs
from magicsim.sweep.measures import SweepQuality
from magicsim.sweep.texture import PatternPowers
from sweep.fakes import small_sweep


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of what is solved beside the film, as it is called."""
    called: list[str] = []

    def press(*_: object, **__: object) -> SimpleNamespace:
        called.append("press")
        return SimpleNamespace(seconds=0.5, unknowns=7)

    def spacing_error(*_: object, **__: object) -> float:
        called.append("spacing_error")
        return 0.01

    def film_design(_: object, __: object, quality: SweepQuality, **___: object) -> list[SimpleNamespace]:
        shown = [SimpleNamespace(gap_mm=-depth, force_n=depth, seconds=0.1) for depth in quality.depths_mm]
        seen = np.zeros((2, 2, 3), np.uint8)
        return [
            SimpleNamespace(
                untouched=shown[0],
                approach=(),
                press=shown,
                touches=shown,
                frames=lambda _, draws: [seen] * draws,
                references=lambda: [seen],
                camera=SimpleNamespace(gamma=1.0),
            )
        ]

    def sees_no_grid(_: object) -> None:
        msg = "no grid"
        raise ConfigError(msg)

    for replacement in (press, spacing_error, film_design):
        monkeypatch.setattr(parts, replacement.__name__, replacement)
    monkeypatch.setattr(detection, "fit_detector", sees_no_grid)
    return called


@pytest.mark.parametrize(
    ("measure", "expected"),
    [
        ("contact_auc", []), ("force_1mm_n", ["spacing_error"]), ("stiffness_n_per_mm", ["spacing_error"]),
        ("unknowns", ["press"]), ("frame_seconds", ["press"]),
    ],
)  # fmt: skip
def test_only_what_a_measure_needs_is_solved(solved: list[str], measure: str, expected: list[str]):
    sweep = small_sweep(f"measures=['{measure}']", f"objectives=[{{measure='{measure}',better='lower'}}]")
    found = parts.filmed(list_designs(sweep)[0].sensor, sweep, None)
    assert solved == expected
    assert measure in found.measures


@pytest.mark.usefixtures("solved")
def test_press_that_fails_on_the_own_lattice_costs_no_other_measure(monkeypatch: pytest.MonkeyPatch):
    def fails(*_: object, **__: object) -> None:
        raise ConvergenceError("no equilibrium")

    monkeypatch.setattr(parts, "press", fails)
    sweep = small_sweep("measures=['unknowns','force_1mm_n']", "objectives=[]")
    found = parts.filmed(list_designs(sweep)[0].sensor, sweep, None).measures
    assert (found["unknowns"].value, found["unknowns"].note) == (None, "no equilibrium")
    assert found["force_1mm_n"].value == 1.0


@pytest.mark.parametrize(
    ("measures", "expected"),
    [(["dot_spacing_mm"], ["dots"]), (["line_spacing_mm", "unknowns"], ["lines"]), (["shore_a"], [])],
)
def test_only_wanted_patterns_are_pressed(monkeypatch: pytest.MonkeyPatch, measures: list[str], expected: list[str]):
    pressed: list[str] = []
    monkeypatch.setattr(parts, "_pattern", lambda _, pattern, *__: pressed.append(pattern) or parts.Parts())
    sweep = small_sweep(f"measures={measures}", "objectives=[]")
    parts.textured(list_designs(sweep)[0].sensor, sweep, None)
    assert pressed == expected


def test_no_coarser_spacing_is_tried_than_needed_and_one_that_fails_counts_as_missed(monkeypatch: pytest.MonkeyPatch):
    tried: list[tuple[str | None, float]] = []

    def press_plate(_: object, pattern: str | None, spacing_mm: float, *__: object, **___: object) -> SimpleNamespace:
        tried.append((pattern, spacing_mm))
        if spacing_mm == 1.4:
            raise ConfigError("a plate is larger than the face")
        return SimpleNamespace(picture=np.zeros((2, 2, 3), np.uint8))

    def observe(_: object, __: object, ___: object, spacing_mm: float) -> PatternPowers:
        power = 1.0 if spacing_mm < 2 else 100.0
        return PatternPowers(pattern=power, around=np.ones(4), pattern_parts=1.0, clutter_parts=4.0)

    monkeypatch.setattr(texture, "press_plate", press_plate)
    monkeypatch.setattr(texture, "observe", observe)
    sweep = small_sweep("measures=['line_spacing_mm']", "objectives=[]", "quality.line_spacings_mm=[4.0,2.0,1.4,1.0]")
    found = parts.textured(list_designs(sweep)[0].sensor, sweep, None)
    assert tried == [("lines", 1.0), (None, 1.0), ("lines", 1.4), ("lines", 2.0), (None, 2.0)]
    assert 1.0 < found.measures["line_spacing_mm"].value < 2.0
    assert "at 1.4 mm: a plate is larger than the face" in found.measures["line_spacing_mm"].note
