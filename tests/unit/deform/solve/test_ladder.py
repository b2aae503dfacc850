from magicsim.deform.solve.ladder import SHORTEST, Care, Strides


def fail_until_given_up(strides: Strides, *, min_jacobian: float) -> list[tuple[float, Care]]:
    tried = []
    while not strides.gave_up:
        tried.append((strides.target, strides.care))
        strides.fail(min_jacobian)
    return tried


def test_a_path_without_failures_goes_in_usual_steps():
    strides, targets = Strides(usual=0.25), []
    while strides.done < 1:
        targets.append(strides.target)
        strides.succeed()
    assert targets == [0.25, 0.5, 0.75, 1.0]


def test_a_step_that_fails_is_halved_with_care_and_patience_down_to_the_shortest():
    strides = Strides(usual=0.25)
    tried = fail_until_given_up(strides, min_jacobian=0.5)
    assert tried[:4] == [
        (0.25, Care.ORDINARY), (0.125, Care.CAREFUL), (0.125, Care.PATIENT), (0.0625, Care.CAREFUL),
    ]  # fmt: skip
    assert tried[-1] == (0.25 * SHORTEST, Care.PATIENT)
    assert strides.cutbacks == 6


def test_only_shorter_steps_are_tried_where_a_cell_is_folded():
    tried = fail_until_given_up(Strides(usual=0.25), min_jacobian=0.01)
    assert [target for target, _ in tried] == [0.25 / 2**halvings for halvings in range(6)]
    assert Care.PATIENT not in {care for _, care in tried}


def test_the_last_step_is_tried_again_with_care_before_it_is_halved():
    strides = Strides(usual=0.4)
    strides.succeed()
    strides.succeed()
    tried = fail_until_given_up(strides, min_jacobian=0.05)
    assert tried[:2] == [(1.0, Care.ORDINARY), (1.0, Care.CAREFUL)]
    assert [round(target, 9) for target, _ in tried[2:4]] == [0.9, 0.85]


def test_steps_grow_again_after_a_failure():
    strides = Strides(usual=0.4)
    strides.fail(0.5)
    strides.succeed()
    assert round(strides.target - strides.done, 9) == 0.3
