"""What a print bears: the largest force and depth of a press that its makers recommend, and strengths of its materials.

A contact is sharp, and the sharp limits hold, where its radius, that of a disc of its area, is below `sharp_radius_mm`.
Strengths are told as the lowest and the highest of a data sheet, or of what is assumed; `deform.indentation.bearing`
says where a press reaches them. A solve uses none unless it is given as one of `CoreFailure`.
"""

import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from magicsim.config.models import Config

LOGGER = logging.getLogger(__name__)
LimitN = Annotated[float, Field(gt=0, le=1e4)]
LimitMm = Annotated[float, Field(gt=0, le=25)]
Strength = Annotated[float, Field(gt=0, le=1e3)]
STRENGTHS = ("elongation_at_break", "tensile_strength_mpa", "infill_yield_mpa")


class PressLimits(Config):
    """Largest press that a block is made for; what is left out has no limit."""

    force_n: LimitN | None = None
    """Normal force [N]."""
    depth_mm: LimitMm | None = None
    """Depth from first contact [mm]."""
    sharp_force_n: LimitN | None = None
    """Normal force of a sharp contact; `force_n` where left out [N]."""
    sharp_depth_mm: LimitMm | None = None
    """Depth of a sharp contact; `depth_mm` where left out [mm]."""
    sharp_radius_mm: Annotated[float, Field(gt=0, le=100)] = 1.5
    """A contact whose area is less than that of a disc of this radius is sharp [mm]; assumed."""
    elongation_at_break: tuple[Strength, Strength] | None = None
    """Stretch less 1 at which the body tears, 2.2 for 220 %: lowest and highest."""
    tensile_strength_mpa: tuple[Strength, Strength] | None = None
    """Force over area at rest at which the body tears: lowest and highest [MPa]."""
    infill_yield_mpa: tuple[Strength, Strength] | None = None
    """Shear stress at which the infill begins to flow: lowest and highest [MPa]."""

    def _problems(self) -> Iterator[str | None]:
        for name in ("force_n", "depth_mm"):
            most, sharp = getattr(self, name), getattr(self, f"sharp_{name}")
            if most is not None and sharp is not None and sharp > most:
                yield f"sharp_{name} = {sharp:g} is not allowed: must be at most {name} = {most:g}"
        for name in STRENGTHS:
            low, high = getattr(self, name) or (0.0, 0.0)
            if low > high:
                yield f"{name} = [{low:g}, {high:g}] is not allowed: must not fall"

    def excess(self, *, depth_mm: float, force_n: float, area_mm2: float) -> str:
        """What of a touch is above its limit, with figures; empty where nothing is, and without force."""
        if force_n <= 0:
            return ""
        radius = math.sqrt(max(area_mm2, 0.0) / math.pi)
        is_sharp = radius < self.sharp_radius_mm
        found = []
        for name, value, unit in (("force_n", force_n, "N"), ("depth_mm", depth_mm, "mm")):
            sharp, most = getattr(self, f"sharp_{name}"), getattr(self, name)
            key, limit = (f"sharp_{name}", sharp) if is_sharp and sharp is not None else (name, most)
            if limit is not None and value > limit * (1 + 1e-9):
                found.append(f"{value:.3g} {unit} is above design.limits.{key} = {limit:g}")
        if not found:
            return ""
        return " and ".join(found) + f", contact radius {radius:.2g} mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreFailure:
    """How the printed core of a block fails in a solve; not at all by default (`deform.lattice.core_failure`)."""

    infill_yield_mpa: float | None = None
    """Shear stress at which the infill flows [MPa]."""
    wall_buckling_strain: float | None = None
    """Squeeze along a wall from which on it carries no more."""
    wall_tear_elongation: float | None = None
    """Elongation at which walls tear; 1 is twice as long."""

    @property
    def is_remembered(self) -> bool:
        """Whether earlier touches matter; buckled walls come back."""
        return self.infill_yield_mpa is not None or self.wall_tear_elongation is not None


WHOLE = CoreFailure()
"""A core that does not fail."""


@dataclass(slots=True)
class LimitsWatch:
    """Warns once of touches that a print may not bear."""

    limits: PressLimits
    has_warned: bool = False

    def see(self, excess: str) -> None:
        """Warns where something is above its limit and nothing was before."""
        if excess and not self.has_warned:
            self.has_warned = True
            LOGGER.warning("beyond what the print bears: %s; infill may yield, walls and skin may tear", excess)
