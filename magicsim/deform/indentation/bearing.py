"""Where a press makes infill flow and tears skin and walls: depth and force at the strengths of a design's `limits`.

The object is pressed deeper and deeper into the middle of the block, quasi-statically, on a lattice that is fine below
it: two layers of cells or more across the skin, five across the radius of what touches. At each depth the largest
principal stretch and nominal stress on the two sides of the skin (`SkinCells.strained`) stand beside the elongation at
break and the tensile strength of the body, and the largest mean shear stress of an infill cube, mu gamma
(`magicsim.deform.strain`), beside the yield stress of the infill. Walls of a printed cell are told at the elongation at
break as well; a press does not go deeper for them. Each strength has a lowest and a highest value, and
so has what follows from it; between two depths all is linear.

The solve is elastic: nothing fails in it, so only the first of what fails is told truly, and later ones as if nothing
had. A neo-Hookean body that meets a hardness reading carries less at its elongation at break than its tensile strength,
which is measured at 500 mm/min: stretch then decides. Flaws, notches and fatigue are left out.
"""

import math
import time
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.config.ranges import check_number
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.indentation.press import check_depth, check_friction, compile_kernels
from magicsim.deform.lattice.core_failure import CoreLaw, weakened
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.spot import QUARTERS, central_lattice, is_mirror_image
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.tearing import MOST_ELONGATION, TearLaw
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.solve.iterate import Progress, part_of
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import InfillCells, SkinCells
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.geometry.face_shape import HeightMap
from magicsim.geometry.indenter import place_object
from magicsim.geometry.limits import STRENGTHS, CoreFailure
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.waiting import Told, on_stderr, unheard, waiting

STEP_MM, FEWEST_STEPS = 0.25, 4
"""Longest way between two depths [mm], and fewest of them: assumed."""
LAYERS, ACROSS, MOST_ACROSS = 2, 5, 12
"""Cells across the skin at least, across the radius of what touches at least, and at most."""
COARSEST_MM, FINEST_MM = 0.25, 0.1
"""Largest node spacing below a small object, and smallest one at all [mm]."""
CUBES_BEYOND = 2
"""Infill cubes beyond what touches, sideways, that are looked at; in depth all of them."""

EVENTS = ("yield", "tear", "wall_tear")
"""The infill flows, the skin tears, walls tear."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingPlace:
    """One solved depth."""

    depth_mm: float
    """Depth from first contact [mm]."""
    force_n: float
    """Normal force [N]."""
    skin_stretch: float
    """Largest principal stretch of the skin, 1 at rest."""
    skin_stress_mpa: float
    """Largest principal nominal stress of the skin, force over area at rest [MPa]."""
    infill_stress_mpa: float | None
    """Largest mean shear stress of an infill cube, at most that at which it flows [MPa]; None without infill."""
    wall_stretch: float | None = None
    """Largest stretch in the walls of a printed cell (`lattice.tearing`), 1 at rest; None without walls."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Onset:
    """Where the first place of a block reaches a strength."""

    event: str
    """One of `EVENTS`."""
    by: str
    """What reaches the strength: a name of `BearingPlace`."""
    strength: float
    """Lowest or highest value of the strength."""
    depth_mm: float | None
    """Depth from first contact [mm]; None where it is not reached."""
    force_n: float | None
    """Normal force [N]; None where it is not reached."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bearing:
    """What a block bears under an object."""

    onsets: tuple[Onset, ...]
    """Every strength of the design, its lowest value before its highest."""
    history: tuple[BearingPlace, ...]
    """Every solved depth."""
    stopped: str
    """Why no deeper place was solved."""
    spacing_mm: float
    """Largest node spacing below the object [mm]."""
    skin_layers: int
    """Layers of cells across the skin."""
    seconds: float
    """Wall time [s]."""

    def first(self, event: str, end: int) -> Onset | None:
        """The onset of an event that comes first when all strengths are lowest (0) or highest (1); None without one."""
        reached = [each for each in self.onsets[end::2] if each.event == event and each.depth_mm is not None]
        return min(reached, key=lambda each: each.depth_mm or 0.0, default=None)

    @property
    def recommended(self) -> Onset | None:
        """What fails first when every strength is lowest: limits of depth and force; None where nothing fails."""
        firsts = [each for event in EVENTS if (each := self.first(event, 0)) is not None]
        return min(firsts, key=lambda each: each.depth_mm or 0.0, default=None)

    def as_dict(self) -> dict[str, Any]:
        """The keys of the command line's JSON; lowest before highest, None for what is not reached."""
        values: dict[str, Any] = {}
        for event in EVENTS:
            ends = [self.first(event, end) for end in (0, 1)]
            values[f"{event}_depth_mm"] = [each.depth_mm if each else None for each in ends]
            values[f"{event}_force_n"] = [each.force_n if each else None for each in ends]
        least = self.recommended
        values["recommended_depth_mm"] = least.depth_mm if least else None
        values["recommended_force_n"] = least.force_n if least else None
        values["recommended_by"] = least.by if least else None
        values["onsets"] = [asdict(each) for each in self.onsets]
        values |= {name: getattr(self, name) for name in ("stopped", "spacing_mm", "skin_layers", "seconds")}
        return values | {"history": [asdict(each) for each in self.history]}


def press_limits(
    design: ElastomerDesign,
    object_config: ObjectBase,
    *,
    depth_mm: float | None = None,
    friction: float = 0.0,
    infill_yield_mpa: float | None = None,
    wall_buckling_strain: float | None = None,
    wall_tear_elongation: float | None = None,
    until: Collection[str] | None = None,
    coarsening: float = 1.0,
    progress: Progress | None = None,
    told: Told = on_stderr,
) -> Bearing:
    """Presses an object into the middle of a block until every strength of the design's `limits` is passed.

    Args:
        design: The block.
        object_config: The object.
        depth_mm: Deepest place that is tried, from first contact [mm]; 90 % of the height by default.
        friction: Coulomb's coefficient between object and face.
        infill_yield_mpa: Shear stress at which the infill flows [MPa]; the solve is elastic by default.
        wall_buckling_strain: Squeeze along a wall from which on it carries no more; none does by default.
        wall_tear_elongation: Elongation at which walls tear; none does by default.
        until: Events, `yield` and `tear`, of which one strength each ends the press already; of none, any strength.
        coarsening: Node spacing in units of the usual one.
        progress: Told after every iteration, see `Progress`.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A number is not allowed, or the design has no strength that the press can reach.
        GeometryError: The design cannot be built.
        ConvergenceError: Not even the first depth has a valid equilibrium.
    """
    strengths = _strengths(design)
    of_walls = [("wall_tear", "wall_stretch", value) for event, by, value in strengths if by == "skin_stretch"]
    deepest = MAX_DEPTH_SHARE * design.height_mm if depth_mm is None else depth_mm
    check_depth(deepest, design)
    check_friction(friction)
    check_number("coarsening", coarsening, 0.1, 10.0)
    if unknown := sorted(set(until or ()).difference(EVENTS[:2])):
        raise ConfigError(f"until = {unknown} is not allowed: events are {', '.join(EVENTS[:2])}")
    if deepest == 0:
        raise ConfigError("depth_mm = 0 is not allowed with limits: must be above 0")
    count = max(FEWEST_STEPS, math.ceil(deepest / STEP_MM - 1e-9))
    poses = [place_object(object_config, gap_mm=-deepest * step / count, design=design) for step in range(1, count + 1)]
    zone = contact_zone(poses, design)
    if zone is None:
        raise ConfigError(f"the object does not reach the face at a depth of {deepest:g} mm")
    compile_kernels()
    start = time.perf_counter()
    is_quarter = is_mirror_image(poses[-1]) and not isinstance(design.face, HeightMap)
    spacing = coarsening * bearing_spacing_mm(design, zone)
    failure = CoreFailure(
        infill_yield_mpa=infill_yield_mpa, wall_buckling_strain=wall_buckling_strain,
        wall_tear_elongation=wall_tear_elongation,
    )  # fmt: skip
    lattice = weakened(central_lattice(design, zone, spacing_mm=spacing, is_quarter=is_quarter), failure)
    solver = ContactSolver(
        lattice, friction=friction, point_spacing_mm=point_spacing_mm(poses[0].shape),
        core=CoreLaw.of(design, lattice, failure),
    )  # fmt: skip
    skin, infill, gel = SkinCells.of(design, lattice), _infill_below(design, lattice, zone), design.materials.infill
    modulus = gel.shear_modulus_mpa if gel is not None else 0.0
    walls = TearLaw.of(design, lattice, MOST_ELONGATION) if infill is not None else None
    whole = Elasticity.of(lattice)
    places, state, stopped = list[BearingPlace](), None, f"depth_mm = {deepest:g} is reached"
    with waiting("pressing until something fails", told if progress is None else unheard) as share:
        for number, pose in enumerate(poses):
            try:
                state = solver.solve(pose, state, progress=part_of(progress or share, number, count))
            except ConvergenceError as error:
                if not places:
                    raise
                stopped = str(error)
                break
            stretch, stress = skin.strained(state)
            moved = lattice.nodes_mm + state.displacements_mm
            shear = float(infill.shears(state.displacements_mm).max()) if infill is not None else 0.0
            place = BearingPlace(
                depth_mm=deepest * (number + 1) / count,
                force_n=float(state.force_n[2]) * (QUARTERS if is_quarter else 1),
                skin_stretch=stretch,
                skin_stress_mpa=stress,
                infill_stress_mpa=min(modulus * shear, infill_yield_mpa or math.inf) if infill is not None else None,
                wall_stretch=float(walls.stretches(whole, moved).max()) if walls else None,
            )
            places.append(place)
            passed = [each for each in strengths if onset(places, *each).depth_mm is not None]
            events = {event for event, *_ in passed}
            if len(passed) == len(strengths) or (until is not None and events and events.issuperset(until)):
                asked = "every strength is" if until is None else "the strengths that were asked for are"
                stopped = f"{asked} passed"
                break
    return Bearing(
        onsets=tuple(onset(places, *each) for each in [*strengths, *(of_walls if walls else [])]),
        history=tuple(places), stopped=stopped,
        spacing_mm=spacing, skin_layers=skin.layers, seconds=time.perf_counter() - start,
    )  # fmt: skip


def onset(places: Sequence[BearingPlace], event: str, by: str, strength: float) -> Onset:
    """Where a press first reaches a strength, linear between its places, the first of them rest."""
    start = 1.0 if by in {"skin_stretch", "wall_stretch"} else 0.0
    values = np.array([start, *(getattr(each, by) for each in places)])
    above = np.flatnonzero(values >= strength)
    if len(above) == 0:
        return Onset(event=event, by=by, strength=strength, depth_mm=None, force_n=None)
    last = max(int(above[0]), 1)
    part = (strength - values[last - 1]) / (values[last] - values[last - 1])
    depth, force = (
        (1 - part) * rest[last - 1] + part * rest[last]
        for rest in ([0.0, *(each.depth_mm for each in places)], [0.0, *(each.force_n for each in places)])
    )
    return Onset(event=event, by=by, strength=strength, depth_mm=float(depth), force_n=float(force))


def bearing_spacing_mm(design: ElastomerDesign, zone: Zone) -> float:
    """Largest node spacing below an object that touches a zone [mm]; a finer one of the design's own stays."""
    fine = min(COARSEST_MM, design.skin_mm / LAYERS, zone.radius_mm / ACROSS)
    return min(max(fine, zone.radius_mm / MOST_ACROSS, FINEST_MM), design.lattice.spacing_mm or math.inf)


def _strengths(design: ElastomerDesign) -> list[tuple[str, str, float]]:
    """Event, measure and value of every strength, the lowest of each before the highest."""
    limits, has_infill = design.limits, design.has_grid and design.materials.infill is not None
    if limits.infill_yield_mpa is not None and not has_infill:
        raise ConfigError("limits.infill_yield_mpa is not allowed for a block without infill (cell_mm = 0)")
    found = []
    for low_high, event, by, rest in (
        (limits.infill_yield_mpa, "yield", "infill_stress_mpa", 0.0),
        (limits.elongation_at_break, "tear", "skin_stretch", 1.0),
        (limits.tensile_strength_mpa, "tear", "skin_stress_mpa", 0.0),
    ):
        found += [(event, by, rest + value) for value in low_high or ()]
    if not found:
        names = ", ".join(f"limits.{name}" for name in STRENGTHS)
        raise ConfigError(f"the design says no strength: limits needs one of {names}, each [lowest, highest]")
    return found


def _infill_below(design: ElastomerDesign, lattice: Lattice, zone: Zone) -> InfillCells | None:
    """Cubes of infill below and around what touches, counted from the middle; None without infill.

    The core is made of effective cells, so that a cube may be anywhere: one that lies beside the axis stands for all.
    """
    grid = lattice.grid
    if grid is None:
        return None
    reach = max(*np.abs(zone.low_mm), *np.abs(zone.high_mm))
    pitch, far = grid.pitch_mm, [float(planes[-1]) for planes in lattice.planes_mm[:2]]
    corners: list[Array] = []
    for axis in range(2):
        most = min(math.ceil(reach / pitch[axis]) + CUBES_BEYOND, int((far[axis] - design.skin_mm) / pitch[axis]))
        corners.append(pitch[axis] * np.arange(0 if lattice.is_mirrored else -most, most))
    heights = grid.origin_mm[2] + pitch[2] * np.arange(grid.counts[2])
    places = np.stack(np.meshgrid(*corners, heights, indexing="ij"), -1).reshape(-1, 3)
    return InfillCells.of(design, lattice, corners_mm=places)
