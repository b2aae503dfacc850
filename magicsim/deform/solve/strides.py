"""How far the next load step goes, and with how much care it is solved, after what came of the last one.

A step that fails is halved and iterated with more care (`Problem.careful`), then with patience (`Problem.patient`),
down to the shortest one. Where the face snaps from one shape to another no step is short enough: where the equilibrium
does not depend on the path, longer ones, which leap over the snap, are tried before the shortest. A state that is
nearly folded is spared the costlier of these: shorter steps bring it to its fold, and nothing leads beyond.
"""

from dataclasses import dataclass
from enum import Enum

from magicsim.deform.solve.ladder import Rung

SHORTEST, SHORTEST_BEFORE_LEAP = 1 / 32, 1 / 8
"""Shortest load steps in units of the usual one, of all and of those before leaps."""
LEAPS = (1.5, 2.0, 3.0, 4.0)
"""Longer steps that are tried in turn, in the same units."""
GROWTH = 1.5
"""Growth of a step after one that succeeded."""
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
    is_leap: bool = False
    """Whether the next step is longer than the usual one."""
    _stride: float = 0.0
    _halved: float = 0.0
    """The step to go on with when no leap succeeds."""
    _leaps: tuple[float, ...] = LEAPS
    """Those that were not tried yet."""

    def __post_init__(self) -> None:
        """Begins with the usual step."""
        self._stride = self.usual

    @property
    def rungs(self) -> frozenset[Rung]:
        """Rungs of the ladder, on which the next step would stand."""
        cared = {Care.ORDINARY: (), Care.CAREFUL: (Rung.CAREFUL,), Care.PATIENT: (Rung.PATIENT,)}[self.care]
        if self.is_leap:
            return frozenset((*cared, Rung.LEAP))
        is_halved = self._stride < (1 - ROUNDING) * self.usual
        return frozenset((*cared, Rung.HALVED) if is_halved else cared)

    @property
    def target(self) -> float:
        """Where the next step ends."""
        target = self.done + self._stride
        return 1.0 if target > 1 - ROUNDING else target

    def succeed(self) -> None:
        """The step was solved."""
        self.done, self.care = self.target, Care.ORDINARY
        self._stride = min(self._stride * GROWTH, self.usual)
        self.is_leap, self._leaps = False, LEAPS

    def fail(self, min_jacobian: float) -> None:
        """The step was not solved.

        Args:
            min_jacobian: Smallest Jacobian of the state that it began from.
        """
        if self.care is Care.CAREFUL and not self.is_leap and min_jacobian > NEARLY_FOLDED:
            self.care = Care.PATIENT
            return
        was_ordinary, self.care = self.care is Care.ORDINARY, Care.CAREFUL
        if self.is_leap:
            self._leaps = () if self.target == 1 else self._leaps[1:]
        else:
            # the last step of a path may be cut short: it is solved again with care before it is halved
            self._halved = (self._stride if was_ordinary else self.target - self.done) / 2
            self.cutbacks += 1
        is_short = self._halved < SHORTEST_BEFORE_LEAP * self.usual
        self.is_leap = self.may_leap and is_short and min_jacobian > FOLDED and len(self._leaps) > 0
        self._stride = self._leaps[0] * self.usual if self.is_leap else self._halved
        self.gave_up = not self.is_leap and self._halved < SHORTEST * self.usual
