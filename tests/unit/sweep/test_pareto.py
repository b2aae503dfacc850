import numpy as np
import pytest

from magicsim.sweep.result import DesignResult
from magicsim.sweep.search import costs_of, pareto_front
from magicsim.sweep.sweep_file import Objective


def test_front_holds_what_nothing_beats():
    costs = np.array([[1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [3.0, 3.0], [2.0, 2.0], [np.nan, 0.0]])
    assert pareto_front(costs).tolist() == [True, True, True, False, True, False]


def test_without_objectives_no_design_is_in_the_front():
    assert not pareto_front(np.zeros((3, 0))).any()


def test_front_of_one_objective_is_its_best():
    assert pareto_front(np.array([[2.0], [1.0], [3.0]])).tolist() == [False, True, False]


def test_wanted_direction_turns_the_sign(results: list[DesignResult]):
    objectives = [Objective(measure="shore_a", better="higher"), Objective(measure="localisation_mm")]
    costs = costs_of(results, objectives)
    assert costs[0] == pytest.approx([-27.0, 0.6])
