"""Where a number of a recipe comes from: a constant, an interval, a normal distribution, or a list."""

from collections.abc import Mapping
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from magicsim.config.models import Config

CUTOFF_SD = 3.0
"""Normal distributions end at so many standard deviations: what differs more is no good part."""


Value = Annotated[float, Field(ge=-1e12, le=1e12)]
"""Wider than any field that it may be drawn for, which checks what is drawn."""
Weight = Annotated[float, Field(ge=0, le=1e6)]


class Distribution(Config):
    """One of: `low` and `high`; `mean` and `sd`; `choices`."""

    low: Value | None = None
    """Smallest value."""
    high: Value | None = None
    """Largest value."""
    scale: Literal["linear", "log"] = "linear"
    """Whether values between low and high are uniform themselves or in their logarithm."""
    mean: Value | None = None
    """Centre of a normal distribution, cut off at 3 standard deviations."""
    sd: Annotated[float, Field(ge=0, le=1e12)] | None = None
    """Standard deviation of the normal distribution before the cut."""
    choices: Annotated[tuple[Value, ...], Field(min_length=1)] | None = None
    """Values to choose from."""
    weights: tuple[Weight, ...] | None = None
    """How often each is chosen, relative; equally often by default."""

    @model_validator(mode="after")
    def _check_family(self) -> Self:
        families = [
            self.low is not None or self.high is not None,
            self.mean is not None or self.sd is not None,
            self.choices is not None or self.weights is not None,
        ]
        whole = [None not in (self.low, self.high), None not in (self.mean, self.sd), self.choices is not None]
        if sum(families) != 1 or families != whole:
            raise ValueError("a distribution needs either low and high, or mean and sd, or choices")
        if self.low is not None and self.high is not None:
            self._check_interval(self.low, self.high)
        if self.choices is not None and self.weights is not None:
            check_weights(self.weights, len(self.choices))
        return self

    def _check_interval(self, low: float, high: float) -> None:
        if low > high:
            raise ValueError(f"low = {low:g} is not allowed: must be at most high = {high:g}")
        if self.scale == "log" and low <= 0:
            raise ValueError(f"low = {low:g} is not allowed with scale 'log': must be above 0")

    def at(self, share: float) -> float:
        """The value below which a share of all values lies (the quantile), share in [0, 1)."""
        if self.low is not None and self.high is not None:
            if self.scale == "log":
                return float(np.clip(self.low * (self.high / self.low) ** share, self.low, self.high))
            return self.low + (self.high - self.low) * share
        if self.mean is not None and self.sd is not None:
            from scipy.special import ndtr, ndtri

            tail = float(ndtr(-CUTOFF_SD))
            return self.mean + self.sd * float(ndtri(tail + (1 - 2 * tail) * share))
        choices = self.choices or ()
        return choices[choose(share, self.weights or (1.0,) * len(choices))]


def _written_as(value: object) -> str:
    return "distribution" if isinstance(value, Mapping | Distribution) else "number"


Number = Annotated[
    Annotated[Value, Tag("number")] | Annotated[Distribution, Tag("distribution")], Discriminator(_written_as)
]
"""A number of a recipe: a constant, or a distribution."""


def choose(share: float, weights: tuple[float, ...]) -> int:
    """Place that a share in [0, 1) of the summed weights falls on."""
    ends = np.cumsum(weights) / np.sum(weights)
    return min(int(np.searchsorted(ends, share, side="right")), len(weights) - 1)


def check_weights(weights: tuple[float, ...], count: int) -> None:
    """Refuses weights that do not belong to as many things, or of which none is above 0.

    Raises:
        ValueError: With what is allowed.
    """
    if len(weights) != count or not any(weights):
        raise ValueError(f"weights = {list(weights)} is not allowed: must be {count} numbers, one of them above 0")
