from itertools import pairwise

import pytest

from magicsim_experiments.assembly.playing import carriage_ways, spread


def test_ways_are_short_near_the_base_and_as_many_as_samples_far_from_it():
    assert carriage_ways(-0.5, 2.0, 4) == (0.0, pytest.approx([0.5, 1.0, 1.5, 2.0]))
    assert carriage_ways(2.0, 2.3, 4) == (2.0, [2.3])
    assert carriage_ways(None, 8.0, 1)[1] == [8.0]
    assert carriage_ways(None, -0.5, 1)[1] == [-0.5]
    assert carriage_ways(None, 8.0, 4) == (0.0, pytest.approx([2.0, 4.0, 6.0, 8.0]))


@pytest.mark.parametrize(("count", "samples"), [(1, 4), (3, 4), (4, 4), (16, 3), (7, 1)])
def test_samples_are_spread_over_a_step_and_hold_its_end(count: int, samples: int):
    found = spread(count, samples)
    assert found[-1] == count
    assert len(found) == min(count, samples)
    gaps = [after - before for before, after in pairwise([0, *found])]
    assert max(gaps) - min(gaps) <= 1
