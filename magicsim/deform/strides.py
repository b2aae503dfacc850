"""How far the next load step goes, and with how much care it is solved, after what came of the last one.

A step that fails is halved and iterated with more care (`Problem.careful`), then with patience (`Problem.patient`),
down to the shortest one. Where the face snaps from one shape to another no step is short enough: where the equilibrium
does not depend on the path, a longer one leaps over the snap. A state that is nearly folded is spared the costlier of
these: shorter steps bring it to its fold, and nothing leads beyond.
"""

from dataclasses import dataclass
from enum import Enum

SHORTEST, SHORTEST_BEFORE_LEAP = 1 / 32, 1 / 8
"""Shortest load steps in units of the usual one; after a leap that fails too the whole path may be begun again."""
LEAPS = (1.5, 2.0, 3.0, 4.0)
"""Steps that are tried in turn where the shortest one failed, in the same units."""
GROWTH = 1.5
"""Of a step after one that succeeded."""
NEARLY_FOLDED, FOLDED = 0.1, 0.02
"""Smallest Jacobians of a state below which patience does not lead on, and below which leaps do not either."""
ROUNDING = 1e-9


class Care(Enum):
    """How a load step is solved."""

    ORDINARY = 0
    CAREFUL = 1
    PATIENT = 2


@dataclass(slots=True)
class Strides:
    """Where a path stands; lengths are in units of the whole way."""

    usual: float
    """Longest step, but for leaps."""
    may_leap: bool
    """Whether the equilibrium does not depend on the path."""
    done: float = 0.0
    care: Care = Care.ORDINARY
    cutbacks: int = 0
    """Steps that were halved."""
    gave_up: bool = False
    _stride: float = 0.0
    _leaps: int = 0
    """How many were tried."""

    def __post_init__(self) -> None:
        """Begins with the usual step."""
        self._stride = self.usual

    @property
    def target(self) -> float:
        """Where the next step ends."""
        target = self.done + self._stride
        return 1.0 if target > 1 - ROUNDING else target

    def succeed(self) -> None:
        """The step was solved."""
        self.done, self.care = self.target, Care.ORDINARY
        self._stride = min(self._stride * GROWTH, self.usual)
        self._leaps = 0

    def fail(self, min_jacobian: float) -> None:
        """The step was not solved.

        Args:
            min_jacobian: Smallest Jacobian of the state that it began from.
        """
        if self.care is Care.CAREFUL and not self._leaps and min_jacobian > NEARLY_FOLDED:
            self.care = Care.PATIENT
            return
        self.care = Care.CAREFUL
        may_leap = self.may_leap and min_jacobian > FOLDED
        if not self._leaps:
            self._stride = (self.target - self.done) / 2
            self.cutbacks += 1
            if self._stride >= self.usual * (SHORTEST_BEFORE_LEAP if may_leap else SHORTEST):
                return
        self.gave_up = not (may_leap and self._can_leap())

    def _can_leap(self) -> bool:
        was_to_the_end = self._leaps > 0 and self.target == 1
        if was_to_the_end or self._leaps == len(LEAPS):
            return False
        self._stride = LEAPS[self._leaps] * self.usual
        self._leaps += 1
        return True
