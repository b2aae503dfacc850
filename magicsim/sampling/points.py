"""Points of the unit cube from which everything random is drawn; point k never depends on how many there are."""

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np

from magicsim.arrays import Array

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
