import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim_experiments.learn.samples import fold

PRESS = np.repeat(np.arange(20), 3)
UNIT = PRESS // 5


def test_no_press_is_in_two_parts_and_every_press_is_tested_once():
    tested = []
    for number in range(5):
        found = fold(PRESS, number, 5, validation_share=0.2)
        parts = [set(PRESS[rows]) for rows in (found.train, found.validation, found.test)]
        assert sum(map(len, parts)) == len(set.union(*parts)) == 20
        tested += [PRESS[found.test]]
    assert sorted(np.concatenate(tested)) == sorted(PRESS)


def test_units_of_the_test_are_unseen_and_validation_is_of_whole_presses():
    found = fold(UNIT, 1, 4, validation_share=0.2, inner=PRESS)
    assert set(UNIT[found.test]) & set(UNIT[np.concatenate([found.train, found.validation])]) == set()
    assert not set(PRESS[found.train]) & set(PRESS[found.validation])
    assert len(set(UNIT[found.test])) == 1


def test_smaller_share_is_a_part_of_a_larger_one_and_leaves_the_test():
    whole, part = (fold(PRESS, 0, 4, validation_share=0.2, share=share) for share in (1.0, 0.4))
    assert set(part.train) < set(whole.train)
    assert (part.test == whole.test).all()
    assert (part.validation == whole.validation).all()


def test_too_few_groups_are_refused():
    with pytest.raises(ConfigError, match="2 groups for 3 folds"):
        fold(np.array([0, 1]), 0, 3, validation_share=0.2)
    with pytest.raises(ConfigError, match="too few to train on"):
        fold(np.array([0, 1]), 0, 2, validation_share=0.2)
