"""The published figures of E, C and S as targets, and how far a sensor is from them.

From the runs of Fan, Li and Zhang (arXiv 2505.24382), as far as their figures and text give numbers. A target is an
interval; its tolerance, by which distances are counted, is our reading of how well the figures can be read.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, sqrt

FRAME_MM = 1.0
"""How far an object comes in one frame while a gripper closes [mm]; assumed, nothing was published. The lead of 10 to
15 frames is a lead of as many millimetres."""
WORST = 5.0
"""Distance of a target that counts at most [tolerances]: one that cannot be met must not hide the others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """What was published of one quantity."""

    low: float
    high: float
    tolerance: float
    unit: str
    says: str
    """The figure in words."""

    def distance(self, value: float) -> float:
        """How far outside the interval a value lies, signed [tolerances]."""
        outside = min(value - self.low, 0.0) + max(value - self.high, 0.0)
        return outside / self.tolerance


TARGETS: Mapping[str, Target] = {
    "s_rest": Target(low=0.83, high=0.87, tolerance=0.03, unit="", says="S of the untouched sensor is about 0.85"),
    "s_near": Target(low=0.8, high=inf, tolerance=0.03, unit="", says="S stays until contact"),
    "s_touch": Target(low=0.7, high=0.8, tolerance=0.03, unit="", says="S falls just below 0.8 on light contact"),
    "s_sway": Target(low=0.0, high=0.02, tolerance=0.02, unit="", says="S stays within 0.02 on the way to contact"),
    "s_drop": Target(low=0.05, high=inf, tolerance=0.03, unit="", says="S falls by more than 0.05 in contact"),
    "s_light": Target(low=-inf, high=0.5, tolerance=0.1, unit="", says="S falls below 0.5 under a flashlight"),
    "c_far": Target(low=0.1, high=0.3, tolerance=0.1, unit="", says="C is about 0.2 while the object is far"),
    "c_near": Target(low=-0.1, high=0.1, tolerance=0.1, unit="", says="C falls to about 0 as the object nears"),
    "c_back": Target(low=-inf, high=0.0, tolerance=0.1, unit="", says="C never rises on the way"),
    "c_rise": Target(low=0.05, high=inf, tolerance=0.05, unit="", says="C rises again in contact"),
    "c_light": Target(low=0.8, high=1.0, tolerance=0.1, unit="", says="C goes towards 1 under a flashlight"),
    "e_rest": Target(
        low=0.0, high=0.5, tolerance=0.25, unit="bit", says="E at rest is below tau_E = 0.5 (a threshold, not measured)"
    ),
    "e_near": Target(low=3.5, high=4.5, tolerance=0.5, unit="bit", says="E rises to about 4 near large objects"),
    "lead_mm": Target(
        low=10 * FRAME_MM, high=15 * FRAME_MM, tolerance=5.0, unit="mm", says="proximity is seen 10 to 15 frames before"
    ),
}
"""All targets by quantity."""


def distances(values: Mapping[str, float]) -> dict[str, float]:
    """Signed distance of every quantity from its target [tolerances]."""
    return {name: target.distance(values[name]) for name, target in TARGETS.items()}


def total_distance(values: Mapping[str, float]) -> float:
    """Root mean square of the distances, each at most `WORST` [tolerances]; 0 where all targets are met."""
    squares = [min(abs(each), WORST) ** 2 for each in distances(values).values()]
    return sqrt(sum(squares) / len(squares))
