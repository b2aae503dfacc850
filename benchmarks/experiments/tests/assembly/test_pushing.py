"""Where the base stops that pushes a plug, on grips whose force is known."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from magicsim.geometry.objects.kinds import parse_object
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.load import Hold
from magicsim_experiments.assembly.playing import LOST_MM, WITHIN, Pusher

PLUG = parse_object("plug:radius_mm=4")
MEETS_MM = 0.3


@dataclass(frozen=True)
class Spring:
    """Pushes back with 3 N/mm beyond where it meets the plug."""

    way_mm: float

    def met(self, _: object) -> np.ndarray:
        return np.array([0.0, -3.0 * max(self.way_mm - MEETS_MM, 0.0), 0, 0, 0, 0])


@dataclass
class SpringGrip:
    """Loses the plug beyond a force."""

    holds_n: float = np.inf
    tried: list[float] = field(default_factory=list)
    place: ObjectPlace = field(default_factory=ObjectPlace)
    outcome: Hold = Hold.HELD

    def hold(self, *, load: Spring, most_slide_mm: float) -> Hold:
        assert self.outcome is Hold.HELD, "nothing is held any more"
        assert most_slide_mm > 0
        self.tried.append(load.way_mm)
        self.outcome = Hold.DROPPED if -load.met(None)[1] > self.holds_n else Hold.HELD
        return self.outcome

    def now(self) -> SimpleNamespace:
        return SimpleNamespace(state=SimpleNamespace(hold=self.outcome))

    def go_back(self, moment: SimpleNamespace) -> None:
        self.outcome = moment.state.hold

    def truth(self) -> SimpleNamespace:
        return SimpleNamespace(slid_mm=0.01)


def walk(grip: SpringGrip, push_n: float, samples: int = 1):
    return Pusher(grip, PLUG, Spring).walk_in_samples(0.0, [0.5, 1.0, 1.5, 2.0], push_n, samples=samples)


@pytest.mark.parametrize("push_n", [0.2, 1.0, 2.0, 4.0])
def test_carriage_stops_as_hard_as_it_may_push(push_n: float):
    grip = SpringGrip()
    walked = walk(grip, push_n)
    assert (1 - WITHIN) * push_n <= walked[-1].push_n <= push_n
    assert walked[-1].way_mm == pytest.approx(MEETS_MM + walked[-1].push_n / 3)
    assert all(each.push_n <= push_n for each in walked)
    assert len(grip.tried) <= len(walked) + 5


def test_way_without_much_resistance_is_gone_to_its_end():
    assert [each.way_mm for each in walk(SpringGrip(), 10.0)] == [0.5, 1.0, 1.5, 2.0]


@pytest.mark.parametrize("samples", [1, 12])
def test_plug_that_is_lost_has_the_force_that_it_was_held_against_last(samples: int):
    walked = walk(SpringGrip(holds_n=1.3), 4.0, samples)
    end = walked[-1]
    assert end.is_lost
    assert [each.is_lost for each in walked[:-1]] == [False] * (len(walked) - 1)
    assert 1.3 - 3 * LOST_MM <= end.push_n <= 1.3
    assert end.way_mm == pytest.approx(MEETS_MM + 1.3 / 3, abs=LOST_MM)
    assert len(walked) >= samples


def test_plug_that_would_be_lost_beyond_the_largest_push_is_not():
    end = walk(SpringGrip(holds_n=1.05), 1.0)[-1]
    assert not end.is_lost
    assert 0.95 <= end.push_n <= 1.0


def test_way_that_is_gone_in_samples_ends_at_the_same_place():
    walked = walk(SpringGrip(), 2.0, samples=8)
    assert len(walked) == 8
    assert np.diff([0.0, *(each.way_mm for each in walked)]) == pytest.approx(walked[-1].way_mm / 8)
    assert 1.9 <= walked[-1].push_n <= 2.0
