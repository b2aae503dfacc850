"""Footprint, layers, grid, materials and face of a printed block: the configuration model of `geometry/*.toml`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field

from magicsim.arrays import Array
from magicsim.config.models import Config, load_preset
from magicsim.geometry.coat import Coat, HalfMirror, OpaqueCoat
from magicsim.geometry.face_shape import Face, HeightMap, flattened, lifted
from magicsim.geometry.flaws import MIN_WALL_MM, Inclusions, Roughness, Unevenness
from magicsim.geometry.limits import PressLimits
from magicsim.geometry.markers import Markers

Modulus = Annotated[float, Field(ge=1e-6, le=1e6)]
"""From 1 Pa, a liquid more than a gel, to what is stiffer than steel [MPa]."""
HEIGHT_MM = (1.0, 25.0)
CELL_MM = (0.3, 3.0)
FACET_MM = 0.2
"""Length to which the edges of the rendered contact face are split [mm], diagonals up to twice as long: rims around
what presses bend over tenths of a millimetre. With 0.1 no difference is to be seen (`benchmarks/face_facets.py`)."""
MAX_DEPTH_SHARE = 0.9
"""Deepest press in units of the block's height."""


class Optics(Config):
    """How one material refracts, scatters and absorbs."""

    ior: Annotated[float, Field(ge=1.0, le=2.5)]
    """Refractive index."""
    sigma_s_per_mm: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Scattering coefficient [1/mm]; with `anisotropy = 0` a reduced coefficient."""
    absorption_per_mm: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Absorption coefficient [1/mm]."""
    anisotropy: Annotated[float, Field(gt=-1, lt=1)] = 0.0
    """Mean cosine of the scattering angle."""


class PronyTerm(Config):
    """One relaxing part of a body's stiffness."""

    time_s: Annotated[float, Field(ge=1e-6, le=1e9)]
    """Relaxation time [s]."""
    modulus_mpa: Modulus
    """Young's modulus that it adds to the long-term one [MPa]."""


class BodyMaterial(Optics):
    """Skin and walls: a rubbery solid."""

    youngs_modulus_mpa: Modulus
    """Long-term Young's modulus [MPa]."""
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)]
    """Poisson's ratio of the long-term response."""
    prony: Annotated[tuple[PronyTerm, ...], Field(max_length=32)] = ()
    """Relaxation, used on timed paths only; without it the body has its long-term stiffness at any rate."""

    @property
    def shear_modulus_mpa(self) -> float:
        """Shear modulus E / (2 (1 + nu)) [MPa]."""
        return self.youngs_modulus_mpa / (2 * (1 + self.poisson_ratio))

    @property
    def bulk_modulus_mpa(self) -> float:
        """Bulk modulus E / (3 (1 - 2 nu)) [MPa]."""
        return self.youngs_modulus_mpa / (3 * (1 - 2 * self.poisson_ratio))

    @property
    def lame_mpa(self) -> float:
        """First Lame parameter lambda [MPa]."""
        return self.bulk_modulus_mpa - 2 / 3 * self.shear_modulus_mpa

    @property
    def instantaneous_shear_modulus_mpa(self) -> float:
        """Shear modulus before anything has relaxed [MPa]."""
        return self.shear_modulus_mpa + sum(term.modulus_mpa for term in self.prony) / (2 * (1 + self.poisson_ratio))


class InfillMaterial(Optics):
    """Filling of the cells: nearly a liquid, so its stiffness is given as shear and bulk modulus."""

    shear_modulus_mpa: Modulus
    """Shear modulus [MPa]."""
    bulk_modulus_mpa: Modulus
    """Bulk modulus [MPa]."""

    @property
    def lame_mpa(self) -> float:
        """First Lame parameter lambda [MPa]."""
        return self.bulk_modulus_mpa - 2 / 3 * self.shear_modulus_mpa


class Materials(Config):
    """The two printed materials."""

    body: BodyMaterial
    infill: InfillMaterial | None = None


Base = Literal["bonded", "table"]
"""Hold of the face opposite the contact face."""


class Mounting(Config):
    """Hold of the block from below."""

    base: Base = "bonded"
    """`bonded` to what carries it, as a print glued or pressed onto its lens is, or loose on a rigid `table`: held by
    friction, free to lift off. The sensor is assumed to be bonded: nobody says how the print is held."""
    friction: Annotated[float, Field(ge=0.05, le=5)] = 0.7
    """Coulomb's coefficient between block and table; assumed, rubber on smooth hard surfaces 0.3 to 1.5."""


FAR_FIELD_BOUND = 0.01
"""Largest relative change of a force by the coarse far field as it is by default; a test holds it."""


class LatticeOptions(Config):
    """Resolution of the lattice that carries the deformation."""

    spacing_mm: Annotated[float, Field(ge=0.1, le=5)] | None = None
    """Largest node spacing where contact is [mm]; the pitch by default (1 mm without a grid)."""
    growth: Annotated[float, Field(ge=1, le=3)] = 1.6
    """Ratio of neighbouring node spacings away from the contact; 1 keeps the whole lattice as fine as the contact."""
    margin: Annotated[float, Field(ge=0, le=20)] = 2.5
    """Node spacings around what can be touched, sideways and below, that stay fine."""
    fine_depth: Annotated[float, Field(ge=0, le=5)] = 1.0
    """How deep they stay fine below what can be touched, before the margin, in units of its half width."""
    cells_across: Annotated[int, Field(ge=0, le=20)] = 4
    """Least number of cells across what a small blunt object can touch, of 0.1 mm or more; 0 keeps `spacing_mm`."""
    cells_across_round: Annotated[int, Field(ge=0, le=20)] = 7
    """That below a round object of 1 mm radius or more, of 0.15 mm or more, across what the undeformed block has of it;
    0 makes none for it."""
    edge_nodes: Annotated[int, Field(ge=0, le=20_000)] = 256
    """Most nodes of the face below what touches where a lattice is made finer at its edges; 0 keeps `spacing_mm`."""


class ElastomerDesign(Config):
    """One printed block: footprint, skin, core, grid and materials."""

    schema_version: Literal[1]
    footprint_mm: tuple[Annotated[float, Field(ge=2, le=200)], Annotated[float, Field(ge=2, le=200)]]
    """Size along x and y [mm]."""
    skin_mm: Annotated[float, Field(ge=0.1, le=5)]
    """Clear layer on every side of the core [mm]."""
    core_mm: Annotated[float, Field(ge=0.1, le=25)]
    """Height of the core [mm]; total height is core plus two skins."""
    cell_mm: Annotated[float, Field(ge=0, le=3)]
    """Edge of one infill cube asked for [mm]; 0 means no grid."""
    wall_mm: Annotated[float, Field(ge=0, le=3)] = 0.0
    """Wall between neighbouring cells [mm]."""
    materials: Materials
    mounting: Mounting = Mounting()
    lattice: LatticeOptions = LatticeOptions()
    limits: PressLimits = PressLimits()
    """Largest press that the print bears; not known by default."""
    face: Face | None = None
    """Shape of the contact face; flat by default. Heights of skin and core then hold at the crown."""
    coat: Coat | None = None
    """Cover of the contact face; bare by default."""
    markers: Markers | None = None
    """Print on or below the contact face; nothing by default."""
    unevenness: Unevenness = Unevenness()
    roughness: Roughness = Roughness()
    inclusions: Inclusions = Inclusions()

    @property
    def height_mm(self) -> float:
        """Total height [mm]."""
        return 2 * self.skin_mm + self.core_mm

    @property
    def has_grid(self) -> bool:
        """Whether cells are printed inside."""
        return self.cell_mm > 0

    def lifted(self, points_mm: Array) -> Array:
        """Points of the box where the block has them, shape (..., 3) [mm]; the same array for a flat face."""
        return lifted(points_mm, self.face, self.height_mm)

    def flattened(self, points_mm: Array) -> Array:
        """Points of the block where its box has them, shape (..., 3) [mm]; the inverse of `lifted`."""
        return flattened(points_mm, self.face, self.height_mm)

    def rise_mm(self, places_mm: Array) -> Array:
        """Height of the contact face over z = 0 at places x, y of shape (..., 2) [mm]; 0 for a flat face."""
        return self.face.rise_mm(places_mm) if self.face is not None else np.zeros(places_mm.shape[:-1])

    @property
    def is_opaque(self) -> bool:
        """Whether nothing outside is seen through the contact face."""
        return isinstance(self.coat, OpaqueCoat)

    @property
    def face_is_special(self) -> bool:
        """Whether the contact face is anything but bare."""
        return self.coat is not None or (self.markers is not None and self.markers.depth_mm == 0)

    @property
    def scatters(self) -> bool:
        """Whether body or infill scatter light."""
        infill = self.materials.infill
        in_cells = self.has_grid and infill is not None and infill.sigma_s_per_mm > 0
        return self.materials.body.sigma_s_per_mm > 0 or in_cells

    def mounted(self, mounting: Mounting) -> Self:
        """This print on another mounting."""
        return self.model_copy(update={"mounting": mounting})

    def _problems(self) -> Iterator[str | None]:
        """Why the block cannot be printed, rule by rule, each once those before it hold; None where a rule holds."""
        low, high = HEIGHT_MM
        if not low <= self.height_mm <= high:
            yield f"height 2 * skin_mm + core_mm = {self.height_mm:g} mm is not allowed: must be {low:g} to {high:g} mm"
        if self.face is not None:
            yield self.face.problem(self.height_mm)
        if isinstance(self.face, HeightMap) and self.face.footprint_mm != self.footprint_mm:
            yield f"face.footprint_mm = {list(self.face.footprint_mm)} is not allowed: must be the block's own"
        if self.markers is not None:
            yield self.markers.problem(self.footprint_mm, self.height_mm)
        yield self.inclusions.problem(self.cell_mm)
        if self.coat is not None:
            yield self.coat.problem(self.height_mm, self.materials.body.youngs_modulus_mpa)
        if self.roughness.skin > 0 and isinstance(self.coat, HalfMirror):
            yield (
                f"roughness.skin = {self.roughness.skin:g} is not allowed with coat.kind = 'half_mirror': must be 0, "
                "since a film's share is known for a smooth face"
            )
        if not self.has_grid:
            return
        low, high = CELL_MM
        if not low <= self.cell_mm <= high:
            yield f"cell_mm = {self.cell_mm:g} is not allowed: must be 0 (no grid) or {low:g} to {high:g} mm"
        if self.wall_mm < MIN_WALL_MM:
            yield f"wall_mm = {self.wall_mm:g} is not allowed: must be at least {MIN_WALL_MM:g} mm"
        core_mm = np.array([*self.footprint_mm, self.height_mm]) - 2 * self.skin_mm
        yield from self.unevenness.problems(core_mm, self.skin_mm, self.cell_mm, self.wall_mm)
        if self.materials.infill is None:
            yield "materials.infill is missing: a design with cells (cell_mm > 0) needs an infill material"


def load_design(name: str | Path, overrides: Sequence[str] = ()) -> ElastomerDesign:
    """Reads the design of a block: a preset, such as `mini-magictac`, or a TOML file, with `dotted.key=value` settings.

    Raises:
        PresetError: The design does not exist.
        ConfigError: The content is not acceptable.
    """
    return load_preset(ElastomerDesign, "design", name, overrides)
