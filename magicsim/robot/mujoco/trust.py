"""How far an object may move before its contact is solved again."""

import math
from dataclasses import dataclass, replace
from typing import Self

LEAST_MM, MOST_MM = 0.005, 0.3
"""Shortest and longest way between two solves [mm]."""
SAFETY, SLOWEST, FASTEST = 0.9, 0.5, 1.5
"""Part of the way that the error allows which is gone, and the least and largest change of it from solve to solve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trust:
    """Way between solves, learned from the errors of the linear answers.

    The error of a linear answer grows with the square of the way, so the way that would have met the tolerance is the
    present one times the root of tolerance over error, as step sizes of differential equations are chosen.
    """

    tolerance_n: float
    """Error of the predicted force that is aimed at [N]."""
    way_mm: float = 0.05
    """Way after which the contact is solved again [mm]."""
    worst_n: float = 0.0
    """Largest error so far [N]."""

    def learned(self, error_n: float) -> Self:
        """After a prediction turned out to be wrong by so much [N]."""
        wanted = SAFETY * math.sqrt(self.tolerance_n / max(error_n, 1e-12))
        way = self.way_mm * min(max(wanted, SLOWEST), FASTEST)
        return replace(self, way_mm=min(max(way, LEAST_MM), MOST_MM), worst_n=max(self.worst_n, error_n))
