"""How a print differs from its drawing: `unevenness`, `roughness` and `inclusions` of a design."""

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from pydantic import Field

from magicsim.arrays import Array
from magicsim.config.models import Config

MIN_WALL_MM = 0.05
"""Thinnest wall: thinner ones could close below the renderer's safe gap when the grid deforms."""
WIDEST_FILLET = 0.4
"""Largest radius where walls cross, in units of a cell's edge."""
CUTOFF_SKIN_SD = 3.0
"""The skin differs from the drawing by at most so many standard deviations."""
WAVE_REACH_SD = 4.0
"""No wave of a print moves a cell by more standard deviations: it would lie outside of the skin."""
MOST_OF_SKIN, MOST_OF_CELL = 0.5, 0.25
"""Part of the skin that cells may move into, and of a cell that an uneven skin may take or give."""
Scale = Annotated[float, Field(ge=0.9, le=1.1)]
Drift = Annotated[float, Field(ge=-0.2, le=0.2)]
Spread = Annotated[float, Field(ge=0, le=0.5)]
WaveLength = Annotated[float, Field(ge=0.5, le=100)]
Slope = Annotated[float, Field(ge=0, le=0.5)]
WIDEST_SHARE = 0.35
"""Largest radius of a bubble or flake in units of a cell's edge."""
Radius = Annotated[float, Field(ge=0.005, le=0.5)]
Density = Annotated[float, Field(ge=0, le=20)]


class Unevenness(Config):
    """How the grid of a print differs from its drawing, as far as one sees it; forces are those of the drawing."""

    wall_sd_mm: Spread = 0.0
    """Standard deviation of the walls' thickness, cut off at two of them [mm]; assumed, 0 to 0.015 for a wall of 0.1:
    half a droplet line of a 600 dpi printer is 0.02."""
    crossing_radius_mm: Spread = 0.0
    """Radius of the fillets where walls cross [mm]; assumed, 0 to 0.15: droplets of 0.04 mm fill inner corners. Light
    then takes longer, as the next wall is searched for among all."""
    wave_sd_mm: Spread = 0.0
    """Standard deviation of the grid planes' places [mm]; assumed, 0 to 0.03."""
    wave_length_mm: WaveLength = 6.0
    """Length of the waves [mm]; assumed, 3 to 20."""
    skin_sd_mm: Spread = 0.0
    """Standard deviation of the skin's thickness over the contact face, which the lowest cells take or give, cut off at
    three of them [mm]; assumed, 0 to 0.05: two layers of 0.027 that a printer jets."""
    skin_length_mm: WaveLength = 6.0
    """Length of its waves [mm]; assumed, 3 to 20."""
    pitch_scale: tuple[Scale, Scale, Scale] = (1.0, 1.0, 1.0)
    """Pitch along x, y and z in units of the drawn one, about the middle of the core; assumed, 0.994 to 1.006: parts of
    26 mm by a printer that keeps 0.05 to 0.15."""
    pitch_drift: tuple[Drift, Drift, Drift] = (0.0, 0.0, 0.0)
    """Relative change of the pitch from one side of the core to the other along x, y and z, the mean as drawn; assumed,
    0 to 0.02."""
    torn_share: Annotated[float, Field(ge=0, le=0.1)] = 0.0
    """Share of walls between cells that a print lacks (a touch tears by `contact.wall_tear_elongation`): light finds
    one cell there; of each cell one at most. Assumed, 0 to 0.02: a wall of four droplets tears where one stays out."""
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Seed of the print: each printed sensor has its own."""

    @property
    def shifts_cells(self) -> bool:
        """Whether cells lie or end where no wave about their drawn places has them."""
        return self.skin_sd_mm > 0 or set(self.pitch_scale) != {1.0} or any(self.pitch_drift)

    @property
    def is_even(self) -> bool:
        """Whether the cells' surfaces are where they are drawn."""
        return self.wall_sd_mm == 0 and self.wave_sd_mm == 0 and not self.shifts_cells

    def _problems(self) -> Iterator[str | None]:
        for part in ("wave", "skin"):
            spread, length = getattr(self, f"{part}_sd_mm"), getattr(self, f"{part}_length_mm")
            if 10 * spread > length:
                yield (
                    f"{part}_sd_mm = {spread:g} is not allowed with {part}_length_mm = {length:g}: "
                    "must be at most a tenth of it"
                )
        if self.torn_share > 0 and self.crossing_radius_mm > 0:
            yield (
                f"torn_share = {self.torn_share:g} is not allowed with crossing_radius_mm = "
                f"{self.crossing_radius_mm:g}: one of them must be 0, since a wall is missing up to its crossings"
            )

    def shift_mm(self, places: Array, low_mm: Array, high_mm: Array) -> Array:
        """How far a pitch that is not the drawn one moves places in a core between two corners, shape (places, 3) [mm].

        The pitch grows linearly along an axis, from scale - drift / 2 to scale + drift / 2 of the drawn one.
        """
        half = (high_mm - low_mm) / 2
        along = (places - low_mm) / half - 1
        growth = np.array(self.pitch_drift) / 4 * (along**2 - 1 / 3)
        return np.asarray(half * ((np.array(self.pitch_scale) - 1) * along + growth))

    def problems(self, core_mm: Array, skin_mm: float, cell_mm: float, wall_mm: float) -> Iterator[str]:
        """Why a grid in a core of a size along x, y and z cannot be printed like this."""
        if wall_mm - 3 * self.wall_sd_mm < MIN_WALL_MM and self.wall_sd_mm > 0:
            yield (
                f"unevenness.wall_sd_mm = {self.wall_sd_mm:g} is not allowed with wall_mm = {wall_mm:g}: "
                f"wall_mm - 3 wall_sd_mm must be at least {MIN_WALL_MM:g} mm"
            )
        if self.crossing_radius_mm > WIDEST_FILLET * cell_mm:
            yield (
                f"unevenness.crossing_radius_mm = {self.crossing_radius_mm:g} is not allowed with cell_mm = "
                f"{cell_mm:g}: must be at most {WIDEST_FILLET:g} cell_mm"
            )
        if WAVE_REACH_SD * self.wave_sd_mm > skin_mm:
            yield (
                f"unevenness.wave_sd_mm = {self.wave_sd_mm:g} is not allowed with skin_mm = {skin_mm:g}: must be at "
                f"most {skin_mm / WAVE_REACH_SD:.3g}, or cells would pass through the skin"
            )
        thickest = CUTOFF_SKIN_SD * self.skin_sd_mm
        if thickest > MOST_OF_CELL * cell_mm:
            yield (
                f"unevenness.skin_sd_mm = {self.skin_sd_mm:g} is not allowed with cell_mm = {cell_mm:g}: must be at "
                f"most {MOST_OF_CELL / CUTOFF_SKIN_SD * cell_mm:.3g}"
            )
        if not self.shifts_cells or core_mm.min() <= 0:
            return
        ends = np.stack([-core_mm, core_mm]) / 2
        reach = np.abs(self.shift_mm(ends, *ends)).max(0)
        reach[2] += thickest
        if (reach > MOST_OF_SKIN * skin_mm).any():
            axis = int(reach.argmax())
            yield (
                f"unevenness.pitch_scale, pitch_drift and skin_sd_mm move cells by up to {reach[axis]:.3g} mm into the "
                f"skin along {'xyz'[axis]}: must be at most {MOST_OF_SKIN:g} skin_mm = {MOST_OF_SKIN * skin_mm:g} mm"
            )


class Roughness(Config):
    """Rough interfaces, smooth by default.

    A value is the slope that half of the facets exceed (Trowbridge and Reitz's alpha). Assumed, 0.02 to 0.3: glossy
    PolyJet faces have Ra of 0.5 to 4 micrometres (Udroiu, Braga, Nedelcu, Materials 12 (2019) 995), and a wave of that
    height as long as two droplets of a 600 dpi printer (0.085 mm) has an rms slope of 0.04 to 0.33.
    """

    skin: Slope = 0.0
    """Slope of contact face and sides. The face on the lens is in optical contact and smooth."""
    walls: Slope = 0.0
    """Slope between walls and infill."""


class Inclusions(Config):
    """Bubbles and flakes in the infill; none by default.

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

    def _problems(self) -> Iterator[str | None]:
        for name in ("bubble_radius_mm", "flake_radius_mm"):
            low, high = getattr(self, name)
            if low > high:
                yield f"{name} = [{low:g}, {high:g}] is not allowed: the first must be at most the second"

    def problem(self, cell_mm: float) -> str | None:
        """Why bubbles and flakes do not fit into cells with that edge, 0 without a grid, or None where they do."""
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
