"""How a sweep that searches goes about it: the table `[search]` of a sweep file."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config
from magicsim.errors import unknown_choice
from magicsim.sampling.distribution import Value
from magicsim.sweep.judging.measures import MEASURES
from magicsim.sweep.result import DesignResult

MAX_DESIGNS = 10_000
"""Most designs of a sweep."""


class SearchLimit(Config):
    """A measure that has to stay in a range."""

    measure: str
    low: Value | None = None
    """Smallest value that is allowed."""
    high: Value | None = None
    """Largest value that is allowed."""

    @model_validator(mode="after")
    def _check_limit(self) -> Self:
        if self.measure not in MEASURES:
            raise ValueError(unknown_choice("measure", self.measure, MEASURES))
        if self.low is None and self.high is None:
            msg = f"limit of '{self.measure}' needs low or high"
            raise ValueError(msg)
        if self.low is not None and self.high is not None and self.low > self.high:
            msg = f"low = {self.low:g} is not allowed: must be at most high = {self.high:g}"
            raise ValueError(msg)
        return self

    def excess(self, result: DesignResult) -> float | None:
        """By how much a design is out of the range, in the measure's unit; 0 or less inside, None without a value."""
        found = result.measures.get(self.measure)
        if found is None or found.value is None:
            return None
        below = self.low - found.value if self.low is not None else -float("inf")
        above = found.value - self.high if self.high is not None else -float("inf")
        return max(below, above)


class SearchSettings(Config):
    """Everything here changes which designs are chosen."""

    start: Annotated[int, Field(ge=1, le=MAX_DESIGNS)] = 16
    """Designs that are spread evenly (Sobol) before the search looks at results."""
    batch: Annotated[int, Field(ge=1, le=MAX_DESIGNS)] = 8
    """Designs that are chosen at once, and judged at the same time; the next batch knows their results."""
    limits: tuple[SearchLimit, ...] = ()
    """What a design has to keep; one that does not is in no Pareto front."""

    def keeps(self, result: DesignResult) -> bool:
        """Whether a design is inside every limit."""
        return all((excess := each.excess(result)) is not None and excess <= 0 for each in self.limits)
