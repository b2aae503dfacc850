"""What a film serves: nothing is solved that no measure asks for."""

from types import SimpleNamespace

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.sweep import detection, parts
from magicsim.sweep.designs import list_designs
from magicsim.sweep.measures import SweepQuality
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
