"""Stretches of equal values in a sequence."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True, kw_only=True)
class Run(Generic[Value]):
    """Neighbouring places that hold the same value."""

    start: int
    """First place."""
    stop: int
    """Place after the last one."""
    value: Value
    """What they hold."""

    @property
    def length(self) -> int:
        """Number of places."""
        return self.stop - self.start


def runs(values: Sequence[Value]) -> Iterator[Run[Value]]:
    """The longest stretches of equal neighbours, in order; together they cover every place once."""
    start = 0
    for place in range(1, len(values) + 1):
        if place == len(values) or values[place] != values[start]:
            yield Run(start=start, stop=place, value=values[start])
            start = place
