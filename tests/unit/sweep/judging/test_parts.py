"""What a film serves: nothing is solved that no measure asks for."""

import pytest

from magicsim.errors import ConfigError
from magicsim.sweep.designs import list_designs
from magicsim.sweep.judging import parts
from sweep.fakes import small_sweep


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the parts that solve something of their own, as they are called."""
    called: list[str] = []

    def part(name: str):
        def call(*_: object) -> parts.Parts:
            called.append(name)
            return parts.Parts()

        return call

    def sees_no_grid(_: object) -> None:
        msg = "no grid"
        raise ConfigError(msg)

    monkeypatch.setattr(parts, "film_design", lambda *_, **__: [object()])
    monkeypatch.setattr(parts, "_pictures", lambda _: {})
    monkeypatch.setattr(parts, "fit_detector", sees_no_grid)
    for name in ("_pressed", "_cost"):
        monkeypatch.setattr(parts, name, part(name))
    return called


@pytest.mark.parametrize(
    ("measure", "expected"),
    [
        ("contact_auc", []), ("force_1mm_n", ["_pressed"]), ("stiffness_n_per_mm", ["_pressed"]),
        ("unknowns", ["_cost"]), ("frame_seconds", ["_cost"]),
    ],
)  # fmt: skip
def test_only_what_a_measure_needs_is_solved(solved: list[str], measure: str, expected: list[str]):
    sweep = small_sweep(f"measures=['{measure}']", f"objectives=[{{measure='{measure}',better='lower'}}]")
    parts.filmed(list_designs(sweep)[0].sensor, sweep, None)
    assert solved == expected


@pytest.mark.parametrize(
    ("measures", "expected"),
    [({"dot_spacing_mm"}, ["dots"]), ({"line_spacing_mm", "unknowns"}, ["lines"]), (set(), [])],
)
def test_only_wanted_patterns_are_pressed(measures: set[str], expected: list[str]):
    assert parts.wanted_patterns(frozenset(measures)) == expected
