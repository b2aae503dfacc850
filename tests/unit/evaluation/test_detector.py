from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.evaluation.answers import check_detection, detection_of, fitted
from magicsim.evaluation.detector import Detection, built_in, find_detector
from magicsim.evaluation.evaluate import Evaluation
from magicsim.judge.measures import measure
from magicsim.judge.tally import tally

EXAMPLE = Path(__file__).resolve().parents[3] / "detectors" / "example_detector.py"
GOOD = Detection(proximity="Normal", contact="Untouched", approach=0.0, touch=0.0)


def test_plug_in_is_found_in_a_module_a_file_and_an_entry_point(monkeypatch: pytest.MonkeyPatch):
    by_file = find_detector(f"{EXAMPLE}:ChangedPixels")()
    assert type(by_file).__name__ == "ChangedPixels"
    stand_in = f"{__name__}:Blind"
    assert isinstance(find_detector(stand_in)(), Blind)
    point = EntryPoint(name="blind", value=stand_in, group="magicsim.detectors")
    monkeypatch.setattr("magicsim.evaluation.detector.entry_points", lambda group: [point] * (group == point.group))
    assert isinstance(find_detector("blind")(), Blind)
    with pytest.raises(ConfigError, match=r"unknown detector 'blond' \(did you mean 'blind'\?\)"):
        find_detector("blond")


def test_file_of_a_plug_in_may_define_its_answer_as_a_dataclass(tmp_path: Path):
    (tmp_path / "mine.py").write_text(
        "from __future__ import annotations\nfrom dataclasses import dataclass\n@dataclass\nclass Said:\n"
        "  proximity: str = 'Normal'\n  contact: str = 'Untouched'\n  approach: float = 0.0\n  touch: float = 0.0\n"
        "class X:\n  def fit(self, _): pass\n  def step(self, _): return Said()\n"
    )
    frame = np.zeros((8, 8, 3), np.uint8)
    assert detection_of(find_detector(f"{tmp_path / 'mine.py'}:X")(), frame, who="mine") == GOOD


class Blind:
    """Never sees anything."""

    def fit(self, references: object) -> None:
        del references

    def step(self, frame: object) -> Detection:
        del frame
        return GOOD


class Deaf:
    """Has no `step`."""

    def fit(self, references: object) -> None:
        del references


class Needy(Blind):
    """Wants an argument."""

    def __init__(self, threshold: float) -> None:
        self.threshold = threshold


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("no_such_module:Thing", "cannot be imported"),
        ("missing.py:Thing", "does not exist"),
        (f"{__name__}:Blnd", "did you mean 'Blind'"),
        (f"{__name__}:Deaf", "has no methods fit and step"),
        (f"{__name__}:Needy", "cannot be made without arguments"),
    ],
)
def test_what_is_no_detector_is_refused(name: str, words: str):
    with pytest.raises(ConfigError, match=words):
        find_detector(name)()


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("1/0", "cannot be loaded: ZeroDivisionError: division by zero"),
        ("raise SystemExit(7)", "cannot be loaded: SystemExit: 7"),
        ("import sys\nsys.exit()", "cannot be loaded: SystemExit \\(mine.py, line 2\\)$"),
        ("X = (", "cannot be loaded: SyntaxError"),
        ("class X:\n  def __init__(self): raise KeyError('x')", r"cannot be made without arguments: KeyError: 'x'"),
        ("class X:\n  def __init__(self): raise SystemExit(7)", "cannot be made without arguments: SystemExit: 7"),
        ("X = 5", "cannot be made without arguments: TypeError: 'int' object is not callable"),
    ],
)
def test_whatever_a_file_raises_is_one_line(tmp_path: Path, code: str, words: str):
    (tmp_path / "mine.py").write_text(code)
    with pytest.raises(ConfigError, match=words) as caught:
        find_detector(f"{tmp_path / 'mine.py'}:X")()
    assert "mine.py" in str(caught.value)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero (mine.py, line 3)"),
        ("import sys; sys.exit()", "SystemExit (mine.py, line 3)"),
        ("raise ValueError('no\\nway')", "ValueError: no way (mine.py, line 3)"),
    ],
)
@pytest.mark.parametrize("method", ["fit", "step"])
def test_whatever_a_detector_raises_is_one_line(tmp_path: Path, code: str, words: str, method: str):
    lines = [
        "class X:",
        *(f"  def {each}(self, _):\n    {code if each == method else 'pass'}" for each in ("fit", "step")),
    ]
    (tmp_path / "mine.py").write_text("\n".join(lines if method == "fit" else [lines[0], *reversed(lines[1:])]))
    frame = np.zeros((8, 8, 3), np.uint8)
    with pytest.raises(ConfigError) as caught:
        detection_of(fitted(find_detector(f"{tmp_path / 'mine.py'}:X"), [frame], who="mine"), frame, who="mine")
    assert str(caught.value) == f"detector 'mine': {method} raised: {words}"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"proximity": "Nearby"}, "unknown proximity 'Nearby'"),
        ({"contact": "Toched"}, "unknown contact 'Toched' (did you mean 'Touched'?)"),
        ({"approach": float("nan")}, "approach = nan is not allowed"),
        ({"touch": "much"}, "touch = 'much' is not allowed"),
    ],
)
def test_wrong_answer_is_named(change: dict[str, object], words: str):
    values = {field: getattr(GOOD, field) for field in GOOD.__slots__} | change
    with pytest.raises(ConfigError) as caught:
        check_detection(Detection(**values), who="mine")
    assert words in str(caught.value)


def test_answer_of_another_kind_is_named():
    with pytest.raises(ConfigError, match="step returned dict without proximity"):
        check_detection({"proximity": "Normal"}, who="mine")


def test_built_in_detector_needs_its_references_first():
    with pytest.raises(ConfigError, match="step before fit"):
        built_in("published")().step(np.zeros((8, 8, 3), np.uint8))


def test_blind_detector_scores_as_chance(evaluate: object):
    found: Evaluation = evaluate(Blind)
    table = tally(found.episodes)
    assert measure("proximity_balanced_accuracy", table) == pytest.approx(1 / 3)
    assert measure("contact_balanced_accuracy", table) == 0.5
    assert measure("approach_auc", table) == 0.5
    assert measure("lead_mm", table) == 0


def test_worked_example_is_judged_like_the_built_in_one(evaluate: object):
    found: Evaluation = evaluate(find_detector(f"{EXAMPLE}:ChangedPixels"))
    row = found.metrics[found.standard]
    assert row["proximity_balanced_accuracy"].value > 0.9
    assert row["contact_balanced_accuracy"].value > 0.9
