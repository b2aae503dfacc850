"""Where a number of a recipe comes from: a constant, an interval, a normal distribution, or a list.

Points of the unit cube from which everything random is drawn; point k never depends on how many there are.
"""

import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from magicsim.arrays import Array
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

    def _problems(self) -> Iterator[str | None]:
        families = [
            self.low is not None or self.high is not None,
            self.mean is not None or self.sd is not None,
            self.choices is not None or self.weights is not None,
        ]
        whole = [None not in (self.low, self.high), None not in (self.mean, self.sd), self.choices is not None]
        if sum(families) != 1 or families != whole:
            yield "a distribution needs either low and high, or mean and sd, or choices"
        if self.low is not None and self.high is not None:
            if self.low > self.high:
                yield f"low = {self.low:g} is not allowed: must be at most high = {self.high:g}"
            if self.scale == "log" and self.low <= 0:
                yield f"low = {self.low:g} is not allowed with scale 'log': must be above 0"
        if self.choices is not None and self.weights is not None:
            yield weights_problem(self.weights, len(self.choices))

    @property
    def lowest(self) -> float:
        """Smallest value."""
        return min(self.choices) if self.choices is not None else self.at(0.0)

    def at(self, share: float, least: float = -math.inf, most: float = math.inf) -> float:
        """The value below which a share of all values lies (the quantile), share in [0, 1).

        Of what lies from `least` to `most` alone, with its relative frequency; `ValueError` if nothing does.
        """
        if self.low is not None and self.high is not None:
            low, high = max(self.low, least), min(self.high, most)
            if low <= high:
                if self.scale == "log":
                    return float(np.clip(low * (high / low) ** share, low, high))
                return low + (high - low) * share
        elif self.mean is not None and self.sd is not None:
            value = self._normal(share, least, most)
            if least <= value <= most:
                return value
        else:
            choices = self.choices or ()
            pairs = zip(choices, self.weights or (1.0,) * len(choices), strict=True)
            kept = {place: weight for place, (each, weight) in enumerate(pairs) if least <= each <= most}
            if any(kept.values()):
                return choices[list(kept)[choose(share, tuple(kept.values()))]]
        raise ValueError(f"nothing of it lies in {least:.3g} to {most:.3g}")

    def _normal(self, share: float, least: float, most: float) -> float:
        """Quantile of the part of a normal distribution between two values; NaN or the mean where there is none."""
        from scipy.special import ndtr, ndtri

        mean, sd = self.mean or 0.0, self.sd or 0.0
        if sd == 0:
            return mean
        below = float(ndtr(max(-CUTOFF_SD, (least - mean) / sd)))
        above = float(ndtr(max(-CUTOFF_SD, (mean - most) / sd)))
        if below + above >= 1:
            return math.nan
        value = mean + sd * float(ndtri(below + (1 - (below + above)) * share))
        return min(max(value, least), most)


Number = Annotated[
    Annotated[Value, Tag("number")] | Annotated[Distribution, Tag("distribution")],
    Discriminator(lambda value: "distribution" if isinstance(value, Mapping | Distribution) else "number"),
]
"""A number of a recipe: a constant, or a distribution."""


def choose(share: float, weights: tuple[float, ...]) -> int:
    """Place that a share in [0, 1) of the summed weights falls on."""
    ends = np.cumsum(weights) / np.sum(weights)
    return min(int(np.searchsorted(ends, share, side="right")), len(weights) - 1)


def weights_problem(weights: tuple[float, ...], count: int) -> str | None:
    """What is wrong with weights that do not belong to as many things, or of which none is above 0."""
    if len(weights) == count and any(weights):
        return None
    return f"weights = {list(weights)} is not allowed: must be {count} numbers, one of them above 0"


if TYPE_CHECKING:
    from scipy.stats import qmc

Sampling = Literal["sobol", "stratified", "random"]
BELOW_ONE = np.nextafter(1.0, 0.0)
BLOCK = 1024
"""Points that are made at once: a power of two, in which Sobol points are balanced."""
KEPT_BLOCKS = 4
RUN = 16
"""Consecutive stratified points that have one in each of as many equal parts of every dimension."""


class UnitPoints:
    """The points of one sequence, made when they are asked for."""

    def __init__(self, dimensions: int, *, seed: int, stream: int, sampling: Sampling) -> None:
        """Chooses a sequence.

        Args:
            dimensions: Of each point.
            seed: Seed of the recipe or sweep.
            stream: Sequences of different streams are independent.
            sampling: Scrambled Sobol points (Owen 1998), which fill the cube most evenly and tie dimensions to each
                other, most of all in small numbers; stratified ones, each dimension in an order of its own (Latin
                hypercubes of `RUN` points, McKay et al. 1979), which do not; or independent ones.
        """
        self._dimensions, self._seed, self._stream, self._sampling = dimensions, seed, stream, sampling
        self._engine: qmc.Sobol | None = None
        self._block = lru_cache(maxsize=KEPT_BLOCKS)(self._made)

    def __getitem__(self, index: int) -> Array:
        """One point, shape (dimensions,), in [0, 1)."""
        number, place = divmod(index, BLOCK)
        return np.asarray(self._block(number)[place])

    def first(self, count: int) -> Array:
        """The first points, shape (count, dimensions), in [0, 1)."""
        blocks = [self._made(number)[: count - number * BLOCK] for number in range(-(-count // BLOCK))]
        return np.concatenate([np.zeros((0, self._dimensions)), *blocks])

    def _made(self, number: int) -> Array:
        """Block of points by its number, shape (BLOCK, dimensions)."""
        if self._dimensions == 0:
            return np.zeros((BLOCK, 0))
        if self._sampling == "random":
            return np.stack([random.random(self._dimensions) for random in self._generators(number, BLOCK)])
        if self._sampling == "stratified":
            return np.concatenate([self._run(random) for random in self._generators(number, BLOCK // RUN)])
        engine = self._at(number * BLOCK)
        return np.asarray(np.minimum(engine.random(BLOCK), BELOW_ONE))

    def _generators(self, block: int, count: int) -> Iterator[np.random.Generator]:
        """One generator for each equal part of a block."""
        for part in range(block * count, (block + 1) * count):
            yield np.random.Generator(np.random.PCG64(np.random.SeedSequence([self._seed, self._stream, part])))

    def _run(self, random: np.random.Generator) -> Array:
        """Consecutive stratified points, shape (RUN, dimensions)."""
        parts = random.permuted(np.tile(np.arange(RUN), (self._dimensions, 1)), axis=1).T
        return np.asarray(np.minimum((parts + random.random(parts.shape)) / RUN, BELOW_ONE))

    def _at(self, place: int) -> "qmc.Sobol":
        """The generator of Sobol points, so far that a point is the next one."""
        from scipy.stats import qmc

        if self._engine is None:
            scramble = np.random.Generator(np.random.PCG64(np.random.SeedSequence([self._seed, self._stream])))
            self._engine = qmc.Sobol(self._dimensions, scramble=True, rng=scramble)
        elif self._engine.num_generated > place:
            self._engine.reset()
        if place > self._engine.num_generated:
            self._engine.fast_forward(place - self._engine.num_generated)
        return self._engine


def unit_points(count: int, dimensions: int, *, seed: int, stream: int, sampling: Sampling) -> Array:
    """The first points of a sequence, see `UnitPoints`; shape (count, dimensions), in [0, 1)."""
    return UnitPoints(dimensions, seed=seed, stream=stream, sampling=sampling).first(count)
