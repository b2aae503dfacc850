"""The ladder of ways to an equilibrium that is not found in the ordinary one: every rung, and where it stands.

| level | what fails | what is tried, in this order | where |
| --- | --- | --- | --- |
| iteration | the model of the body is a poor one | a factor at the present state | `condensed` |
| iteration | the matrix is not definite | `SHIFTED` | `condensed`, `load_step` |
| iteration | the condensed step, for one of `WHY_PLAIN` | `PLAIN` | `load_step` |
| iteration | the step folds a cell, or the energy rises | a shorter one | `descent` |
| load step | no equilibrium | `HALVED` and `CAREFUL` | `Strides`, `Problem` |
| path | no load step leads on | `FEWER` | `path` |

A result names the rungs on which it stands (`Deformation.rungs`), and for plain steps why they were taken, so that
`python benchmarks/stress.py` counts what each one of them is good for.
"""

from dataclasses import dataclass
from enum import StrEnum


class Rung(StrEnum):
    """A way other than the ordinary one."""

    SHIFTED = "shifted"
    """A multiple of the spring Laplacian was added to the matrix."""
    PLAIN = "plain"
    """A Newton step of body and contact together, the contact not solved in full; why is one of `WHY_PLAIN`."""
    UNTOUCHED = "untouched"
    """Plain: no facet of the face is near the object."""
    LARGE = "large"
    """Plain: the part of the face near the object is too large for a dense matrix."""
    INDEFINITE = "indefinite"
    """Plain: no shift makes the body's matrix definite."""
    UNSOLVED = "unsolved"
    """Plain: the contact problem of the face, solved by itself, has no solution."""
    HALVED = "halved"
    """A shorter load step."""
    CAREFUL = "careful"
    """More iterations, each of them with a new factor; friction limits wait for balance."""
    FEWER = "fewer"
    """The path begun again from rest with longer load steps."""


WHY_PLAIN = frozenset({Rung.UNTOUCHED, Rung.LARGE, Rung.INDEFINITE, Rung.UNSOLVED})
"""Reasons for a plain step: what a condensed one says instead of a result."""


def rung_names(rungs: frozenset[Rung]) -> tuple[str, ...]:
    """Their names in the order of the ladder."""
    return tuple(rung.value for rung in Rung if rung in rungs)


# Numbers without a source are assumed: they decide how soon an equilibrium is found, not which one is accepted.
SHORTEST = 1 / 32
"""Shortest load step in units of the usual one."""
GROWTH = 1.5
"""Growth of a step after one that succeeded."""
ROUNDING = 1e-9


@dataclass(slots=True)
class Strides:
    """Where a path stands; lengths are in units of the whole way."""

    usual: float
    """Longest step."""
    done: float = 0.0
    is_careful: bool = False
    """Whether the next step is solved with care: the one before failed."""
    cutbacks: int = 0
    _stride: float = 0.0

    def __post_init__(self) -> None:
        self._stride = self.usual

    @property
    def rungs(self) -> frozenset[Rung]:
        """Rungs of the ladder, on which the next step would stand."""
        found = {Rung.CAREFUL: self.is_careful, Rung.HALVED: self._stride < (1 - ROUNDING) * self.usual}
        return frozenset(rung for rung, stands in found.items() if stands)

    @property
    def gave_up(self) -> bool:
        """Whether the next step would be shorter than the shortest."""
        return self._stride < SHORTEST * self.usual

    @property
    def target(self) -> float:
        """Where the next step ends."""
        target = self.done + self._stride
        return 1.0 if target > 1 - ROUNDING else target

    def succeed(self) -> None:
        """The step was solved."""
        self.done, self.is_careful = self.target, False
        self._stride = min(self._stride * GROWTH, self.usual)

    def fail(self) -> None:
        """The step was not solved."""
        # the last step of a path may be cut short: it is solved again with care before it is halved
        self._stride = (self.target - self.done if self.is_careful else self._stride) / 2
        self.cutbacks, self.is_careful = self.cutbacks + 1, True
