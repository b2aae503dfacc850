"""How many bubbles and flakes the infill of a print holds: the configuration model of `design.inclusions`."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config

WIDEST_SHARE = 0.35
"""Largest radius in units of a cell's edge."""
Radius = Annotated[float, Field(ge=0.005, le=0.5)]
Density = Annotated[float, Field(ge=0, le=20)]


class Inclusions(Config):
    """What a print holds that is neither of its materials; none by default.

    All values are assumed: nobody has counted them. Bubbles show in clear prints as points that glitter, flakes are
    cured droplets and dust that the jets bring.
    """

    bubbles_per_mm3: Density = 0.0
    """Spheres of air in each mm3 of infill [1/mm3]; assumed, 0 to 1."""
    bubble_radius_mm: tuple[Radius, Radius] = (0.02, 0.08)
    """Range of their radii, all alike likely [mm]; assumed, from half a droplet line of a 600 dpi printer."""
    flakes_per_mm3: Density = 0.0
    """Thin round platelets in each mm3 of infill, in all directions [1/mm3]; assumed, 0 to 1."""
    flake_radius_mm: tuple[Radius, Radius] = (0.02, 0.08)
    """Range of their radii, all alike likely [mm]; assumed."""
    flake_reflectance: Annotated[float, Field(ge=0, le=1)] = 0.3
    """Diffuse reflectance of both sides; the rest is absorbed. Assumed, 0.05 to 0.8."""
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Seed of the print: each printed sensor has its own."""

    @property
    def is_clean(self) -> bool:
        """Whether there are none."""
        return self.bubbles_per_mm3 == 0 and self.flakes_per_mm3 == 0

    @property
    def widest_mm(self) -> float:
        """Largest radius of what there is, 0 where there is nothing [mm]."""
        bubbles = self.bubble_radius_mm[1] if self.bubbles_per_mm3 > 0 else 0.0
        return max(bubbles, self.flake_radius_mm[1] if self.flakes_per_mm3 > 0 else 0.0)

    @model_validator(mode="after")
    def _check_ranges(self) -> Self:
        for name in ("bubble_radius_mm", "flake_radius_mm"):
            low, high = getattr(self, name)
            if low > high:
                msg = f"{name} = [{low:g}, {high:g}] is not allowed: the first must be at most the second"
                raise ValueError(msg)
        return self

    def problem(self, cell_mm: float) -> str | None:
        """Why they do not fit into cells of that size, None where they do.

        Args:
            cell_mm: Edge of a cell, 0 without a grid [mm].
        """
        if self.is_clean:
            return None
        if cell_mm == 0:
            return "inclusions are not allowed with cell_mm = 0: bubbles and flakes lie in cells"
        if self.widest_mm > WIDEST_SHARE * cell_mm:
            return (
                f"inclusions with radii of up to {self.widest_mm:g} mm are not allowed with cell_mm = {cell_mm:g}: "
                f"must be at most {WIDEST_SHARE:g} cell_mm = {WIDEST_SHARE * cell_mm:.3g}"
            )
        return None
