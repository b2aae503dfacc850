"""Kinds of inputs that once gave a silent wrong answer: each has three variations, and those of one process hold."""

from pathlib import Path

import pytest
from fault_inputs import register
from laboratory.input_kinds import objects, program, surroundings
from laboratory.input_kinds.registry import KINDS, Variation

register()
OWN = [(kind, each) for kind, variations in KINDS.items() for each in variations
       if each.attempt.__module__ in {objects.__name__, program.__name__, surroundings.__name__}]  # fmt: skip

SLOW = {"renderer imported before the program", "press that takes too long"}
"""Kinds that start a program, beside all of `surroundings`."""


def is_slow(kind: str, each: Variation) -> bool:
    return each.attempt.__module__ == surroundings.__name__ or kind in SLOW


@pytest.mark.parametrize(
    "each",
    [pytest.param(each, id=f"{kind}: {each.name}", marks=[pytest.mark.slow] * is_slow(kind, each))
     for kind, each in OWN],
)  # fmt: skip
def test_answer_is_right_or_one_line(each: Variation, tmp_path: Path):
    assert each.attempt(tmp_path) is None


def test_every_kind_has_three_variations():
    assert {kind: len(variations) for kind, variations in KINDS.items() if len(variations) < 3} == {}
