"""Detectors that break the rules are refused by one line each, and those that keep them are not."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from laboratory.injected_faults import FAULTS

from evaluation.synthetic import PROFILE
from magicsim.errors import ConfigError
from magicsim.evaluation.answers import check_order, judge_footage
from magicsim.evaluation.detector import Detection, ProfileDetector
from magicsim.evaluation.evaluate import Evaluation, film_suite
from magicsim.evaluation.footage import Footage
from magicsim.evaluation.suite import SuiteConfig


@pytest.fixture(scope="module")
def film(tiny: tuple[SuiteConfig, Path]) -> Footage:
    return next(film_suite(*tiny))[0]


class Sound(ProfileDetector):
    """The built-in one, made without arguments."""

    def __init__(self) -> None:
        super().__init__(PROFILE)


class Forgetful(Sound):
    """Has no answer to every tenth frame."""

    count = 0

    def step(self, frame: np.ndarray) -> Detection | None:
        self.count += 1
        return None if self.count == 10 else super().step(frame)


class Spoiler(Sound):
    """Blurs its references where they lie."""

    def fit(self, references: Sequence[np.ndarray]) -> None:
        super().fit(references)
        references[2][5:, 5:] //= 2


class Foreseeing(Sound):
    """Says what the class has learned that it will say in two frames."""

    known: list[Detection] = []  # noqa: RUF012 - shared by its objects on purpose

    def __init__(self) -> None:
        super().__init__()
        self.count, self.was = 0, list(type(self).known)
        type(self).known.clear()

    def step(self, frame: np.ndarray) -> Detection:
        type(self).known.append(super().step(frame))
        self.count += 1
        later = self.was[self.count + 1 : self.count + 2]
        return later[0] if later else type(self).known[-1]


class Reciting(Sound):
    """Knows the story by heart."""

    count = -1

    def step(self, frame: np.ndarray) -> Detection:
        del frame
        self.count += 1
        is_touched = 14 <= self.count <= 17
        return Detection(
            proximity="Normal", contact="Touched" if is_touched else "Untouched", approach=0.0, touch=float(is_touched)
        )


def test_too_few_answers_are_refused_with_the_frame(film: Footage):
    with pytest.raises(ConfigError) as caught:
        judge_footage(film, Forgetful, who="mine")
    assert str(caught.value) == (
        "detector 'mine': step returned no answer to frame 9 of ball-0/story/dark/1; must be one for every frame"
    )


def test_changed_references_are_refused(film: Footage):
    with pytest.raises(ConfigError) as caught:
        judge_footage(film, Spoiler, who="mine")
    assert str(caught.value) == (
        "detector 'mine' changes its references in ball-0/story/dark/1; must leave their pixels as they are"
    )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (Foreseeing, "'mine' reads the future, or differs from run to run: of frame "),
        (Reciting, "'mine' does not look at the frames: of those from 13 on of ball-0/story/dark/1 it said"),
    ],
)
def test_answers_that_do_not_follow_from_frames_so_far_are_refused(
    film: Footage, make: Callable[[], Sound], words: str
):
    Foreseeing.known.clear()
    with pytest.raises(ConfigError) as caught:
        check_order(film, make, who="mine")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_plug_in_is_tried_before_it_is_judged_and_a_profile_is_not(evaluate: Callable[..., Evaluation]):
    with pytest.raises(ConfigError, match="does not look at the frames"):
        evaluate(Reciting)


@pytest.mark.parametrize("name", FAULTS)
def test_detectors_that_are_late_stuck_or_dead_keep_to_the_rules(film: Footage, name: str):
    check_order(film, lambda: FAULTS[name].make(PROFILE), who=name)
