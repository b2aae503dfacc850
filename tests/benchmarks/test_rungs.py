"""What the ablation of the solver's ladder counts, and that each of its rungs can still be taken away."""

from contextlib import ExitStack

import pytest
import rungs
from laboratory.stress.cases import StressPath
from laboratory.stress.grid import VALID

from magicsim.deform.solve.ladder import Rung


def row(**changes):
    values = {"number": 0, "label": "ball", "stages": 4, "valid": 4, "ran": [], "seconds": 1.0, "without": {}}
    return rungs.Row(**(values | changes))


def test_a_rung_rescues_a_path_that_is_valid_less_far_without_it():
    rescued = row(ran=["halved", "careful"], without={"halved": 1, "careful": 4})
    found = rungs.summary([row(), rescued, row(ran=["halved"], valid=3, without={"halved": 2})])
    assert found["rungs"]["halved"] == {"ran": 2, "paths": 2, "stages": 4}
    assert found["rungs"]["careful"] == {"ran": 1, "paths": 0, "stages": 0}
    assert found["rungs"]["large"] == {"ran": 0}
    assert (found["paths"], found["stages"], found["valid"]) == (3, 12, 11)


@pytest.mark.parametrize("rung", sorted(rungs.LEFT_OUT))
def test_every_rung_can_be_taken_away(rung):
    with ExitStack() as stack:
        for each in rungs.ablated(rung):
            stack.enter_context(each)


def test_only_rungs_on_which_valid_stages_stand_are_left_out(monkeypatch):
    stress = StressPath(group="single", label="small", object_text="sphere:radius_mm=2")
    asked = []
    monkeypatch.setattr(rungs, "valid_without", lambda _, rung, limit_s: asked.append((rung, limit_s)) or 1)
    good = {"outcome": VALID, "rungs": ["halved", "large"], "seconds": 2.0}
    bad = {"outcome": "declared failure", "rungs": None, "seconds": 8.0}
    found = rungs.run(7, stress, [good, bad])
    assert (found.valid, found.ran, found.without) == (1, ["halved", "large"], {"halved": 1})
    assert asked == [(Rung.HALVED, rungs.PATIENCE * 10 + rungs.LEAST_S)]
