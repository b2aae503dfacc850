"""Paths of the stress grid: every combination of extremes, single departures, and paths that drag and twist.

A path that drags presses, shears, twists, goes back and lets go under friction, quasi-statically and on a body that
relaxes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product

import numpy as np

from magicsim.config.models import load_preset
from magicsim.deform.lattice.relaxation import Branches, body_branches
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object

CONTRASTS = (1.0, 1e2, 1e4, 1e6)
"""Shear modulus of the skin over that of the core."""
POISSON_RATIOS = (0.25, 0.45, 0.4999, 0.499999)
DEPTH_SHARES = (0.1, 0.3, 0.5, 0.65)
"""Depths in units of the height."""
OBJECTS = {
    "sphere 4 mm": "sphere:radius_mm=4",
    "sphere 0.5 mm": "sphere:radius_mm=0.5",
    "domed cylinder 1 mm": "domed_cylinder:radius_mm=0.5",
    "cone 30 deg": "cone:half_angle_deg=30",
    "punch 1 mm": "punch:radius_mm=0.5",
    "dots 0.2 mm": "dots:radius_mm=0.2,spacing_mm=0.8",
}
BLOCK = ("footprint_mm=[12.0, 12.0]", "skin_mm=1.0", "core_mm=4.0", "cell_mm=0.8", "wall_mm=0.2", "lattice.spacing_mm=1.0")  # fmt: skip  # noqa: E501
"""The block of the grid: 12 x 12 x 6 mm, a skin of 1 mm, 1 mm spacing."""
RELAXING = (
    "materials.body.poisson_ratio=0.4999",
    "materials.body.prony=[{time_s=0.03,modulus_mpa=2.0},{time_s=1.0,modulus_mpa=0.5},{time_s=20.0,modulus_mpa=0.2}]",
)
"""A body three times as stiff at once as in the long term."""
FRICTIONS = (0.3, 1.0)
STAGE_TIMES_S = (0.01, 1.0)
"""Times of the stages of a path: shorter than all of the body's relaxation times but one, and between them."""
JITTER = 0.2
SEED = 0


def block(*overrides: str) -> ElastomerDesign:
    """The grid's block with changes, `dotted.key=value`."""
    return load_preset(ElastomerDesign, "design", "mini-magictac", [*BLOCK, *overrides])


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """Place and turn of the object at the end of a stage."""

    depth_share: float
    """Depth from first contact in units of the height."""
    shear_mm: float = 0.0
    """Along x."""
    twist_deg: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StressPath:
    """Path of one object into one block; each stage is a case."""

    group: str
    """`grid`, `single`, `friction` or `relaxing`."""
    label: str
    """Name of the case."""
    object_text: str
    design: ElastomerDesign = field(default_factory=block)
    change: Callable[[Lattice], Lattice] = lambda lattice: lattice
    """Change of the design's lattice."""
    stages: tuple[Stage, ...] = tuple(Stage(depth_share=share) for share in DEPTH_SHARES)
    contrast: float | None = None
    poisson_ratio: float | None = None
    friction: float = 0.0
    max_step_mm: float | None = None
    """Longest load step [mm]; None is the solver's own."""
    stage_s: float = math.inf
    """Time that each stage takes [s]; infinite where the body is that of the long term."""

    @property
    def key(self) -> tuple[str, str, float | None, float | None]:
        """Values that tell this path from all others."""
        return self.group, self.label, self.contrast, self.poisson_ratio

    def indenters(self) -> list[Indenter]:
        """The object at the end of each stage."""
        config, height = parse_object(self.object_text), self.design.height_mm
        return [
            place_object(config, gap_mm=-stage.depth_share * height, x_mm=stage.shear_mm, twist_deg=stage.twist_deg)
            for stage in self.stages
        ]

    def lattice(self) -> Lattice:
        """The block as a press would solve it: fine where the path touches, coarse far away."""
        return self.change(build_lattice(self.design, zone=contact_zone(self.indenters(), self.design)))

    def branches(self, lattice: Lattice) -> Branches | None:
        """Relaxing branches of the body on a path that takes time."""
        return body_branches(self.design, lattice) if math.isfinite(self.stage_s) else None


def layered(lattice: Lattice, *, contrast: float, poisson_ratio: float) -> Lattice:
    """One Poisson ratio everywhere, and the shear modulus of the core lower than the skin's by a factor.

    Args:
        lattice: Of any design with a grid.
        contrast: The factor.
        poisson_ratio: Of all cells.
    """
    skin = float(lattice.shear_modulus_mpa[~lattice.is_core][0])
    shear = np.where(lattice.is_core, skin / contrast, skin)
    return replace(
        lattice,
        shear_modulus_mpa=shear,
        lame_mpa=2 * shear * poisson_ratio / (1 - 2 * poisson_ratio),
        wall_modulus_mpa=np.zeros_like(shear),
    )


def grid_paths() -> list[StressPath]:
    """Every combination of contrast, Poisson ratio and object, each through all depths."""
    return [
        StressPath(
            group="grid", label=name, object_text=text, contrast=contrast, poisson_ratio=ratio,
            change=partial(layered, contrast=contrast, poisson_ratio=ratio),
        )
        for (name, text), contrast, ratio in product(OBJECTS.items(), CONTRASTS, POISSON_RATIOS)
    ]  # fmt: skip


def single_paths() -> list[StressPath]:
    """Tiny, huge and distorted cells, thin and thick blocks, a huge step, friction and twist."""
    ball = OBJECTS["sphere 4 mm"]
    designs = {
        "cell 0.3 mm": (
            "cell_mm=0.3", "wall_mm=0.1", "lattice.spacing_mm=0.4", "footprint_mm=[8.8, 8.8]", "core_mm=2.0",
        ),
        "cell 3 mm": (
            "cell_mm=3.0", "wall_mm=0.2", "lattice.spacing_mm=3.2", "footprint_mm=[14.8, 14.8]", "core_mm=6.4",
        ),
        "skin 0.1 mm": ("skin_mm=0.1",),
        "skin 3 mm": ("skin_mm=3.0",),
        "height 1.5 mm": ("skin_mm=0.25", "core_mm=1.0"),
        "height 20 mm": ("core_mm=18.0",),
    }  # fmt: skip
    paths = [
        StressPath(group="single", label=label, object_text=ball, design=block(*overrides))
        for label, overrides in designs.items()
    ]
    one_step, moved = (Stage(depth_share=0.5),), partial(jittered, share=JITTER, seed=SEED)
    paths.append(
        StressPath(group="single", label="one step of 50 %", object_text=ball, stages=one_step, max_step_mm=100.0)
    )
    paths += [
        StressPath(
            group="single",
            label=f"nodes moved by 20 %, {name}",
            object_text=text,
            change=moved,
        )
        for name, text in OBJECTS.items()
    ]
    shear = (
        Stage(depth_share=0.3),
        Stage(depth_share=0.3, shear_mm=1.0),
        Stage(depth_share=0.3, shear_mm=1.0, twist_deg=90.0),
    )
    paths += [
        StressPath(
            group="single", label=f"friction {friction:g}, 1 mm of shear, 90 deg of twist, {name}", object_text=text,
            stages=shear, friction=friction,
        )
        for friction in (0.0, 1.0)
        for name, text in {"sphere": ball, "box": "box:size_mm=4"}.items()
    ]  # fmt: skip
    return paths


def friction_paths() -> list[StressPath]:
    """Every object pressed, moved along, twisted, moved back and half let go, at little and much friction."""
    return [
        StressPath(
            group="friction", label=f"friction {friction:g}, {name}", object_text=text, stages=_dragged(),
            friction=friction,
        )
        for (name, text), friction in product(OBJECTS.items(), FRICTIONS)
    ]  # fmt: skip


def relaxing_paths() -> list[StressPath]:
    """Paths of `friction_paths` on a body that relaxes, quickly and slowly, with friction and without, and held."""
    held = (*_dragged(), _dragged()[-1])
    return [
        StressPath(
            group="relaxing", label=f"{time:g} s a stage, friction {friction:g}, {name}", object_text=text,
            stages=held, friction=friction, design=block(*RELAXING), stage_s=time,
        )
        for (name, text), time, friction in product(OBJECTS.items(), STAGE_TIMES_S, (0.0, FRICTIONS[-1]))
    ]  # fmt: skip


def every_path() -> list[StressPath]:
    """The grid, the single cases and the paths that drag, always in the same order."""
    return [*grid_paths(), *single_paths(), *friction_paths(), *relaxing_paths()]


def _dragged() -> tuple[Stage, ...]:
    return (
        Stage(depth_share=0.1),
        Stage(depth_share=0.1, shear_mm=0.5),
        Stage(depth_share=0.1, shear_mm=0.5, twist_deg=30.0),
        Stage(depth_share=0.1, shear_mm=-0.2, twist_deg=30.0),
        Stage(depth_share=0.05, shear_mm=-0.2, twist_deg=30.0),
    )


def jittered(lattice: Lattice, *, share: float, seed: int) -> Lattice:
    """A lattice with its nodes moved at random, the block's faces kept plane.

    Args:
        lattice: Box cells.
        share: Largest motion along each axis in units of the shorter neighbouring edge.
        seed: Of the random motion.
    """
    moved = lattice.nodes_mm.copy()
    rng = np.random.default_rng(seed)
    for axis, planes in enumerate(lattice.planes_mm):
        room = np.zeros(len(planes))
        room[1:-1] = share * np.minimum(np.diff(planes)[:-1], np.diff(planes)[1:])
        number = np.searchsorted(planes, lattice.nodes_mm[:, axis])
        moved[:, axis] += room[number] * rng.uniform(-1, 1, len(moved))
    return replace(lattice, nodes_mm=moved)
