from magicsim.deform.solve.ladder import SHORTEST, Strides


def fail_until_given_up(strides: Strides) -> list[tuple[float, bool]]:
    tried = []
    while not strides.gave_up:
        tried.append((strides.target, strides.is_careful))
        strides.fail()
    return tried


def test_a_path_without_failures_goes_in_usual_steps():
    strides, targets = Strides(usual=0.25), []
    while strides.done < 1:
        targets.append(strides.target)
        strides.succeed()
    assert targets == [0.25, 0.5, 0.75, 1.0]


def test_a_step_that_fails_is_halved_with_care_down_to_the_shortest():
    strides = Strides(usual=0.25)
    tried = fail_until_given_up(strides)
    assert tried == [(0.25 / 2**halvings, halvings > 0) for halvings in range(6)]
    assert tried[-1][0] == 0.25 * SHORTEST
    assert strides.cutbacks == 6


def test_the_last_step_is_tried_again_with_care_before_it_is_halved():
    strides = Strides(usual=0.4)
    strides.succeed()
    strides.succeed()
    tried = fail_until_given_up(strides)
    assert tried[:2] == [(1.0, False), (1.0, True)]
    assert [round(target, 9) for target, _ in tried[2:4]] == [0.9, 0.85]


def test_steps_grow_again_after_a_failure():
    strides = Strides(usual=0.4)
    strides.fail()
    strides.succeed()
    assert round(strides.target - strides.done, 9) == 0.3
